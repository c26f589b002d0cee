#!/bin/sh
# Prints as one JSON object the functions that narratives.json names, from their comments' first line to their last:
# {"sl_direct_rows(), src/cache/light/direct_rays.c": {"file": .., "first": line, "text": ..}, ...}
set -eu
echo '{'
grep -ohE 'sl_[a-z0-9_]+\(\), src/[a-z_/]+\.c' src/app/steps/narratives.json | sort -u | while read -r name file; do
    awk -v name="${name%%(*}" -v file="$file" '
        function quoted(s) { gsub(/\\/, "\\\\", s); gsub(/"/, "\\\"", s); gsub(/\t/, "\\t", s); return s }
        body && NR > begun { text = text "\\n" quoted($0); if ($0 ~ /^}/) exit; next }
        /^$/ || /^}/ || /^#/ { kept = ""; next }
        { kept = kept == "" ? quoted($0) : kept "\\n" quoted($0); if (kept == quoted($0)) first = NR }
        $0 ~ "^[a-z].*[ *]" name "\\(" && $0 !~ /;$/ { body = 1; begun = NR; text = kept }
        END { if (text != "") printf "\"%s(), %s\": {\"file\": \"%s\", \"first\": %d, \"text\": \"%s\"},\n", name, file, file, first, text }
    ' "$file"
done
echo '"": {}}'
