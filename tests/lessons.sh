#!/bin/sh
# Runs every command of the lessons, answers included, and holds the pictures on their pages against what comes out. `--update` takes the new ones
# over instead; a file's name after that: this lesson alone.
set -eu
cd "$(dirname "$0")/.."
build=$1 update=${2:-}
for lesson in ${3:-docs/lessons/[0-9]*.md}; do
    script=$(mktemp)
    awk '/^```sh$/ {on = 1; next} /^```$/ {on = 0} on' "$lesson" >"$script"
    [ -s "$script" ]
    echo "$lesson"
    PATH="$PWD/$build:$PATH" sh -eu "$script"
    rm -f "$script"
    for picture in $(sed -n 's/!\[/\n![/gp' "$lesson" | sed -n 's/^!\[[^]]\{10,\}\](pictures\/\([^)]*\)).*/\1/p'); do
        made=build/lessons/$picture kept=docs/lessons/pictures/$picture
        [ "$update" = --update ] && cp "$made" "$kept"
        "$build/softlux" compare "$made" "$kept" --max-rmse 0 >/dev/null || { echo "$lesson: $picture is not what its commands make"; exit 1; }
    done
done
