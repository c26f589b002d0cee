#!/bin/sh
# bench/experiments.sh METHOD BUILD [--brief] [--docs] [SCENE ...]: the experiments on one method: the tables of bench/METHOD.trials, those of
# bench/frames.trials that are its own, and programs for what trials cannot measure. METHOD is also bidirectional, estimates, raster or motion.
# Tables go to BUILD/METHOD/ (brief ones, of small pictures, to BUILD/METHOD-brief/). With --docs they also replace what stands between the marks
# of docs pages. Interrupted, the same command goes on. From outside: REFERENCE_BUDGET of each reference in processor seconds (60).
set -eu
cd "$(dirname "$0")/.."
method=$1 build=$2 brief='' docs='' scenes=''
shift 2
for word in "$@"; do
    case $word in
    --brief) brief=--brief ;;
    --docs) docs=yes ;;
    *) scenes="$scenes $word" ;;
    esac
done
case $method in
splatting) programs='table1' frames=splatting pages=docs/splatting-experiments.md ;;
direct-radiance) programs='' frames=radiance pages=docs/direct-radiance-experiments.md ;;
light-octree) programs='' frames=octree pages=docs/light-octree-experiments.md ;;
multi-mesh) programs='light_sample' frames=mesh pages=docs/multi-mesh-experiments.md ;;
shading-cache) programs='shading_equal shading_moving' frames='' pages=docs/shading-cache-experiments.md ;;
bidirectional) programs='' frames='' pages=docs/bidirectional.md ;;
estimates) programs='' frames='' pages=docs/error-estimates.md ;;
raster) make -s BUILD="$build" scenes && exec "$build/bench/bench_raster" ;;
motion) # every method while things move; BUILD/motion/ gets the errors frame by frame
    make -s BUILD="$build" scenes && mkdir -p "$build/motion"
    # shellcheck disable=SC2086 # a list
    exec "$build/bench/bench_motion" $brief --csv "$build/motion" ;;
*) echo "unknown method: $method" >&2 && exit 2 ;;
esac
out=$build/$method${brief:+-brief}
[ -f scenes/generated/ring.json ] || make -s scenes >/dev/null
mkdir -p "$out"
frame_count=100 seconds=10
if [ -n "$brief" ]; then frame_count=10 seconds=2; fi
# shellcheck disable=SC2086 # lists
"$build/softlux" bench $scenes --trials "bench/$method.trials" -o "$out" --allow-outside --reference-budget "${REFERENCE_BUDGET:-60}" \
    ${brief:+--size 48x48 --repeats 1 --reference-budget 2}
[ -z "$frames" ] || "$build/bench/bench_frames" bench/frames.trials --table "$frames" ${brief:+--size 48 --frames 10} | tee "$out/frames.md"
[ "$method" != direct-radiance ] || "$build/bench/bench_frames" bench/flicker.trials --frames "$frame_count" | tee -a "$out/frames.md"
for program in $programs; do
    { echo "<!-- table $program -->" && "$build/bench/bench_$program" $brief && echo '<!-- end -->'; } | tee "$out/$program-table.md"
done
# Frames beside updates, by the clock.
if [ "$method" = shading-cache ]; then
    for scene in study study-walk pool-walk; do
        "$build/softlux" live "scenes/generated/$scene.json" --fps 0 --seconds "$seconds" --json >"$out/live-$scene.json"
    done
fi
[ -n "$docs" ] || exit 0
for tables in "$out"/tables.md "$out"/frames.md "$out"/*-table.md; do
    if [ -f "$tables" ]; then bench/fill_tables.sh "$tables" "$pages"; fi
done
