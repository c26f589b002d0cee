#!/bin/sh
# Installs what softlux needs to build and test, and only what is missing. Debian and its relatives; elsewhere it names the
# missing packages and stops.
set -eu

wanted='gcc make pkg-config libembree-dev libopenexr-dev libassimp-dev libcjson-dev libstb-dev libpng-dev libcmocka-dev'
# What softlux serve speaks, and the pictures that it sends while things move; without them the program says so.
wanted="$wanted libwebsockets-dev libjpeg62-turbo-dev"
# The tests compare compilers, sanitize with clang, compare the rasterizer with Mesa's, build the public header's pages, and open pages of steps
# in a browser; one makes a locale with a decimal comma; and the library is used from Python and CMake, and packed.
tests='clang libomp-dev libclang-rt-dev libosmesa6-dev doxygen chromium chromium-driver locales cmake debhelper'
# Several processes as one, by MPI.
tests="$tests libopenmpi-dev openmpi-bin"
tests="$tests python3-cffi python3-numpy python3-pytest python3-pip python3-setuptools"
[ "${1:-}" = --build-only ] || wanted="$wanted $tests"

# What a package is recognised by where dpkg does not know it.
proof() {
    case $1 in
    gcc | make | clang | doxygen | chromium | cmake) command -v "$1" ;;
    debhelper) command -v dh ;;
    python3-*) "$(ls /usr/bin/python3 2>/dev/null || echo python3)" -c "import ${1#python3-}" ;;
    chromium-driver) command -v chromedriver ;;
    pkg-config) command -v pkg-config ;;
    libembree-dev) ls /usr/include/embree4/rtcore.h /usr/include/embree3/rtcore.h 2>/dev/null | grep . ;;
    libopenexr-dev) ls /usr/include/OpenEXR/openexr.h ;;
    libassimp-dev) ls /usr/include/assimp/cimport.h ;;
    libcjson-dev) ls /usr/include/cjson/cJSON.h ;;
    libstb-dev) ls /usr/include/stb/stb_image.h ;;
    locales) dpkg -s locales || ls /usr/share/i18n/locales/de_DE ;;
    libpng-dev) ls /usr/include/png.h ;;
    libwebsockets-dev) ls /usr/include/libwebsockets.h ;;
    libjpeg62-turbo-dev) ls /usr/include/jpeglib.h ;;
    libcmocka-dev) ls /usr/include/cmocka.h ;;
    libopenmpi-dev) pkg-config --exists ompi-c ;;
    openmpi-bin) command -v mpirun ;;
    libosmesa6-dev) ls /usr/include/GL/osmesa.h /usr/include/EGL/eglext.h 2>/dev/null | grep . ;;
    libomp-dev) echo 'int main(void){return 0;}' | clang -fopenmp -x c - -o /dev/null ;;
    libclang-rt-dev) echo 'int main(void){return 0;}' | clang -fsanitize=thread -x c - -o /dev/null ;;
    esac
}

missing=
for package in $wanted; do
    proof "$package" >/dev/null 2>&1 || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

# Without Mesa's rasterizer those tests skip.
cannot() {
    [ "$missing" = ' libosmesa6-dev' ] && exit 0
    echo "softlux: $1" >&2
    exit 5
}
if ! command -v apt-get >/dev/null 2>&1; then
    cannot "missing (Debian's names):$missing. There is no apt-get here; please install them and try again."
fi
as_root=
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null 2>&1 || cannot "missing packages:$missing. Please install them as root: apt-get install$missing"
    as_root=sudo
fi
echo "softlux: installing$missing"
log=$(mktemp)
# Mesa has dropped OSMesa with release 25.1; the same rasterizer is then reached through EGL.
without_osmesa() {
    apt-cache show libosmesa6-dev >/dev/null 2>&1 || missing=$(echo "$missing" | sed 's/libosmesa6-dev/libegl-dev libgl-dev libegl-mesa0 libgl1-mesa-dri/')
}
install_missing() {
    $as_root apt-get update && without_osmesa && DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y --no-install-recommends $missing
}
if ! install_missing >"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "softlux: apt-get could not install$missing" >&2
    exit 5
fi
rm -f "$log"
