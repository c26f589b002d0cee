# softlux. `make help` lists what can be made.
#
#   CONFIG=release (default)  optimised
#   CONFIG=debug              address and undefined-behaviour sanitizers
#   CONFIG=tsan               thread sanitizer (clang)
#   CONFIG=baseline           without the multiversioned loops
#   CONFIG=fuzz               for the fuzzer: sanitizers and coverage (clang)
# Each configuration and compiler has its own folder: build/ for the default, build/CONFIG[-clang] otherwise.

CONFIG ?= release
ifeq ($(origin CC),default)
CC := gcc
endif
PREFIX ?= /usr/local
LIBDIR ?= $(PREFIX)/lib
LIBEXECDIR ?= $(PREFIX)/libexec
MANDIR ?= $(PREFIX)/share/man
DOCDIR ?= $(PREFIX)/share/doc/softlux
DESTDIR ?=

COMPILER := $(if $(findstring clang,$(CC)),clang,gcc)
ifeq ($(CONFIG)-$(COMPILER),release-gcc)
BUILD ?= build
else
BUILD ?= build/$(CONFIG)$(if $(filter clang,$(COMPILER)),-clang)
endif

# ---- flags -------------------------------------------------------------------------------------------------------

WARNINGS := -Wall -Wextra -Wconversion -Wshadow
# The determinism contract: no contraction, no fast-math. The two -fno- flags change no value, only errno and traps.
# gcc's vectorizer of straight code (gcc 12, found there) drops the rounding of (double)(float)x: so loops only.
EXACT := -std=c11 -ffp-contract=off -fno-math-errno -fno-trapping-math -fno-tree-slp-vectorize
DEFINES := -D_POSIX_C_SOURCE=200809L
INCLUDES := -Iinclude -Isrc
OPENMP := -fopenmp
ISAS := baseline avx2 avx512

ifeq ($(CONFIG),release)
OPTIMISE := -O3 -g
else ifeq ($(CONFIG),debug)
OPTIMISE := -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
else ifeq ($(CONFIG),tsan)
OPTIMISE := -O1 -g -fsanitize=thread
DEFINES += -DSL_THREADS_WITHOUT_OPENMP
OPENMP :=
else ifeq ($(CONFIG),baseline)
OPTIMISE := -O2 -g
ISAS := baseline
DEFINES += -DSL_BASELINE_ONLY
else ifeq ($(CONFIG),fuzz)
OPTIMISE := -O1 -g -fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow -fno-sanitize-recover=all -fno-omit-frame-pointer
ISAS := baseline
DEFINES += -DSL_BASELINE_ONLY -DSL_THREADS_WITHOUT_OPENMP
OPENMP :=
else
$(error CONFIG is release, debug, tsan, baseline or fuzz, not '$(CONFIG)')
endif

FLAGS_baseline := -DSL_ISA_SUFFIX=baseline
FLAGS_avx2 := -DSL_ISA_SUFFIX=avx2 -march=x86-64-v3
FLAGS_avx512 := -DSL_ISA_SUFFIX=avx512 -march=x86-64-v4 -mprefer-vector-width=512
KERNEL_OPTIMISE := $(if $(filter release baseline,$(CONFIG)),-O3) -Wno-psabi # vectors are passed to inlined functions alone

PACKAGES := OpenEXR assimp libcjson libpng
PACKAGE_CFLAGS = $(shell pkg-config --cflags $(PACKAGES) 2>/dev/null)
PACKAGE_LIBS = $(shell pkg-config --libs-only-L libcjson libpng 2>/dev/null) -lOpenEXRCore -lcjson -lpng
IMPORT_LIBS = $(shell pkg-config --libs-only-L assimp 2>/dev/null) -lassimp -lm # of the program that imports mesh files, and of it alone
EMBREE := $(if $(wildcard /usr/include/embree4/rtcore.h /usr/local/include/embree4/rtcore.h),embree4,embree3)
DEFINES += $(if $(filter embree4,$(EMBREE)),-DSL_EMBREE4)

ALL_CFLAGS = $(EXACT) $(WARNINGS) $(OPTIMISE) $(OPENMP) $(DEFINES) $(INCLUDES) $(PACKAGE_CFLAGS) -fPIC \
             -fvisibility=hidden -MMD -MP $(CFLAGS)
LIBS = $(PACKAGE_LIBS) -l$(EMBREE) -lm -lpthread

# ---- sources -----------------------------------------------------------------------------------------------------

