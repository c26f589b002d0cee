#include "import/serve.h"

int main(int argc, char **argv) { return sl_import_serve(argc, argv); }
