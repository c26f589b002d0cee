#!/bin/sh
# The determinism contract, by the program itself: small pictures by every method and gather, at 1, 2, 3 and 7 threads, by gcc
# and clang, and on every instruction set that the CPU has, must have the same bits.
set -u
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
bad=0 compared=0

render() { # render PROGRAM OUTPUT ARGUMENTS...
    program=$1 output=$2
    shift 2
    "$program" render "$@" --quiet -o "$output" || { echo "could not render: $program $*"; bad=1; }
}

same() { # same NAME ARGUMENTS...: renders with everything and compares with the first
    name=$1
    shift
    first=$folder/$name.pfm
    render build/softlux "$first" "$@" -t 1
    for threads in 2 3 7; do
        render build/softlux "$folder/other.pfm" "$@" -t $threads
        expect "$name, $threads threads"
    done
    for isa in baseline avx2 avx512; do
        SOFTLUX_ISA=$isa
        export SOFTLUX_ISA
        render build/softlux "$folder/other.pfm" "$@" -t 2
        expect "$name, instruction set $isa (or the best below)"
        unset SOFTLUX_ISA
    done
    for other in build/release-clang build/baseline; do
        render $other/softlux "$folder/other.pfm" "$@" -t 2
        expect "$name, $other"
    done
}

expect() {
    compared=$((compared + 1))
    cmp -s "$first" "$folder/other.pfm" && return
    echo "other bits: $1"
    build/softlux compare "$folder/other.pfm" "$first" || true
    bad=1
}

for gather in raster hemicube trace; do
    same splatting-$gather scenes/cornell.json -m splatting --set splatting.gather=$gather -q draft -s 96x96 --filter centre
done
same splatting-maps scenes/sphere.json -m splatting --set splatting.direct=shadow-maps -q draft -s 64x64 --filter centre
same splatting-mirror scenes/cornell-mirror.json -m splatting -q draft -s 96x96
same splatting-rooms scenes/two-rooms.json -m splatting -q draft -s 96x64 --filter blackman-harris
same splatting-glossy scenes/cornell-glossy.json -m splatting -q draft -s 64x64
# Direct radiance mapping: glossy surfaces and photons, mirrors, moving samples, polygons, rays to photons; the light octree
# with its area and its sky, its other lobes, and by way of the atlas.
same radiance-glossy scenes/cornell-glossy.json -m direct-radiance -q draft -s 96x96
same radiance-balls scenes/mirror-balls.json -m direct-radiance -q normal --visibility rays -s 96x96 --filter centre
same radiance-polygons scenes/cornell-lamp.json -m direct-radiance -q high --visibility rays -s 64x64 --filter centre
same octree-mirror scenes/cornell-mirror.json -m light-octree -q draft --stored-photons 30000 -s 96x96
same octree-glossy scenes/cornell-glossy.json -m light-octree -q draft --stored-photons 20000 --set light-octree.lobes=surface -s 64x64 --filter centre
same octree-atlas scenes/two-rooms.json -m light-octree -q draft --stored-photons 20000 --set light-octree.whole-voxels=1 --set light-octree.atlas=1 --set light-octree.atlas-size=256 -s 96x64 --filter centre
same octree-bumps scenes/bricks.json -m light-octree -q draft --stored-photons 20000 --set light-octree.own-photons=1 -s 64x48 --filter centre
same mesh-cornell scenes/cornell.json -m multi-mesh -q draft -s 64x64
same mesh-glossy scenes/cornell-glossy.json -m multi-mesh -q normal --set multi-mesh.selection=chain --bounces 2 -s 48x48 --filter centre
same mesh-rays scenes/two-rooms.json -m multi-mesh -q draft --set multi-mesh.light-estimator=look-at -s 64x48 --filter centre
same shading-cornell scenes/cornell.json -m shading-cache -q draft --updates 10 -s 64x64
same shading-glossy scenes/cornell-glossy.json -m shading-cache -q draft --updates 10 --set shading-cache.pixel-selection=sorted --set shading-cache.variance-aware=1 -s 48x48 --filter centre
same shading-vase scenes/vase.json -m shading-cache -q draft --updates 6 --caustics -s 64x64 --filter centre
same path-cornell scenes/cornell.json -m path --spp 4 -s 64x64
same path-glossy scenes/cornell-glossy.json -m path --spp 4 -s 64x64
same path-mirror scenes/cornell-mirror.json -m path --spp 4 -s 64x64 --filter blackman-harris
same path-matched scenes/two-rooms.json -m path --transport matched:splatting --spp 4 -s 64x64
same bidirectional-cornell scenes/cornell.json -m bidirectional --spp 2 -s 64x64
same bidirectional-balls scenes/mirror-balls.json -m bidirectional --spp 2 -s 64x64
same bidirectional-matched scenes/two-rooms.json -m bidirectional --transport matched:splatting --spp 2 -s 64x64
echo "$compared pictures compared"
exit $bad