LIBRARY_SOURCES := $(filter-out src/app/% src/import/% %_kernels.c,$(wildcard src/*/*.c src/*/*/*.c src/*/*/*/*.c))
KERNEL_SOURCES := $(wildcard src/*/*_kernels.c src/*/*/*_kernels.c src/*/*/*/*_kernels.c)
IMPORT_SOURCES := $(wildcard src/import/*.c)
APP_SOURCES := $(wildcard src/app/*.c src/app/*/*.c)
TEST_SOURCES := $(wildcard tests/test_*.c)
BENCH_SOURCES := $(wildcard bench/bench_*.c)
GENERATE_SOURCES := $(wildcard scenes/generate/*.c)

LIBRARY_OBJECTS := $(LIBRARY_SOURCES:%.c=$(BUILD)/o/%.o) \
                   $(foreach isa,$(ISAS),$(KERNEL_SOURCES:%.c=$(BUILD)/o/%.$(isa).o))
APP_FILES := $(wildcard src/app/*/*.css src/app/*/*.js)
IMPORT_OBJECTS := $(IMPORT_SOURCES:%.c=$(BUILD)/o/%.o)
APP_OBJECTS := $(APP_SOURCES:%.c=$(BUILD)/o/%.o) $(APP_FILES:%=$(BUILD)/o/%.o)
TESTS := $(TEST_SOURCES:tests/%.c=$(BUILD)/tests/%)
BENCHES := $(BENCH_SOURCES:bench/%.c=$(BUILD)/bench/%)
HELPERS := $(patsubst tests/%.c,$(BUILD)/o/tests/%.o,$(filter-out tests/test_%.c tests/osmesa.c,$(wildcard tests/*.c)))
# Mesa's software OpenGL, which only tests/test_osmesa_* and bench/bench_raster* load: OSMesa, or EGL, or NONE (they skip).
OSMESA := $(if $(wildcard /usr/include/GL/osmesa.h),OSMESA,$(if $(wildcard /usr/include/EGL/eglext.h),EGL,NONE))
OSMESA_LIBS_OSMESA := -lOSMesa
OSMESA_LIBS_EGL := -lEGL -lGL
OSMESA_LIBS := $(OSMESA_LIBS_$(OSMESA))
OSMESA_HARNESS := $(BUILD)/o/tests/osmesa.$(OSMESA).o
RASTER_BENCH := $(patsubst %.c,$(BUILD)/o/%.o,$(filter-out %_kernels.c,$(wildcard bench/raster_*.c))) \
                $(foreach isa,$(ISAS),$(BUILD)/o/bench/raster_bench_kernels.$(isa).o)

.PHONY: all demo check check-all fuzz fuzz-targets test golden scenes bench report auto-table bench-raster bench-splatting bench-direct-radiance bench-light-octree bench-multi-mesh bench-shading-cache install uninstall doc lessons clean help setup
.DELETE_ON_ERROR:
.SECONDARY:

all: $(BUILD)/softlux $(BUILD)/softlux-import $(BUILD)/libsoftlux.a $(BUILD)/libsoftlux.so

$(BUILD)/softlux: $(APP_OBJECTS) $(BUILD)/libsoftlux.a
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) $(LIBS)

$(BUILD)/softlux-import: $(IMPORT_OBJECTS) $(BUILD)/libsoftlux.a
	$(CC) $(OPTIMISE) -o $@ $^ $(LDFLAGS) $(IMPORT_LIBS)

# Where the library looks for that program: here, or where it is installed, which the installed library has another object for.
$(BUILD)/o/src/scene/importer_path.o: override DEFINES += -DSL_IMPORTER='"$(abspath $(BUILD))/softlux-import"'

$(BUILD)/libsoftlux.a: $(LIBRARY_OBJECTS)
	@rm -f $@
	$(AR) rcs $@ $^

$(BUILD)/libsoftlux.so: $(LIBRARY_OBJECTS)
	$(CC) $(OPTIMISE) $(OPENMP) -shared -Wl,--no-undefined -Wl,-soname,libsoftlux.so.0 -o $@ $^ $(LDFLAGS) $(LIBS)
	@ln -sf libsoftlux.so $(BUILD)/libsoftlux.so.0

# stb_image's integers overflow in damaged JPEGs; this makes that defined.
$(BUILD)/o/src/image/stb_image.o: override CFLAGS += -fwrapv -fno-sanitize=shift

$(BUILD)/o/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) -c $< -o $@

# What pages hold, as it stands: symbols are named after the path.
$(APP_FILES:%=$(BUILD)/o/%.o): $(BUILD)/o/%.o: %
	@mkdir -p $(@D)
	$(LD) -r -b binary -z noexecstack -o $@ $<

$(OSMESA_HARNESS): tests/osmesa.c
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) -DSL_HAVE_$(OSMESA) -c $< -o $@

define kernel_rule
$(BUILD)/o/%.$(1).o: %.c
	@mkdir -p $$(@D)
	$$(CC) $$(ALL_CFLAGS) $$(KERNEL_OPTIMISE) $$(FLAGS_$(1)) -c $$< -o $$@
endef
$(foreach isa,$(ISAS),$(eval $(call kernel_rule,$(isa))))

$(BUILD)/softlux $(TESTS) $(BENCHES): | $(BUILD)/softlux-import

$(BUILD)/tests/%: $(BUILD)/o/tests/%.o $(HELPERS) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) -lcmocka $(LIBS)

$(BUILD)/tests/test_osmesa_%: $(BUILD)/o/tests/test_osmesa_%.o $(OSMESA_HARNESS) $(HELPERS) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) -lcmocka $(LIBS) $(OSMESA_LIBS)

$(BUILD)/bench/bench_raster: $(BUILD)/o/bench/bench_raster.o $(RASTER_BENCH) $(OSMESA_HARNESS) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) -lcmocka $(LIBS) $(OSMESA_LIBS)

GATHER_BENCH := $(patsubst %.c,$(BUILD)/o/%.o,$(wildcard bench/gather_*.c))
$(BUILD)/bench/bench_gather: $(BUILD)/o/bench/bench_gather.o $(GATHER_BENCH) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) $(LIBS)

SPLAT_BENCHES := $(patsubst bench/%.c,$(BUILD)/bench/%,$(wildcard bench/bench_table*.c bench/bench_glossy.c bench/bench_walk.c bench/bench_curve.c bench/bench_half.c))
COMMON_BENCH := $(patsubst %.c,$(BUILD)/o/%.o,$(wildcard bench/common_*.c))
SPLAT_BENCH := $(patsubst %.c,$(BUILD)/o/%.o,$(wildcard bench/splat_*.c)) $(COMMON_BENCH)
$(SPLAT_BENCHES): $(BUILD)/bench/%: $(BUILD)/o/bench/%.o $(SPLAT_BENCH) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) $(LIBS)

DRM_BENCHES := $(patsubst bench/%.c,$(BUILD)/bench/%,$(wildcard bench/bench_drm_*.c))
DRM_BENCH := $(BUILD)/o/bench/drm_run.o $(COMMON_BENCH)
$(filter-out %table1,$(DRM_BENCHES)): $(BUILD)/bench/%: $(BUILD)/o/bench/%.o $(DRM_BENCH) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) $(LIBS)
$(BUILD)/bench/bench_drm_table1: $(BUILD)/o/bench/bench_drm_table1.o $(DRM_BENCH) $(BUILD)/o/bench/drm_osmesa.o $(BUILD)/o/bench/raster_osmesa.o \
                                 $(OSMESA_HARNESS) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) $(LIBS) $(OSMESA_LIBS)

# Tests of the program from inside.
PROGRAM_TESTS := $(filter $(BUILD)/tests/test_bench_% $(BUILD)/tests/test_program_%,$(TESTS))
$(PROGRAM_TESTS): $(BUILD)/tests/%: $(BUILD)/o/tests/%.o $(filter-out %/main.o,$(APP_OBJECTS)) $(HELPERS) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) -lcmocka $(LIBS)

# In it Assimp's part is played by one of its own.
$(BUILD)/tests/test_import_process: $(BUILD)/o/tests/test_import_process.o $(filter-out %/main.o,$(IMPORT_OBJECTS)) $(HELPERS) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) -lcmocka $(LIBS) $(IMPORT_LIBS)

# The rival in the experiments on the shading cache is held to what it promises, too.
$(BUILD)/tests/test_render_cache: $(BUILD)/o/tests/test_render_cache.o $(BUILD)/o/bench/render_cache.o $(HELPERS) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) -lcmocka $(LIBS)

SHADING_BENCHES := $(patsubst bench/%.c,$(BUILD)/bench/%,$(wildcard bench/bench_shading_*.c))
SHADING_BENCH := $(BUILD)/o/bench/shading_run.o $(BUILD)/o/bench/render_cache.o $(COMMON_BENCH)
$(SHADING_BENCHES): $(BUILD)/bench/%: $(BUILD)/o/bench/%.o $(SHADING_BENCH) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) $(LIBS)

OCTREE_BENCHES := $(patsubst bench/%.c,$(BUILD)/bench/%,$(wildcard bench/bench_octree_*.c))
OCTREE_BENCH := $(patsubst %.c,$(BUILD)/o/%.o,$(wildcard bench/octree_*.c)) $(COMMON_BENCH)
$(OCTREE_BENCHES): $(BUILD)/bench/%: $(BUILD)/o/bench/%.o $(OCTREE_BENCH) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) $(LIBS)

MESH_BENCHES := $(patsubst bench/%.c,$(BUILD)/bench/%,$(wildcard bench/bench_mesh_*.c))
MESH_BENCH := $(patsubst %.c,$(BUILD)/o/%.o,$(wildcard bench/mesh_*.c)) $(COMMON_BENCH)
$(MESH_BENCHES): $(BUILD)/bench/%: $(BUILD)/o/bench/%.o $(MESH_BENCH) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) $(LIBS)

$(BUILD)/bench/bench_light_sample: $(BUILD)/o/bench/bench_light_sample.o $(COMMON_BENCH) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) $(LIBS)

# Makes src/app/auto_table.h (`make auto-table`), so it takes of the program what does not read that.
AUTO_BENCH := $(patsubst %,$(BUILD)/o/src/app/%.o,auto_choice bench/curves bench/results)
$(BUILD)/bench/bench_auto: $(BUILD)/o/bench/bench_auto.o $(AUTO_BENCH) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) $(LIBS)

$(BUILD)/bench/%: $(BUILD)/o/bench/%.o $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(OPTIMISE) $(OPENMP) -o $@ $^ $(LDFLAGS) $(LIBS)

# Fuzzing's targets: with libFuzzer where CONFIG=fuzz, else with a main() that replays files.
FUZZ_TARGETS := $(patsubst tests/fuzz/target_%.c,%,$(wildcard tests/fuzz/target_*.c))
FUZZ_DRIVER := $(if $(filter fuzz,$(CONFIG)),,$(BUILD)/o/tests/fuzz/replay.o)
FUZZ_APP_command_line := $(filter-out %/main.o,$(APP_OBJECTS))
FUZZ_MUTATOR_scene_file := $(if $(filter fuzz,$(CONFIG)),$(BUILD)/o/tests/fuzz/json_mutator.o)
$(FUZZ_TARGETS:%=$(BUILD)/fuzz/%): | $(BUILD)/softlux-import
.SECONDEXPANSION:
$(FUZZ_TARGETS:%=$(BUILD)/fuzz/%): $(BUILD)/fuzz/%: $(BUILD)/o/tests/fuzz/target_%.o $(BUILD)/o/tests/fuzz/support.o $(FUZZ_DRIVER) $$(FUZZ_APP_$$*) $$(FUZZ_MUTATOR_$$*) $(BUILD)/libsoftlux.a
	@mkdir -p $(@D)
	$(CC) $(subst fuzzer-no-link,fuzzer,$(OPTIMISE)) $(OPENMP) -o $@ $^ $(LDFLAGS) $(LIBS)

# Stands alone: of the library it takes the elementary functions only, so that its files are the same everywhere.
$(BUILD)/generate: $(BUILD)/o/scenes/generate.o $(GENERATE_SOURCES:%.c=$(BUILD)/o/%.o) $(BUILD)/o/src/base/math.o
	$(CC) $(OPTIMISE) -o $@ $^ -lm

-include $(shell find $(BUILD)/o -name '*.d' 2>/dev/null)

# ---- what a person asks for ----------------------------------------------------------------------------------------

setup:
	@./setup.sh

demo:
	@./setup.sh --build-only
	@$(MAKE) --no-print-directory -j$$(nproc) all
	@./demo.sh $(BUILD)

check: setup
	@./tests/check.sh

# The tests of this configuration alone.
test: all $(TESTS) $(BUILD)/generate
	@./tests/run.sh $(BUILD)

fuzz-targets: $(FUZZ_TARGETS:%=$(BUILD)/fuzz/%)

# Tries inputs that nobody wrote on every target, FUZZ_SECONDS each (FUZZ_TARGETS: which).
fuzz:
	@tests/fuzz/fuzz.sh $(or $(FUZZ_SECONDS),60) $(FUZZ_TARGETS)

# What `make check` does, and all that takes longer.
check-all: setup
	@tests/check-all.sh

# Writes the golden images of the tests anew; look at them before committing.
golden: $(BUILD)/tests/test_golden_passes
	@mkdir -p tests/golden && rm -f tests/golden/*.exr
	SOFTLUX_UPDATE_GOLDEN=1 $(BUILD)/tests/test_golden_passes

# The lessons' pictures anew, likewise.
lessons: all
	@./tests/lessons.sh $(BUILD) --update

scenes: $(BUILD)/generate
	@$(BUILD)/generate scenes/generated

bench: all $(BENCHES)
	@./bench/run.sh $(BUILD)

# Every method on many scenes: docs/report/, and build/report/report.html (bench/report.sh says what can be chosen). Interrupted, it goes on.
report: all $(BUILD)/generate
	@./bench/report.sh $(BUILD)

# What --method auto knows, from the report's measurements; the program is then to be made again.
auto-table: $(BUILD)/bench/bench_auto
	@$(BUILD)/bench/bench_auto docs/report >$(BUILD)/auto_table.h && mv $(BUILD)/auto_table.h src/app/auto_table.h
	@$(BUILD)/bench/bench_auto --judge docs/report >docs/report/auto.md
	@bench/fill_tables.sh docs/report/auto.md docs/error-estimates.md

bench-raster: $(BUILD)/bench/bench_raster
	@[ -f scenes/generated/figure.json ] || $(MAKE) --no-print-directory scenes
	@$(BUILD)/bench/bench_raster

# The five experiments on radiance cache splatting (docs/splatting-experiments.md). BRIEF=1: small, to see that all works.
bench-splatting: all $(SPLAT_BENCHES)
	@./bench/splatting.sh $(BUILD) $(if $(BRIEF),--brief)

# The three on direct radiance mapping (docs/direct-radiance-experiments.md), beside OSMesa.
bench-direct-radiance: all $(DRM_BENCHES)
	@./bench/direct_radiance.sh $(BUILD) $(if $(BRIEF),--brief)

# Those on the light octree (docs/light-octree-experiments.md).
bench-light-octree: all $(OCTREE_BENCHES)
	@./bench/light_octree.sh $(BUILD) $(if $(BRIEF),--brief)

# Those on multi-mesh caching (docs/multi-mesh-experiments.md).
bench-multi-mesh: all $(MESH_BENCHES) $(BUILD)/bench/bench_light_sample
	@./bench/multi_mesh.sh $(BUILD) $(if $(BRIEF),--brief)

# Those on the shading cache (docs/shading-cache-experiments.md).
bench-shading-cache: all $(SHADING_BENCHES)
	@./bench/shading_cache.sh $(BUILD) $(if $(BRIEF),--brief)

# ---- installing ------------------------------------------------------------------------------------------------------

VERSION := $(shell sed -n 's/^.define SL_VERSION "\(.*\)"/\1/p' include/softlux.h)
COMMANDS = $(shell $(BUILD)/softlux --help | sed -n '/^commands:/,/^$$/s/^  \([a-z-]*\) .*/\1/p')

# What is installed is linked anew, with an object that says where softlux-import then is.
STAGE := $(BUILD)/install
PATH_OBJECT := $(BUILD)/o/src/scene/importer_path.o

install: all
	@mkdir -p $(STAGE)
	$(CC) $(ALL_CFLAGS) -DSL_IMPORTER='"$(LIBEXECDIR)/softlux-import"' -c src/scene/importer_path.c -o $(STAGE)/importer_path.o
	cp $(BUILD)/libsoftlux.a $(STAGE)/libsoftlux.a && $(AR) rs $(STAGE)/libsoftlux.a $(STAGE)/importer_path.o
	$(CC) $(OPTIMISE) $(OPENMP) -o $(STAGE)/softlux $(APP_OBJECTS) $(STAGE)/libsoftlux.a $(LDFLAGS) $(LIBS)
	$(CC) $(OPTIMISE) $(OPENMP) -shared -Wl,--no-undefined -Wl,-soname,libsoftlux.so.0 -o $(STAGE)/libsoftlux.so \
	  $(filter-out $(PATH_OBJECT),$(LIBRARY_OBJECTS)) $(STAGE)/importer_path.o $(LDFLAGS) $(LIBS)
	install -d $(DESTDIR)$(PREFIX)/bin $(DESTDIR)$(LIBEXECDIR) $(DESTDIR)$(LIBDIR)/pkgconfig $(DESTDIR)$(PREFIX)/include $(DESTDIR)$(MANDIR)/man1 $(DESTDIR)$(DOCDIR)
	install -m 644 LICENSE NOTICES CHANGELOG.md $(DESTDIR)$(DOCDIR)
	install -m 755 $(STAGE)/softlux $(DESTDIR)$(PREFIX)/bin/softlux
	install -m 755 $(BUILD)/softlux-import $(DESTDIR)$(LIBEXECDIR)/softlux-import
	install -m 644 include/softlux.h $(DESTDIR)$(PREFIX)/include/softlux.h
	install -m 644 $(STAGE)/libsoftlux.a $(DESTDIR)$(LIBDIR)/libsoftlux.a
	install -m 755 $(STAGE)/libsoftlux.so $(DESTDIR)$(LIBDIR)/libsoftlux.so.$(VERSION)
	ln -sf libsoftlux.so.$(VERSION) $(DESTDIR)$(LIBDIR)/libsoftlux.so.$(firstword $(subst ., ,$(VERSION)))
	ln -sf libsoftlux.so.$(firstword $(subst ., ,$(VERSION))) $(DESTDIR)$(LIBDIR)/libsoftlux.so
	sed 's|@PREFIX@|$(PREFIX)|; s|@LIBDIR@|$(LIBDIR)|; s|@VERSION@|$(VERSION)|; s|@LIBS@|$(LIBS) $(OPENMP)|' packaging/softlux.pc.in \
	  > $(DESTDIR)$(LIBDIR)/pkgconfig/softlux.pc
	$(BUILD)/softlux --man > $(DESTDIR)$(MANDIR)/man1/softlux.1
	for c in $(COMMANDS); do $(BUILD)/softlux $$c --man > $(DESTDIR)$(MANDIR)/man1/softlux-$$c.1 || exit; done

uninstall:
	rm -f $(DESTDIR)$(PREFIX)/bin/softlux $(DESTDIR)$(LIBEXECDIR)/softlux-import $(DESTDIR)$(PREFIX)/include/softlux.h $(DESTDIR)$(LIBDIR)/libsoftlux.* \
	  $(DESTDIR)$(LIBDIR)/pkgconfig/softlux.pc $(DESTDIR)$(MANDIR)/man1/softlux.1 $(DESTDIR)$(MANDIR)/man1/softlux-*.1
	rm -rf $(DESTDIR)$(DOCDIR)

# The contract of every public function as pages, into build/doc/html; a warning is a failure.
doc:
	@mkdir -p $(BUILD)/doc
	@(cat packaging/Doxyfile; echo 'OUTPUT_DIRECTORY = $(BUILD)/doc'; echo 'PROJECT_NUMBER = $(VERSION)'; echo 'WARN_AS_ERROR = FAIL_ON_WARNINGS') | doxygen -

clean:
	rm -rf build scenes/generated

help:
	@echo 'make            build/softlux, build/softlux-import, build/libsoftlux.a and build/libsoftlux.so'
	@echo 'make demo       install what is missing, build, render a scene and print its error'
	@echo 'make check      install what is missing, build, run all tests'
	@echo 'make check-all  that, and what takes longer: two hours on two cores'
	@echo 'make fuzz       inputs that nobody wrote, FUZZ_SECONDS=60 for each of FUZZ_TARGETS; wants clang with its libFuzzer'
	@echo 'make test       build and run the tests of one configuration'
	@echo 'make golden     write the golden images of the tests anew'
	@echo 'make scenes     generate the larger scenes into scenes/generated/'
	@echo 'make bench      speed against error; make bench-raster: the rasterizer beside OSMesa and rays'
	@echo 'make report     speed against error of every method on many scenes, into docs/report/'
	@echo 'make auto-table what --method auto knows, anew from docs/report/'
	@echo 'make bench-splatting  the experiments on radiance cache splatting; BRIEF=1: a short form'
	@echo 'make bench-direct-radiance  those on direct radiance mapping'
	@echo 'make bench-light-octree  those on the light octree'
	@echo 'make bench-multi-mesh  those on multi-mesh caching'
	@echo 'make bench-shading-cache  those on the shading cache, beside a RenderCache'
	@echo 'make install    into PREFIX (default /usr/local), DESTDIR respected; make uninstall removes'
	@echo 'make lessons    the pictures of docs/lessons anew'
	@echo 'make doc        the public header as pages, into build/doc/html'
	@echo 'make clean      remove what was built and generated'
	@echo
	@echo 'CONFIG=release|debug|tsan|baseline|fuzz, CC=gcc|clang; CFLAGS and LDFLAGS are added last.'
