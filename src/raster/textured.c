/* The textured pass: perspective-correct texture coordinates, level of detail and filtered colour, once for each visible pixel.
 * strip of pixels is cut into runs that show one texture; corners are fetched pixel by pixel, the rest runs in vector lanes. */
#include <string.h>

#include "base/parallel.h"
#include "raster/lookup_kernels.h"

enum { STRIP = 1024 };

typedef struct {
    const sl_raster *raster;
    const sl_view *view;
    const uint32_t *id;
    const sl_textured_pass *pass;
    const sl_textured_planes *out;
    const sl_texture_kernels *kernels;
    size_t pixels;
} textured;

/* NULL: a mesh alone has none. */
static const sl_material *material_of(const textured *c, uint32_t triangle) {
    const sl_scene *scene = c->raster->scene;
    return scene ? &scene->materials[scene->material_index[triangle]] : NULL;
}

/* NULL: without texture. */
static const sl_texture_image *image_of(const textured *c, uint32_t triangle) {
    if (c->pass->single) return c->pass->single;
    const sl_material *m = material_of(c, triangle);
    return m && m->texture != SL_NO_INDEX && c->pass->set ? sl_texture_set_image(c->pass->set, m->texture) : NULL;
}

static void write_if(float *plane, size_t pixel, float value) {
    if (plane) plane[pixel] = value;
}

static void write_background(const textured *c, size_t pixel) {
    for (int k = 0; k < 4; k++) write_if(c->out->color[k], pixel, 0.0f);
    for (int k = 0; k < 3; k++) write_if(c->out->specular[k], pixel, 0.0f);
    write_if(c->out->s, pixel, 0.0f);
    write_if(c->out->t, pixel, 0.0f);
    write_if(c->out->lod, pixel, 0.0f);
}

static void write_material(const textured *c, size_t pixel, const float rgba[4]) {
    const sl_material *m = material_of(c, c->id[pixel]);
    sl_rgb kd = c->pass->single || !m ? sl_grey(1.0f) : m->diffuse, ks = m ? m->specular : sl_grey(0.0f);
    write_if(c->out->color[0], pixel, kd.r * rgba[0]);
    write_if(c->out->color[1], pixel, kd.g * rgba[1]);
    write_if(c->out->color[2], pixel, kd.b * rgba[2]);
    write_if(c->out->color[3], pixel, rgba[3]);
    write_if(c->out->specular[0], pixel, ks.r);
    write_if(c->out->specular[1], pixel, ks.g);
    write_if(c->out->specular[2], pixel, ks.b);
}

/* What the kernel needs of a triangle. */
typedef struct {
    uint32_t triangle;
    float corner[9], s[3], t[3];
} corners;

static void fetch_corners(const textured *c, uint32_t triangle, corners *out) {
    const sl_raster_mesh *mesh = &c->raster->mesh;
    const sl_scene *scene = c->raster->scene;
    const float *own = c->pass->coordinates;
    out->triangle = triangle;
    for (int k = 0; k < 3; k++) {
        uint32_t vertex = mesh->vertex[k][triangle];
        sl_vec3 q = sl_sub(sl_v3(mesh->x[vertex], mesh->y[vertex], mesh->z[vertex]), c->view->origin);
        out->corner[3 * k] = q.x;
        out->corner[3 * k + 1] = q.y;
        out->corner[3 * k + 2] = q.z;
        const float *corner = own ? own + 6 * (size_t)triangle + 2 * (size_t)k : NULL;
        out->s[k] = corner ? corner[0] : scene ? scene->texture_u[vertex] : 0.0f;
        out->t[k] = corner ? corner[1] : scene ? scene->texture_v[vertex] : 0.0f;
    }
}

