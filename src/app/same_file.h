/* What a command writes must not take the place of what it reads, or of what else it writes. */
#ifndef SL_APP_SAME_FILE_H
#define SL_APP_SAME_FILE_H

#include <stdbool.h>

/* False, and a line on stderr, if the option's file is one of the others. NULL is none. */
bool sl_is_file_of_its_own(const char *option, const char *file, const char *const others[], int count);

#endif
