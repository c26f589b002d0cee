#include "app/scene_of_ranks.h"

#include "app/files_of_ranks.h"
#include "app/memory_limit.h"
#include "app/same_file.h"
#include "base/error.h"
#include "base/ranks.h"
#include "scene/scene.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

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
