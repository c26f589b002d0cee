#!/bin/sh
# large.sh BUILD [TRIANGLES]: ten million triangles, and pictures of 8192 x 8192, within stated memory. Each row renders in a process of its own, with
# --memory, and fails if the system says that it took more, or if there is no picture. Rows that are refused say what they would need: they pass where that
# is what is expected. About ten minutes of one core; 8 GB of memory and 7 GB in /tmp.
set -u
build=${1:-build}
triangles=${2:-1e7}
[ -x /usr/bin/time ] || { echo 'needs /usr/bin/time, which tells the peak of a process'; exit 77; }
[ -x "$build/softlux" ] || { echo "no $build/softlux: make it first"; exit 77; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
bad=0
${CC:-cc} -O2 -std=c11 -D_POSIX_C_SOURCE=200809L tests/hard/large_scene.c -o "$folder/large_scene" || exit 1
"$folder/large_scene" "$folder/area" "$triangles" || exit 1

row() { # row EXPECTED-STATUS MEGABYTES SCENE METHOD SIZE OPTIONS...
    wanted=$1 most=$2 scene=$3 method=$4 size=$5
    shift 5
    OMP_WAIT_POLICY=passive nice -n 5 /usr/bin/time -f '%M %U' -o "$folder/cost" \
        "$build/softlux" render "$scene" -m "$method" -s "$size" -q draft --spp 1 -t 1 --quiet --memory "${most}M" -o "$folder/x.exr" "$@" 2>"$folder/said"
    status=$?
    peak=$(tail -1 "$folder/cost" | cut -d' ' -f1)
    seconds=$(tail -1 "$folder/cost" | cut -d' ' -f2)
    verdict=ok
    [ $status -eq "$wanted" ] || { verdict="FAILED: status $status, expected $wanted"; bad=1; }
    [ "$peak" -le $((most * 1024)) ] || { verdict="FAILED: more than allowed"; bad=1; }
    echo "result $(basename "$scene") $method $size: $((peak / 1024)) of $most MB, $seconds s: $verdict $(cat "$folder/said")"
    rm -f "$folder/x.exr"
}

large=$folder/area/large.json
row 0 4000 "$large" path 256x256
row 0 4000 "$large" direct-radiance 256x256
row 0 4500 "$large" splatting 256x256
row 0 6000 "$large" light-octree 256x256
row 5 6000 "$large" multi-mesh 256x256
row 5 3000 "$large" shading-cache 256x256
row 5 1000 "$large" path 256x256
row 0 4200 scenes/cornell.json direct-radiance 8192x8192
row 0 6200 scenes/cornell.json path 8192x8192
row 5 6200 scenes/cornell.json splatting 8192x8192
row 5 6200 scenes/cornell.json multi-mesh 8192x8192
exit $bad
