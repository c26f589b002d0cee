#!/bin/sh
# tests/hard/debian.sh BUILD: dpkg-buildpackage makes a library, its development files, a program and a Python package; unpacked into one folder the
# program and Python render what BUILD/softlux does, and a C program is linked.
set -eu
cd "$(dirname "$0")/../.."
build=$1
for command in dpkg-buildpackage dh git; do
    command -v $command >/dev/null || { echo "no $command: debhelper, dpkg-dev and git are wanted"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/tree" "$work/root"
git ls-files -z --cached --others --exclude-standard | tar -c --null -T - | tar -x -C "$work/tree"
(cd "$work/tree" && dpkg-buildpackage -b -us -uc -j"$(nproc)") >"$work/log" 2>&1 || { tail -n 60 "$work/log"; exit 1; }
version=$("$build/softlux" --version | cut -d' ' -f2)
architecture=$(dpkg --print-architecture)
for package in libsoftlux0 libsoftlux-dev softlux python3-softlux; do
    dpkg-deb -x "$work/${package}_${version}_$([ $package = python3-softlux ] && echo all || echo "$architecture").deb" "$work/root"
done
echo "result $(cd "$work" && ls -s --block-size=1K ./*.deb | grep -v dbgsym | sed 's|\./||; s/^ *\([0-9]*\) /\1 KiB /' | tr '\n' ' ')"
dpkg-deb -f "$work/libsoftlux0_${version}_$architecture.deb" Depends | grep -q libembree

root=$work/root library=$(echo "$work"/root/usr/lib/*/libsoftlux.so.0)
export SOFTLUX_IMPORTER="$root/usr/libexec/libsoftlux0/softlux-import" LD_LIBRARY_PATH="${library%/*}"
[ -x "$SOFTLUX_IMPORTER" ]
grep -q /usr/libexec/libsoftlux0/softlux-import "$library"
for program in bin/softlux libexec/libsoftlux0/softlux-import; do
    if readelf -S "$root/usr/$program" | grep -q '\.symtab\|\.debug_info'; then echo "$program is not stripped"; exit 1; fi
done
"$build/softlux" render scenes/cornell.json -s 64x64 -q draft --quiet -o "$work/built.exr"
"$root/usr/bin/softlux" render scenes/cornell.json -s 64x64 -q draft --quiet -o "$work/packed.exr"
cmp "$work/built.exr" "$work/packed.exr"
gcc -I"$root/usr/include" examples/golden_image_test.c -o "$work/golden" -L"${library%/*}" -lsoftlux
"$work/golden" scenes/cornell.json "$work/golden.exr"
if [ -x /usr/bin/python3 ] && /usr/bin/python3 -c 'import cffi, numpy' 2>/dev/null; then
    PYTHONPATH=$root/usr/lib/python3/dist-packages PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 -c '
import softlux, sys
picture = softlux.render("scenes/cornell.json", size=(64, 64), quality="draft")
sys.exit(not softlux.compare(picture, softlux.Image.read(sys.argv[1])).identical)' "$work/golden.exr"
fi
