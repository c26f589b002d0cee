/* Step 6 of Algorithm 2: means of E' and of the reflected radiance, filled where nothing reached, times
 * albedo / pi and ks, plus direct light and emission. */
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/frame/picture_value.h"
#include "cache/splatting/splatting.h"

const char *const sl_layer_names[SL_LAYERS_GLOSSY] = {
    "R",        "G",         "B",        "emission.R", "emission.G", "emission.B",
    "direct.R", "direct.G",  "direct.B", "indirect.R", "indirect.G", "indirect.B",
    "weight.Y", "records.Y", "glossy.R", "glossy.G",   "glossy.B"};

enum {
    PICTURE = 0,
    EMISSION = 3,
    DIRECT = 6,
    INDIRECT = 9,
    WEIGHT = 12,
    RECORDS = 13,
    GLOSSY = 14,
    MEANS = 6
};

typedef struct {
    const sl_composition *parts;
    const float *mean[MEANS]; /* irradiance, then reflected radiance per unit ks; bottom row first */
    float *layers;
    bool has_glossy;
    float right, top;         /* the picture's extent at unit distance */
} composing;

/* ---- emission ---- */

static sl_rgb sky_at(const composing *c, int x, int y) {
    const sl_scene *scene = c->parts->scene;
    const sl_gbuffer *g = c->parts->gbuffer;
    const sl_camera *camera = &scene->camera;
    if (!scene->environment.present) return sl_grey(0.0f);
    float u = (2.0f * ((float)x + 0.5f + scene->sub_frame.right) / (float)g->width - 1.0f) * c->right;
    float v = (2.0f * ((float)y + 0.5f + scene->sub_frame.up) / (float)g->height - 1.0f) * c->top;
    sl_vec3 direction = sl_mad(sl_mad(sl_neg(camera->back), u, camera->right), v, camera->up);
    return sl_environment_radiance(&scene->environment, sl_normalize_or(direction, sl_neg(camera->back)));
}

static sl_rgb emission_at(const composing *c, int x, int y, size_t pixel) {
    const sl_scene *scene = c->parts->scene;
    const sl_gbuffer *g = c->parts->gbuffer;
    if (!c->parts->drawn) return sl_grey(0.0f);
    if (g->material[pixel] == SL_NO_INDEX) return sky_at(c, x, y);
    return sl_scene_emission(scene, g->id[pixel],
                             sl_v3(g->geometric_x[pixel], g->geometric_y[pixel], g->geometric_z[pixel]));
}

/* ---- rows ---- */

static bool receives(const sl_composition *p, sl_receiver_class class, size_t i) {
    return p->receives[class] && p->receives[class][i];
}

/* Row y counts from the bottom, as on the hardware; images have row 0 at the top. */
static void compose_row(void *context, size_t index, unsigned worker) {
    (void)worker;
    const composing *c = context;
    const sl_composition *p = c->parts;
    const sl_gbuffer *g = p->gbuffer;
    const float *albedo[3] = {g->diffuse_r, g->diffuse_g, g->diffuse_b};
    size_t pixels = (size_t)g->width * (size_t)g->height, width = (size_t)g->width;
    for (size_t x = 0; x < width; x++) {
        if (!sl_sub_frame_shows(&p->scene->sub_frame, index * width + x)) continue;
        size_t i = index * width + x, out = ((size_t)g->height - 1 - index) * width + x;
        bool glossy = receives(p, SL_RECEIVES_RADIANCE, i),
             diffuse = glossy || receives(p, SL_RECEIVES_IRRADIANCE, i);
        sl_rgb e = emission_at(c, (int)x, (int)index, i),
               ks = glossy ? p->scene->materials[g->material[i]].specular : sl_grey(0.0f);
        const float emitted[3] = {e.r, e.g, e.b}, specular[3] = {ks.r, ks.g, ks.b};
        for (size_t k = 0; k < 3; k++) {
            float emission = sl_picture_value(emitted[k]), direct = sl_picture_value(p->direct[k][i]);
            float indirect =
                diffuse ? sl_picture_value(c->mean[k][i] * (albedo[k][i] * (float)(1.0 / SL_PI))) : 0.0f;
            /* A lobe of finite order rings below 0. */
            float reflected =
                glossy && c->mean[3 + k][i] > 0.0f ? sl_picture_value(c->mean[3 + k][i] * specular[k]) : 0.0f;
            c->layers[(EMISSION + k) * pixels + out] = emission;
            c->layers[(DIRECT + k) * pixels + out] = direct;
            c->layers[(INDIRECT + k) * pixels + out] = indirect;
            c->layers[(PICTURE + k) * pixels + out] =
                sl_picture_value(emission + direct + indirect + reflected);
            if (c->has_glossy) c->layers[(GLOSSY + k) * pixels + out] = reflected;
        }
        c->layers[WEIGHT * pixels + out] = p->splats.weight[i];
        c->layers[RECORDS * pixels + out] = p->splats.count[i];
    }
}

