#!/bin/sh
# bench/experiments.sh NAME PROGRAMS BUILD [--brief|--once] [--docs] [EXPERIMENT ...]: the experiments on one method, all of PROGRAMS or those
# named; what splatting.sh and direct_radiance.sh share. Tables go to the terminal and, as Markdown and CSV, to build/NAME/ (brief ones to
# build/NAME-brief/). With --docs the Markdown, without columns that hold nothing, also replaces what stands between the markers of
# docs/NAME-experiments.md.
set -eu
cd "$(dirname "$0")/.."
name=$1 programs=$2 build=$3
shift 3
folder=build/$name options='' docs='' experiments=''
for word in "$@"; do
    case $word in
    --brief) options='--brief' folder=build/$name-brief ;;
    --once) options='--once' ;;
    --docs) docs=docs/$name-experiments.md ;;
    *) experiments="$experiments $word" ;;
    esac
done
[ -f scenes/generated/ring.json ] || make -s scenes >/dev/null
for experiment in ${experiments:-$programs}; do
    [ -x "$build/bench/bench_$experiment" ] || continue
    echo "== $experiment: softlux $("$build/softlux" --version | cut -d' ' -f2), commit $(git rev-parse --short HEAD 2>/dev/null || echo unknown)," \
        "$(nproc) processors,$(sed -n 's/^model name[^:]*:/ /p' /proc/cpuinfo | head -n 1)"
    "$build/bench/bench_$experiment" $options --pictures --out "$folder"
    [ -n "$docs" ] || continue
    awk -f bench/full_columns.awk "$folder/$experiment.md" >"$folder/$experiment-full.md"
    awk -v name="$experiment" -v file="$folder/$experiment-full.md" '
        $0 == "<!-- end " name " -->" { while ((getline line < file) > 0) print line; print ""; inside = 0 }
        !inside { print }
        $0 == "<!-- begin " name " -->" { inside = 1 }' "$docs" >"$docs.new"
    mv "$docs.new" "$docs"
    for picture in "$folder"/*.svg; do
        if [ -f "$picture" ]; then cp "$picture" docs/pictures/; fi
    done
done
