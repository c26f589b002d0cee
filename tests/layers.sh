#!/bin/sh
# The includes of each folder under src/ point only down the house: base < image, scene < raster, trace < cache < app;
# raster and trace do not know each other, and a method in cache knows no other method. And what else grep can tell of all the source.
set -u
cd "$(dirname "$0")/../src"
bad=0
allow() { # allow FOLDER REGEX-OF-ALLOWED
    [ -d "$1" ] || return
    found=$(grep -rnE '^#include "' "$1" | grep -vE "#include \"(softlux\.h|$2)" || true)
    [ -z "$found" ] || { echo "$found"; bad=1; }
}
allow base 'base/'
allow image '(base|image)/'
allow scene '(base|image|scene)/'
allow import '(import|base|image|scene)/'
allow raster '(base|image|scene|raster)/'
allow trace '(base|image|scene|trace)/'
allow cache '(base|image|scene|raster|trace|cache)/'
# Floors that methods share, from the bottom up; then splatting, whose records bounces keeps where no eye sees them.
below='base|image|scene|raster|trace'
allow cache/frame "($below|cache/frame)/"
allow cache/light "($below|cache/(light/|frame/picture_value))"
allow cache/hemisphere "($below|cache/(hemisphere|light))/"
allow cache/reflect "($below|cache/(reflect/|frame/picture_value))"
allow cache/bounces "($below|cache/(bounces|hemisphere|light|splatting/record|frame/))"
allow cache/splatting "($below|cache/(splatting|bounces|hemisphere|reflect|light|frame/))"
allow cache/direct_radiance "($below|cache/(direct_radiance|reflect|light|frame/))"
allow cache/photons "($below|cache/photons)/"
allow cache/light_octree "($below|cache/(light_octree|photons|reflect|light|frame/))"
allow cache/patches "($below|cache/(patches|light/|frame/picture_value))"
allow cache/multi_mesh "($below|cache/(patches|multi_mesh|light|hemisphere/gather|frame/))"
allow cache/shading_cache "($below|cache/(patches|shading_cache|photons|light|frame/))"
allow cache/reference "($below|cache/(reference|frame/))"
# The judge of pictures knows no method, only what light paths each declares.
allow cache/audit "($below|cache/(audit|frame/))"
# Pages of steps draw marks over pictures, which takes the camera, and rays that tell what is hidden; what measures methods asks which light paths
# each declares. Pictures in pages are encoded and pages written as those in files are.
allow app '(app/|scene/(features|scene)|base/(batch|counters|error|grow|memory|random|ranks|sanitized|thread|values|vec)|image/(color|formats|output_file|tone)|trace/trace|cache/frame/(all_light|live|method|settings)\.h)'
# Nobody can look up numbers of a document that is not here: features, formulas in boxes, pages by their names; in tests and experiments no more than
# in the library. A section's number stands in one line with the year of the paper that has it, or "of the paper" where its experiments are repeated,
# or with OpenGL's version; flip.c says once whose they are; a pass announces its own paper's.
refer() { grep -rnIE --exclude-dir=golden --exclude-dir=corpus --exclude=layers.sh "$1" . ../include ../tests ../bench; }
found=$(refer 'cache-math|radiance-cache-splatting|boxed formula|(^|[^A-Za-z/_])spec/|(^|[^A-Za-z0-9_])[FG][0-9]{1,2}([^A-Za-z0-9_.]|$)' || true)
[ -z "$found" ] || { echo "refers to what is not in the repository: $found"; bad=1; }
found=$(refer '[Ss]ections? [0-9]' | grep -vE '(19|20)[0-9][0-9]|OpenGL [0-9]|[Ss]ection [0-9.]+ of the paper|"sections? [0-9]|^\./image/flip\.c:' || true)
[ -z "$found" ] || { echo "whose section? $found"; bad=1; }
# Pages of steps name functions and the files that hold them.
found=$(grep -rhoE 'sl_[a-z0-9_]+\(\), src/[a-z_/]+\.c' --include=narratives.json app/steps | sort -u |
    while read -r name file; do grep -qsE "\<${name%%(*})?\(" "../$file" || echo "$name $file"; done)
[ -z "$found" ] || { echo "a page of steps names what is not there: $found"; bad=1; }
# Every symbol that the library shows begins with sl_.
library=../build/libsoftlux.so
[ -f $library ] || { echo "no $library: make it first"; exit 1; }
foreign=$(nm -D --defined-only $library | awk '$2 ~ /[TDRB]/ {print $3}' | grep -v '^sl_\|^_init$\|^_fini$\|^__' || true)
[ -z "$foreign" ] || { echo "exported: $foreign"; bad=1; }
exit $bad
