#!/bin/sh
# softlux as a library, installed into a folder of its own: what it exports, the examples in C and C++ against the shared and the static
# library, as pkg-config and CMake find them, manual pages, and the header's pages.
set -eu
cd "$(dirname "$0")/.."
build=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
prefix=/opt/softlux
make -s BUILD="$build" DESTDIR="$folder" PREFIX=$prefix install

lib=$folder$prefix/lib
for f in LICENSE NOTICES; do cmp -s $f "$folder$prefix/share/doc/softlux/$f" || { echo "$f is not installed"; exit 1; }; done
foreign=$(nm -D --defined-only "$lib/libsoftlux.so" | awk '{print $3}' | grep -v '^sl_' || true)
[ -z "$foreign" ] || { echo "the shared library exports $foreign"; exit 1; }
for f in $(sed -n 's/^SL_API[^(]*[ *]\(sl_[a-z_]*\)(.*/\1/p' include/softlux.h); do
    nm -D --defined-only "$lib/libsoftlux.so" | grep -q " $f$" || { echo "the shared library lacks $f"; exit 1; }
done
readelf -d "$lib/libsoftlux.so" | grep -q NODELETE || { echo 'the shared library may be unloaded from under its threads'; exit 1; }
for program in bin/softlux libexec/softlux-import; do
    if readelf -S "$folder$prefix/$program" | grep -q '\.symtab\|\.debug'; then echo "$program is not stripped"; exit 1; fi
done
readelf -d "$lib/libsoftlux.so" | grep -q 'SONAME.*libsoftlux\.so\.[0-9]*\]' || { echo 'the shared library has no version'; exit 1; }

if readelf -d "$lib/libsoftlux.so" | grep -q assimp; then echo 'the shared library links Assimp, which is softlux-import'"'"'s alone'; exit 1; fi

PKG_CONFIG_PATH=$lib/pkgconfig PKG_CONFIG_SYSROOT_DIR=$folder
export PKG_CONFIG_PATH PKG_CONFIG_SYSROOT_DIR
[ "$(pkg-config --modversion softlux)" = "$("$build/softlux" --version | cut -d' ' -f2)" ]
strict='-Wall -Wextra -Wpedantic -Werror'
shared="$(pkg-config --cflags --libs softlux) -Wl,-rpath,$lib"
mkdir "$folder/archive"
cp "$lib/libsoftlux.a" "$folder/archive"
# shellcheck disable=SC2046,SC2086
{
    gcc -std=c11 $strict examples/golden_image_test.c -o "$folder/c" $shared
    g++ -std=c++11 -x c++ $strict examples/golden_image_test.c -o "$folder/c++" $shared
    gcc -std=c11 $strict examples/build_scene.c -o "$folder/build_scene" $shared
    gcc -std=c11 $strict examples/moving_lamp.c -o "$folder/moving_lamp" $shared -lm
    g++ -std=c++11 $strict examples/render.cpp -o "$folder/render" $shared
    gcc -std=c11 $strict examples/golden_image_test.c -o "$folder/static" $(pkg-config --static --cflags --libs softlux | sed "s|-L$lib|-L$folder/archive|")
}
# The importer is looked for where it will be, not where this folder is; both libraries say so in one line.
mesh=$folder/triangle.ply
printf '%s\n' ply 'format ascii 1.0' 'element vertex 3' 'property float x' 'property float y' 'property float z' 'element face 1' \
    'property list uchar int vertex_indices' end_header '0 0 0' '1 0 0' '0 1 0' '3 0 1 2' >"$mesh"
for program in c static; do
    if "$folder/$program" "$mesh" "$folder/mesh.exr" >"$folder/out" 2>&1; then echo 'nothing was installed there'; exit 1; fi
    [ "$(grep -c "$prefix/libexec/softlux-import, cannot be started" "$folder/out")" -eq 1 ] || { cat "$folder/out"; exit 1; }
done
export SOFTLUX_IMPORTER="$folder$prefix/libexec/softlux-import"
"$folder/static" "$mesh" "$folder/mesh.exr"
"$folder/c" scenes/cornell.json "$folder/golden.exr"
for program in c c++ static; do "$folder/$program" scenes/cornell.json "$folder/golden.exr" | grep -q identical; done
"$folder/render" scenes/cornell.json "$folder/render.exr" size=64x64 quality=draft >/dev/null
"$build/softlux" compare "$folder/render.exr" "$folder/golden.exr" --identical >/dev/null
"$folder/build_scene" "$folder/built.json" "$folder/built.exr"
"$build/softlux" render "$folder/built.json" -q draft -o "$folder/read.exr" --quiet
"$build/softlux" compare "$folder/built.exr" "$folder/read.exr" --identical >/dev/null
"$folder/moving_lamp" direct-radiance 3 "$folder/lamp"
[ "$(cksum "$folder"/lamp-00[012].png | cut -d' ' -f1 | sort -u | wc -l)" -eq 3 ] || { echo 'what moves is not seen'; exit 1; }
if "$folder/render" scenes/cornell.json "$folder/render.exr" no-such=1 2>"$folder/out"; then exit 1; fi
grep -qx 'unknown option no-such' "$folder/out"
if "$folder/c" scenes/two-rooms.json "$folder/golden.exr" >"$folder/out"; then
    echo 'the example took another picture for the golden one'; exit 1
fi

for command in $("$build/softlux" --help | sed -n '/^commands:/,/^$/s/^  \([a-z-]*\) .*/\1/p'); do
    page=$folder$prefix/share/man/man1/softlux-$command.1
    grep -q '^.SH SYNOPSIS' "$page"
    for option in $("$build/softlux" "$command" --help | sed -n 's/^  .*--\([a-z-]*\) .*/\1/p' | grep -v '^man$'); do
        grep -q "$(printf '%s' "$option" | sed 's/-/.-/g')" "$page" || { echo "softlux-$command(1) lacks --$option"; exit 1; }
    done
    ! command -v groff >/dev/null || [ -z "$(groff -man -ww -Tutf8 -z "$page" 2>&1)" ]
done

if command -v cmake >/dev/null; then
    mkdir "$folder/cmake"
    cp examples/golden_image_test.c "$folder/cmake"
    cat >"$folder/cmake/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.16)
project(golden C)
find_package(softlux 0.1 REQUIRED)
foreach(library softlux static)
  add_executable(with-${library} golden_image_test.c)
  target_link_libraries(with-${library} softlux::${library})
endforeach()
END
    cmake -S "$folder/cmake" -B "$folder/cmake/build" -DCMAKE_PREFIX_PATH="$folder$prefix" >/dev/null
    cmake --build "$folder/cmake/build" >/dev/null
    for program in softlux static; do "$folder/cmake/build/with-$program" scenes/cornell.json "$folder/golden.exr" | grep -q identical; done
    sed -i 's/softlux 0.1/softlux 9.0/' "$folder/cmake/CMakeLists.txt"
    if cmake -S "$folder/cmake" -B "$folder/cmake/build" >/dev/null 2>&1; then echo 'CMake takes any version'; exit 1; fi
else echo 'skip: find_package(softlux): no cmake'; fi
if command -v doxygen >/dev/null; then make -s BUILD="$build" doc; else echo 'skip: the pages of the header: no doxygen'; fi
make -s BUILD="$build" DESTDIR="$folder" PREFIX=$prefix uninstall
[ -z "$(find "$folder$prefix" -type f -o -type l)" ] || { echo 'uninstall left files'; exit 1; }
