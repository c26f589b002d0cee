#!/bin/sh
# The includes of each folder under src/ point only down the house: base < image, scene < raster, trace < cache < app;
# raster and trace do not know each other, and a method in cache knows no other method.
set -u
cd "$(dirname "$0")/../src"
bad=0
allow() { # allow FOLDER REGEX-OF-ALLOWED
    found=$(grep -rnE '^#include "' "$1" | grep -vE "#include \"(softlux\.h|$2)" || true)
    [ -z "$found" ] || { echo "$found"; bad=1; }
}
allow base 'base/'
allow image '(base|image)/'
allow scene '(base|image|scene)/'
allow raster '(base|image|scene|raster)/'
allow trace '(base|image|scene|trace)/'
allow cache '(base|image|scene|raster|trace|cache)/'
allow cache/splatting '(base|image|scene|raster|trace|cache/(splatting|gather|method))'
allow cache/gather '(base|image|scene|raster|trace|cache/gather)/'
allow app '(app|scene/features)'
# Every symbol that the library shows begins with sl_.
library=../build/libsoftlux.so
[ -f $library ] || { echo "no $library: make it first"; exit 1; }
foreign=$(nm -D --defined-only $library | awk '$2 ~ /[TDRB]/ {print $3}' | grep -v '^sl_\|^_init$\|^_fini$\|^__' || true)
[ -z "$foreign" ] || { echo "exported: $foreign"; bad=1; }
exit $bad
