#!/bin/sh
# bench/report.sh BUILD: speed against error of every method (softlux bench) on the scenes of this repository and, where they are there, on real ones;
# the tables and plots go to docs/report/, the page with everything in it stays in BUILD/report/report.html.
#
# From outside: SIZE (128x128), REPEATS (3), LIMIT of one trial in seconds (60), REFERENCE_BUDGET of each reference in seconds (60), THREADS (1),
# SCENES (those below), SHARED (../shared/scenes), OPTIONS (more of softlux bench; --report-only writes the report anew from what was measured).
set -eu
cd "$(dirname "$0")/.."
build=$1
out=$build/report
shared=${SHARED:-../shared/scenes}
mkdir -p "$out" docs/report

if [ -z "${SCENES:-}" ]; then
    [ -f scenes/generated/atrium.json ] || make -s scenes >/dev/null
    SCENES="scenes/cornell.json scenes/cornell-point.json scenes/cornell-glossy.json scenes/two-rooms.json scenes/vase.json scenes/bricks.json
        scenes/mirror-balls.json scenes/furnace.json scenes/generated/room.json scenes/generated/atrium.json scenes/generated/cathedral.json"
    for name in sponza living-room veach-ajar classroom; do
        wanted=$(sed -n 's#.*"file": *"../../../shared/scenes/\([^/]*\)/.*#\1#p' "bench/scenes/$name.json" | head -n 1)
        if [ ! -d "$shared/$wanted" ]; then
            echo "skip: $name, there is no $shared/$wanted"
        elif [ "$shared" = ../shared/scenes ]; then
            SCENES="$SCENES bench/scenes/$name.json"
        else
            mkdir -p "$out/scenes" # the same scene, its files looked for elsewhere
            sed "s#\"../../../shared/scenes/#\"$(cd "$shared" && pwd)/#; s#\"../../scenes/#\"$PWD/scenes/#" "bench/scenes/$name.json" >"$out/scenes/$name.json"
            SCENES="$SCENES $out/scenes/$name.json"
        fi
    done
fi

# shellcheck disable=SC2086 # lists
"${SOFTLUX:-$build/softlux}" bench $SCENES -o "$out" --size "${SIZE:-128x128}" --repeats "${REPEATS:-3}" --limit "${LIMIT:-60}" \
    --reference-budget "${REFERENCE_BUDGET:-60}" --threads "${THREADS:-1}" ${OPTIONS:-}
rm -f docs/report/*.svg
for plot in "$out"/*.svg; do [ -f "$plot" ] && cp "$plot" docs/report/; done
cp "$out/results.csv" docs/report/
cp "$out/report.md" docs/report/README.md
