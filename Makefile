# softlux. `make help` lists what can be made; V=1 shows every command.
#   CONFIG=release (default)  optimised
#   CONFIG=debug              address and undefined-behaviour sanitizers
#   CONFIG=tsan               thread sanitizer (clang)
#   CONFIG=baseline           without the multiversioned loops
#   CONFIG=fuzz               for the fuzzer: sanitizers and coverage (clang)
#   CONFIG=arm64              for 64-bit Arm, by a cross compiler; `make sysroot-arm64` gets the libraries
# Each configuration and compiler has its own folder: build/ for the default, build/CONFIG[-clang] otherwise.
CONFIG ?= release
.DEFAULT_GOAL := all
include packaging/cross.mk
COMPILER := $(if $(findstring clang,$(CC)),clang,gcc)
CONFIGURED := $(CONFIG)$(if $(filter clang,$(COMPILER)),-clang)
BUILD ?= build$(if $(filter-out release,$(CONFIGURED)),/$(CONFIGURED))
silent := $(findstring s,$(filter-out --%,$(firstword $(MAKEFLAGS))))
# Shows a short line for a command; V=1 the command itself, make -s neither.
run = $(if $(V),,@$(if $(silent),,echo '$(1) $(2:$(BUILD)/%=%)' &&))

# ---- flags -----------------------------------------------------------------------------------------------

WARNINGS := -Wall -Wextra -Wconversion -Wshadow
# The determinism contract: no contraction, no fast-math. -fno-math-errno, -fno-trapping-math change no value.
# The vectorizer of straight code in gcc 12 drops the rounding of (double)(float)x: loops only.
EXACT := -std=c11 -ffp-contract=off -fno-math-errno -fno-trapping-math -fno-tree-slp-vectorize
DEFINES := -D_POSIX_C_SOURCE=200809L
OPENMP := -fopenmp
ISAS := baseline avx2 avx512

SANITIZE := -O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined
OPTIMISE_release := -O3 -g
OPTIMISE_arm64 := -O3 -g
OPTIMISE_baseline := -O2 -g
OPTIMISE_debug := $(SANITIZE) -fno-sanitize-recover=undefined
OPTIMISE_tsan := -O1 -g -fsanitize=thread
OPTIMISE_fuzz := $(SANITIZE),fuzzer-no-link,float-cast-overflow -fno-sanitize-recover=all
OPTIMISE := $(or $(OPTIMISE_$(CONFIG)),$(error CONFIG=$(CONFIG): release, debug, tsan, baseline, fuzz or arm64))
TARGET := $(shell $(CC) -dumpversion)-$(shell $(CC) -dumpmachine)
ifneq ($(filter baseline fuzz,$(CONFIG))$(if $(findstring -x86_64-,$(TARGET)),,other),)
ISAS := baseline
DEFINES += -DSL_BASELINE_ONLY
endif
ifneq ($(filter tsan fuzz,$(CONFIG)),)
OPENMP :=
DEFINES += -DSL_THREADS_WITHOUT_OPENMP
endif

FLAGS_baseline := -DSL_ISA_SUFFIX=baseline
FLAGS_avx2 := -DSL_ISA_SUFFIX=avx2 -march=x86-64-v3
FLAGS_avx512 := -DSL_ISA_SUFFIX=avx512 -march=x86-64-v4 -mprefer-vector-width=512
# Vectors are passed to inlined functions alone, so that their passing does not matter.
KERNEL_OPTIMISE := $(if $(filter release baseline arm64,$(CONFIG)),-O3) -Wno-psabi

header = $(wildcard $(SYSROOT)/usr/include/$(1) $(SYSROOT)/usr/local/include/$(1))
PACKAGE_CFLAGS = $(shell pkg-config --cflags OpenEXR assimp libcjson libpng 2>/dev/null)
LIBS = $(shell pkg-config --libs-only-L libcjson libpng 2>/dev/null) \
       -lOpenEXRCore -lcjson -lpng -l$(EMBREE) -lm -lpthread
# Of the program that imports mesh files, and of it alone.
IMPORT_LIBS = $(shell pkg-config --libs-only-L assimp 2>/dev/null) -lassimp -lm
EMBREE := $(if $(call header,embree4/rtcore.h),embree4,embree3)
DEFINES += $(if $(filter embree4,$(EMBREE)),-DSL_EMBREE4)
# What `softlux serve` speaks, and the pictures that it sends while things move; without them it says so, or sends PNG.
WEBSOCKETS := $(if $(call header,libwebsockets.h),-lwebsockets)
JPEG := $(if $(call header,jpeglib.h),-ljpeg)
SERVE_LIBS := $(WEBSOCKETS) $(JPEG)
DEFINES += $(if $(WEBSOCKETS),-DSL_HAVE_WEBSOCKETS) $(if $(JPEG),-DSL_HAVE_JPEG)
# Mesa's software OpenGL, which only tests and benchmarks of the rasterizer load; without it they skip.
OSMESA := $(if $(call header,GL/osmesa.h),OSMESA,$(if $(call header,EGL/eglext.h),EGL,NONE))
OSMESA_LIBS := $(if $(filter OSMESA,$(OSMESA)),-lOSMesa)$(if $(filter EGL,$(OSMESA)),-lEGL -lGL)

