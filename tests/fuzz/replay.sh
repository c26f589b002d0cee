#!/bin/sh
# tests/fuzz/replay.sh BUILD: the corpus through every target of a build folder, without a fuzzer. BUILD is best one with sanitizers.
set -u
cd "$(dirname "$0")/../.."
build=$1
export OMP_WAIT_POLICY=passive LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp print_suppressions=0"
for source in tests/fuzz/target_*.c; do
    target=$(basename "$source" .c)
    target=${target#target_}
    if ! "$build/fuzz/$target" "$PWD/tests/fuzz/corpus/$target" >"$build/fuzz/$target.out" 2>"$build/fuzz/$target.err"; then
        tail -n 40 "$build/fuzz/$target.err"
        echo "tests/fuzz/replay.sh: $target failed" >&2
        exit 1
    fi
    grep -h '[0-9] inputs$' "$build/fuzz/$target.out" | tail -n 1
done
