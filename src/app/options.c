#include "app/options.h"

#include "app/manual.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static size_t smaller(size_t a, size_t b) { return a < b ? a : b; }

/* Levenshtein distance; words longer than the row are taken as far apart. */
static size_t edit_distance(const char *a, const char *b) {
    enum { LONGEST = 64 };
    size_t row[LONGEST + 1], a_length = strlen(a), b_length = strlen(b);
    if (a_length > LONGEST || b_length > LONGEST) return LONGEST;
    for (size_t j = 0; j <= b_length; j++) row[j] = j;
    for (size_t i = 1; i <= a_length; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b_length; j++) {
            size_t above = row[j];
            row[j] = smaller(smaller(above, row[j - 1]) + 1, diagonal + (a[i - 1] != b[j - 1]));
            diagonal = above;
        }
    }
    return row[b_length];
}

const char *sl_nearest_word(const char *word, const char *const *candidates, size_t count) {
    const char *nearest = NULL;
    size_t best = strlen(word) / 3 + 2; /* a word further off than this is another word, not a slip */
    for (size_t i = 0; i < count; i++) {
        size_t distance = edit_distance(word, candidates[i]);
        if (distance < best) best = distance, nearest = candidates[i];
    }
    return nearest;
}

static void print_option(const sl_option *o) {
    char left[64], letter[8] = "    ";
    if (o->kind == SL_OPTION_HEADING) {
        printf("\n%s:\n", o->help);
        return;
    }
    if (o->letter) snprintf(letter, sizeof letter, "-%c, ", o->letter);
    snprintf(left, sizeof left, "%s--%s%s%s", letter, o->name, o->metavar ? " " : "", o->metavar ? o->metavar : "");
    printf("  %-32s %s\n", left, o->help);
}

static void print_help(const sl_command_line *line) {
    printf("usage: %s\n\n%s\n\noptions:\n", line->usage, line->summary);
    printf("  %-32s %s\n", "-h, --help", "this page");
    printf("  %-32s %s\n", "    --man", "this page as a manual page, for man(1)");
    for (const sl_option *o = line->options; o->name; o++) print_option(o);
    if (line->details) printf("\n%s\n", line->details);
}

