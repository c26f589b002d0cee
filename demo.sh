#!/bin/sh
# demo.sh BUILD: renders two scenes by radiance cache splatting, the same paths by the reference path tracer, and prints how far
# apart they are. Pictures go to demo/.
set -eu
cd "$(dirname "$0")"
build=$1
mkdir -p demo
[ -f scenes/generated/atrium.json ] || make -s scenes >/dev/null

LC_ALL=C; export LC_ALL
number() { printf '%.3g' "$(value "$1" "$2")"; } # rounded
value() { sed -n "s/.*\"$1\":[[:space:]]*\([-+.0-9eE]*\).*/\1/p" "$2" | head -n 1; }

show() { # show NAME SCENE SIZE REFERENCE-SAMPLES
    name=$1 scene=$2 size=$3 samples=$4
    echo "softlux: $scene, $size: radiance cache splatting"
    "$build/softlux" render "$scene" -s "$size" --json -o "demo/$name.exr" >"demo/$name.json"
    "$build/softlux" render "$scene" -s "$size" --quiet -o "demo/$name.png"
    echo "softlux: $scene, $size: reference path tracer, the same paths, $samples samples a pixel"
    "$build/softlux" render "$scene" -s "$size" -m path --transport matched:splatting --spp "$samples" \
        --json -o "demo/$name-reference.exr" >"demo/$name-reference.json"
    "$build/softlux" compare "demo/$name.exr" "demo/$name-reference.exr" --json --difference "demo/$name-difference.png" \
        >"demo/$name-error.json"
    printf '%-8s %8s %8s %10s %10s %10s %12s  %s\n' "$name" "$(number seconds "demo/$name.json")" \
        "$(value records "demo/$name.json")" "$(number rel_rmse "demo/$name-error.json")" \
        "$(number rel_mse_less_noise "demo/$name-error.json")" "$(number bias "demo/$name-error.json")" \
        "$(number seconds "demo/$name-reference.json")" "demo/$name.png" >>demo/table.txt
}

: >demo/table.txt
show cornell scenes/cornell.json 512x512 256
show atrium scenes/generated/atrium.json 800x800 64
printf '\n%-8s %8s %8s %10s %10s %10s %12s  %s\n' scene seconds records relRMSE 'relMSE*' bias 'reference s' picture
cat demo/table.txt
echo
echo '* less the noise of the reference; `softlux compare --help` defines the errors. demo/*-difference.png show where they are.'
