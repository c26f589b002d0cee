#!/bin/sh
# packaging/sysroot.sh FOLDER ARCHITECTURE: unpacks what softlux needs of Debian's packages for another machine into a folder
# that a cross compiler takes for /, and an emulator too. Needs no root and leaves this machine's packages alone.
set -eu
folder=$1 architecture=$2
packages='libc6-dev libgcc-12-dev libgomp1 libembree-dev libopenexr-dev libassimp-dev libcjson-dev libstb-dev libpng-dev'
packages="$packages libcmocka-dev libwebsockets-dev libjpeg62-turbo-dev libosmesa6-dev"
[ ! -e "$folder/complete" ] || exit 0
mkdir -p "$folder/apt/lists/partial" "$folder/apt/archives/partial"
folder=$(cd "$folder" && pwd)
: >"$folder/apt/status" # nothing is there, so that all that these packages need is fetched too

fetch() {
    apt-get -q -y -o APT::Architecture="$architecture" -o APT::Architectures="$architecture" \
        -o Dir::State="$folder/apt" -o Dir::State::status="$folder/apt/status" -o Dir::Cache="$folder/apt" \
        -o APT::Install-Recommends=0 -o APT::Sandbox::User= -o Debug::NoLocking=1 "$@"
}

log=$folder/apt/log
# shellcheck disable=SC2086
if ! { fetch update && fetch --download-only install $packages; } >"$log" 2>&1; then
    tail -n 5 "$log" >&2
    echo "softlux: apt-get could not fetch the packages for $architecture" >&2
    exit 5
fi
for package in "$folder"/apt/archives/*.deb; do dpkg -x "$package" "$folder"; done
rm -rf "$folder/apt"
touch "$folder/complete"
