/* Small things that all readers need: paths and names. */
#pragma once


#include "softlux.h"

/* Larger files are refused: the readers of text count bytes in 31 bits. */
#define SL_FILE_BYTES ((size_t)INT32_MAX)

/* Tells whether there is a file (not a folder) that can be read. */
bool sl_file_exists(const char *path);
/* Returns the part of a path behind its last slash. */
const char *sl_file_name(const char *path);
/* `name` as seen from the folder of `beside`: absolute names stay. Release with sl_free(); NULL without
 * memory. */
char *sl_file_beside(const char *beside, const char *name);
/* The real path of the folder in which a file lies; release with sl_free(). NULL where there is none, or no
 * memory. */
char *sl_file_folder(const char *path);
/* Tells whether a file lies below a folder given by its real path, symbolic links followed. Where there is no
 * such file, or the folder is NULL: true. */
bool sl_file_is_below(const char *folder, const char *path);
/* Names that are told apart by the order in which they were added; zeroed: none. */
typedef struct sl_names {
    char **name;
    uint32_t *sorted; /* their numbers */
    size_t count, name_room, sorted_room;
} sl_names;

/* Finds the number of a name, or adds it. False: there is no memory. */
bool sl_names_find(sl_names *names, const char *name, uint32_t *number);
void sl_names_release(sl_names *names);
