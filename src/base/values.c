#include "base/values.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/print.h"

/* ---- numbers ---- */

static double read_real(const char *text, char **end) {
    void *before = sl_c_locale_begin();
    const double value = strtod(text, end);
    sl_c_locale_end(before);
    return value;
}

static bool within(double value, double least, double most) {
    return !(least < most) || (value >= least && value <= most);
}

sl_status sl_value_real(const char *text, double least, double most, double *value, sl_error *error) {
    char *end;
    const double read = read_real(text, &end);
    if (end == text || *end || !isfinite(read))
        return sl_fail(error, SL_ERROR_USAGE, "expected a number, got '%s'", text);
    if (!within(read, least, most))
        return sl_fail(error, SL_ERROR_USAGE, "expected %g to %g, got %s", least, most, text);
    *value = read;
    return SL_OK;
}

sl_status sl_value_count(const char *text, double least, double most, uint64_t *value, sl_error *error) {
    char *end;
    errno = 0;
    const unsigned long long read = strtoull(text, &end, 10);
    if (text[0] < '0' || text[0] > '9' || *end || errno)
        return sl_fail(error, SL_ERROR_USAGE, "expected a whole number, got '%s'", text);
    if (!within((double)read, least, most))
        return sl_fail(error, SL_ERROR_USAGE, "expected %.0f to %.0f, got %s", least, most, text);
    *value = read;
    return SL_OK;
}

/* Moves on behind K, M, G or T and an iB or B after it. */
static double unit_of(char **end) {
    static const char units[] = "kmgt";
    const char *unit = **end ? strchr(units, **end | 0x20) : NULL;
    if (unit) (*end)++;
    if (unit && **end == 'i') (*end)++;
    if (**end == 'B' || **end == 'b') (*end)++;
    return unit ? (double)(1ull << 10 * (unit - units + 1)) : 1.0;
}

sl_status sl_value_bytes(const char *text, double least, double most, uint64_t *value, sl_error *error) {
    char *end = NULL;
    double read = text[0] >= '0' && text[0] <= '9' ? read_real(text, &end) : -1.0;
    if (read >= 0.0) read *= unit_of(&end);
    if (!(read >= 0.0) || *end)
        return sl_fail(error, SL_ERROR_USAGE, "expected bytes, as 512M or 2G, got '%s'", text);
    if (!within(read, least, most))
        return sl_fail(error, SL_ERROR_USAGE, "expected %.0fM to %.0fG, got %s", least / 0x1p20,
                       most / 0x1p30, text);
    *value = (uint64_t)read;
    return SL_OK;
}

sl_status sl_value_size(const char *text, int most, int size[2], sl_error *error) {
    int width, height, used = 0;
    const bool read = sscanf(text, "%5dx%5d%n", &width, &height, &used) == 2 && !text[used];
    if (!read || width < 1 || height < 1 || width > most || height > most)
        return sl_fail(error, SL_ERROR_USAGE, "expected WIDTHxHEIGHT in pixels, 1 to %d each, got '%s'", most,
                       text);
    size[0] = width;
    size[1] = height;
    return SL_OK;
}

sl_status sl_value_vector(const char *text, float vector[3], sl_error *error) {
    const char *at = text;
    double read[3];
    for (int i = 0; i < 3; i++) {
        char *end;
        read[i] = read_real(at, &end);
        if (end == at || !isfinite(read[i]) || *end != (i < 2 ? ',' : '\0'))
            return sl_fail(error, SL_ERROR_USAGE, "expected three numbers, as 1,2.5,-3, got '%s'", text);
        at = end + 1;
    }
    for (int i = 0; i < 3; i++) vector[i] = (float)read[i];
    return SL_OK;
}

/* ---- words ---- */

enum { LONGEST_WORD = 64 };

static char lower(char c) { return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c; }

bool sl_ends_with(const char *text, const char *ending) {
    size_t at = strlen(text), left = strlen(ending);
    if (at < left) return false;
    while (left > 0 && lower(text[at - 1]) == lower(ending[left - 1])) at--, left--;
    return left == 0;
}

static size_t length_of(const char *word) { return sl_fewer(strlen(word), LONGEST_WORD); }

/* Counts the insertions, deletions and replacements that turn one word into the other (Levenshtein), of the
 * first 64 letters. */
static size_t edit_distance(const char *a, const char *b) {
    size_t row[LONGEST_WORD + 1], a_length = length_of(a), b_length = length_of(b);
    for (size_t j = 0; j <= b_length; j++) row[j] = j;
    for (size_t i = 1; i <= a_length; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b_length; j++) {
            size_t above = row[j], replaced = diagonal + (lower(a[i - 1]) != lower(b[j - 1]));
            row[j] = sl_fewer(sl_fewer(above, row[j - 1]) + 1, replaced);
            diagonal = above;
        }
    }
    return row[b_length];
}

/* Tells whether one of the two, neither being empty, begins with the other. */
static bool begin_alike(const char *a, const char *b) {
    size_t i = 0;
    while (a[i] && b[i] && lower(a[i]) == lower(b[i])) i++;
    return i > 0 && (!a[i] || !b[i]);
}

const char *sl_nearest_word(const char *word, const char *const *candidates, size_t count) {
    const char *nearest = NULL;
    size_t best = strlen(word) / 3 + 2; /* a word further off than this is another word, not a slip */
    for (size_t i = 0; i < count; i++) {
        const size_t distance = begin_alike(word, candidates[i]) ? 1 : edit_distance(word, candidates[i]);
        if (distance < best) best = distance, nearest = candidates[i];
    }
    return nearest;
}

void sl_value_choice_name(const char *choices, int index, char *text, size_t room) {
    for (; index > 0 && choices; index--) {
        choices = strchr(choices, '|');
        if (choices) choices++;
    }
    snprintf(text, room, "%.*s", choices ? (int)strcspn(choices, "|") : 0, choices ? choices : "");
}

sl_status sl_value_choice(const char *text, const char *choices, int *index, sl_error *error) {
    enum { CHOICES = 16, NAME = 32 };
    char name[CHOICES][NAME], all[CHOICES * NAME] = "";
    const char *names[CHOICES];
    size_t count = 0, used = 0;
    for (; count < CHOICES; count++) {
        sl_value_choice_name(choices, (int)count, name[count], NAME);
        if (!name[count][0]) break;
        names[count] = name[count];
        used += (size_t)snprintf(all + used, sizeof all - used, "%s%s", count ? ", " : "", name[count]);
        if (strcmp(text, name[count]) != 0) continue;
        *index = (int)count;
        return SL_OK;
    }
    const char *near = sl_nearest_word(text, names, count);
    return sl_fail(error, SL_ERROR_USAGE, "expected one of %s; got '%s'%s%s%s", all, text,
                   near ? ", did you mean " : "", near ? near : "", near ? "?" : "");
}
