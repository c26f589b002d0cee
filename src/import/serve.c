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

#include "base/memory.h"
#include "base/sanitized.h"
#include "import/files.h"
#include "import/write.h"

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
static void keep_within(unsigned long processor_seconds, unsigned long long address_bytes) {
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

static sl_import_outcome outcome_of(const sl_import_files *files, const struct aiScene *scene,
                                    const char **text) {
    *text = "";
    if (files->refused) {
        *text = files->refused;
        return SL_IMPORT_OUTSIDE;
    }
    if (files->starved) return SL_IMPORT_STARVED; /* what Assimp takes for a file that is not there */
    if (scene && scene->mRootNode) return SL_IMPORT_READ;
    *text = scene ? "it is empty" : aiGetErrorString();
    if (!*text) *text = "";
    if (!scene && (strstr(*text, "bad_alloc") || sl_memory_has_ended())) return SL_IMPORT_STARVED;
    return strncmp(*text, "No suitable reader found", 24) == 0 ? SL_IMPORT_UNKNOWN : SL_IMPORT_DAMAGED;
}

/* Points and lines stay, and are left out when it is written. */
static bool import(const char *path, sl_import_files *files) {
    const char *text;
    const struct aiScene *scene = aiImportFileEx(path, 0, &files->procedures);
    sl_import_outcome outcome = outcome_of(files, scene, &text);
    if (outcome == SL_IMPORT_READ) {
        scene = aiApplyPostProcessing(scene, aiProcess_Triangulate);
        if (!scene) outcome = SL_IMPORT_DAMAGED, text = "its polygons cannot be cut into triangles";
    }
    return sl_import_write(stdout, outcome, text, files, outcome == SL_IMPORT_READ ? scene : NULL);
}

/* Ends at once: there is nothing that anybody would see released. */
int sl_import_serve(int argc, char **argv) {
    if (argc < 5 || strtoul(argv[1], NULL, 10) != SL_IMPORT_VERSION) _exit(2);
    close_what_came_along();
    keep_within(strtoul(argv[2], NULL, 10), strtoull(argv[3], NULL, 10));
    sl_import_files files;
    sl_import_files_init(&files, argv[4], argc > 5 ? argv[5] : NULL);
    _exit(import(argv[4], &files) ? 0 : 1);
}
