/* The files that Assimp opens while it reads one: material libraries, buffers, whatever a format can name. */
#pragma once

#include <assimp/cfileio.h>

#include "scene/model.h"

typedef struct sl_import_files {
    struct aiFileIO procedures;
    const char *path; /* the file itself may be opened wherever it is; the others must lie below the model's
                         folder, if there is one */
    sl_model *model;
    sl_status status; /* of the first that did not, or for which there was no memory */
    sl_error *error;
} sl_import_files;

void sl_import_files_init(sl_import_files *files, const char *path, sl_model *model, sl_error *error);
