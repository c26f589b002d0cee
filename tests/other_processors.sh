#!/bin/sh
# tests/other_processors.sh [--brief]: the determinism contract on other processors than this one, which an emulator (qemu-user)
# plays: 64-bit Arm, by a cross compiler, and x86-64 from its first years on, by the program as it is. The pictures of
# tests/pictures.list must have the bits that build/softlux gives them here, and on Arm the golden images too. --brief: the test of
# rays' hits and a raster frame, and a smaller picture of each method. Exit status 77: there is no emulator, and it says so.
# Variables: MODELS, those of qemu-x86_64's processors to play; ARM_CC, a compiler for Arm (clang knows it as well).
set -u
cd "$(dirname "$0")/.."
brief=
[ "${1:-}" = --brief ] && brief=1
models=${MODELS-Opteron_G1 core2duo Nehalem Haswell}
arm_cc=${ARM_CC:-aarch64-linux-gnu-gcc}
arm=build/arm64 sysroot=build/sysroot-arm64
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
bad=0 equal=0 processors=0 left_out=

have() { command -v "$1" >/dev/null 2>&1; }

pictures() { # the list; --brief: the first picture of each method, smaller
    if [ -z "$brief" ]; then
        cat tests/pictures.list
    else
        awk '{ for (i = 1; i < NF; i++) if ($i == "-m" && !seen[$(i + 1)]++) print }' tests/pictures.list |
            sed 's/-s [0-9]*x[0-9]*/-s 24x16/; s/--spp 4/--spp 1/; s/--stored-photons [0-9]*/--stored-photons 3000/'
    fi
}

render_all() { # render_all SUFFIX PROGRAM...: each picture as $folder/NAME.SUFFIX
    suffix=$1
    shift
    pictures | while read -r name arguments; do
        # shellcheck disable=SC2086
        "$@" render $arguments --quiet -t 2 -o "$folder/picture.pfm" </dev/null &&
            mv "$folder/picture.pfm" "$folder/$name.$suffix"
    done
}

compare() { # compare PROCESSOR PROGRAM...: all pictures against those made here
    processor=$1 before=$equal
    shift
    rm -f "$folder"/*.other
    render_all other "$@"
    for first in "$folder"/*.here; do
        if cmp -s "$first" "${first%.here}.other"; then equal=$((equal + 1)); continue; fi
        echo "other bits on $processor: $(basename "$first" .here)"
        bad=1
    done
    echo "$processor: $((equal - before)) pictures have the same bits"
    processors=$((processors + 1))
}

arm_test() { # arm_test NAME...: test programs
    for name in "$@"; do
        if QEMU_LD_PREFIX=$sysroot qemu-aarch64 $arm/tests/"$name" >"$folder/log" 2>&1; then
            echo "64-bit Arm: $name: $(grep -c '^\[ *OK' "$folder/log") cases passed"
        else
            cat "$folder/log"
            bad=1
        fi
    done
}

on_arm() {
    tests=test_same_bits
    [ -n "$brief" ] || tests="$tests test_base_math test_golden_passes test_trace_hits"
    # shellcheck disable=SC2086
    make -s -j"$(nproc)" CONFIG=arm64 CC="$arm_cc" BUILD=$arm $arm/softlux $(printf "$arm/tests/%s " $tests) || exit 1
    # shellcheck disable=SC2086
    arm_test $tests
    compare '64-bit Arm' qemu-aarch64 -L $sysroot $arm/softlux
}

render_all here build/softlux
if ! have qemu-aarch64 || ! have "$arm_cc"; then
    left_out='no qemu-aarch64 or no cross compiler: apt-get install qemu-user gcc-aarch64-linux-gnu'
elif [ ! -e $sysroot/complete ] && { [ -n "$brief" ] || ! make -s sysroot-arm64; }; then
    left_out="no libraries for 64-bit Arm: make sysroot-arm64"
else
    on_arm
fi
if have qemu-x86_64; then
    for model in $models; do compare "x86-64, $model" qemu-x86_64 -cpu "$model" build/softlux; done
fi
[ -z "$left_out" ] || echo "left out: $left_out"
[ $processors -gt 0 ] || exit 77
echo "$equal pictures on $processors other processors have the same bits"
exit $bad
