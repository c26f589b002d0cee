# Markdown as it is, but its tables without the columns that hold nothing: what was not measured.
function end_table(    row, column, line) {
    for (row = 1; row <= rows; row++) {
        line = "|"
        for (column = 2; column < columns; column++)
            if (rows < 3 || column in full) line = line cell[row, column] "|"
        print line
    }
    rows = 0
    split("", full)
}
/^\|.*\|$/ {
    rows++
    columns = split($0, parts, "|")
    for (column = 2; column < columns; column++) {
        cell[rows, column] = parts[column]
        if (rows > 2 && parts[column] ~ /[^ ]/) full[column] = 1
    }
    next
}
{ if (rows) end_table(); print }
END { if (rows) end_table() }
