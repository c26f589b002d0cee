/* Pass 8: the accumulation targets as a picture. */
#include "base/error.h"
#include "base/parallel.h"
#include "cache/direct_radiance/direct_radiance.h"
#include "cache/picture_value.h"

enum { PICTURE = 0, EMISSION = 3, DIRECT = 6, INDIRECT = 9, SPREAD = 12, LAYERS };

static const char *const layer_names[LAYERS] = {"R",        "G",        "B",          "emission.R", "emission.G", "emission.B", "direct.R",
                                                "direct.G", "direct.B", "indirect.R", "indirect.G", "indirect.B", "spread.Y"};

typedef struct {
    const sl_radiance_layers *layers;
    const sl_receivers *receivers;
    float *out;
} composing;

/* Rows count from the bottom, as on the hardware; images have row 0 at the top. */
static void compose_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const composing *c = context;
    const sl_receivers *r = c->receivers;
    size_t width = (size_t)r->width, height = (size_t)r->height, pixels = width * height;
    size_t from = row * width, to = (height - 1 - row) * width;
    for (size_t k = 0; k < 3; k++) {
        const float *emission = c->layers->emission[k] + from, *direct = c->layers->direct[k] + from;
        const float *indirect = c->layers->indirect[k] + from, *throughput = r->throughput[k] ? r->throughput[k] + from : NULL;
        for (size_t x = 0; x < width; x++) {
            float share = throughput ? throughput[x] : 1.0f, e = sl_picture_value(share * emission[x]);
            float d = sl_picture_value(share * direct[x]), i = sl_picture_value(share * indirect[x]);
            c->out[(EMISSION + k) * pixels + to + x] = e;
            c->out[(DIRECT + k) * pixels + to + x] = d;
            c->out[(INDIRECT + k) * pixels + to + x] = i;
            c->out[(PICTURE + k) * pixels + to + x] = sl_picture_value(e + d + i);
        }
    }
    for (size_t x = 0; x < width; x++) c->out[SPREAD * pixels + to + x] = sl_picture_value(c->layers->spread[from + x]);
}

sl_status sl_radiance_compose(const sl_radiance_layers *layers, const sl_receivers *receivers, unsigned threads, sl_image **image,
                              sl_error *error) {
    sl_status status = sl_image_create(receivers->width, receivers->height, LAYERS, layer_names, image, error);
    if (status != SL_OK) return status;
    composing c = {layers, receivers, (*image)->planes};
    sl_parallel_for(threads, (size_t)receivers->height, compose_row, &c);
    return SL_OK;
}
