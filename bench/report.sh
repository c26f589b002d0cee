#!/bin/sh
# bench/report.sh BUILD: speed against error of every method (softlux bench) on the scenes of this repository and, where they are there, on real ones;
# the tables and plots go to docs/report/, the page with everything in it stays in BUILD/report/report.html. Interrupted, the same command goes on.
#
# From outside: SIZE (128x128), REPEATS (3), LIMIT of one trial in seconds (60), REFERENCES (folder, the user's cache),
# REFERENCE_BUDGET of each reference in processor seconds (60), THREADS of a trial (1), JOBS: scenes measured at once (1), SCENES (those below),
# SHARED (../shared/scenes), STEPS (trials report), OPTIONS (more of softlux bench).
set -eu
cd "$(dirname "$0")/.."
build=$1
out=$build/report
shared=${SHARED:-../shared/scenes}
mkdir -p "$out" docs/report

if [ -z "${SCENES:-}" ]; then
    [ -f scenes/generated/atrium.json ] || make -s scenes >/dev/null
    # Not walk.json: its first picture is that of cornell-glossy.json.
    SCENES="scenes/cornell.json scenes/two-rooms.json scenes/generated/room.json scenes/cornell-glossy.json scenes/mirror-balls.json scenes/generated/atrium.json
        scenes/cornell-point.json scenes/vase.json scenes/cornell-mirror.json scenes/generated/cathedral.json scenes/generated/cave.json scenes/bricks.json
        scenes/furnace.json scenes/cornell-lamp.json scenes/generated/castle.json scenes/generated/figure.json scenes/generated/mirror-cave.json
        scenes/moving-ball.json scenes/moving-light.json scenes/sphere.json"
    for name in sponza veach-ajar classroom living-room sponza-crytek fzk-haus map-complex cornell-mcguire cornell-mcguire-glossy cornell-mitsuba; do
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
# Scenes of bench/scenes name files elsewhere.
set -- -o "$out" --allow-outside --size "${SIZE:-128x128}" --repeats "${REPEATS:-3}" --limit "${LIMIT:-60}" --reference-budget "${REFERENCE_BUDGET:-60}" \
    --threads "${THREADS:-1}" ${REFERENCES:+--references "$REFERENCES"} ${OPTIONS:-}
softlux=${SOFTLUX:-$build/softlux}

for step in ${STEPS:-trials report}; do
    case $step in
    trials) # what a busy machine spoils
        # shellcheck disable=SC2086 # a list
        printf '%s\n' $SCENES | xargs -P "${JOBS:-1}" -I SCENE "$softlux" bench SCENE "$@" --trials-only --quiet || echo "a scene could not be measured" ;;
    report) # errors, with better references where they need them
        # shellcheck disable=SC2086 # a list
        "$softlux" bench $SCENES "$@" --report-only
        rm -f docs/report/*.svg
        for plot in "$out"/*.svg; do [ -f "$plot" ] && cp "$plot" docs/report/; done
        cp "$out/results.csv" docs/report/
        cp "$out/report.md" docs/report/README.md
        bench/fill_tables.sh "$out/tables.md" docs/speed-against-error.md ;;
    *) echo "STEPS: trials, report; not '$step'" >&2 && exit 2 ;;
    esac
done
