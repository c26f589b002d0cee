/* Pass 8: the accumulation targets as a picture. */
#include "base/error.h"
#include "base/parallel.h"
#include "cache/direct_radiance/compose_kernels.h"
#include "cache/direct_radiance/direct_radiance.h"
#include "cache/frame/picture_value.h"
#include "image/unset.h"

enum { PICTURE = 0, EMISSION = 3, DIRECT = 6, INDIRECT = 9, SPREAD = 12, LAYERS };

static const char *const layer_names[LAYERS] = {"R",        "G",        "B",          "emission.R", "emission.G", "emission.B", "direct.R",
                                                "direct.G", "direct.B", "indirect.R", "indirect.G", "indirect.B", "spread.Y"};

sl_status sl_radiance_picture_create(int width, int height, bool layers, sl_image **image, sl_error *error) {
    return sl_image_create_unset(width, height, layers ? LAYERS : EMISSION, layer_names, image, error);
}

/* Rows count from the bottom, as on the hardware; images have row 0 at the top. */
static void compose_row(const sl_radiance_layers *layers, const sl_receivers *r, size_t row, sl_compose_kernel *compose, sl_image *image) {
    size_t width = (size_t)image->width, height = (size_t)image->height, pixels = width * height;
    size_t from = row * width, to = (height - 1 - (size_t)r->first_row - row) * width;
    bool all = image->channels == LAYERS;
    for (size_t k = 0; k < 3; k++) {
        float *out = image->planes + k * pixels + to;
        const sl_compose_row channel = {width, r->throughput[k] ? r->throughput[k] + from : NULL, layers->emission[k] + from,
                                        layers->direct[k] + from, layers->indirect[k] + from,
                                        {out + PICTURE * pixels, all ? out + EMISSION * pixels : NULL, all ? out + DIRECT * pixels : NULL,
                                         all ? out + INDIRECT * pixels : NULL}};
        compose(&channel);
    }
    for (size_t x = 0; x < width && all; x++) image->planes[SPREAD * pixels + to + x] = sl_picture_value(layers->spread[from + x]);
}

void sl_radiance_compose_rows(const sl_radiance_layers *layers, const sl_receivers *r, size_t first, size_t end, sl_image *image) {
    sl_compose_kernel *compose = sl_compose_kernel_for(sl_isa_best());
    for (size_t row = first; row < end; row++) compose_row(layers, r, row, compose, image);
}

typedef struct {
    const sl_radiance_layers *layers;
    const sl_receivers *receivers;
    sl_image *image;
} composing;

static void compose_one(void *context, size_t row, unsigned worker) {
    (void)worker;
    const composing *c = context;
    sl_radiance_compose_rows(c->layers, c->receivers, row, row + 1, c->image);
}

sl_status sl_radiance_compose(const sl_radiance_layers *layers, const sl_receivers *receivers, bool all, unsigned threads, sl_image **image,
                              sl_error *error) {
    sl_status status = sl_radiance_picture_create(receivers->width, receivers->height, all, image, error);
    if (status != SL_OK) return status;
    composing c = {layers, receivers, *image};
    sl_parallel_for(threads, (size_t)receivers->height, compose_one, &c);
    return SL_OK;
}
