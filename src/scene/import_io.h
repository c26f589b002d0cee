/* The files that the importer (Assimp) opens while it reads one: material libraries, buffers, whatever a format can name. */
#ifndef SL_SCENE_IMPORT_IO_H
#define SL_SCENE_IMPORT_IO_H

#include <assimp/cfileio.h>

#include "scene/model.h"
#include "scene/text.h"
#include "softlux.h"

typedef struct sl_import_io {
    struct aiFileIO procedures;
    const char *path;     /* the file itself, which was asked for and may be opened wherever it is */
    sl_model *model;      /* the others must lie below its folder; it remembers them */
    char refused[512];    /* the first that did not; "": none */
    const sl_text *plain; /* what an OBJ file is read as; its material libraries are spelled plainly too. NULL or empty: as it is */
    bool starved;         /* one could not be opened for want of memory */
} sl_import_io;

/* It must stay where it is, and the text too, until what was read with it is released. */
void sl_import_io_init(sl_import_io *io, const char *path, sl_model *model, const sl_text *plain);

#endif
