/* The program softlux-import: has one mesh file read by Assimp, makes a model of it and writes that to its
 * standard output, for the library that started it (scene/import_reply.h). */
#pragma once

/* The program's main(). Arguments: version, seconds by the clock and of processor time, bytes of addresses,
 * the file, the twelve numbers of its placement, and the folder that all other files must lie below, if any.
 */
int sl_import_serve(int argc, char **argv);
