#!/bin/sh
# tests/run.sh BUILD [NAME ...]: runs the test programs of a build folder (all, or those named), two at a time, and tells
# which failed.
set -u
build=$1
shift
cd "$(dirname "$0")/.."
out=$build/test-results
mkdir -p "$out"
rm -f "$out"/*
if [ $# -eq 0 ]; then set -- $(cd "$build/tests" && ls | grep '^test_' | grep -v '\.'); fi
export SOFTLUX=${SOFTLUX:-$build/softlux} SOFTLUX_GENERATE=${SOFTLUX_GENERATE:-$build/generate}
export TSAN_OPTIONS="suppressions=$PWD/tests/tsan.supp ${TSAN_OPTIONS:-}"
export LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp print_suppressions=0 ${LSAN_OPTIONS:-}"

printf '%s\n' "$@" | xargs -P 2 -I{} sh -c '
    start=$(date +%s)
    if "$1/tests/$3" >"$2/$3.log" 2>&1; then result=ok; else result=FAILED; fi
    echo "$result" >"$2/$3.result"
    echo "$result $3 ($(($(date +%s) - start)) s)"' sh "$build" "$out" {}

passed=$(grep -lx ok "$out"/*.result 2>/dev/null | wc -l)
failed=$(grep -lx FAILED "$out"/*.result 2>/dev/null | wc -l)
names=
for name in $(grep -lx FAILED "$out"/*.result 2>/dev/null); do
    names="$names $(basename "${name%.result}")"
    echo "---- $name"
    grep -v '^\[ *\(OK\|RUN\) *\]' "${name%.result}.log" | tail -n 40
done
cases=$(cat "$out"/*.log | grep -c '^\[ *OK *\]')
skipped=$(cat "$out"/*.log | grep -c '^\[ *SKIPPED *\] [a-z]')
echo "$build: $passed programs passed, $failed failed ($cases cases, $skipped skipped)${names:+; failed:$names}"
cat "$out"/*.log | grep '^skip' | sort -u
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
