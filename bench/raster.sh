#!/bin/sh
# raster.sh BUILD: the rasterizer beside OSMesa and rays, workload by workload (docs/rasterizer.md).
cd "$(dirname "$0")/.." && make -s BUILD="$1" scenes && "$1/bench/bench_raster"
