#define _XOPEN_SOURCE 700 /* realpath() */
#include "scene/file.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/grow.h"
#include "base/memory.h"
#include "scene/derive.h"

bool sl_file_exists(const char *path) {
    struct stat about;
    return stat(path, &about) == 0 && S_ISREG(about.st_mode);
}

const char *sl_file_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

char *sl_file_beside(const char *beside, const char *name) {
    const char *slash = strrchr(beside, '/');
    size_t folder = name[0] == '/' || !slash ? 0 : (size_t)(slash - beside) + 1, length = strlen(name);
    char *path = sl_allocate(folder + length + 1, 1);
    if (!path) return NULL;
    memcpy(path, beside, folder);
    memcpy(path + folder, name, length);
    return path;
}

char *sl_file_folder(const char *path) {
    char *name = sl_file_beside(path, "."), *real = name ? realpath(name, NULL) : NULL,
         *folder = real ? sl_string_copy(real) : NULL;
    free(real);
    sl_free(name);
    return folder;
}

bool sl_file_is_below(const char *folder, const char *path) {
    char real[PATH_MAX];
    if (!folder) return true;
    /* of another file reading it will say that it does not exist */
    if (!realpath(path, real)) return errno != ENOMEM;
    size_t length = strcmp(folder, "/") == 0 ? 0 : strlen(folder);
    return strncmp(real, folder, length) == 0 && real[length] == '/';
}

/* Returns the first place in the alphabet that does not come before this name's. */
static size_t find_place(const sl_names *n, const char *name) {
    size_t low = 0, high = n->count;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (strcmp(n->name[n->sorted[middle]], name) < 0) low = middle + 1;
        else high = middle;
    }
    return low;
}

bool sl_names_find(sl_names *n, const char *name, uint32_t *number) {
    const size_t place = find_place(n, name);
    if (place == n->count || strcmp(n->name[n->sorted[place]], name) != 0) {
        char *copy = NULL;
        if (!sl_make_room(&n->name, n->count, &n->name_room, sizeof *n->name) ||
            !sl_make_room(&n->sorted, n->count, &n->sorted_room, sizeof *n->sorted) ||
            !(copy = sl_string_copy(name)))
            return false;
        memmove(n->sorted + place + 1, n->sorted + place, (n->count - place) * sizeof *n->sorted);
        n->sorted[place] = (uint32_t)n->count;
        n->name[n->count++] = copy;
    }
    *number = n->sorted[place];
    return true;
}

void sl_names_release(sl_names *n) {
    sl_strings_free(n->name, n->count);
    sl_free(n->sorted);
    *n = (sl_names){0};
}
