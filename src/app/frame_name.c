#include "app/frame_name.h"

#include <stdio.h>
#include <string.h>

bool sl_name_ends_with(const char *name, const char *end) {
    size_t n = strlen(name), m = strlen(end);
    return n >= m && strcmp(name + n - m, end) == 0;
}

/* Finds where the number begins and ends, and its width. */
static bool find_number(const char *name, const char **begin, const char **end, int *width) {
    const char *p = strchr(name, '%');
    *begin = p;
    *width = 0;
    if (!p) return false;
    for (p++; *p >= '0' && *p <= '9'; p++) *width = *width < 99 ? 10 * *width + (*p - '0') : *width;
    *end = p + 1;
    return *p == 'd' && *width < 20 && !strchr(p, '%');
}

bool sl_frame_pattern_is_good(const char *pattern) {
    const char *begin, *end;
    int width;
    return find_number(pattern, &begin, &end, &width);
}

void sl_frame_name(const char *pattern, unsigned long long frame, char *name, size_t size) {
    const char *begin = pattern, *end = pattern;
    int width;
    find_number(pattern, &begin, &end, &width);
    snprintf(name, size, "%.*s%0*llu%s", (int)(begin - pattern), pattern, width, frame, end);
}

bool sl_frame_name_fits(const char *pattern, const char *name) {
    const char *begin, *end;
    int width;
    unsigned long long frame;
    char made[4096];
    if (!find_number(pattern, &begin, &end, &width) || strncmp(pattern, name, (size_t)(begin - pattern)) != 0)
        return false;
    if (sscanf(name + (begin - pattern), "%19llu", &frame) != 1) return false;
    sl_frame_name(pattern, frame, made, sizeof made);
    return strcmp(made, name) == 0;
}
