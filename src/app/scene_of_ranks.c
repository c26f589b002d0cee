#include "app/scene_of_ranks.h"

#include "app/memory_limit.h"
#include "base/error.h"
#include "base/ranks.h"
#include "scene/scene.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { NAME = 4096 };

static bool make_folder(char name[NAME]) {
    const char *place = getenv("TMPDIR");
    const int used = snprintf(name, NAME, "%s/softlux-XXXXXX", place && *place ? place : "/tmp");
    return used > 0 && used < NAME && mkdtemp(name);
}

static void remove_folder(const char *name) {
    DIR *folder = opendir(name);
    for (struct dirent *e; folder && (e = readdir(folder)) != NULL;) unlinkat(dirfd(folder), e->d_name, 0);
    if (folder) closedir(folder);
    rmdir(name);
}

static void scene_in(const char *folder, char path[NAME + 16]) {
    snprintf(path, NAME + 16, "%s/scene.json", folder);
}

/* Tells whether files would hold all of it, to the bit: they leave keyframes out, and surfaces that were
 * moved are evaluated before they are moved. */
static bool is_whole_in_files(const sl_scene *scene) {
    return sl_scene_duration(scene) == 0.0 && !scene->bicubic_count;
}

/* The first rank's: what cannot be written, for want of a disk, is not given either. */
static void give(const sl_scene *scene, const char *folder) {
    char path[NAME + 16];
    scene_in(folder, path);
    sl_ranks_share_files(folder, is_whole_in_files(scene) && sl_scene_write(scene, path, NULL) == SL_OK);
}

static sl_status load_shared(const char *folder, const char *path, const sl_load_options *load,
                             const sl_settings *settings, sl_scene **scene, sl_error *error) {
    const sl_load_options plain = {.allow_outside = false};
    char shared[NAME + 16];
    scene_in(folder, shared);
    if (sl_ranks_here().rank) {
        const bool given = sl_ranks_share_files(folder, true);
        return sl_load_within_memory(given ? shared : path, given ? &plain : load, settings, scene, error);
    }
    sl_status status = sl_load_within_memory(path, load, settings, scene, error);
    if (status == SL_OK) give(*scene, folder);
    return status;
}

sl_status sl_load_for_ranks(const char *path, const sl_load_options *load, const sl_settings *settings,
                            sl_scene **scene, sl_error *error) {
    char folder[NAME];
    if (!sl_ranks_share()) return sl_load_within_memory(path, load, settings, scene, error);
    if (!make_folder(folder)) return sl_fail(error, SL_ERROR_OUTPUT, "no folder for the scene's files");
    sl_status status = load_shared(folder, path, load, settings, scene, error);
    remove_folder(folder);
    const char *why = status == SL_OK ? sl_ranks_begin(sl_scene_hash(*scene)) : NULL;
    return why ? sl_fail(error, SL_ERROR_INPUT, "%s: %s", path, why) : status;
}
