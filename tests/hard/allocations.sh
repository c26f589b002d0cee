#!/bin/sh
# tests/hard/allocations.sh BUILD [NAME]: every call path that allocates is refused memory once, alone and with all that follow, in all methods and
# whatever else tests/test_every_allocation*.c do (or what NAME names of it). EVERY=N: every N-th call instead, whatever its path (EVERY=50: minutes).
# BUILD with sanitizers: leaks are faults, too. Half an hour.
set -u
cd "$(dirname "$0")/../.."
build=$1
shift
bad=0
for program in test_every_allocation test_every_allocation_files; do
    SOFTLUX_EVERY_ALLOCATION=${EVERY:-1} OMP_WAIT_POLICY=passive "$build/tests/$program" "$@" || bad=1
done
exit $bad
