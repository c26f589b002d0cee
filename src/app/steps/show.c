#include "app/steps/show.h"

#include "image/color.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Linear light that a PNG stores as this displayed level. */
static float displayed(float level) { return sl_srgb_decode(fminf(fmaxf(level, 0.0f), 1.0f)); }

static void range_of(const float *plane, size_t count, float *least, float *greatest) {
    *least = INFINITY, *greatest = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(plane[i])) continue;
        *least = fminf(*least, plane[i]);
        *greatest = fmaxf(*greatest, plane[i]);
    }
}

/* Values between the extremes as brightness; one value everywhere as grey, what is not finite as black. */
static void show_scalar(const float *in, size_t count, float *out) {
    float least, greatest;
    range_of(in, count, &least, &greatest);
    float width = greatest - least;
    for (size_t i = 0; i < count; i++) {
        float level = width > 0.0f ? (in[i] - least) / width : 0.5f;
        out[i] = isfinite(in[i]) ? displayed(level) : 0.0f;
    }
}

static void show_normals(const float *in, size_t count, float *out) {
    for (size_t i = 0; i < count; i++) out[i] = isfinite(in[i]) ? displayed(0.5f + 0.5f * in[i]) : 0.0f;
}

/* A colour for a number, far from those of its neighbours; nothing (0xffffffff or negative) is black. */
static void show_ids(const float *in, size_t count, float *const out[3]) {
    for (size_t i = 0; i < count; i++) {
        bool something = isfinite(in[i]) && in[i] >= 0.0f && in[i] < 4.0e9f;
        uint32_t h = something ? (uint32_t)in[i] * 2654435761u : 0;
        h ^= h >> 15;
        h *= 2246822519u;
        for (int c = 0; c < 3; c++)
            out[c][i] = something ? displayed(0.2f + 0.75f * (float)((h >> (8 * c)) & 255u) / 255.0f) : 0.0f;
    }
}

sl_status sl_show_buffer(const sl_image *buffer, sl_show show, sl_image **picture, sl_error *error) {
    sl_status status = sl_image_create(buffer->width, buffer->height, 3, NULL, picture, error);
    if (status != SL_OK) return status;
    size_t count = (size_t)buffer->width * (size_t)buffer->height;
    float *out[3];
    for (size_t c = 0; c < 3; c++) {
        const float *in = buffer->planes + (buffer->channels >= 3 ? c : 0) * count;
        out[c] = (*picture)->planes + c * count;
        if (show == SL_SHOW_SCALAR || show == SL_SHOW_POSITIONS) show_scalar(in, count, out[c]);
        else if (show == SL_SHOW_NORMALS) show_normals(in, count, out[c]);
        else memcpy(out[c], in, count * sizeof *in);
    }
    if (show == SL_SHOW_IDS) show_ids(buffer->planes, count, out);
    return SL_OK;
}
