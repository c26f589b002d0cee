/* Light seen directly, L S* E: it takes no light pass, only what each pixel shows. */
#include "cache/direct_radiance/emission.h"

#include "base/counters.h"
#include "base/parallel.h"

/* ---- the environment's mean ---- */

sl_rgb sl_environment_mean(const sl_environment *environment) {
    if (!environment->present) return sl_grey(0.0f);
    if (environment->width == 0) return environment->constant;
    double sum[3] = {0.0, 0.0, 0.0}, whole = 0.0;
    for (int row = 0; row < environment->height; row++) {
        double of_row[3] = {0.0, 0.0, 0.0};
        float angle = 0.0f;
        for (int column = 0; column < environment->width; column++) {
            const float *texel = environment->texels + 3 * ((size_t)row * (size_t)environment->width + (size_t)column);
            for (int k = 0; k < 3; k++) of_row[k] += (double)texel[k];
        }
        sl_rgb unused;
        sl_environment_texel(environment, row, 0, &unused, &angle); /* that of all its row */
        for (int k = 0; k < 3; k++) sum[k] += of_row[k] * (double)angle;
        whole += (double)angle * (double)environment->width;
    }
    double over = whole > 0.0 ? 1.0 / whole : 0.0;
    return (sl_rgb){(float)(sum[0] * over), (float)(sum[1] * over), (float)(sum[2] * over)};
}

/* ---- pixels ---- */

static sl_rgb emission_of(const sl_emission *e, const sl_receivers *r, size_t pixel) {
    const sl_gbuffer *g = r->gbuffer;
    const uint32_t id = g->id[pixel];
    const sl_material *m = &e->scene->materials[g->material[pixel]];
    const bool beyond = r->mirrors && r->mirrors->of_triangle[id] != SL_NO_INDEX;
    sl_rgb reflected = beyond ? sl_rgb_mul(m->mirror, e->mean) : sl_grey(0.0f);
    if (!sl_material_is_emitter(m)) return reflected;
    sl_vec3 side = sl_v3(g->geometric_x[pixel], g->geometric_y[pixel], g->geometric_z[pixel]);
    return sl_rgb_add(reflected, sl_scene_emission(e->scene, id, side));
}

/* Mirrored views have their reflections in their matrices. */
static sl_rgb background_at(const sl_emission *e, const sl_receivers *r, size_t x, size_t y, size_t pixel) {
    const sl_environment *environment = &e->scene->environment;
    if (!environment->present || environment->width == 0) return e->mean;
    size_t path = r->path ? r->path[pixel] : 0;
    return sl_environment_radiance(environment, sl_view_direction(&r->view[path], (double)x + 0.5, (double)(r->first_row + (int)y) + 0.5));
}

static bool is_dark(const sl_emission *e, uint32_t material) {
    if (material == SL_NO_INDEX) return !e->scene->environment.present;
    const sl_material *m = &e->scene->materials[material];
    return !sl_material_is_emitter(m) && !sl_material_is_mirror(m);
}

bool sl_emission_add_row(const sl_emission *e, const sl_receivers *r, size_t y, float *const emission[3]) {
    const sl_gbuffer *g = r->gbuffer;
    const size_t width = (size_t)r->width, first = y * width;
    bool any = false;
    for (size_t x = 0, end; x < width && !e->none; x = end) {
        const uint32_t material = g->material[first + x];
        for (end = x + 1; end < width && g->material[first + end] == material;) end++;
        if (is_dark(e, material)) continue;
        any = true;
        for (size_t k = x; k < end; k++) {
            const size_t i = first + k;
            sl_rgb light = material == SL_NO_INDEX ? background_at(e, r, k, y, i) : emission_of(e, r, i);
            emission[0][i] += light.r;
            emission[1][i] += light.g;
            emission[2][i] += light.b;
        }
    }
    return any;
}

/* ---- a picture ---- */

/* Some pixel shows a planar mirror beyond the nesting limit. */
static bool ends_in_a_mirror(const sl_receivers *r) {
    const size_t pixels = (size_t)r->width * (size_t)r->height;
    uint32_t before = SL_NO_INDEX;
    for (size_t i = 0; r->mirrors && i < pixels; i++) {
        const uint32_t id = r->gbuffer->id[i];
        if (id != before && id != SL_NO_INDEX && r->mirrors->of_triangle[id] != SL_NO_INDEX) return true;
        before = id;
    }
    return false;
}

sl_emission sl_emission_of(const sl_scene *scene, const sl_receivers *picture) {
    const bool sky = scene->environment.present;
    bool wanted = sky && (scene->environment.width == 0 || ends_in_a_mirror(picture));
    return (sl_emission){scene, wanted ? sl_environment_mean(&scene->environment) : sl_grey(0.0f), !sky && scene->emitter_count == 0};
}

typedef struct {
    sl_emission of;
    const sl_receivers *receivers;
    float *const *emission;
} emitting;

static void emit_row(void *context, size_t y, unsigned worker) {
    (void)worker;
    const emitting *e = context;
    (void)sl_emission_add_row(&e->of, e->receivers, y, e->emission);
}

void sl_add_emission(const sl_scene *scene, const sl_receivers *receivers, unsigned threads, float *const emission[3],
                     sl_counters *counters) {
    emitting e = {sl_emission_of(scene, receivers), receivers, emission};
    if (e.of.none) return;
    sl_parallel_for(sl_thread_count(threads), (size_t)receivers->height, emit_row, &e);
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, (size_t)receivers->width * (size_t)receivers->height);
}
