/* Writes an imported file as scene/import_reply.h describes it. */
#ifndef SL_IMPORT_WRITE_H
#define SL_IMPORT_WRITE_H

#include <assimp/scene.h>
#include <stdbool.h>
#include <stdio.h>

#include "import/files.h"
#include "scene/import_reply.h"

/* scene: NULL unless the outcome is SL_IMPORT_READ. What it says that cannot be (indices beyond their lists,
 * children and meshes that are not there) is left out. False: it could not be written. */
bool sl_import_write(FILE *to, sl_import_outcome outcome, const char *text, const sl_import_files *files,
                     const struct aiScene *scene);

#endif
