#!/bin/sh
# All that `make check` runs, each step on its own line; ends with "N passed, N failed".
show='/^skip\|cases,/p' failed_lines=60
. "$(dirname "$0")/steps.sh"

build_and_test() { # build_and_test BUILD "MAKE ARGUMENTS" [TEST ...]
    build=$1 arguments=$2
    shift 2
    targets=
    for t in "$@"; do targets="$targets $build/tests/$t"; done
    # shellcheck disable=SC2086
    if [ $# -eq 0 ]; then
        make -s -j"$jobs" $arguments BUILD="$build" test
    else
        make -s -j"$jobs" $arguments BUILD="$build" $targets && tests/run.sh "$build" "$@"
    fi
}

# Warnings are errors here and only here: a newer compiler's new warning does not keep a user from building.
step 'release, gcc: all tests' build_and_test build 'CC=gcc CFLAGS=-Werror'
step 'the program: usage, exit statuses, files' tests/program.sh build/softlux
step 'benchmarks: build' sh -c 'make -s -j"$1" CC=gcc CFLAGS=-Werror $(ls bench/bench_*.c | sed "s|^|build/|; s|\.c\$||")' sh "$jobs"
step 'release, clang: builds without warnings' make -s -j"$jobs" CC=clang CFLAGS=-Werror all
step 'baseline, gcc: builds' make -s -j"$jobs" CONFIG=baseline all
step 'same bits: threads, compilers, instruction sets' tests/same_bits.sh
step 'same bits on several ranks' tests/ranks.sh build
step 'same bits on other processors, by an emulator: short form' tests/hard/other_processors.sh build --brief
step 'address and undefined-behaviour sanitizers' build_and_test build/debug CONFIG=debug \
    $(find tests -name 'test_*.c' | sort | sed 's|.*/||;s|\.c$||' | grep -v '_reference$\|_truth$\|_gradients$\|_draw_lists$')
step 'inputs that fuzzing found or began with' sh -c 'make -s -j"$1" CONFIG=debug BUILD=build/debug fuzz-targets && tests/fuzz/replay.sh build/debug' sh "$jobs"
step 'thread sanitizer' build_and_test build/tsan-clang 'CONFIG=tsan CC=clang' \
    test_base_parts test_raster_plain test_gather_determinism test_splatting_determinism test_path_determinism test_shading_cache_windows test_shading_cache_live test_threads
step 'serve: who is let in, what ends a connection, what is freed' python3 tests/serve/network.py build/softlux
step 'as a library: installed, in C and C++, documented' tests/library.sh build
step 'in Python: installed by pip, tested by pytest' tests/python.sh build
step 'hard cases: every method' build/softlux check-numerics
step 'lessons: commands, answers, pictures' tests/lessons.sh build
step 'every command of the README' tests/readme.sh
step 'dependencies run one way, references lead somewhere' tests/layers.sh

conclude
