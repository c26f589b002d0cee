#!/bin/sh
# tests/hard/scene_folder.sh BUILD: every file of a folder of real and of damaged scenes (SOFTLUX_CORPUS, or ../shared/scenes) ends in a picture or in
# one line on stderr and exit status 3, within 60 s and 4 GB of addresses; and again with the sanitizers of BUILD/debug where that is built, within
# 4 GB of memory. REFUSALS=FILE keeps the lines, to be read.
set -u
cd "$(dirname "$0")/../.."
build=$1
folder=${SOFTLUX_CORPUS:-../shared/scenes}
[ -d "$folder" ] || { echo "skip: no folder $folder (set SOFTLUX_CORPUS)"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export OMP_WAIT_POLICY=passive ASAN_OPTIONS="hard_rss_limit_mb=4096:allocator_may_return_null=1:detect_leaks=0:exitcode=86" # the importer leaks where it gives up
: >"$work/refusals"

# Pictures, buffers and notes too: what is no scene is refused like what is a damaged one.
find "$folder" -type f | sort >"$work/files"

try() { # try SOFTLUX KILOBYTES WHAT
    pictures=0 refused=0 bad=0
    while read -r file; do
        rm -f "$work/x.pfm"
        (
            [ "$2" -eq 0 ] || ulimit -v "$2"
            exec timeout 60 "$1" render "$file" -m path --spp 1 -s 16x16 --threads 1 --quiet -o "$work/x.pfm"
        ) >"$work/out" 2>"$work/err" </dev/null
        status=$?
        if [ $status -eq 0 ] && [ -s "$work/x.pfm" ] && [ ! -s "$work/err" ]; then
            pictures=$((pictures + 1))
        elif [ $status -eq 3 ] && [ ! -e "$work/x.pfm" ] && [ "$(wc -l <"$work/err")" -eq 1 ] && grep -q "^softlux: .*$(basename "$file")" "$work/err"; then
            refused=$((refused + 1))
            cat "$work/err" >>"$work/refusals"
        else
            bad=$((bad + 1))
            echo "$file: status $status"
            head -n 20 "$work/err"
        fi
    done <"$work/files"
    echo "result $3: $((pictures + refused + bad)) files, $pictures pictures, $refused refused in one line, $bad neither"
    [ $((pictures + refused)) -gt 0 ] && [ $bad -eq 0 ]
}

good=0
try "$build/softlux" 4000000 'as it is' || good=1
[ -z "${REFUSALS:-}" ] || cp "$work/refusals" "$REFUSALS"
sanitized=$build/debug/softlux
if [ -x "$sanitized" ]; then try "$sanitized" 0 'with sanitizers' || good=1; else echo "skip: $sanitized is not built"; fi
exit $good
