#include "scene/import_process.h"

#ifndef SL_IMPORTER
#error "the makefile says where softlux-import is: in the build folder, or where it is installed"
#endif

const char sl_importer_path[] = SL_IMPORTER;