__attribute__((format(printf, 2, 3))) static bool mistake(int *status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs("softlux: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    *status = 2;
    return false;
}

static bool unknown_option(const sl_command_line *line, const char *word, int *status) {
    enum { NAMES = 128 };
    const char *names[NAMES];
    size_t count = 0;
    for (const sl_option *o = line->options; o->name && count < NAMES; o++) {
        if (o->kind != SL_OPTION_HEADING) names[count++] = o->name;
    }
    const char *near = sl_nearest_word(word, names, count);
    if (near) return mistake(status, "unknown option --%s; did you mean --%s?", word, near);
    return mistake(status, "unknown option --%s; see --help", word);
}

static bool within_bounds(const sl_option *o, double value) {
    return !(o->minimum < o->maximum) || (value >= o->minimum && value <= o->maximum);
}

static bool parse_real(const sl_option *o, const char *text, int *status) {
    char *end;
    double value = strtod(text, &end);
    if (end == text || *end || !isfinite(value)) return mistake(status, "--%s: expected a number, got '%s'", o->name, text);
    if (!within_bounds(o, value))
        return mistake(status, "--%s: expected %g to %g, got %s", o->name, o->minimum, o->maximum, text);
    *(double *)o->value = value;
    return true;
}

static bool parse_count(const sl_option *o, const char *text, int *status) {
    char *end;
    errno = 0;
    unsigned long long value = strtoull(text, &end, 10);
    if (text[0] < '0' || text[0] > '9' || *end || errno)
        return mistake(status, "--%s: expected a whole number, got '%s'", o->name, text);
    if (!within_bounds(o, (double)value))
        return mistake(status, "--%s: expected %.0f to %.0f, got %s", o->name, o->minimum, o->maximum, text);
    *(uint64_t *)o->value = value;
    return true;
}

static bool parse_choice(const sl_option *o, const char *text, int *status) {
    size_t count = 0;
    char all[512] = "";
    for (; o->choices[count]; count++) {
        if (strcmp(text, o->choices[count]) == 0) {
            *(int *)o->value = (int)count;
            return true;
        }
        size_t used = strlen(all);
        snprintf(all + used, sizeof all - used, "%s%s", count ? ", " : "", o->choices[count]);
    }
    const char *near = sl_nearest_word(text, o->choices, count);
    return mistake(status, "--%s: expected one of %s; got '%s'%s%s%s", o->name, all, text, near ? ", did you mean " : "",
                   near ? near : "", near ? "?" : "");
}

static bool parse_size(const sl_option *o, const char *text, int *status) {
    int width, height, used = 0;
    bool read = sscanf(text, "%5dx%5d%n", &width, &height, &used) == 2 && !text[used];
    if (!read || width < 1 || height < 1 || width > 32768 || height > 32768)
        return mistake(status, "--%s: expected WIDTHxHEIGHT in pixels, 1 to 32768 each, got '%s'", o->name, text);
    ((int *)o->value)[0] = width;
    ((int *)o->value)[1] = height;
    return true;
}

static bool parse_vector(const sl_option *o, const char *text, int *status) {
    const char *at = text;
    for (int i = 0; i < 3; i++) {
        char *end;
        double value = strtod(at, &end);
        if (end == at || !isfinite(value) || *end != (i < 2 ? ',' : '\0')) return mistake(status, "--%s: expected three numbers, as 1,2.5,-3, got '%s'", o->name, text);
        ((double *)o->value)[i] = value;
        at = end + 1;
    }
    return true;
}

/* K, M, G and T are powers of 1024; a B or iB after them is allowed. */
static bool parse_bytes(const sl_option *o, const char *text, int *status) {
    static const char units[] = "kmgt";
    char *end;
    double value = text[0] >= '0' && text[0] <= '9' ? strtod(text, &end) : -1.0;
    if (value >= 0.0 && *end) {
        const char *unit = strchr(units, *end | 0x20);
        if (unit) value *= (double)(1ull << 10 * (unit - units + 1)), end++;
        if (unit && *end == 'i') end++;
        if (*end == 'B' || *end == 'b') end++;
    }
    if (!(value >= 0.0) || *end) return mistake(status, "--%s: expected bytes, as 512M or 2G, got '%s'", o->name, text);
    if (!within_bounds(o, value)) return mistake(status, "--%s: expected %.0fM to %.0fG, got %s", o->name, o->minimum / 0x1p20, o->maximum / 0x1p30, text);
    *(uint64_t *)o->value = (uint64_t)value;
    return true;
}

static bool take_value(const sl_option *o, const char *text, int *status) {
    if (o->given) *o->given = true;
    switch (o->kind) {
    case SL_OPTION_FLAG: *(bool *)o->value = true; return true;
    case SL_OPTION_TEXT: *(const char **)o->value = text; return true;
    case SL_OPTION_REAL: return parse_real(o, text, status);
    case SL_OPTION_COUNT: return parse_count(o, text, status);
    case SL_OPTION_CHOICE: return parse_choice(o, text, status);
    case SL_OPTION_BYTES: return parse_bytes(o, text, status);
    case SL_OPTION_SIZE: return parse_size(o, text, status);
    case SL_OPTION_VECTOR: return parse_vector(o, text, status);
    case SL_OPTION_HEADING: break;
    }
    return false;
}

static const sl_option *find_option(const sl_command_line *line, const char *word, size_t length, char letter) {
    for (const sl_option *o = line->options; o->name; o++) {
        if (o->kind == SL_OPTION_HEADING) continue;
        if (letter ? o->letter == letter : strlen(o->name) == length && strncmp(o->name, word, length) == 0) return o;
    }
    return NULL;
}

/* One option at argv[*i]; moves *i on to its value. */
static bool take_option(const sl_command_line *line, int argc, char **argv, int *i, int *status) {
    char *word = argv[*i];
    const char *value = NULL;
    const sl_option *o = NULL;
    if (word[1] == '-') {
        size_t length = strcspn(word + 2, "=");
        o = find_option(line, word + 2, length, 0);
        if (word[2 + length] == '=') value = word + 3 + length;
        word[2 + length] = '\0';
        if (!o) return unknown_option(line, word + 2, status);
    } else {
        if (!word[2]) o = find_option(line, NULL, 0, word[1]);
        if (!o) return mistake(status, "unknown option %s; see --help", word);
    }
    if (o->kind == SL_OPTION_FLAG) {
        if (value) return mistake(status, "--%s takes no value", o->name);
        return take_value(o, NULL, status);
    }
    if (!value && *i + 1 < argc) value = argv[++*i];
    if (!value) return mistake(status, "--%s needs a value: %s", o->name, o->metavar);
    return take_value(o, value, status);
}

bool sl_options_parse(const sl_command_line *line, int argc, char **argv, const char **operands, int *operand_count,
                      int *status) {
    int count = 0;
    bool only_operands = false;
    *status = 0;
    for (int i = 0; i < argc; i++) {
        if (!only_operands && (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)) {
            print_help(line);
            return false;
        }
        if (!only_operands && strcmp(argv[i], "--man") == 0) {
            sl_print_command_manual(line);
            return false;
        }
        if (!only_operands && strcmp(argv[i], "--") == 0) {
            only_operands = true;
        } else if (!only_operands && argv[i][0] == '-' && argv[i][1]) {
            if (!take_option(line, argc, argv, &i, status)) return false;
        } else {
            if (count == line->operands_max) return mistake(status, "unexpected '%s'; usage: %s", argv[i], line->usage);
            operands[count++] = argv[i];
        }
    }
    if (count < line->operands_min) return mistake(status, "usage: %s", line->usage);
    *operand_count = count;
    return true;
}
