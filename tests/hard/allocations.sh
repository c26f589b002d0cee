#!/bin/sh
# tests/hard/allocations.sh BUILD [NAME]: every call path that allocates is refused memory once, alone and with all that follow, in all methods and
# whatever else tests/library/test_every_allocation*.c do (or what NAME names of it).
# BUILD with sanitizers: leaks are faults, too. A case has one thread, so each core has a case of its own.
# The longest takes half an hour, all together three quarters of one on two cores.
set -u
cd "$(dirname "$0")/../.."
build=$1 name=${2:-}
export SOFTLUX_EVERY_ALLOCATION=1 OMP_WAIT_POLICY=passive
cases=$(for program in test_every_allocation test_every_allocation_files; do
    "$build/tests/$program" --list | sed -n "s/^case /$program:/p"
done | grep -F "$name") || { echo "no case is named so: $name"; exit 1; }
echo "$cases" | xargs -d '\n' -n 1 -P "$(nproc)" sh -c '"$0/tests/${1%%:*}" "${1#*:}" || exit 1' "$build"
