#!/bin/sh
# demo.sh BUILD: renders scenes by each method, the same paths by the reference path tracer, and prints how far apart they are. Pictures go
# to demo/.
set -eu
cd "$(dirname "$0")"
build=$1
mkdir -p demo
[ -f scenes/generated/atrium.json ] || make -s scenes >/dev/null

LC_ALL=C; export LC_ALL
number() { printf '%.3g' "$(value "$1" "$2")"; } # rounded
value() { sed -n "s/.*\"$1\":[[:space:]]*\([-+.0-9eE]*\).*/\1/p" "$2" | head -n 1; }

show() { # show NAME SCENE METHOD SIZE REFERENCE-SAMPLES
    name=$1 scene=$2 method=$3 size=$4 samples=$5
    echo "softlux: $scene, $size: $method"
    "$build/softlux" render "$scene" -m "$method" -s "$size" --json -o "demo/$name.exr" >"demo/$name.json"
    "$build/softlux" render "$scene" -m "$method" -s "$size" --quiet -o "demo/$name.png"
    echo "softlux: $scene, $size: reference path tracer, the paths of $method, $samples samples a pixel"
    "$build/softlux" render "$scene" -s "$size" -m path --transport "matched:$method" --spp "$samples" \
        --json -o "demo/$name-reference.exr" >"demo/$name-reference.json"
    "$build/softlux" compare "demo/$name.exr" "demo/$name-reference.exr" --json --difference "demo/$name-difference.png" \
        >"demo/$name-error.json"
    printf '%-12s %-15s %8s %10s %10s %10s %12s  %s\n' "$name" "$method" "$(number seconds "demo/$name.json")" \
        "$(number rel_rmse "demo/$name-error.json")" "$(number rel_mse_less_noise "demo/$name-error.json")" \
        "$(number bias "demo/$name-error.json")" "$(number seconds "demo/$name-reference.json")" "demo/$name.png" >>demo/table.txt
}

: >demo/table.txt
show cornell scenes/cornell.json splatting 512x512 256
show balls scenes/mirror-balls.json direct-radiance 400x400 64
show mirror scenes/cornell-mirror.json light-octree 400x400 64
show atrium scenes/generated/atrium.json splatting 800x800 64
printf '\n%-12s %-15s %8s %10s %10s %10s %12s  %s\n' scene method seconds relRMSE 'relMSE*' bias 'reference s' picture
cat demo/table.txt
echo
echo '* less the noise of the reference; `softlux compare --help` defines the errors. demo/*-difference.png show where they are.'
echo 'Direct radiance mapping has no shadows between surfaces: that is most of its error here.'
