/* The importer (Assimp) at work in a process of its own, softlux-import: some damaged files lead it astray,
 * and a library has to live on. */
#pragma once


#include "scene/affine.h"
#include "softlux.h"

/* Where that program is: the one thing of the library that differs between the build folder and an
 * installation. */
extern const char sl_importer_path[];

/* Limits of a process; beyond them it is ended. */
typedef struct sl_import_limits {
    unsigned seconds, processor_seconds; /* the former by the clock */
    uint64_t address_bytes;
} sl_import_limits;

/* By the file's size: far more than a sound file takes, on a slow machine too. */
sl_import_limits sl_import_limits_of(const char *path);

/* Has a file imported where the placement puts it, and returns the whole reply (import_reply.h), to be freed.
 * folder: the other files must lie below it; NULL: they may lie anywhere. Nothing of the caller's is touched:
 * signals, children, descriptors, environment, folder. A process that crashes, takes too much or answers by
 * halves is an input error; one that cannot be started, or has no memory, an error of resources. */
sl_status sl_import_run(const char *path, const sl_affine *placement, const char *folder,
                        sl_import_limits limits, void **reply, size_t *size, sl_error *error);