ALL_CFLAGS = $(EXACT) $(WARNINGS) $(OPTIMISE) $(OPENMP) $(DEFINES) -Iinclude -Isrc $(PACKAGE_CFLAGS) -fPIC \
             -fvisibility=hidden -MMD -MP $(CFLAGS)

# ---- sources ---------------------------------------------------------------------------------------------

sources = $(foreach depth,* */* */*/* */*/*/*,$(wildcard $(1)/$(depth).c))
objects = $(patsubst %.c,$(BUILD)/o/%.o,$(filter-out %_kernels.c,$(1))) \
          $(foreach isa,$(ISAS),$(patsubst %.c,$(BUILD)/o/%.$(isa).o,$(filter %_kernels.c,$(1))))

SOURCES := $(filter-out src/mpi/% $(if $(WEBSOCKETS),,src/app/serve/network.c),$(call sources,src))
APP_FILES := $(foreach kind,html css js svg json trials,$(wildcard src/app/*/*.$(kind) src/app/serve/page/*.$(kind)))
APP_OBJECTS := $(call objects,$(filter src/app/%,$(SOURCES))) $(APP_FILES:%=$(BUILD)/o/%.o) \
               $(BUILD)/o/src/app/serve/sources.json.o
IMPORT_OBJECTS := $(call objects,$(filter src/import/%,$(SOURCES)))
LIBRARY_OBJECTS := $(call objects,$(filter-out src/app/% src/import/%,$(SOURCES)))

TEST_SOURCES := $(shell find tests -name 'test_*.c' | sort)
TESTS := $(patsubst %.c,$(BUILD)/tests/%,$(notdir $(TEST_SOURCES)))
BENCH_SOURCES := $(wildcard bench/bench_*.c)
BENCHES := $(BENCH_SOURCES:%.c=$(BUILD)/%)
FUZZERS := $(patsubst tests/fuzz/target_%.c,$(BUILD)/fuzz/%,$(wildcard tests/fuzz/target_*.c))
# Tests, benchmarks and fuzzing also link what several of them use, and the insides of both programs.
SHARED_SOURCES := $(filter-out $(TEST_SOURCES) $(BENCH_SOURCES) tests/fuzz/%,\
                  $(call sources,tests) $(wildcard bench/*.c))
PARTS := $(BUILD)/libparts.a
PARTS_OBJECTS := $(call objects,$(SHARED_SOURCES)) $(filter-out %/main.o,$(APP_OBJECTS) $(IMPORT_OBJECTS))

.PHONY: all setup demo check check-all test conformance fuzz-targets fuzz golden lessons scenes bench report \
        clean help sysroot-arm64
.DELETE_ON_ERROR .SECONDARY:

# ---- what is built ---------------------------------------------------------------------------------------
link = $(call run,LD,$@) mkdir -p $(@D) && \
       $(CC) $(OPTIMISE) $(OPENMP) -o $@ $(filter %.o,$^) $(filter %.a,$^) $(LDFLAGS)
compile = $(call run,CC,$<) mkdir -p $(@D) && $(CC) $(ALL_CFLAGS)
archive = $(call run,AR,$@) rm -f $@ && $(AR) rcs $@ $^

all: $(if $(MPI),$(BUILD)/softlux-mpi) $(BUILD)/softlux $(BUILD)/softlux-import $(BUILD)/libsoftlux.a \
     $(BUILD)/libsoftlux.so

$(BUILD)/softlux: $(APP_OBJECTS) $(BUILD)/libsoftlux.a
	$(link) $(LIBS) $(SERVE_LIBS)

$(BUILD)/softlux-import: $(IMPORT_OBJECTS) $(BUILD)/libsoftlux.a
	$(link) -Wl,--as-needed $(LIBS) $(IMPORT_LIBS)

$(BUILD)/libsoftlux.a: $(LIBRARY_OBJECTS)
	$(archive)

# Stays in memory once it is loaded: OpenMP's threads outlive calls, and their code must not go.
SHARED = -shared -Wl,--no-undefined,-z,nodelete,-soname,libsoftlux.so.$(MAJOR)
$(BUILD)/libsoftlux.so: $(LIBRARY_OBJECTS)
	$(link) $(SHARED) $(LIBS)
	@ln -sf libsoftlux.so $(BUILD)/libsoftlux.so.$(MAJOR)

$(PARTS): $(PARTS_OBJECTS)
	$(archive)

$(BUILD)/o/%.o: %.c
	$(compile) -c $< -o $@

define kernel_rule
$(BUILD)/o/%.$(1).o: %.c
	$$(compile) $$(KERNEL_OPTIMISE) $$(FLAGS_$(1)) -c $$< -o $$@
endef
$(foreach isa,$(ISAS),$(eval $(call kernel_rule,$(isa))))

# Pages' files as they stand: symbols are named after the path.
$(APP_FILES:%=$(BUILD)/o/%.o): $(BUILD)/o/%.o: %
	@mkdir -p $(@D)
	@$(LD) -r -b binary -z noexecstack -o $@ $<

# The functions that pages name, as they stand in the sources.
$(BUILD)/sources.json: src/app/serve/sources.sh src/app/steps/narratives.json $(SOURCES)
	@mkdir -p $(@D) && $< >$@
$(BUILD)/o/src/app/serve/sources.json.o: $(BUILD)/sources.json
	@mkdir -p $(@D)
	@cd $(BUILD) && $(LD) -r -b binary -z noexecstack -o o/src/app/serve/sources.json.o sources.json

# Where the library looks for softlux-import: here, or where it is installed (packaging/install.mk).
$(BUILD)/o/src/scene/importer_path.o: override DEFINES += -DSL_IMPORTER='"$(abspath $(BUILD))/softlux-import"'
# stb_image's integers overflow in damaged JPEGs; this makes that defined.
$(BUILD)/o/src/image/stb_image.o: override CFLAGS += -fwrapv -fno-sanitize=shift
include packaging/mpi.mk tests/build.mk

# Takes only the elementary functions of the library, so that its files are the same everywhere.
$(BUILD)/generate: $(call objects,scenes/generate.c $(wildcard scenes/generate/*.c) src/base/math.c)
	$(link) -lm

-include $(shell find $(BUILD)/o -name '*.d' 2>/dev/null)

# ---- what a person asks for ------------------------------------------------------------------------------

setup: ## install what is missing
	@./setup.sh
demo: ## install what is missing, build, render a scene and print its error
	@./setup.sh --build-only && $(MAKE) --no-print-directory -j$$(nproc) all && ./demo.sh $(BUILD)
check: setup ## install what is missing, build, run all tests
	@./tests/check.sh
check-all: setup ## that, and the tests that take longer: two hours on two cores
	@tests/check-all.sh
test: all $(TESTS) $(BUILD)/generate ## build and run the tests of one configuration
	@./tests/run.sh $(BUILD)
conformance: $(filter $(BUILD)/tests/test_osmesa_%,$(TESTS)) $(BUILD)/generate ## what methods draw beside OSMesa
	@tests/conformance.sh $(BUILD)
fuzz-targets: $(FUZZERS)
fuzz: ## try inputs that nobody wrote, FUZZ_SECONDS=60 for each of FUZZ_TARGETS (clang with libFuzzer)
	@tests/fuzz/fuzz.sh $(or $(FUZZ_SECONDS),60) $(FUZZ_TARGETS)
golden: $(BUILD)/tests/test_golden_passes ## write the golden images of the tests anew
	@mkdir -p tests/golden && rm -f tests/golden/*.exr && SOFTLUX_UPDATE_GOLDEN=1 $<
lessons: all ## write the pictures of docs/lessons anew
	@./tests/lessons.sh $(BUILD) --update
scenes: $(BUILD)/generate ## generate the larger scenes into scenes/generated/
	@$(BUILD)/generate scenes/generated
bench: all scenes $(BENCHES) ## speed against error
	@$(BUILD)/softlux bench scenes/cornell.json scenes/generated/atrium.json -o $(BUILD)/report
	@$(BUILD)/bench/bench_raster
bench-%: all $(BENCHES) ## the experiments of docs/METHOD-experiments.md; BRIEF=1: a short form
	@./bench/experiments.sh $* $(BUILD) $(if $(BRIEF),--brief)
report: all $(BUILD)/generate ## speed against error, every method on many scenes: docs/report/
	@./bench/report.sh $(BUILD)
clean: ## remove what was built and generated
	rm -rf build scenes/generated
help:
	@echo 'make            both programs and both libraries, in build/'
	@sed -n 's/^\([a-z0-9%-]*\):[^#]*## \(.*\)/make \1@\2/p' Makefile packaging/*.mk | \
	  while IFS=@ read -r target text; do printf '%-15s %s\n' "$$target" "$$text"; done
	@echo 'CONFIG=release|debug|tsan|baseline|fuzz|arm64, CC=gcc|clang; CFLAGS, LDFLAGS are added last; V=1 shows all.'
include packaging/install.mk
