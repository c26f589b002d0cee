/* The picture: emission, direct and indirect light, and what mirrors leave of them. */
#include "base/error.h"
#include "base/parallel.h"
#include "cache/light_octree/light_octree.h"
#include "cache/frame/picture_value.h"

enum { PICTURE = 0, EMISSION = 3, DIRECT = 6, INDIRECT = 9, LAYERS = 12 };

static const char *const layer_names[LAYERS] = {"R",          "G",          "B",          "emission.R",
                                                "emission.G", "emission.B", "direct.R",   "direct.G",
                                                "direct.B",   "indirect.R", "indirect.G", "indirect.B"};

typedef struct {
    const sl_octree_composition *parts;
    sl_view view;
    float *out;
} composing;

/* ---- emission ---- */

static sl_rgb sky_at(const composing *c, int x, int y) {
    const sl_scene *scene = c->parts->scene;
    if (!scene->environment.present) return sl_grey(0.0f);
    return sl_environment_radiance(&scene->environment, sl_view_direction(&c->view, x + 0.5, y + 0.5));
}

static sl_rgb emission_of(const sl_scene *scene, const sl_gbuffer *g, size_t pixel) {
    return sl_scene_emission(scene, g->id[pixel],
                             sl_v3(g->geometric_x[pixel], g->geometric_y[pixel], g->geometric_z[pixel]));
}

/* ---- pixels ---- */

static void put(const composing *c, size_t pixel, sl_rgb emission, sl_rgb share) {
    const sl_octree_composition *p = c->parts;
    size_t width = (size_t)p->gbuffer->width, height = (size_t)p->gbuffer->height, pixels = width * height;
    size_t to = (height - 1 - pixel / width) * width + pixel % width;
    const float emitted[3] = {emission.r, emission.g, emission.b}, left[3] = {share.r, share.g, share.b};
    for (size_t k = 0; k < 3; k++) {
        float e = sl_picture_value(emitted[k]), d = sl_picture_value(left[k] * p->direct[k][pixel]);
        float i = sl_picture_value(left[k] * p->indirect[k][pixel]);
        c->out[(EMISSION + k) * pixels + to] = e;
        c->out[(DIRECT + k) * pixels + to] = d;
        c->out[(INDIRECT + k) * pixels + to] = i;
        c->out[(PICTURE + k) * pixels + to] = sl_picture_value(e + d + i);
    }
}

static void compose_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const composing *c = context;
    const sl_octree_composition *p = c->parts;
    size_t width = (size_t)p->gbuffer->width;
    for (size_t x = 0; x < width; x++) {
        size_t i = row * width + x;
        sl_rgb emission = p->gbuffer->material[i] == SL_NO_INDEX ? sky_at(c, (int)x, (int)row)
                                                                 : emission_of(p->scene, p->gbuffer, i);
        put(c, i, emission, sl_grey(1.0f));
    }
}

static void compose_reflections(const composing *c) {
    const sl_octree_composition *p = c->parts;
    const sl_reflections *r = p->reflections;
    for (size_t k = 0; r && k < r->count; k++) {
        size_t i = r->pixel[k];
        bool surface = p->gbuffer->material[i] != SL_NO_INDEX;
        sl_rgb emission =
            surface ? sl_rgb_mul(r->throughput[k], emission_of(p->scene, p->gbuffer, i)) : r->background[k];
        put(c, i, emission, r->throughput[k]);
    }
}

sl_status sl_octree_compose(const sl_octree_composition *parts, sl_image **image, sl_error *error) {
    const sl_gbuffer *g = parts->gbuffer;
    sl_status status = sl_image_create(g->width, g->height, LAYERS, layer_names, image, error);
    if (status != SL_OK || !parts->drawn) return status;
    composing c = {parts, sl_view_scene(parts->scene, g->width, g->height), (*image)->planes};
    sl_parallel_for(parts->threads, (size_t)g->height, compose_row, &c);
    compose_reflections(&c);
    return SL_OK;
}
