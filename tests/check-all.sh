#!/bin/sh
# All that `make check-all` runs: what `make check` does, then the longer ones, a line each; ends with "N passed, N failed".
# Every executable tests/hard/*.sh is one of them: called with the build folder, at the repository's root; exit status 0: passed, 77: cannot
# run here, and its last line says why. Lines that begin with "result " are shown. ONLY=WORD: only those whose names hold the word.
set -u
cd "$(dirname "$0")/.."
jobs=$(nproc)
passed=0 failed=0 failures=

step() { # step NAME COMMAND...
    name=$1
    shift
    case $name in *"${ONLY:-}"*) ;; *) return ;; esac
    start=$(date +%s)
    log=build/check-all-$(echo "$name" | tr -c 'a-zA-Z0-9\n' '-').log
    "$@" >"$log" 2>&1
    status=$?
    seconds=$(($(date +%s) - start))
    case $status in
    0) passed=$((passed + 1)) && echo "ok      $name ($seconds s)" && sed -n 's/^result */          /p' "$log" ;;
    77) echo "skipped $name: $(tail -n 1 "$log")" ;;
    *)
        failed=$((failed + 1))
        failures="$failures, $name"
        echo "FAILED  $name ($seconds s; $log)"
        tail -n 40 "$log" | sed 's/^/          /'
        ;;
    esac
}

fuzz() {
    tests/fuzz/fuzz.sh "${FUZZ_SECONDS:-60}" "$1" >build/fuzz-step.out
    status=$?
    sed 's/^/result /' build/fuzz-step.out
    [ $status -ne 2 ] || status=77 # no clang with libFuzzer, which it has said
    return $status
}

mkdir -p build
step 'make check' tests/check.sh
[ -x build/softlux ] || make -s -j"$jobs" all || exit 1
step 'hard cases with sanitizers: every method' sh -c 'make -s -j"$1" CONFIG=debug BUILD=build/debug build/debug/softlux && build/debug/softlux check-numerics' sh "$jobs"
for script in tests/hard/*.sh; do
    [ -x "$script" ] || continue
    step "$(basename "$script" .sh | tr _ ' ')" "$script" build
done
for target in tests/fuzz/target_*.c; do
    target=$(basename "$target" .c)
    step "fuzzing: ${target#target_}" fuzz "${target#target_}"
done

[ -z "$failures" ] || echo "failed:${failures#,}"
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