/* Dims what mirror pixels show, which has been composed as if it were seen straight, and adds what lies
 * beyond the scene. */
static void compose_mirrors(const composing *c) {
    const sl_composition *p = c->parts;
    const sl_reflections *r = p->reflections;
    const sl_gbuffer *g = p->gbuffer;
    size_t pixels = (size_t)g->width * (size_t)g->height, width = (size_t)g->width;
    for (size_t k = 0; r && k < r->count; k++) {
        size_t i = r->pixel[k], out = ((size_t)g->height - 1 - i / width) * width + i % width;
        bool surface = g->material[i] != SL_NO_INDEX;
        const float throughput[3] = {r->throughput[k].r, r->throughput[k].g, r->throughput[k].b};
        const float beyond[3] = {r->background[k].r, r->background[k].g, r->background[k].b};
        for (size_t channel = 0; channel < 3; channel++) {
            float *layer[] = {&c->layers[(EMISSION + channel) * pixels + out],
                              &c->layers[(DIRECT + channel) * pixels + out],
                              &c->layers[(INDIRECT + channel) * pixels + out],
                              c->has_glossy ? &c->layers[(GLOSSY + channel) * pixels + out] : NULL};
            float sum = 0.0f;
            for (int l = 0; l < 4 && layer[l]; l++) {
                *layer[l] = sl_picture_value(surface  ? *layer[l] * throughput[channel]
                                             : l == 0 ? beyond[channel]
                                                      : 0.0f);
                sum += *layer[l];
            }
            c->layers[(PICTURE + channel) * pixels + out] = sl_picture_value(sum);
        }
    }
}

/* ---- means ---- */

typedef struct {
    const sl_splat_buffer *splats;
    size_t width, pixels;
    bool glossy;
    float *mean;
} averaging;

static void average_row(void *context, size_t index, unsigned worker) {
    (void)worker;
    const averaging *a = context;
    const sl_splat_buffer *s = a->splats;
    const float *sums[MEANS] = {s->r, s->g, s->b, s->glossy[0], s->glossy[1], s->glossy[2]};
    for (size_t k = 0; k < (a->glossy ? MEANS : 3); k++) {
        for (size_t i = index * a->width; i < (index + 1) * a->width; i++)
            a->mean[k * a->pixels + i] = s->weight[i] > 0.0f ? sums[k][i] / s->weight[i] : 0.0f;
    }
}

static sl_status fill(const sl_composition *p, bool glossy, float *mean, sl_error *error) {
    const sl_gbuffer *g = p->gbuffer;
    size_t pixels = (size_t)g->width * (size_t)g->height;
    sl_status status = SL_OK;
    for (int class = 0; status == SL_OK && class < SL_RECEIVER_CLASSES; class++) {
        const uint32_t *mine = p->receives[class];
        if (!mine) continue;
        status = sl_fill_uncovered(g->width, g->height, p->splats.weight, mine, mean, mean + pixels,
                                   mean + 2 * pixels, error);
        if (status == SL_OK && glossy && class == SL_RECEIVES_RADIANCE)
            status = sl_fill_uncovered(g->width, g->height, p->splats.weight, mine, mean + 3 * pixels,
                                       mean + 4 * pixels, mean + 5 * pixels, error);
    }
    return status;
}

sl_status sl_compose(const sl_composition *parts, sl_image *image, sl_error *error) {
    const sl_gbuffer *g = parts->gbuffer;
    size_t width = (size_t)g->width, height = (size_t)g->height, pixels = width * height;
    bool glossy = parts->splats.glossy[0] != NULL;
    float *mean = sl_allocate((glossy ? MEANS : 3) * pixels, sizeof *mean);
    if (!mean) return sl_fail_memory(error, "the picture");
    averaging means = {&parts->splats, width, pixels, glossy, mean};
    sl_parallel_for(parts->threads, height, average_row, &means);
    sl_status status = fill(parts, glossy, mean, error);
    if (status == SL_OK) {
        float top = (float)sl_tan(0.5 * (double)parts->scene->camera.vertical_fov);
        composing c = {.parts = parts,
                       .layers = image->planes,
                       .has_glossy = image->channels == SL_LAYERS_GLOSSY,
                       .top = top,
                       .right = top * (float)g->width / (float)g->height};
        for (size_t k = 0; k < (glossy ? MEANS : 3); k++) c.mean[k] = mean + k * pixels;
        sl_parallel_for(parts->threads, height, compose_row, &c);
        compose_mirrors(&c);
    }
    sl_free(mean);
    return status;
}
