#!/bin/sh
# soak.sh BUILD [SECONDS]: edits, moves and pictures of every method, and shows, for so long (default 120 seconds); fails where memory, descriptors or
# threads grow after the first third of the time.
set -u
build=${1:-build}
seconds=${2:-120}
[ -x "$build/tests/test_soak" ] || { echo "no $build/tests/test_soak: make test first"; exit 77; }
OMP_WAIT_POLICY=passive SOAK_SECONDS=$seconds "$build/tests/test_soak" 2>&1 | sed -n 's/^\([a-z-]*[a-z ]*: .* then .*\)/result \1/p; /^ERROR\|FAILED/p' | tee /tmp/softlux-soak.$$
grep -q 'ERROR\|FAILED' /tmp/softlux-soak.$$ && bad=1 || bad=0
grep -q '^result' /tmp/softlux-soak.$$ || bad=1
rm -f /tmp/softlux-soak.$$
exit $bad
