/* Light seen directly, L S* E: it takes no light pass, only what each pixel shows. */
#include "cache/direct_radiance/emission.h"

#include "base/counters.h"
#include "base/parallel.h"

/* ---- the background's directions ---- */

/* What a pixel at (u, v) in [-1,1]^2 looks along: the d for which rows 0, 1 and 3 of its path's matrix give (u, v, 1); by the rows' cross
 * products. A mirrored view has its reflections in the rows. */
typedef struct {
    sl_vec3d along_x, along_y, middle;
} sight;

static sl_vec3d row_of(const sl_view *view, int k) {
    return sl_v3d((double)view->clip[k][0], (double)view->clip[k][1], (double)view->clip[k][2]);
}

static sight sight_of(const sl_view *view) {
    sl_vec3d x = row_of(view, 0), y = row_of(view, 1), w = row_of(view, 3);
    sl_vec3d yw = sl_crossd(y, w), wx = sl_crossd(w, x), xy = sl_crossd(x, y);
    double determinant = sl_dotd(x, yw), over = determinant != 0.0 ? 1.0 / determinant : 0.0;
    return (sight){sl_scaled(yw, over), sl_scaled(wx, over), sl_scaled(xy, over)};
}

static sl_vec3 direction_at(const sight *s, const sl_view *view, size_t x, size_t y) {
    double u = (2.0 * (double)x + 1.0) / (double)view->width - 1.0, v = (2.0 * (double)y + 1.0) / (double)view->height - 1.0;
    sl_vec3d d = sl_addd(sl_addd(sl_scaled(s->along_x, u), sl_scaled(s->along_y, v)), s->middle);
    return sl_normalize_or(sl_to_float(d), sl_v3(0.0f, 0.0f, -1.0f));
}

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

typedef struct {
    const sl_scene *scene;
    const sl_receivers *receivers;
    const sight *sights; /* by path */
    sl_rgb mean;         /* of the environment */
    float *const *emission;
} emitting;

static sl_rgb emission_of(const emitting *e, size_t pixel) {
    const sl_receivers *r = e->receivers;
    const sl_gbuffer *g = r->gbuffer;
    const uint32_t id = g->id[pixel];
    const sl_material *m = &e->scene->materials[g->material[pixel]];
    if (r->mirrors && r->mirrors->of_triangle[id] != SL_NO_INDEX) return sl_rgb_mul(m->mirror, e->mean);
    if (!sl_material_is_emitter(m)) return sl_grey(0.0f);
    sl_vec3 geometric = sl_v3(g->geometric_x[pixel], g->geometric_y[pixel], g->geometric_z[pixel]);
    bool front = sl_dot(geometric, sl_scene_geometric_normal(e->scene, id)) > 0.0f;
    return front || m->emission_two_sided ? m->emission : sl_grey(0.0f);
}

static sl_rgb background_at(const emitting *e, size_t x, size_t y, size_t pixel) {
    const sl_environment *environment = &e->scene->environment;
    const sl_receivers *r = e->receivers;
    if (!environment->present || environment->width == 0) return e->mean;
    size_t path = r->path ? r->path[pixel] : 0;
    return sl_environment_radiance(environment, direction_at(&e->sights[path], &r->view[path], x, y));
}

static void emit_row(void *context, size_t y, unsigned worker) {
    (void)worker;
    const emitting *e = context;
    const sl_gbuffer *g = e->receivers->gbuffer;
    const size_t width = (size_t)e->receivers->width;
    for (size_t x = 0; x < width; x++) {
        const size_t i = y * width + x;
        sl_rgb light = g->id[i] == SL_NO_INDEX ? background_at(e, x, y, i) : emission_of(e, i);
        e->emission[0][i] += light.r;
        e->emission[1][i] += light.g;
        e->emission[2][i] += light.b;
    }
}

void sl_add_emission(const sl_scene *scene, const sl_receivers *receivers, unsigned threads, float *const emission[3],
                     sl_counters *counters) {
    const bool sky = scene->environment.present;
    if (!sky && scene->emitter_count == 0) return;
    sight sights[SL_MIRROR_PATHS];
    for (size_t p = 0; p < receivers->path_count; p++) sights[p] = sight_of(&receivers->view[p]);
    bool wanted = sky && (receivers->mirrors || scene->environment.width == 0);
    emitting e = {.scene = scene, .receivers = receivers, .sights = sights, .emission = emission,
                  .mean = wanted ? sl_environment_mean(&scene->environment) : sl_grey(0.0f)};
    sl_parallel_for(sl_thread_count(threads), (size_t)receivers->height, emit_row, &e);
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, (size_t)receivers->width * (size_t)receivers->height);
}
