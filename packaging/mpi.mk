# The same program on many ranks, with MPI=1 (Open MPI's libopenmpi-dev).
MPI_OBJECTS := $(patsubst %.c,$(BUILD)/o/%.o,$(wildcard src/mpi/*.c) bench/ranks/batch_log.c)
REPLAY_OBJECTS := $(BUILD)/o/bench/ranks/replay.o $(filter %/ranks.o %/journal.o,$(MPI_OBJECTS))
$(MPI_OBJECTS) $(REPLAY_OBJECTS): override CFLAGS += $(shell pkg-config --cflags ompi-c)
$(BUILD)/o/src/mpi/program.o: src/app/main.c
	$(compile) -Dmain=sl_program_main -c $< -o $@
$(BUILD)/softlux-mpi: $(MPI_OBJECTS) $(BUILD)/o/src/mpi/program.o $(filter-out %/app/main.o,$(APP_OBJECTS)) \
                      $(filter-out %/ranks_alone.o,$(LIBRARY_OBJECTS))
	$(link) -Wl,--wrap=sl_batch_run,--wrap=sl_ranks_share $(LIBS) $(SERVE_LIBS) $(shell pkg-config --libs ompi-c)
# For bench/ranks.py --network
$(BUILD)/ranks-replay: $(REPLAY_OBJECTS) $(BUILD)/libsoftlux.a
	$(link) $(LIBS) $(shell pkg-config --libs ompi-c)
