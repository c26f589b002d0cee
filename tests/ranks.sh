#!/bin/sh
# tests/ranks.sh BUILD: pictures by several processes have the bits of one; what ends a rank ends them all, and says so.
set -u
cd "$(dirname "$0")/.."
build=$1 bad=0 compared=0
if ! command -v mpirun >/dev/null 2>&1 || ! pkg-config --exists ompi-c 2>/dev/null; then
    echo "skip: no Open MPI (Debian: libopenmpi-dev)"
    exit 0
fi
make -s -j"$(nproc)" MPI=1 BUILD="$build" "$build/softlux-mpi" || exit 1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# All ranks are here, however few processors there are, and nothing is started elsewhere.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_plm=isolated
export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_mpi_yield_when_idle=1 OMPI_MCA_btl=self,vader

fail() {
    echo "$1"
    bad=1
}

same() { # same ARGUMENTS...: 2, 3 and 5 ranks, one of them with two threads each
    "$build/softlux" render "$@" --quiet -o "$folder/one.exr" || fail "cannot render $*"
    for ranks in 2 3 5; do
        rm -f "$folder/many.exr"
        mpirun -n $ranks "$build/softlux-mpi" render "$@" --quiet -t $((ranks == 3 ? 2 : 1)) -o "$folder/many.exr" ||
            fail "cannot render with $ranks ranks: $*"
        compared=$((compared + 1))
        cmp -s "$folder/one.exr" "$folder/many.exr" || fail "other bits with $ranks ranks: $*"
    done
}

same scenes/cornell.json -m splatting -q draft -s 48x48
same scenes/cornell-glossy.json -m splatting -q draft -s 40x72 --filter centre
same scenes/cornell-glossy.json -m multi-mesh -q draft -s 48x48
same scenes/cornell.json -m shading-cache -q draft --updates 6 -s 48x48
same scenes/cornell-glossy.json -m light-octree -q draft --stored-photons 20000 -s 48x48
same scenes/mirror-balls.json -m direct-radiance -q draft -s 48x48
same scenes/cornell-mirror.json -m path --spp 4 -s 49x47
same scenes/cornell.json -m bidirectional --spp 2 -s 48x48

# Ranks with different instruction sets.
for scene in "scenes/cornell.json -m splatting" "scenes/cornell-mirror.json -m path --spp 4"; do
    # shellcheck disable=SC2086
    set -- $scene -q draft -s 48x48 --quiet
    "$build/softlux" render "$@" -o "$folder/one.exr" || fail "cannot render $*"
    mpirun -n 1 env SOFTLUX_ISA=baseline "$build/softlux-mpi" render "$@" -o "$folder/many.exr" : \
        -n 1 env SOFTLUX_ISA=avx2 "$build/softlux-mpi" render "$@" -o "$folder/many.exr" || fail "cannot render by two instruction sets: $*"
    cmp -s "$folder/one.exr" "$folder/many.exr" || fail "other bits by two instruction sets: $*"
done

pair() { # pair SCENE OTHER: of two ranks the second is told of another scene
    rm -f "$folder/many.exr"
    # shellcheck disable=SC2086
    mpirun -n 1 "$build/softlux-mpi" render $1 -m splatting -q draft -s 32x32 --quiet -o "$folder/many.exr" : \
        -n 1 env TMPDIR="${temporary:-/tmp}" "$build/softlux-mpi" render $2 -m splatting -q draft -s 32x32 --quiet -o "$folder/many.exr" >"$folder/told" 2>&1
}

# A rank renders what the first one has read, whatever files are there for itself.
for scene in cornell-glossy bricks moving-light vase; do
    "$build/softlux" render scenes/$scene.json -m splatting -q draft -s 32x32 --quiet -o "$folder/one.exr" || fail "cannot render $scene"
    pair scenes/$scene.json "$folder/missing.json" || fail "a rank was not given the files of $scene"
    cmp -s "$folder/one.exr" "$folder/many.exr" || fail "other bits by files that were given: $scene"
done
mkdir -p "$folder/deep/scenes" "$folder/deep/maps" # Also of folders beside each other.
cp scenes/cornell.json "$folder/deep/scenes"
cp scenes/cornell.obj scenes/cornell.mtl "$folder/deep/maps"
sed -i 's|cornell.obj|../textures/../maps/cornell.obj|' "$folder/deep/scenes/cornell.json"
mkdir "$folder/deep/textures"
pair "$folder/deep/scenes/cornell.json --allow-outside" "$folder/missing.json --allow-outside" ||
    fail "a rank was not given the files of several folders"

# A rank cannot take them: one line says which and why, and there is no picture.
temporary=$folder/missing
pair scenes/cornell.json scenes/cornell.json && fail "a rank without a scene was no failure"
grep -q 'softlux-mpi: rank 1: .*cannot make a folder in' "$folder/told" || fail "it is not told which rank had no scene"
[ ! -e "$folder/many.exr" ] || fail "there is a picture although a rank has failed"
temporary=/tmp
# Or it makes another scene of them.
pair scenes/cornell.json "scenes/cornell.json --eye 1,1,3" && fail "ranks with different scenes were no failure"
grep -q 'ranks have read different scenes' "$folder/told" || fail "it is not told that scenes differ"

