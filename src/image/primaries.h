/* Colours given by other primaries than Rec. 709's. */
#ifndef SL_IMAGE_PRIMARIES_H
#define SL_IMAGE_PRIMARIES_H

#include "softlux.h"

/* CIE x and y of red, green, blue and white. */
typedef struct sl_primaries {
    double red[2], green[2], blue[2], white[2];
} sl_primaries;

/* Turns R, G and B into those of Rec. 709 of the same CIE XYZ (no adaptation to another white). False where
 * the primaries span no colours, or the picture has not all three. */
bool sl_to_rec709(sl_image *image, const sl_primaries *from);

#endif
