#!/bin/sh
# Runs every command of the README's ```sh blocks, in order, in a copy of a clean checkout's working folder; commands that
# install, or that run the tests this is part of, are left out by the marker "# not here".
set -eu
cd "$(dirname "$0")/.."
script=$(mktemp)
trap 'rm -f "$script"' EXIT
awk '/^```sh$/ {on = 1; next} /^```$/ {on = 0} on' README.md | grep -v '# not here' >"$script"
[ -s "$script" ]
PATH="$PWD/build:$PATH" sh -eux "$script"
# The C example compiles and does what it says.
example=$(mktemp -d)
awk '/^```c$/ {on = 1; next} /^```$/ {on = 0} on' README.md >"$example/golden.c"
[ -s "$example/golden.c" ]
gcc -std=c11 -Wall -Wextra -Iinclude "$example/golden.c" -o "$example/golden" -Lbuild -lsoftlux -lcmocka -Wl,-rpath,"$PWD/build"
"$example/golden"
rm -rf "$example"
