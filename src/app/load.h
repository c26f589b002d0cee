/* Reading a scene for a command. */
#ifndef SL_APP_LOAD_H
#define SL_APP_LOAD_H

#include "softlux.h"

/* sl_scene_load_with(), but that a reader which crashes ends the process with one line and exit status 3 (input), as other damaged files do. Most mesh
 * files are read by the importer (Assimp), which some damaged ones lead astray; what a library must leave to its user, a program can do: stop. */
sl_status sl_load_scene(const char *path, const sl_load_options *options, sl_scene **scene, sl_error *error);

#endif
