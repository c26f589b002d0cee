/* A look at a PLY file's header before it is imported: the importer trusts it. */
#ifndef SL_SCENE_PLY_CHECK_H
#define SL_SCENE_PLY_CHECK_H

#include "softlux.h"

/* Files that neither are named .ply nor begin like one pass. The header must be whole, without an element twice, and the file long enough for the elements that it announces. */
sl_status sl_ply_check(const char *path, sl_error *error);

#endif
