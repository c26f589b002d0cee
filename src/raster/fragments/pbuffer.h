/* Pbuffers: what passes draw into and other passes read. Row 0 is at the bottom.
 *
 * A pbuffer keeps one plane (array of width x height) for each channel, not texels of several channels: a
 * pass works along rows, and with planes sixteen neighbouring pixels of one channel are one vector load,
 * channels that a pass does not read cost no bandwidth, and a single plane can be handed to whoever wants one
 * float a pixel. (Textures are the other way round, since they are read at scattered places: textures.h.)
 * Several render targets at once (MRT) are several pbuffers of one size; the depth buffer is one of R32F. */
#ifndef SL_RASTER_PBUFFER_H
#define SL_RASTER_PBUFFER_H

#include "softlux.h"

typedef enum sl_pbuffer_format {
    SL_PBUFFER_R32UI,  /* triangle ids */
    SL_PBUFFER_R32F,   /* depth, one number a pixel */
    SL_PBUFFER_RGB32F,
    SL_PBUFFER_RGBA32F
} sl_pbuffer_format;

/* Plain data: planes may as well be a caller's own arrays, then without sl_pbuffer_destroy(). */
typedef struct sl_pbuffer {
    int width, height;
    sl_pbuffer_format format;
    uint32_t *word;     /* R32UI, or NULL */
    float *channel[4];  /* as many as the format has, NULL beyond */
} sl_pbuffer;

/* Channels of float: 0 for R32UI. */
int sl_pbuffer_channels(sl_pbuffer_format format);
/* Owns its planes, all 0; 1 to 16384 pixels each way. */
sl_status sl_pbuffer_create(int width, int height, sl_pbuffer_format format, sl_pbuffer **pbuffer,
                            sl_error *error);
void sl_pbuffer_destroy(sl_pbuffer *pbuffer);

#endif
