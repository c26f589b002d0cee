/* The explanation of a pixel: what a method tells is collected here, and held against the picture. */
#include "cache/frame/method.h"

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "image/tone.h"

#include <string.h>

struct sl_explanation_writer {
    const sl_image *picture;
    size_t pixel; /* in the picture's planes */
    sl_explanation *explanation;
    size_t capacity;
    bool failed;
};

void sl_explanation_add(sl_explanation_writer *writer, const sl_explanation_term *term) {
    sl_explanation *explanation = writer->explanation;
    const bool fits =
        sl_make_room(&explanation->terms, explanation->count, &writer->capacity, sizeof *term);
    writer->failed = writer->failed || !fits;
    if (fits) explanation->terms[explanation->count++] = *term;
}

void sl_explanation_add_light(sl_explanation_writer *writer, const char *layer, const char *kind,
                              uint64_t index, const sl_vec3 *position, double weight, const float value[3],
                              const double factor[3]) {
    sl_explanation_term term = {.layer = layer, .kind = kind, .index = index, .weight = weight};
    bool any = false;
    if (position) {
        const float at[3] = {position->x, position->y, position->z};
        term.placed = true;
        memcpy(term.position, at, sizeof at);
    }
    for (int c = 0; c < 3; c++) {
        term.value[c] = value[c];
        term.contribution[c] = weight * (double)value[c] * factor[c];
        any = any || term.contribution[c] != 0.0;
    }
    if (any) sl_explanation_add(writer, &term);
}

/* The three values of a layer at the pixel, or of the picture where layer is NULL; 0 where there is no such
 * channel. */
static void read_layer(const sl_image *picture, const char *layer, size_t pixel, float value[3]) {
    const float *planes[3];
    sl_layer_planes(picture, layer, planes);
    for (int c = 0; c < 3; c++) value[c] = planes[c] ? planes[c][pixel] : 0.0f;
}

void sl_explanation_add_layer(sl_explanation_writer *writer, const char *layer, const char *kind) {
    sl_explanation_term term = {.layer = layer, .kind = kind, .weight = 1.0};
    read_layer(writer->picture, layer, writer->pixel, term.value);
    if (term.value[0] == 0.0f && term.value[1] == 0.0f && term.value[2] == 0.0f) return;
    for (int c = 0; c < 3; c++) term.contribution[c] = (double)term.value[c];
    sl_explanation_add(writer, &term);
}

/* Notes what is missing to the pixel's exact value once all contributions have been added in order. */
static void settle(sl_explanation *explanation) {
    for (int c = 0; c < 3; c++) {
        double sum = 0.0;
        for (size_t i = 0; i < explanation->count; i++) sum += explanation->terms[i].contribution[c];
        explanation->rounding[c] = (double)explanation->pixel[c] - sum;
    }
}

sl_status sl_explanation_tell(const sl_method_class *class, void *state, const sl_image *picture, int x,
                              int y, sl_explanation **explanation, sl_error *error) {
    *explanation = NULL;
    if (!class->explanation)
        return sl_fail(error, SL_ERROR_USAGE, "%s tells no explanations of pixels", class->name);
    if (x < 0 || y < 0 || x >= picture->width || y >= picture->height)
        return sl_fail(error, SL_ERROR_USAGE, "no pixel %d, %d in a picture of %d x %d", x, y, picture->width,
                       picture->height);
    sl_explanation *told = sl_allocate(1, sizeof *told);
    if (!told) return sl_fail_memory(error, "the explanation of a pixel");
    *told = (sl_explanation){.count = 0};
    sl_explanation_writer writer = {
        .picture = picture, .explanation = told, .pixel = (size_t)y * (size_t)picture->width + (size_t)x};
    read_layer(picture, NULL, writer.pixel, told->pixel);
    sl_status status = class->explanation(state, x, picture->height - 1 - y, &writer, error);
    if (status == SL_OK && writer.failed) status = sl_fail_memory(error, "the explanation of a pixel");
    if (status != SL_OK) {
        sl_explanation_destroy(told);
        return status;
    }
    settle(told);
    *explanation = told;
    return SL_OK;
}

void sl_explanation_destroy(sl_explanation *explanation) {
    if (!explanation) return;
    sl_free(explanation->terms);
    sl_free(explanation);
}
