# Sourced by check.sh and check-all.sh: their steps, a line each. Before it: show, a sed script that picks the lines of a step's log to show below it, and
# failed_lines, how many of its last lines to show where it failed. ONLY=WORD: only steps whose names hold the word.
set -u
cd "$(dirname "$0")/.."
jobs=$(nproc)
passed=0 skipped=0 failed=0 failures=
mkdir -p build

step() { # step NAME COMMAND...; exit status 0: passed, 77: cannot run here, and the last line of what it prints says why
    name=$1
    shift
    case $name in *"${ONLY:-}"*) ;; *) return ;; esac
    start=$(date +%s)
    log=build/$(basename "$0" .sh)-$(echo "$name" | tr -c 'a-zA-Z0-9\n' '-').log
    "$@" >"$log" 2>&1
    status=$?
    seconds=$(($(date +%s) - start))
    case $status in
    0)
        passed=$((passed + 1))
        echo "ok      $name ($seconds s)"
        sed -n "$show" "$log" | sed 's/^/          /'
        ;;
    77)
        skipped=$((skipped + 1))
        echo "skipped $name: $(tail -n 1 "$log")"
        ;;
    *)
        failed=$((failed + 1))
        failures="$failures, $name"
        echo "FAILED  $name ($seconds s; $log)"
        tail -n "$failed_lines" "$log" | sed 's/^/          /'
        ;;
    esac
}

conclude() { # the last line, and the exit status: that nothing was tried is no success
    [ -z "$failures" ] || echo "failed:${failures#,}"
    echo "$passed passed, $failed failed"
    [ "$failed" -eq 0 ] && [ $((passed + skipped)) -gt 0 ]
}
