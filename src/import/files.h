/* The files that Assimp opens while it reads one: material libraries, buffers, whatever a format can name. */
#ifndef SL_IMPORT_FILES_H
#define SL_IMPORT_FILES_H

#include <assimp/cfileio.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/stat.h>

/* Text that is read in place of a file, whatever names it. */
typedef struct sl_import_text {
    const char *data;
    size_t size;
    struct stat file;
} sl_import_text;

typedef struct sl_import_files {
    struct aiFileIO procedures;
    const char *path, *folder; /* the file itself may be opened wherever it is; the others must lie below the
                                  folder, if there is one */
    char *refused;             /* the first that did not; NULL: none */
    char **opened;
    size_t opened_count;
    sl_import_text *texts;
    size_t text_count;
    bool starved; /* one could not be opened for want of memory */
} sl_import_files;

/* Takes the texts that stand one after the other in a block, which stays. False: they are not whole, or there
 * is no memory. */
bool sl_import_files_init(sl_import_files *files, const char *path, const char *folder, const char *texts,
                          size_t size);

#endif
