/* The answer of the importer's process: what came of a file, and the model of what is in it. Written there
 * and read here, as a stranger's file is: the importer may have run astray. */
#pragma once

#include <stdio.h>

#include "scene/model.h"

#define SL_IMPORT_MAGIC 0x4d494c53u
#define SL_IMPORT_VERSION 2u
enum { SL_IMPORT_HEADER_BYTES = 16 };

/* Writes what came of it (status, message), the files that were opened, the warnings, and where the status is
 * SL_OK textures, materials, objects, triangles, lights and camera. False: it could not be written. */
bool sl_import_reply_write(FILE *to, sl_status status, const char *message, sl_model *model);
/* Returns the bytes that a reply of which these are the first SL_IMPORT_HEADER_BYTES says it has; 0: they
 * begin none. */
uint64_t sl_import_reply_bytes(const void *header);
/* Adds what a whole reply holds to a model, and returns what came of the file. Of what is added texts end and
 * indices are below their lists' lengths; numbers may be any. Failing names the path. */
sl_status sl_import_reply_read(const char *path, const void *reply, size_t size, sl_model *model,
                               sl_error *error);
