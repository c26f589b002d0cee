#!/bin/sh
# quality.sh BUILD [FOLDER]: no quality errs more than the one below it. Every method renders every scene of scenes/, the generated parlours and metals,
# at draft, normal and high; against the reference of its own light paths the error of a quality is to be within 1.05 times that of the one below, and
# what the references' noise leaves open (95 %). References are kept in build/quality-references: a second run goes on refining them. FOLDER keeps the
# reports. SCENES: others than all. About ten minutes of two processors.
set -u
build=${1:-build}
folder=${2:-$(mktemp -d)}
[ -x "$build/softlux" ] && [ -x "$build/generate" ] || { echo "no $build/softlux, $build/generate: make them first"; exit 77; }
[ $# -ge 2 ] || trap 'rm -rf "$folder"' EXIT
mkdir -p "$folder/scenes" || exit 1
"$build/generate" "$folder/scenes" parlour metals >/dev/null || exit 1

# A scene, one processor. --limit is by the clock: far more than any takes.
printf '%s\n' ${SCENES:-scenes/*.json "$folder"/scenes/*.json} | OMP_WAIT_POLICY=passive nice -n 5 xargs -P 2 -I{} sh -c '
    "$1/softlux" bench "$3" -o "$2/$(basename "$3" .json)" -s 48x36 -q draft,normal,high -r 1 -t 1 --limit 600 --references "$1/quality-references" \
        --reference-budget 3 --reference-threads 1 --quiet' sh "$build" "$folder" {} || { echo 'a benchmark failed'; exit 1; }

# Columns by their names; commas within quotes are none.
awk -F, '
    function field(name) { return $(column[name]) }
    function judge(low, high) {
        if (!(low in error) || !(high in error)) return
        pairs++
        if (bound[high] || error[high] - doubt[high] <= 1.05 * (error[low] + doubt[low])) return
        printf "result %-16s %-24s %-6s %6.2f %% +- %.2f, %-6s %6.2f %% +- %.2f\n", scene, curve, high, 100 * error[high], 100 * doubt[high], low,
               100 * error[low], 100 * doubt[low]
        bad++
    }
    function conclude_curve() {
        judge("draft", "normal")
        judge("normal", "high")
        split("", error); split("", doubt); split("", bound)
    }
    {
        parts = split($0, part, "\""); line = ""
        for (i = 1; i <= parts; i++) { if (i % 2 == 0) gsub(/,/, ";", part[i]); line = line part[i] }
        $0 = line
    }
    FNR == 1 { conclude_curve(); for (i = 1; i <= NF; i++) column[$i] = i; scene = FILENAME; sub(/\/results.csv$/, "", scene); sub(/.*\//, "", scene); next }
    field("curve") != curve { conclude_curve() }
    {
        curve = field("curve"); quality = field("quality")
        if (field("end") != "ran" || field("matched") == "") {
            printf "result %-16s %-24s %-6s %s\n", scene, curve, quality, field("end")
            bad++
            next
        }
        error[quality] = field("matched"); doubt[quality] = field("matched.doubt"); bound[quality] = field("matched.lost") == 1
    }
    END {
        conclude_curve()
        printf "result %d faults, %d steps from a quality to the next judged\n", bad, pairs
        exit bad > 0 || !pairs
    }' "$folder"/*/results.csv
