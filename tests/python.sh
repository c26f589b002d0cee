#!/bin/sh
# The Python package: installed by pip from the tree, beside the library installed into a folder of its own, and its tests by Debian's Python.
set -eu
cd "$(dirname "$0")/.."
build=$1
python=/usr/bin/python3
[ -x $python ] || python=python3
for module in cffi numpy pytest pip setuptools; do
    "$python" -c "import $module" 2>/dev/null && continue
    echo "no $module for $python: python3-$module is not installed"
    exit 77
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
prefix=/opt/softlux
make -s BUILD="$build" DESTDIR="$folder" PREFIX=$prefix install
# Pip builds beside the sources: those of a copy.
mkdir -p "$folder/tree" && cp -r include python "$folder/tree"
"$python" -m pip install --quiet --no-index --no-build-isolation --no-deps --no-warn-script-location --target "$folder/packages" "$folder/tree/python"
cmp include/softlux.h "$folder/packages/softlux/softlux.h"
[ "$(find "$folder/packages" -name '*.dist-info')" = "$folder/packages/softlux-$("$build/softlux" --version | cut -d' ' -f2).dist-info" ]
export SOFTLUX_LIBRARY="$folder$prefix/lib/libsoftlux.so" SOFTLUX_IMPORTER="$folder$prefix/libexec/softlux-import"
export PYTHONPATH="$folder/packages" PYTHONDONTWRITEBYTECODE=1
"$python" -m pytest -q -p no:cacheprovider --basetemp "$folder/pytest" python/tests
if SOFTLUX_LIBRARY=$folder/none.so "$python" -c 'import softlux' 2>"$folder/out"; then echo 'imported without a library'; exit 1; fi
grep -q 'ImportError.*SOFTLUX_LIBRARY' "$folder/out"
