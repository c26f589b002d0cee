#include "cache/reflect/reflect.h"

#include <string.h>

#include "base/parallel.h"
#include "cache/frame/picture_value.h"

const char *const sl_composed_names[SL_COMPOSED_CHANNELS] = {
    "R",        "G",        "B",        "emission.R", "emission.G", "emission.B",
    "direct.R", "direct.G", "direct.B", "indirect.R", "indirect.G", "indirect.B"};

static bool has_layers(const sl_composition *c) { return c->image->channels > SL_COMPOSED_EMISSION; }

/* Channel `channel` of the picture, at the G-buffer's row. */
static float *row_of(const sl_composition *c, int channel, int row) {
    const size_t width = (size_t)c->image->width, height = (size_t)c->image->height;
    return c->image->planes + ((size_t)channel + 1) * width * height -
           ((size_t)c->first_row + (size_t)row + 1) * width;
}

/* ---- emission ---- */

static sl_rgb surface_emission(const sl_composition *c, size_t i) {
    return sl_scene_emission(c->scene, c->gbuffer->id[i], sl_gbuffer_geometric(c->gbuffer, i));
}

static bool is_dark(const sl_scene *scene, uint32_t material) {
    if (material == SL_NO_INDEX) return !scene->environment.present;
    return !sl_material_is_emitter(&scene->materials[material]);
}

static sl_rgb emission_at(const sl_composition *c, size_t i, int x, int row) {
    if (c->gbuffer->material[i] != SL_NO_INDEX) return surface_emission(c, i);
    return sl_view_emission(c->view, c->scene, SL_NO_INDEX, (size_t)x, (size_t)(c->first_row + row));
}

static bool shines(const sl_scene *scene) { return scene->environment.present || scene->emitter_count > 0; }

/* Begins the sums of columns [from, to) with it. */
static void emit(const sl_composition *c, int row, size_t from, size_t to) {
    const size_t first = (size_t)row * (size_t)c->gbuffer->width;
    float *sum[3];
    for (int k = 0; k < 3; k++)
        memset((sum[k] = row_of(c, k, row)) + from, 0, (to - from) * sizeof **sum);
    const uint32_t *material = c->gbuffer->material + first;
    for (size_t x = from, dark = to; x < to && shines(c->scene); x++) {
        if (dark < to && material[x] == material[dark]) continue;
        if (is_dark(c->scene, material[x])) {
            dark = x;
            continue;
        }
        const sl_rgb light = emission_at(c, first + x, (int)x, row);
        sum[0][x] = sl_picture_value(light.r);
        sum[1][x] = sl_picture_value(light.g);
        sum[2][x] = sl_picture_value(light.b);
    }
    for (int k = 0; has_layers(c) && k < 3; k++)
        memcpy(row_of(c, SL_COMPOSED_EMISSION + k, row) + from, sum[k] + from, (to - from) * sizeof **sum);
}

/* ---- light ---- */

static void add(size_t width, const float *restrict radiance, float *restrict sum) {
#pragma omp simd
    for (size_t x = 0; x < width; x++) sum[x] = sl_picture_value(sum[x] + sl_picture_value(radiance[x]));
}

static void add_layer(size_t width, const float *restrict radiance, float *restrict layer,
                      float *restrict sum) {
#pragma omp simd
    for (size_t x = 0; x < width; x++) {
        layer[x] = sl_picture_value(radiance[x]);
        sum[x] = sl_picture_value(sum[x] + layer[x]);
    }
}

static void compose_run(const sl_composition *c, int row, size_t from, size_t to) {
    const size_t first = (size_t)row * (size_t)c->gbuffer->width + from, count = to - from;
    emit(c, row, from, to);
    for (int l = 0; l < SL_COMPOSED_LAYERS && c->layer[l].channel; l++) {
        for (int k = 0; k < 3; k++) {
            const float *radiance = c->layer[l].radiance[k] + first;
            float *sum = row_of(c, k, row) + from;
            if (has_layers(c))
                add_layer(count, radiance, row_of(c, c->layer[l].channel + k, row) + from, sum);
            else add(count, radiance, sum);
        }
    }
}

void sl_compose_row(const sl_composition *c, int row) {
    const sl_sub_frame *at = &c->scene->sub_frame;
    const size_t width = (size_t)c->gbuffer->width, first = (size_t)(c->first_row + row) * width,
                 end = first + width;
    for (sl_pixel_run r = sl_sub_frame_run(at, first, end); r.first < r.end;
         r = sl_sub_frame_run(at, r.end, end))
        compose_run(c, row, r.first - first, r.end - first);
}

/* ---- mirrors ---- */

static void compose_mirror(const sl_composition *c, size_t slot) {
    const sl_reflections *r = c->reflections;
    const size_t i = r->pixel[slot], width = (size_t)c->gbuffer->width, x = i % width;
    const int row = (int)(i / width);
    const sl_rgb left = r->throughput[slot],
                 seen = c->gbuffer->material[i] == SL_NO_INDEX ? r->background[slot]
                                                               : sl_rgb_mul(left, surface_emission(c, i));
    const float emission[3] = {seen.r, seen.g, seen.b}, share[3] = {left.r, left.g, left.b};
    for (int k = 0; k < 3; k++) {
        float sum = sl_picture_value(emission[k]);
        if (has_layers(c)) row_of(c, SL_COMPOSED_EMISSION + k, row)[x] = sum;
        for (int l = 0; l < SL_COMPOSED_LAYERS && c->layer[l].channel; l++) {
            const float light = sl_picture_value(sl_picture_value(c->layer[l].radiance[k][i]) * share[k]);
            if (has_layers(c)) row_of(c, c->layer[l].channel + k, row)[x] = light;
            sum += light;
        }
        row_of(c, k, row)[x] = sl_picture_value(sum);
    }
}

void sl_compose_mirrors(const sl_composition *c) {
    for (size_t k = 0; c->reflections && k < c->reflections->count; k++) compose_mirror(c, k);
}

static void compose_one_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    sl_compose_row(context, (int)row);
}

void sl_compose_picture(const sl_composition *composition, unsigned threads) {
    sl_composition c = *composition;
    sl_parallel_for(threads, (size_t)c.gbuffer->height, compose_one_row, &c);
    sl_compose_mirrors(&c);
}
