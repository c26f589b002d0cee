/* Files that a command writes must not take the place of those that it reads, or of each other. */
#pragma once

#include "softlux.h"


/* False, and a line on stderr, if the option's file is one of the others. NULL is none. */
bool sl_is_file_of_its_own(const char *option, const char *file, const char *const others[], int count);
/* A usage error if a file to be written is one that the scene was read from, whether the command line names
 * that or not. The file may be a pattern as frame-%04d.png, of which any number counts. NULL is none. */
sl_status sl_spare_scene(const sl_scene *scene, const char *option, const char *file, sl_error *error);
/* The same for a file of that name in the option's folder. */
sl_status sl_spare_scene_in(const sl_scene *scene, const char *option, const char *folder, const char *name,
                            sl_error *error);

/* Makes a folder, and those above it, where they are not there; fails where no file of that name can be
 * written in it. */
sl_status sl_make_folder(const char *folder, const char *name, sl_error *error);

/* ---- names of a series ---- */

/* Tells whether there is one %d, %4d or %04d, and no other %. */
bool sl_frame_pattern_is_good(const char *pattern);
void sl_frame_name(const char *pattern, unsigned long long frame, char *name, size_t size);
