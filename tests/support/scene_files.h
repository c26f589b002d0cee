/* A folder of files that a test writes and reads back. */
#pragma once

#include "softlux.h"

#include <stddef.h>

/* Makes the folder on first use; scene_files_remove() takes it away with all that is in it. */
const char *scene_file_write(const char *name, const void *data, size_t size);
const char *scene_file_text(const char *name, const char *text);
const char *scene_file_copy(const char *from, const char *name); /* of a file of the repository */
const char *scene_file_path(const char *name); /* one of 64, used in turn */
int scene_files_remove(void); /* returns 0 */
int scene_files_teardown(void **state); /* the same, after a group of tests */
