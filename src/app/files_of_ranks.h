/* Files that one rank gives the others, folders where they have them, and a scene that all render. */
#pragma once

#include "cache/frame/settings.h"

enum { SL_RANKS_FOLDER = 1024, SL_RANKS_PATH = 8192 };

/* Makes a folder of this process's own, in $TMPDIR or /tmp. */
sl_status sl_own_folder(char folder[SL_RANKS_FOLDER], sl_error *error);
/* Removes it, and all that is in it. */
void sl_own_folder_remove(const char *folder);

/* Copies a file of one rank, the giver, to a place of every other one that names one; NULL: it does without.
 * All ranks call it; a failure of one ends the job. */
sl_status sl_share_file(unsigned giver, const char *from, const char *to, sl_error *error);

/* As sl_load_within_memory(). Of several ranks the first one loads the scene, and gives the others its files.
 * INPUT: it is not the same scene everywhere. */
sl_status sl_load_for_ranks(const char *path, const sl_load_options *load, const sl_settings *settings,
                            sl_scene **scene, sl_error *error);
