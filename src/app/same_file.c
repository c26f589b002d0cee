#include "app/same_file.h"

#include "base/error.h"
#include "image/output_file.h"
#include "scene/scene.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

/* ---- names of a series ---- */

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

/* Tells whether a name is that of some frame. */
static bool is_name_of_frame(const char *pattern, const char *name) {
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

/* By name, or because it is there by both names. */
static bool are_same(const char *a, const char *b) {
    struct stat of_a, of_b;
    if (strcmp(a, b) == 0) return true;
    return stat(a, &of_a) == 0 && stat(b, &of_b) == 0 && S_ISREG(of_a.st_mode) &&
           of_a.st_dev == of_b.st_dev && of_a.st_ino == of_b.st_ino;
}

bool sl_is_file_of_its_own(const char *option, const char *file, const char *const others[], int count) {
    for (int i = 0; file && i < count; i++) {
        if (!others[i] || !are_same(file, others[i])) continue;
        fprintf(stderr,
                "softlux: --%s: expected a file of its own, got '%s', which would take the place of %s\n",
                option, file, others[i]);
        return false;
    }
    return true;
}

/* Tells whether the other file is one of a series: it has such a name, in the same folder. */
static bool is_one_of(const char *pattern, const char *other) {
    const char *slash = strrchr(pattern, '/'), *other_slash = strrchr(other, '/');
    char name[4096];
    int length = snprintf(name, sizeof name, "%.*s%s", slash ? (int)(slash - pattern) + 1 : 0, pattern,
                          other_slash ? other_slash + 1 : other);
    return length < (int)sizeof name && is_name_of_frame(pattern, name) && are_same(name, other);
}

sl_status sl_spare_scene(const sl_scene *scene, const char *option, const char *file, sl_error *error) {
    for (size_t i = 0; file && i < scene->file_count; i++) {
        if (!are_same(file, scene->files[i]) && !is_one_of(file, scene->files[i])) continue;
        return sl_fail(
            error, SL_ERROR_USAGE,
            "--%s: expected a file of its own, got '%.400s', which would take the place of %.400s, a "
            "file of the scene",
            option, file, scene->files[i]);
    }
    return SL_OK;
}

sl_status sl_spare_scene_in(const sl_scene *scene, const char *option, const char *folder, const char *name,
                            sl_error *error) {
    char path[4096];
    int length = snprintf(path, sizeof path, "%s/%s", folder, name);
    /* none is written there either */
    return length < (int)sizeof path ? sl_spare_scene(scene, option, path, error) : SL_OK;
}

sl_status sl_make_folder(const char *folder, const char *name, sl_error *error) {
    char part[4096];
    const size_t length = strlen(folder);
    for (size_t i = 1; i <= length && i < sizeof part; i++) {
        if (folder[i] != '/' && folder[i]) continue;
        snprintf(part, sizeof part, "%.*s", (int)i, folder);
        if (mkdir(part, 0777) != 0 && errno != EEXIST)
            return sl_fail(error, SL_ERROR_OUTPUT, "cannot make the folder %.900s: %s", part,
                           strerror(errno));
    }
    snprintf(part, sizeof part, "%.3900s/%s", folder, name);
    return sl_output_check(part, error);
}
