#!/bin/bash
# conformance.sh BUILD : everything that OSMesa judges; ends with the number of pixels that differ from its.
set -u
build=$1 failed=0 differing=0
export SOFTLUX_GENERATE=${SOFTLUX_GENERATE:-$build/generate}
for test in "$build"/tests/test_osmesa_*; do
  case $test in *.d) continue ;; esac
  output=$("$test" 2>&1) || failed=1
  echo "$output"
  differing=$((differing + $(sed -n 's/^differing pixels: \([0-9]*\)$/\1/p' <<<"$output" | paste -sd+ | sed 's/^$/0/')))
done
echo "conformance: $differing differing pixels"
[ $failed = 0 ] && [ $differing = 0 ]
