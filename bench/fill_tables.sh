#!/bin/sh
# bench/fill_tables.sh TABLES PAGE...: puts the tables of TABLES (softlux bench writes tables.md) into pages, between the marks <!-- table NAME --> and
# <!-- end --> that stand in both. A mark that TABLES does not know keeps what is between its own.
set -eu
tables=$1
shift
for page in "$@"; do
    awk '
        function name_of(line) { sub(/^<!-- table /, "", line); sub(/ -->$/, "", line); return line }
        /^<!-- table / { name = name_of($0); if (NR != FNR) print; if (NR != FNR && name in text) { printf "%s", text[name]; skipping = 1 } if (NR == FNR) text[name] = ""; next }
        /^<!-- end -->$/ { if (NR != FNR) print; name = ""; skipping = 0; next }
        NR == FNR { if (name != "") text[name] = text[name] $0 "\n"; next }
        !skipping { print }
    ' "$tables" "$page" >"$page.new"
    mv "$page.new" "$page"
done
