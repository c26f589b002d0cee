/* A look at the header of a PLY file before it is imported: the importer trusts it, and makes up what it
 * promises and the file has not. */
#ifndef SL_SCENE_HEADER_CHECK_H
#define SL_SCENE_HEADER_CHECK_H

#include "softlux.h"

/* A PLY header must be whole, without an element twice, and the file long enough for what it announces. Files
 * that neither are named so nor begin so pass. */
sl_status sl_header_check(const char *path, sl_error *error);

#endif
