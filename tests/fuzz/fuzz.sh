#!/bin/sh
# tests/fuzz/fuzz.sh SECONDS [TARGET ...]: libFuzzer on the targets named (all), one after the other, so long each. What it learns stays in
# build/fuzz/TARGET, where the next run begins; what it finds is written beside it and makes the exit status 1.
# An input that is found is tried again by build/fuzz-clang/fuzz/TARGET FILE.
set -u
cd "$(dirname "$0")/../.."
seconds=${1:-60}
[ $# -gt 0 ] && shift
[ $# -gt 0 ] || set -- $(ls tests/fuzz/target_*.c | sed 's|.*/target_||; s|\.c$||')

build=build/fuzz-clang
probe=$(mktemp -d)
trap 'rm -rf "$probe"' EXIT
echo 'int LLVMFuzzerTestOneInput(const unsigned char *d, unsigned long n) { return d && n > 9 ? 0 : 0; }' >"$probe/probe.c"
if ! clang -fsanitize=fuzzer,address -o "$probe/probe" "$probe/probe.c" 2>/dev/null; then
    echo 'make fuzz wants clang with libFuzzer and the sanitizers: on Debian and Ubuntu, apt-get install clang libclang-rt-14-dev' >&2
    exit 2
fi
targets=
for t in "$@"; do targets="$targets $build/fuzz/$t"; done
# shellcheck disable=SC2086
make -s -j"$(nproc)" CONFIG=fuzz CC=clang BUILD=$build $targets || exit 2

export OMP_WAIT_POLICY=passive UBSAN_OPTIONS=print_stacktrace=1
export LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp print_suppressions=0"
failed=0
for t in "$@"; do
    learnt=$PWD/build/fuzz/$t found=$PWD/build/fuzz/$t-found- log=$PWD/build/fuzz/$t.log
    mkdir -p "$learnt"
    dictionary=tests/fuzz/$t.dict
    "$build/fuzz/$t" -max_total_time="$seconds" -timeout=30 -rss_limit_mb=3000 -max_len=4000 -close_fd_mask=3 -print_final_stats=1 \
        $([ -f "$dictionary" ] && echo "-dict=$dictionary") -artifact_prefix="$found" "$learnt" "$PWD/tests/fuzz/corpus/$t" >"$log" 2>&1
    status=$?
    inputs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | tail -n 1)
    if [ $status -eq 0 ]; then
        echo "$t: ${inputs:-0} inputs in $seconds s, nothing found"
    else
        failed=1
        echo "$t: FOUND something after ${inputs:-some} inputs:"
        grep -E 'ERROR|runtime error|SUMMARY|^fuzz:|Test unit written' "$log" | sed 's/^/    /'
    fi
done
exit $failed
