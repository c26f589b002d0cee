/* Where the program that imports mesh files is: the one thing of the library that differs between the build
 * folder and an installation. */
#ifndef SL_SCENE_IMPORTER_PATH_H
#define SL_SCENE_IMPORTER_PATH_H

extern const char sl_importer_path[];

#endif
