#!/bin/sh
# The determinism contract, by the program itself: small pictures by every method and gather (tests/pictures.list), at 1, 2, 3
# and 7 threads, by gcc and clang, and on every instruction set that the CPU has, must have the same bits.
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

# Programs must not read the list.
while read -r name arguments; do
    # shellcheck disable=SC2086
    same "$name" $arguments </dev/null
done <tests/pictures.list
echo "$compared pictures compared"
exit $bad
