#!/bin/sh
# All that `make check-all` runs: what `make check` does, then the longer ones, a line each; ends with "N passed, N failed".
# Every executable tests/hard/*.sh is one of them: called with the build folder, at the repository's root; exit status 0: passed, 77: cannot
# run here, and its last line says why. Lines that begin with "result " are shown.
show='s/^result *//p' failed_lines=40
. "$(dirname "$0")/steps.sh"

fuzz() {
    tests/fuzz/fuzz.sh "${FUZZ_SECONDS:-60}" "$1" >build/fuzz-step.out
    status=$?
    sed 's/^/result /' build/fuzz-step.out
    [ $status -ne 2 ] || status=77 # no clang with libFuzzer, which it has said
    return $status
}

step 'make check' env ONLY= tests/check.sh
[ -x build/softlux ] || make -s -j"$jobs" all || exit 1
step 'hard cases with sanitizers: every method' sh -c 'make -s -j"$1" CONFIG=debug BUILD=build/debug build/debug/softlux && build/debug/softlux check-numerics' sh "$jobs"
for script in tests/hard/*.sh; do
    [ -x "$script" ] || continue
    step "$(basename "$script" .sh | tr _ ' ')" "$script" build
done
for target in tests/fuzz/target_*.c; do
    target=$(basename "$target" .c)
    step "fuzzing: ${target#target_}" fuzz "${target#target_}"
done

step 'serve: a scripted visitor for a minute' python3 tests/serve/soak.py build/softlux 1
step 'serve: a scripted visitor under the thread sanitizer' sh -c 'make -s -j"$1" CONFIG=tsan CC=clang build/tsan-clang/softlux &&
    SLACK=10 TSAN_OPTIONS="suppressions=$PWD/tests/tsan.supp" python3 tests/serve/soak.py build/tsan-clang/softlux 1' sh "$jobs"

conclude
