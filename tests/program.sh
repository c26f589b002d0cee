#!/bin/sh
# The program from outside: what it prints, the statuses it ends with, the files it leaves or does not leave.
set -u
program=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
bad=0

expect() { # expect STATUS PATTERN-OF-OUTPUT ARGUMENTS...: and on failure exactly one line on stderr
    wanted=$1 pattern=$2
    shift 2
    "$program" "$@" >"$folder/out" 2>"$folder/err"
    status=$?
    if [ $status -ne "$wanted" ]; then
        echo "softlux $*: status $status, expected $wanted"; cat "$folder/err"; bad=1
    elif ! cat "$folder/out" "$folder/err" | grep -qE -- "$pattern"; then
        echo "softlux $*: expected /$pattern/ in:"; cat "$folder/out" "$folder/err"; bad=1
    elif [ "$wanted" -ge 2 ] && [ "$(wc -l <"$folder/err")" -ne 1 ]; then
        echo "softlux $*: expected one line of error, got:"; cat "$folder/err"; bad=1
    fi
}

expect 0 'usage: softlux' --help
expect 0 'softlux [0-9]' --version
expect 2 'did you mean render' rendr
for command in render compare info; do expect 0 'usage: softlux' $command --help; done
expect 2 'did you mean --quality' render scenes/cornell.json --qality high
expect 2 'expected one of draft' render scenes/cornell.json -q best
expect 2 'WIDTHxHEIGHT' render scenes/cornell.json --size 64
expect 2 'unknown method' render scenes/cornell.json -s 8x8 -m magic -o "$folder/a.exr"
expect 2 'matched:METHOD' render scenes/cornell.json -s 8x8 -m path --transport some -o "$folder/a.exr"
expect 2 'ends with .exr' render scenes/cornell.json -o "$folder/a.gif"
expect 3 'nowhere.json' render nowhere.json -o "$folder/a.exr"
printf '{"softlux": 1,\n "meshes": [{"file": "%s/scenes/cornell.obj"}],\n "camra": {}}' "$PWD" >"$folder/bad.json"
expect 3 'bad.json:3: .*camera' render "$folder/bad.json" -o "$folder/a.exr"
expect 4 'no-such-folder' render scenes/cornell.json -s 8x8 -q draft --quiet -o "$folder/no-such-folder/a.exr"
[ -z "$(ls "$folder" | grep '^a\.')" ] || { echo 'a failed render left a file'; bad=1; }

expect 0 '"records"' render scenes/cornell.json -s 32x32 -q draft --json --quiet -o "$folder/a.exr"
for key in method size threads seconds batches memory_bytes counters; do
    grep -q "\"$key\"" "$folder/out" || { echo "render --json lacks $key"; bad=1; }
done
expect 0 'triangles' info scenes/cornell.json
expect 0 'skip *mirrors' info scenes/cornell.json
expect 0 'rmse' compare "$folder/a.exr" "$folder/a.exr" --identical
expect 0 '"identical"' compare "$folder/a.exr" "$folder/a.exr" --json
for key in rmse rel_rmse rel_mse max_abs bias ssim flip nonfinite negative identical; do
    grep -q "\"$key\"" "$folder/out" || { echo "compare --json lacks $key"; bad=1; }
done
expect 0 '' render scenes/cornell.json -s 32x32 -q draft --seed 7 --quiet -o "$folder/b.exr"
expect 1 'identical' compare "$folder/b.exr" "$folder/a.exr" --identical
expect 0 '' compare "$folder/b.exr" "$folder/a.exr" --max-rel-rmse 0.5
expect 1 '' compare "$folder/b.exr" "$folder/a.exr" --max-rmse 0
expect 3 '' compare "$folder/a.exr" "$folder/none.exr"

# A picture stopped early has the same bits as one stopped at the same number of batches.
expect 0 '' render scenes/cornell.json -s 48x48 -q draft --batches 5 --quiet -o "$folder/c.pfm"
expect 0 '' render scenes/cornell.json -s 48x48 -q draft --batches 5 --quiet -t 1 -o "$folder/d.pfm"
cmp -s "$folder/c.pfm" "$folder/d.pfm" || { echo '--batches 5 twice gives other bits'; bad=1; }

# Ctrl-C writes what is done and says so.
"$program" render scenes/cornell.json -s 512x512 -m path --spp 100000 -o "$folder/i.exr" 2>"$folder/err" &
pid=$!
sleep 2
kill -INT $pid
wait $pid
status=$?
[ $status -eq 0 ] && [ -s "$folder/i.exr" ] && grep -q 'holds what was done' "$folder/err" ||
    { echo "interrupted: status $status"; cat "$folder/err"; bad=1; }
exit $bad