static void fill_block(const textured *c, size_t first, size_t count, const float *w1, const float *w2, sl_textured_block *block) {
    corners at = {.triangle = SL_NO_INDEX};
    for (size_t n = 0; n < count; n++) {
        if (c->id[first + n] != at.triangle) fetch_corners(c, c->id[first + n], &at);
        for (int k = 0; k < 9; k++) block->corner[k][n] = at.corner[k];
        for (int k = 0; k < 3; k++) {
            block->s[k][n] = at.s[k];
            block->t[k][n] = at.t[k];
        }
        block->w1[n] = w1[n];
        block->w2[n] = w2[n];
        block->x[n] = (int32_t)((first + n) % (size_t)c->view->width);
        block->y[n] = (int32_t)((first + n) / (size_t)c->view->width);
    }
}

/* Pixels [first, first + count), which all show `image`. */
static void shade_run(const textured *c, const sl_texture_image *image, size_t first, size_t count, const float *w1,
                      const float *w2, sl_textured_block *block) {
    float s[SL_TEXTURE_BLOCK], t[SL_TEXTURE_BLOCK], lod[SL_TEXTURE_BLOCK], r[SL_TEXTURE_BLOCK], g[SL_TEXTURE_BLOCK],
        b[SL_TEXTURE_BLOCK], a[SL_TEXTURE_BLOCK];
    float *const plane[4] = {r, g, b, a};
    fill_block(c, first, count, w1, w2, block);
    c->kernels->textured(block, c->view, image->width[0], image->height[0], c->pass->lod_rule, s, t, lod);
    for (size_t n = 0; n < count; n++) lod[n] += c->pass->lod_bias;
    c->kernels->texture(image, c->pass->sampler, count, s, t, lod, plane);
    for (size_t n = 0; n < count; n++) {
        const float rgba[4] = {r[n], g[n], b[n], a[n]};
        write_material(c, first + n, rgba);
        write_if(c->out->s, first + n, s[n]);
        write_if(c->out->t, first + n, t[n]);
        write_if(c->out->lod, first + n, lod[n]);
    }
}

static void shade_plain(const textured *c, size_t pixel) {
    static const float white[4] = {1.0f, 1.0f, 1.0f, 1.0f};
    write_background(c, pixel);
    if (c->id[pixel] != SL_NO_INDEX) write_material(c, pixel, white);
}

static void shade_strip(void *context, size_t index, unsigned worker) {
    (void)worker;
    const textured *c = context;
    size_t first = index * STRIP, count = c->pixels - first < STRIP ? c->pixels - first : STRIP;
    uint32_t pixel[STRIP] = {0};
    float w1[STRIP], w2[STRIP];
    sl_textured_block block;
    memset(&block, 0, sizeof block);
    for (size_t n = 0; n < count; n++) pixel[n] = (uint32_t)(first + n);
    sl_raster_barycentrics(c->raster, c->view, count, pixel, c->id + first, w1, w2);
    for (size_t n = 0; n < count;) {
        uint32_t id = c->id[first + n];
        const sl_texture_image *image = id == SL_NO_INDEX ? NULL : image_of(c, id);
        if (!image) {
            shade_plain(c, first + n++);
            continue;
        }
        size_t end = n + 1;
        while (end < count && end - n < SL_TEXTURE_BLOCK && c->id[first + end] != SL_NO_INDEX &&
               image_of(c, c->id[first + end]) == image) end++;
        shade_run(c, image, first + n, end - n, w1 + n, w2 + n, &block);
        n = end;
    }
}

void sl_raster_textured(const sl_raster *raster, const sl_view *view, unsigned threads, const uint32_t *id,
                        const sl_textured_pass *pass, const sl_textured_planes *out, sl_counters *counters) {
    textured c = {raster, view, id, pass, out, sl_texture_kernels_best(), (size_t)view->width * (size_t)view->height};
    sl_parallel_for(sl_thread_count(threads), (c.pixels + STRIP - 1) / STRIP, shade_strip, &c);
    uint64_t shaded = 0;
    for (size_t i = 0; i < c.pixels; i++) shaded += id[i] != SL_NO_INDEX;
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, shaded);
}
