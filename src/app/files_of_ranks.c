#define _XOPEN_SOURCE 700 /* nftw(), mkdtemp() */
#include "app/files_of_ranks.h"

#include "app/memory_limit.h"
#include "app/same_file.h"
#include "base/error.h"
#include "base/ranks.h"
#include "scene/scene.h"

#include <errno.h>
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

sl_status sl_own_folder(char folder[SL_RANKS_FOLDER], sl_error *error) {
    const char *place = getenv("TMPDIR");
    if (!place || !*place) place = "/tmp";
    const int used = snprintf(folder, SL_RANKS_FOLDER, "%s/softlux-XXXXXX", place);
    if (used < SL_RANKS_FOLDER && mkdtemp(folder)) return SL_OK;
    return sl_fail(error, SL_ERROR_OUTPUT, "cannot make a folder in %.400s: %s", place, strerror(errno));
}

static int remove_it(const char *path, const struct stat *about, int kind, struct FTW *where) {
    (void)about, (void)kind, (void)where;
    return remove(path);
}

void sl_own_folder_remove(const char *folder) { nftw(folder, remove_it, 16, FTW_DEPTH | FTW_PHYS); }

static sl_status fail(const char *what, const char *path, sl_error *error) {
    return sl_fail(error, SL_ERROR_OUTPUT, "cannot %s %.900s, which ranks share: %s", what, path,
                   strerror(errno));
}

/* Returns 0 where a file cannot be read to its end. */
static uint64_t size_of(FILE *file) {
    const bool there = file && fseek(file, 0, SEEK_END) == 0;
    const long size = there ? ftell(file) : 0;
    if (there) rewind(file);
    return size > 0 ? (uint64_t)size : 0;
}

static bool share_bytes(unsigned giver, FILE *file, uint64_t size) {
    enum { PIECE = 1 << 20 };
    const bool gives = sl_ranks_here().rank == giver;
    bool well = true;
    char *bytes = malloc(PIECE);
    for (uint64_t at = 0; bytes && well && at < size; at += PIECE) {
        const size_t some = size - at < PIECE ? (size_t)(size - at) : PIECE;
        if (gives) well = fread(bytes, 1, some, file) == some;
        if (well) sl_ranks_tell(giver, bytes, some);
        if (!gives && file) well = fwrite(bytes, 1, some, file) == some;
    }
    free(bytes);
    return bytes && well;
}

sl_status sl_share_file(unsigned giver, const char *from, const char *to, sl_error *error) {
    const bool gives = sl_ranks_here().rank == giver;
    const char *path = gives ? from : to, *what = gives ? "read" : "write";
    FILE *file = path ? fopen(path, gives ? "rb" : "wb") : NULL;
    if (path && !file) return fail(what, path, error);
    uint64_t size = gives ? size_of(file) : 0;
    sl_ranks_tell(giver, &size, sizeof size);
    bool well = share_bytes(giver, file, size);
    if (file && fclose(file) != 0) well = false;
    return well ? SL_OK : fail(what, path ? path : "files", error);
}

/* ---- a scene ---- */

/* A file's path from the first rank's root. */
static sl_status name_file(const char *path, char name[SL_RANKS_PATH], sl_error *error) {
    char here[SL_RANKS_PATH / 2] = "";
    const bool named = path[0] == '/' || getcwd(here, sizeof here);
    const int used = named ? snprintf(name, SL_RANKS_PATH, "%s/%s", here, path) : SL_RANKS_PATH;
    return used < SL_RANKS_PATH ? SL_OK : sl_fail(error, SL_ERROR_INPUT, "%.400s: too long a path", path);
}

/* The first rank's: names and files, and a name that is empty behind the last one. */
static sl_status give(const sl_scene *scene, sl_error *error) {
    char name[SL_RANKS_PATH] = "";
    sl_status status = SL_OK;
    for (size_t i = 0; status == SL_OK && i < scene->file_count; i++) {
        status = name_file(scene->files[i], name, error);
        if (status == SL_OK) sl_ranks_tell(0, name, sizeof name);
        if (status == SL_OK) status = sl_share_file(0, scene->files[i], NULL, error);
    }
    name[0] = '\0';
    if (status == SL_OK) sl_ranks_tell(0, name, sizeof name);
    return status;
}

/* Finds where a folder that mirrors the first rank's root has a path, and makes the folders that it names. A
 * step upwards never leads out of it. */
static sl_status mirror(const char *folder, const char *path, char place[SL_RANKS_PATH], sl_error *error) {
    const size_t root = strlen(folder);
    sl_status status = root + strlen(path) + 2 < SL_RANKS_PATH
                           ? SL_OK
                           : sl_fail(error, SL_ERROR_INPUT, "%.400s: too long a path", path);
    if (status == SL_OK) memcpy(place, folder, root + 1);
    for (size_t n; status == SL_OK && (path += strspn(path, "/"), n = strcspn(path, "/")) > 0; path += n) {
        const bool up = n == 2 && strncmp(path, "..", 2) == 0, stays = n == 1 && *path == '.';
        if (up && strlen(place) > root) *strrchr(place, '/') = '\0';
        if (up || stays) continue;
        sprintf(place + strlen(place), "/%.*s", (int)n, path);
        if (path[n]) status = sl_make_folder(place, "file", error);
    }
    return status;
}

/* Any other rank's: the first file is the scene's own. */
static sl_status take(const char *folder, char scene[SL_RANKS_PATH], sl_error *error) {
    sl_status status = SL_OK;
    char name[SL_RANKS_PATH];
    for (char place[SL_RANKS_PATH]; status == SL_OK;) {
        sl_ranks_tell(0, name, sizeof name);
        if (!name[0]) break;
        status = mirror(folder, name, place, error);
        if (status == SL_OK) status = sl_share_file(0, NULL, place, error);
        if (!scene[0]) memcpy(scene, place, sizeof place);
    }
    return status;
}

static sl_status load_taken(const sl_load_options *load, const sl_settings *settings, sl_scene **scene,
                            sl_error *error) {
    char folder[SL_RANKS_FOLDER], path[SL_RANKS_PATH] = "";
    sl_status status = sl_own_folder(folder, error);
    if (status != SL_OK) return status;
    status = take(folder, path, error);
    if (status == SL_OK) status = sl_load_within_memory(path, load, settings, scene, error);
    sl_own_folder_remove(folder);
    return status;
}

sl_status sl_load_for_ranks(const char *path, const sl_load_options *load, const sl_settings *settings,
                            sl_scene **scene, sl_error *error) {
    const sl_ranks here = sl_ranks_here();
    sl_status status = here.rank ? load_taken(load, settings, scene, error)
                                 : sl_load_within_memory(path, load, settings, scene, error);
    if (status == SL_OK && here.rank == 0 && here.count > 1) status = give(*scene, error);
    const char *why = status == SL_OK ? sl_ranks_begin(sl_scene_hash(*scene)) : NULL;
    return why ? sl_fail(error, SL_ERROR_INPUT, "%s: %s", path, why) : status;
}
