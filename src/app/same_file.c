#include "app/same_file.h"

#include "app/frame_name.h"
#include "base/error.h"
#include "scene/scene.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

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
    return length < (int)sizeof name && sl_frame_name_fits(pattern, name) && are_same(name, other);
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
