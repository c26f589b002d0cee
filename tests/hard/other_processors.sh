#!/bin/sh
# other_processors.sh BUILD [--brief]: the determinism contract on other processors than this one, which an emulator (qemu-user) plays: 64-bit Arm,
# by a cross compiler, and x86-64 from its first years on, by the program as it is. Rays' hits, frames of the rasterizer and pictures must have
# this machine's bits: on Arm all of tests/pictures.list, and the golden images; on x86-64, and with --brief, a smaller picture of each method.
# MODELS: the x86-64 processors, as qemu-x86_64 -cpu calls them. ARM_CC: a compiler for Arm. --brief: Arm and the oldest alone, no download.
set -u
cd "$(dirname "$0")/../.."
build=${1:-build} brief=${2:-}
models=${MODELS-Opteron_G1 core2duo Nehalem SandyBridge Haswell EPYC}
[ -z "$brief" ] || models=${models%% *}
arm_cc=${ARM_CC:-aarch64-linux-gnu-gcc}
arm=build/arm64 sysroot=build/sysroot-arm64
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
bad=0 equal=0 processors=0 left_out=
# What make check, and make check-all, show of a log.
shown='result '
[ -z "$brief" ] || shown='skip '

have() { command -v "$1" >/dev/null 2>&1; }

# The first picture of each method, smaller.
awk '{ for (i = 1; i < NF; i++) if ($i == "-m" && !seen[$(i + 1)]++) print }' tests/pictures.list |
    sed 's/-s [0-9]*x[0-9]*/-s 24x16/; s/--spp 4/--spp 1/; s/--stored-photons [0-9]*/--stored-photons 3000/' >"$folder/short"
cp tests/pictures.list "$folder/whole"

render_all() { # render_all LIST SUFFIX PROGRAM...: each picture as $folder/LIST-NAME.SUFFIX
    list=$1 suffix=$2
    shift 2
    while read -r name arguments; do
        # shellcheck disable=SC2086
        if "$@" render $arguments --quiet -t 2 -o "$folder/picture.pfm" </dev/null 2>"$folder/told"; then
            mv "$folder/picture.pfm" "$folder/$list-$name.$suffix"
        else
            grep -v "TCG doesn't support" "$folder/told"
        fi
    done <"$folder/$list"
}

compare() { # compare PROCESSOR LIST PROGRAM...: all pictures of a list against those made here
    processor=$1 list=$2 before=$equal
    shift 2
    [ -e "$folder/$list-done" ] || render_all "$list" here "$build/softlux"
    touch "$folder/$list-done"
    rm -f "$folder"/*.other
    render_all "$list" other "$@"
    for first in "$folder/$list"-*.here; do
        if cmp -s "$first" "${first%.here}.other"; then equal=$((equal + 1)); continue; fi
        echo "other bits on $processor: $(basename "$first" .here)"
        bad=1
    done
    echo "result $processor: $((equal - before)) pictures have the same bits"
    processors=$((processors + 1))
}

run_test() { # run_test PROCESSOR PROGRAM...
    processor=$1
    shift
    "$@" >"$folder/log" 2>&1 || { cat "$folder/log"; bad=1; }
    for last; do :; done
    echo "result $processor: $(basename "$last"): $(grep -c '^\[ *OK' "$folder/log") cases passed"
}

on_arm() {
    tests=test_same_bits list=short
    [ -n "$brief" ] || tests="$tests test_base_math test_golden_passes" list=whole
    # shellcheck disable=SC2046,SC2086
    make -s -j"$(nproc)" CONFIG=arm64 CC="$arm_cc" BUILD=$arm $arm/softlux $(printf "$arm/tests/%s " $tests) || exit 1
    for name in $tests; do run_test '64-bit Arm' qemu-aarch64 -L $sysroot "$arm/tests/$name"; done
    compare '64-bit Arm' $list qemu-aarch64 -L $sysroot $arm/softlux
}

if ! have qemu-aarch64 || ! have "$arm_cc"; then
    left_out='no qemu-aarch64 or no cross compiler: apt-get install qemu-user gcc-aarch64-linux-gnu'
elif [ ! -e $sysroot/complete ] && { [ -n "$brief" ] || ! make -s sysroot-arm64; }; then
    left_out='no libraries for it: make sysroot-arm64'
else
    on_arm
fi
for model in $models; do
    have qemu-x86_64 || continue
    run_test "x86-64, $model" qemu-x86_64 -cpu "$model" "$build/tests/test_same_bits"
    compare "x86-64, $model" short qemu-x86_64 -cpu "$model" "$build/softlux"
done
[ -z "$left_out" ] || echo "${shown}64-bit Arm is left out: $left_out"
[ $processors -gt 0 ] || { echo "64-bit Arm: $left_out"; exit 77; }
echo "$equal pictures on $processors other processors have the same bits"
exit $bad
