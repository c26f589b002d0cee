# How tests, benchmarks and fuzzing's targets are built.
# gcc 12 for Arm fails at fmax() in loops over floats: tests may have them, sources do without.
# Tests are functions of a state that few of them use.
$(BUILD)/o/tests/% $(BUILD)/o/bench/%: override DEFINES += -I. -Itests/support -Wno-unused-parameter \
  $(if $(filter gcc-12-aarch64-%,$(COMPILER)-$(TARGET)),-fno-tree-loop-vectorize)
$(BUILD)/o/tests/support/osmesa.o: override DEFINES += -DSL_HAVE_$(OSMESA)

$(foreach s,$(TEST_SOURCES),$(eval $(BUILD)/tests/$(basename $(notdir $(s))): $(s:%.c=$(BUILD)/o/%.o)))
$(TESTS) $(BENCHES) $(FUZZERS): $(PARTS) $(BUILD)/libsoftlux.a | $(BUILD)/softlux-import
$(BENCHES): $(BUILD)/bench/%: $(BUILD)/o/bench/%.o
$(FUZZERS): $(BUILD)/fuzz/%: $(BUILD)/o/tests/fuzz/target_%.o $(BUILD)/o/tests/fuzz/support.o
# Fuzzing's targets have libFuzzer where CONFIG=fuzz, else a main() that replays files.
ifeq ($(CONFIG),fuzz)
$(FUZZERS): override OPTIMISE := $(subst fuzzer-no-link,fuzzer,$(OPTIMISE_fuzz))
$(BUILD)/fuzz/scene_file: $(BUILD)/o/tests/fuzz/json_mutator.o
else
$(FUZZERS): $(BUILD)/o/tests/fuzz/replay.o
endif

$(TESTS) $(BENCHES) $(FUZZERS):
	$(link) -Wl,--as-needed -lcmocka $(LIBS) $(IMPORT_LIBS) $(SERVE_LIBS) $(OSMESA_LIBS)
