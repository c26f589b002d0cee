#include "import/serve.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include "base/error.h"
#include "base/memory.h"
#include "base/sanitized.h"
#include "base/values.h"
#include "import/assimp.h"
#include "import/files.h"
#include "scene/import_reply.h"

enum { MOST_DESCRIPTORS = 1024 }; /* that are closed */

static void limit(int resource, rlim_t soft, rlim_t hard) {
    struct rlimit now;
    if (getrlimit(resource, &now) != 0) return;
    if (now.rlim_max == RLIM_INFINITY || hard < now.rlim_max) now.rlim_max = hard;
    if (now.rlim_cur == RLIM_INFINITY || soft < now.rlim_cur) now.rlim_cur = soft;
    if (now.rlim_cur > now.rlim_max) now.rlim_cur = now.rlim_max;
    setrlimit(resource, &now);
}

/* A second beyond its time it is killed, if it does not end by itself. */
static void keep_within(unsigned long seconds, unsigned long processor_seconds,
                        unsigned long long address_bytes) {
    alarm((unsigned)seconds);
    limit(RLIMIT_CORE, 0, 0);
    limit(RLIMIT_CPU, processor_seconds, processor_seconds + 1);
    if (!SL_SANITIZED) limit(RLIMIT_AS, (rlim_t)address_bytes, (rlim_t)address_bytes);
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);   /* who waits for the answer is gone */
    prctl(PR_SET_DUMPABLE, 0, 0, 0, 0); /* nor is a core handed to a program that collects them */
#endif
}

/* Closes descriptors that the caller did not keep from its children: a pipe of its own would not end before
 * this process does. */
static void close_what_came_along(void) {
    for (int descriptor = 3; descriptor < MOST_DESCRIPTORS; descriptor++) close(descriptor);
}

/* Fails for the reason that Assimp gives. */
static sl_status fail(const char *path, const char *said, sl_error *error) {
    if (strstr(said, "bad_alloc") || sl_memory_has_ended()) return sl_fail_memory(error, path);
    if (strncmp(said, "No suitable reader found", 24) == 0)
        return sl_fail(
            error, SL_ERROR_INPUT,
            "%s: expected a scene file (.json) or a mesh file (.obj, .gltf, .glb, .ply, .stl, .bpt, ...)",
            path);
    return sl_fail(error, SL_ERROR_INPUT, "%s: cannot be read as a mesh: %s", path,
                   *said ? said : "it is damaged");
}

/* Points and lines stay, and are left out of the model. */
static sl_status import(const char *path, const cJSON *gltf, const sl_affine *placement, sl_model *model,
                        sl_error *error) {
    sl_import_files files;
    sl_import_files_init(&files, path, model, error);
    const struct aiScene *scene = aiImportFileEx(path, 0, &files.procedures);
    if (files.status != SL_OK) return files.status;
    if (!scene) return fail(path, aiGetErrorString(), error);
    if (!scene->mRootNode) return fail(path, "it is empty", error);
    scene = aiApplyPostProcessing(scene, aiProcess_Triangulate);
    if (!scene) return fail(path, "its polygons cannot be cut into triangles", error);
    return sl_import_scene(path, scene, gltf, placement, model, error);
}

static sl_status read_file(const char *path, const sl_affine *placement, sl_model *model, sl_error *error) {
    cJSON *gltf;
    if (!sl_ends_with(path, ".gltf") && !sl_ends_with(path, ".glb")) {
        sl_status status = sl_ply_check(path, error);
        return status == SL_OK ? import(path, NULL, placement, model, error) : status;
    }
    sl_status status = sl_gltf_read(path, model, &gltf, error);
    return status == SL_OK ? import(path, gltf, placement, model, error) : status;
}

static sl_affine placement_of(const char *text) {
    sl_affine a;
    char *at = (char *)(uintptr_t)text; /* which is not written to */
    for (int i = 0; i < 12; i++) a.m[i / 4][i % 4] = strtod(at, &at);
    return a;
}

/* Ends at once: there is nothing that anybody would see released. */
int sl_import_serve(int argc, char **argv) {
    if (argc < 7 || strtoul(argv[1], NULL, 10) != SL_IMPORT_VERSION) _exit(2);
    close_what_came_along();
    keep_within(strtoul(argv[2], NULL, 10), strtoul(argv[3], NULL, 10), strtoull(argv[4], NULL, 10));
    const sl_affine placement = placement_of(argv[6]);
    sl_model model = {.folder = argc > 7 ? argv[7] : NULL};
    sl_error error = {.message = ""};
    sl_status status = read_file(argv[5], &placement, &model, &error);
    _exit(sl_import_reply_write(stdout, status, error.message, &model) ? 0 : 1);
}
