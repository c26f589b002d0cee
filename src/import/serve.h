/* The program softlux-import: has one mesh file read by Assimp and writes what is in it to its standard
 * output, for the library that started it. */
#ifndef SL_IMPORT_SERVE_H
#define SL_IMPORT_SERVE_H

/* The program's main(). Arguments: version, seconds of processor time, bytes of addresses, the file, and the
 * folder that all others must lie below, if any. */
int sl_import_serve(int argc, char **argv);

#endif
