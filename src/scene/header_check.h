/* A look at the headers of PLY and OFF files before they are imported: the importer trusts them, and makes up
 * what they promise and the file has not. */
#ifndef SL_SCENE_HEADER_CHECK_H
#define SL_SCENE_HEADER_CHECK_H

#include "softlux.h"

/* A PLY header must be whole, without an element twice; PLY and OFF files must be long enough for what they
 * announce, and faces of OFF files have one to nine corners. Files that neither are named so nor begin so
 * pass. */
sl_status sl_header_check(const char *path, sl_error *error);

#endif
