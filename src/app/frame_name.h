/* Names of pictures, and of those of a series: frame-%04d.png. */
#ifndef SL_APP_FRAME_NAME_H
#define SL_APP_FRAME_NAME_H

#include <stdbool.h>
#include <stddef.h>

bool sl_name_ends_with(const char *name, const char *end);
/* Tells whether there is one %d, %4d or %04d, and no other %. */
bool sl_frame_pattern_is_good(const char *pattern);
void sl_frame_name(const char *pattern, unsigned long long frame, char *name, size_t size);
/* Tells whether a name is that of some frame. */
bool sl_frame_name_fits(const char *pattern, const char *name);

#endif
