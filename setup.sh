#!/bin/sh
# Installs what softlux needs to build and test, and only what is missing. Debian and its relatives; elsewhere it names the
# missing packages and stops.
set -eu

wanted='gcc make pkg-config libembree-dev libopenexr-dev libassimp-dev libcjson-dev libstb-dev libpng-dev libcmocka-dev'
# The tests compare compilers, and sanitize with clang.
tests='clang libomp-dev libclang-rt-dev'
[ "${1:-}" = --build-only ] || wanted="$wanted $tests"

# What a package is recognised by where dpkg does not know it.
proof() {
    case $1 in
    gcc | make | clang) command -v "$1" ;;
    pkg-config) command -v pkg-config ;;
    libembree-dev) ls /usr/include/embree4/rtcore.h /usr/include/embree3/rtcore.h 2>/dev/null | grep . ;;
    libopenexr-dev) ls /usr/include/OpenEXR/openexr.h ;;
    libassimp-dev) ls /usr/include/assimp/cimport.h ;;
    libcjson-dev) ls /usr/include/cjson/cJSON.h ;;
    libstb-dev) ls /usr/include/stb/stb_image.h ;;
    libpng-dev) ls /usr/include/png.h ;;
    libcmocka-dev) ls /usr/include/cmocka.h ;;
    libomp-dev) echo 'int main(void){return 0;}' | clang -fopenmp -x c - -o /dev/null ;;
    libclang-rt-dev) echo 'int main(void){return 0;}' | clang -fsanitize=thread -x c - -o /dev/null ;;
    esac
}

missing=
for package in $wanted; do
    proof "$package" >/dev/null 2>&1 || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

if ! command -v apt-get >/dev/null 2>&1; then
    echo "softlux: missing (Debian's names):$missing. There is no apt-get here; please install them and try again." >&2
    exit 5
fi
as_root=
if [ "$(id -u)" -ne 0 ]; then
    if command -v sudo >/dev/null 2>&1; then as_root=sudo; else
        echo "softlux: missing packages:$missing. Please install them as root: apt-get install$missing" >&2
        exit 5
    fi
fi
echo "softlux: installing$missing"
log=$(mktemp)
if ! { $as_root apt-get update && DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y --no-install-recommends $missing; } >"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "softlux: apt-get could not install$missing" >&2
    exit 5
fi
rm -f "$log"
