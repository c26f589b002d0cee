#!/bin/sh
# bench/run.sh BUILD: every benchmark, speed beside error. Nothing here is a test: figures depend on the machine.
set -eu
cd "$(dirname "$0")/.."
build=$1
[ -f scenes/generated/atrium.json ] || make -s scenes >/dev/null
"$build/bench/bench_gather" scenes/generated/room.json scenes/generated/atrium.json scenes/generated/figure.json
"$build/softlux" bench scenes/cornell.json scenes/generated/atrium.json -o "$build/report"
"$build/bench/bench_raster"
