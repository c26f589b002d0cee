#!/bin/sh
# bench/splatting.sh BUILD [--brief|--once] [--docs] [EXPERIMENT ...]: the five experiments on radiance cache splatting, all of them or those
# named: table1, table2, glossy, walk, curve. Tables go to the terminal and, as Markdown and CSV, to build/splatting/ (brief ones to
# build/splatting-brief/); --once measures each thing once, with one thread. With --docs the Markdown also replaces the tables of docs/splatting-experiments.md.
set -eu
cd "$(dirname "$0")/.."
build=$1
shift
folder=build/splatting options='' docs='' experiments=''
for word in "$@"; do
    case $word in
    --brief) options='--brief' folder=build/splatting-brief ;;
    --once) options='--once' ;;
    --docs) docs=docs/splatting-experiments.md ;;
    *) experiments="$experiments $word" ;;
    esac
done
[ -f scenes/generated/atrium.json ] || make -s scenes >/dev/null
for name in ${experiments:-table1 table2 glossy walk curve}; do
    [ -x "$build/bench/bench_$name" ] || continue
    echo "== $name: softlux $("$build/softlux" --version | cut -d' ' -f2), commit $(git rev-parse --short HEAD 2>/dev/null || echo unknown)," \
        "$(nproc) processors,$(sed -n 's/^model name[^:]*:/ /p' /proc/cpuinfo | head -n 1)"
    "$build/bench/bench_$name" $options --pictures --out "$folder"
    [ -n "$docs" ] || continue
    awk -v name="$name" -v file="$folder/$name.md" '
        $0 == "<!-- end " name " -->" { while ((getline line < file) > 0) print line; print ""; inside = 0 }
        !inside { print }
        $0 == "<!-- begin " name " -->" { inside = 1 }' "$docs" >"$docs.new"
    mv "$docs.new" "$docs"
    if [ "$name" = curve ]; then cp "$folder"/curve-*.svg docs/pictures/; fi
done