# Frames of a series by direct radiance mapping are drawn one a rank, and come to the first one.
"$build/softlux" render scenes/moving-ball.json -m direct-radiance -q draft -s 32x32 --frames 5 --fps 4 --quiet -o "$folder/one-%d.pfm"
mpirun -n 3 "$build/softlux-mpi" render scenes/moving-ball.json -m direct-radiance -q draft -s 32x32 --frames 5 --fps 4 --quiet \
    --json --journal "$folder/journal" -o "$folder/many-%d.pfm" >"$folder/told" 2>&1 || fail "no series by ranks"
for frame in 0 1 2 3 4; do
    compared=$((compared + 1))
    cmp -s "$folder/one-$frame.pfm" "$folder/many-$frame.pfm" || fail "other bits by ranks: frame $frame"
done
[ "$(grep -c '"frame":' "$folder/told")" = 5 ] || fail "it is not told of every frame of a series"

# Trials of a report are run by all ranks, each of them once.
mpirun -n 2 "$build/softlux-mpi" bench scenes/cornell.json -m direct-radiance,light-octree,path -q draft -s 16x16 -r 1 --quiet \
    --reference-budget 0.1 --references "$folder/references" -o "$folder/report" >"$folder/told" 2>&1 || fail "no report by ranks"
"$build/softlux" bench scenes/cornell.json -m direct-radiance,light-octree,path -q draft -s 16x16 -r 1 --quiet --trials-only \
    -o "$folder/report-of-one"
for report in report report-of-one; do
    grep -o '[^,]*, run 0"' "$folder/$report/journal.jsonl" | sort >"$folder/$report.trials"
done
[ -s "$folder/report.trials" ] && cmp -s "$folder/report.trials" "$folder/report-of-one.trials" || fail "other trials by ranks"
grep -q 'direct-radiance' "$folder/report/results.csv" || fail "a report by ranks has no table"

# A rank that is killed, or does nothing any more, takes the others along within ten seconds.
for signal in KILL STOP; do
    mpirun -n 3 "$build/softlux-mpi" render scenes/cornell.json -m path --spp 100000 -s 256x256 -t 1 --quiet \
        -o "$folder/many.exr" >"$folder/told" 2>&1 &
    job=$!
    sleep 3
    begin=$(date +%s)
    kill -s $signal "$(pgrep -n -P $job)" || fail "no rank for signal $signal"
    wait $job && fail "a rank that ended by signal $signal was no failure"
    [ $(($(date +%s) - begin)) -le 10 ] || fail "others went on for more than ten seconds after signal $signal"
    [ ! -e "$folder/many.exr" ] || fail "there is a picture although a rank got signal $signal"
done
[ "$(grep -c 'softlux-mpi: rank 2 has not been heard of for 8 s' "$folder/told")" = 1 ] ||
    fail "it is not told in a line that a rank does nothing"
# A call with a journal that was ended is gone on with, by other ranks, and behind a fault in the file too.
journal() { # journal RANKS: a call that takes seconds
    mpirun -n "$1" "$build/softlux-mpi" render scenes/cornell.json -m path --spp 300 -s 96x96 -t 1 \
        --journal "$folder/journal" -o "$folder/many.exr" >"$folder/told" 2>&1
}
"$build/softlux" render scenes/cornell.json -m path --spp 300 -s 96x96 --quiet -o "$folder/one.exr"
rm -f "$folder/many.exr"
journal 2 &
job=$!
until [ "$(stat -c %s "$folder/journal" 2>/dev/null || echo 0)" -gt 1000000 ] || ! kill -0 $job; do sleep 0.1; done
pkill -KILL -n -f -- "--journal $folder/journal"
wait $job && fail "a rank that was killed was no failure with a journal"
mpirun -n 2 "$build/softlux-mpi" render scenes/cornell.json -m path --spp 400 -s 96x96 -t 1 \
    --journal "$folder/journal" -o "$folder/many.exr" >"$folder/told" 2>&1 && fail "another call's journal was taken"
grep -q 'the journal is of another scene or other options' "$folder/told" || fail "it is not told whose journal it is"
printf 'fault' | dd of="$folder/journal" bs=1 seek=500000 conv=notrunc 2>/dev/null
journal 3 || fail "a journal was not gone on with"
grep -q 'goes on from .*batches are there' "$folder/told" || fail "it is not told that a journal is gone on with"
cmp -s "$folder/one.exr" "$folder/many.exr" || fail "other bits by a journal"
[ ! -e "$folder/journal" ] || fail "the journal of a call that is done is still there"
# What batches cost is written, and read by what tells of more ranks.
SOFTLUX_BATCHES=$folder/batches "$build/softlux-mpi" render scenes/cornell.json -m splatting -q draft -s 32x32 -t 1 \
    --quiet -o "$folder/one.exr" && python3 bench/ranks.py "$folder/batches.0" >"$folder/told"
grep -q 'batches.0 | ' "$folder/told" || fail "bench/ranks.py says nothing of a log"
"$build/softlux-mpi" render scenes/cornell.json --time 1 -o "$folder/many.exr" 2>"$folder/told" && fail "--time was taken"
grep -q 'clocks differ' "$folder/told" || fail "--time is not refused in a line"
echo "$compared pictures compared"
exit $bad
