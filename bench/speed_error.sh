#!/bin/sh
# bench/speed_error.sh BUILD [SCENE ...]: speed against error. For each scene a reference (the same paths, many samples),
# radiance cache splatting at three qualities, and the path tracer stopped at the same time: one table. Compare rows of one
# table only: times depend on the machine.
#
# REFERENCE_SPP (512), SIZE (1000x1000) and RUNS (3, medians) can be set from outside. References are kept in build/references/.
set -eu
cd "$(dirname "$0")/.."
build=$1
shift
size=${SIZE:-1000x1000} samples=${REFERENCE_SPP:-512} runs=${RUNS:-3}
store=build/references
mkdir -p "$store"
if [ $# -eq 0 ]; then
    [ -f scenes/generated/atrium.json ] || make -s scenes >/dev/null
    set -- scenes/cornell.json scenes/generated/atrium.json
    if [ -f bench/scenes/sponza.json ] && [ -d ../shared/scenes/sponza-dabrovic ]; then set -- "$@" bench/scenes/sponza.json
    else echo 'skip: sponza, its files are not here'; fi
fi

value() { sed -n "s/.*\"$1\":[[:space:]]*\([-+.0-9eE]*\).*/\1/p" "$2" | head -n 1; }
median() { sort -g | awk '{a[NR] = $1} END {print a[int((NR + 1) / 2)]}'; }

row() { # row NAME ARGUMENTS...: RUNS renders, median seconds, error of the last
    name=$1
    shift
    : >"$store/seconds"
    for _ in $(seq "$runs"); do
        "$build/softlux" render "$scene" -s "$size" --quiet --json "$@" -o "$store/picture.exr" >"$store/run.json"
        value seconds "$store/run.json" >>"$store/seconds"
    done
    seconds=$(median <"$store/seconds")
    "$build/softlux" compare "$store/picture.exr" "$reference" --json >"$store/error.json"
    printf '%-22s %9.2f %9s %12s %12s %10.4f %10.2e %10.2e %10.2e %9.4f\n' "$name" "$seconds" "$(value records "$store/run.json")" \
        "$(value rays "$store/run.json")" "$(value shadow_rays "$store/run.json")" "$(value rel_rmse "$store/error.json")" \
        "$(value rel_mse "$store/error.json")" "$(value rel_mse_less_noise "$store/error.json")" \
        "$(value rel_mse_trimmed "$store/error.json")" \
        "$(value bias "$store/error.json")"
}

echo "softlux $("$build/softlux" --version | cut -d' ' -f2), commit $(git rev-parse --short HEAD 2>/dev/null || echo unknown)," \
    "$(nproc) processors,$(sed -n 's/^model name[^:]*:/ /p' /proc/cpuinfo | head -n 1), median of $runs runs"
for scene in "$@"; do
    reference=$store/$(echo "$scene-$size-$samples" | tr '/' '_').exr
    [ -f "$reference" ] || "$build/softlux" render "$scene" -s "$size" -m path --transport matched:splatting \
        --spp "$samples" --seed 4711 -o "$reference"
    echo
    echo "$scene, $size, against $samples samples a pixel of the same paths"
    printf '%-22s %9s %9s %12s %12s %10s %10s %10s %10s %9s\n' method seconds records rays 'shadow rays' relRMSE relMSE 'less noise' trimmed bias
    for quality in draft normal high; do
        row "splatting $quality" -q $quality
        row "path, same time" -m path --transport matched:splatting --spp 1000000 --time "$seconds"
    done
done
