/* The files that Assimp opens while it reads one: material libraries, buffers, whatever a format can name. */
#ifndef SL_IMPORT_FILES_H
#define SL_IMPORT_FILES_H

#include <assimp/cfileio.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct sl_import_files {
    struct aiFileIO procedures;
    const char *path, *folder; /* the file itself may be opened wherever it is; the others must lie below the
                                  folder, if there is one */
    char *refused;             /* the first that did not; NULL: none */
    char **opened;
    size_t opened_count;
    bool starved; /* one could not be opened for want of memory */
} sl_import_files;

void sl_import_files_init(sl_import_files *files, const char *path, const char *folder);

#endif
