/* The tone of 8-bit pictures, for `softlux compare`: they show radiance after an exposure and a curve, which
 * their metadata may tell. */
#ifndef SL_APP_COMPARE_TONE_H
#define SL_APP_COMPARE_TONE_H

#include "softlux.h"

typedef struct sl_shown {
    bool is_shown;   /* an 8-bit picture; else the other fields mean nothing */
    bool known;      /* it tells its tone; else those below mean nothing */
    sl_tone_curve curve;
    double stops;
    bool automatic;  /* the exposure was made for that picture: its brightness cannot be seen */
} sl_shown;

sl_shown sl_shown_of(const sl_image *image);
/* Where one of two pictures is shown and the other is radiance, the latter is put through the same tone.
 * INPUT: the tone is not known. */
sl_status sl_shown_alike(sl_image **a, const char *a_path, sl_image **b, const char *b_path, sl_error *error);
/* Warns, in one line on stderr, where both are shown and a difference in brightness may be hidden. */
void sl_shown_warn(const sl_shown *a, const char *a_path, const sl_shown *b, const char *b_path);
/* A line, or, for JSON, an object (null for radiance) and a comma. */
void sl_shown_print(const char *name, const sl_shown *shown, bool json);

#endif
