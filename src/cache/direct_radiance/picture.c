/* Passes 5 to 8 at once, four rows of the picture after another. What the hardware keeps in targets as large
 * as the picture (a G-buffer of fourteen planes, nine of light) is here as large as a strip, which one thread
 * resolves, lights and composes while it is in its cache: out of it goes nothing but the picture. */
#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/direct_radiance/direct_radiance.h"
#include "cache/direct_radiance/receivers.h"
#include "image/unset.h"
#include "scene/ambient.h"

#include <string.h>

/* APART: floats between planes, lest at widths that are powers of two the same pixel of all of them fell into
 * the same lines of the cache. */
enum { SURFACE_PLANES = 13, LIGHT_PLANES = 9, APART = 112 };

/* A thread's part of the picture. */
typedef struct {
    sl_gbuffer gbuffer;
    float *surface; /* the G-buffer's planes */
    float *light;   /* and those of light: direct, indirect, emission */
    bool shines;    /* there is something in those of emission, which there seldom is */
    float *emission[3];
    sl_tile_target target;
} strip;

typedef struct {
    const sl_strip_pass *pass;
    const sl_receivers *outline;
    sl_resolver *resolver;
    sl_receiver_kinds kinds, tricked; /* tricked: mirrors receive indirect light as if they were diffuse */
    bool trick;
    sl_emission emission;
    sl_direct_light direct;
    sl_photon_sums *sums; /* NULL: no indirect light */
    sl_image *image;
    sl_compose_kernel *compose;
    strip *worker;
    unsigned workers;
    size_t room;            /* from plane to plane of a strip */
    sl_counters *counters;  /* one a strip */
} drawing;

/* ---- memory ---- */

static void set_planes(const drawing *d, strip *s) {
    sl_gbuffer *g = &s->gbuffer;
    float **const surface[SURFACE_PLANES - 1] = {
        &g->position_x,  &g->position_y,  &g->position_z,  &g->normal_x,  &g->normal_y,  &g->normal_z,
        &g->geometric_x, &g->geometric_y, &g->geometric_z, &g->diffuse_r, &g->diffuse_g, &g->diffuse_b};
    for (size_t k = 0; k < SURFACE_PLANES - 1; k++) *surface[k] = s->surface + k * d->room;
    g->material = (uint32_t *)(void *)(s->surface + (SURFACE_PLANES - 1) * d->room);
    s->target = (sl_tile_target){.width = d->outline->width};
    for (size_t k = 0; k < 3; k++) {
        s->target.direct[k] = s->light + k * d->room;
        s->target.indirect[k] = s->light + (3 + k) * d->room;
        s->emission[k] = s->light + (6 + k) * d->room;
    }
}

static bool allocate_workers(drawing *d) {
    d->worker = sl_allocate(d->workers, sizeof *d->worker);
    bool ok = d->worker != NULL;
    for (unsigned w = 0; ok && w < d->workers; w++) {
        strip *s = &d->worker[w];
        s->surface = sl_allocate(SURFACE_PLANES * d->room, sizeof *s->surface);
        s->light = sl_allocate(LIGHT_PLANES * d->room, sizeof *s->light);
        ok = s->surface && s->light;
        if (ok) set_planes(d, s);
    }
    return ok;
}

static void release(drawing *d) {
    for (unsigned w = 0; d->worker && w < d->workers; w++) {
        sl_free(d->worker[w].surface);
        sl_free(d->worker[w].light);
    }
    sl_free(d->worker);
    sl_free(d->counters);
    sl_photon_sums_destroy(d->sums);
    sl_receiver_kinds_release(&d->kinds);
    sl_receiver_kinds_release(&d->tricked);
    sl_resolver_destroy(d->resolver);
}

/* ---- a strip ---- */

/* Returns the strip's rows as receivers of their own. */
static sl_receivers rows_of(const drawing *d, strip *s, size_t index) {
    const sl_receivers *all = d->outline;
    sl_receivers r = *all;
    int left = all->height - (int)index * SL_TILE_HEIGHT;
    size_t first = index * SL_TILE_HEIGHT * (size_t)all->width;
    r.first_row = (int)index * SL_TILE_HEIGHT;
    r.height = left < SL_TILE_HEIGHT ? left : SL_TILE_HEIGHT;
    r.gbuffer = &s->gbuffer;
    if (all->path) r.path = all->path + first;
    for (int k = 0; k < 3 && all->throughput[k]; k++) r.throughput[k] = all->throughput[k] + first;
    s->gbuffer.width = r.width;
    s->gbuffer.height = r.height;
    s->gbuffer.id = all->gbuffer->id + first;
    return r;
}

typedef struct {
    const drawing *drawing;
    const sl_tile_target *target;
} tile_program;

static void light_directly(void *context, const sl_receiver_tile *tile, bool glossy, sl_counters *counters) {
    const tile_program *p = context;
    sl_direct_light_tile(&p->drawing->direct, tile, glossy, p->target, counters);
}

static void light_indirectly(void *context, const sl_receiver_tile *tile, bool glossy,
                             sl_counters *counters) {
    const tile_program *p = context;
    sl_indirect_light_tile(p->drawing->sums, tile, glossy, p->target, counters);
}

/* Each pass counts the fragments that it shades. */
static void light_both(void *context, const sl_receiver_tile *tile, bool glossy, sl_counters *counters) {
    light_directly(context, tile, glossy, counters);
    light_indirectly(context, tile, glossy, counters);
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, tile->count);
}

/* Passes 6 and 7: of the same tiles, but where the trick makes other receivers of mirrors. */
static void light_strip(const drawing *d, const strip *s, const sl_receivers *rows, sl_counters *counters) {
    tile_program program = {d, &s->target};
    const bool direct = d->pass->light->lights->count > 0, indirect = d->sums != NULL;
    if (direct && indirect && !d->trick) {
        sl_receiver_tiles_strip(rows, &d->kinds, 0, light_both, &program, counters);
        return;
    }
    if (direct) sl_receiver_tiles_strip(rows, &d->kinds, 0, light_directly, &program, counters);
    if (indirect)
        sl_receiver_tiles_strip(rows, d->trick ? &d->tricked : &d->kinds, 0, light_indirectly, &program,
                                counters);
}

/* ---- pass 8: the accumulation targets as a picture ---- */

static const char *const layer_names[SL_RADIANCE_CHANNELS] = {
    "R",        "G",        "B",        "emission.R", "emission.G", "emission.B",
    "direct.R", "direct.G", "direct.B", "indirect.R", "indirect.G", "indirect.B"};

/* Composes a row. Rows count from the bottom, as on the hardware; images have row 0 at the top. */
static void compose_row(const drawing *d, const strip *s, const sl_receivers *r, size_t row) {
    const sl_image *image = d->image;
    const size_t width = (size_t)image->width, height = (size_t)image->height, pixels = width * height;
    const size_t from = row * width, to = (height - 1 - (size_t)r->first_row - row) * width;
    const bool all = d->pass->layers;
    for (size_t k = 0; k < 3; k++) {
        float *out = image->planes + k * pixels + to;
        const sl_compose_row channel = {width,
                                        r->throughput[k] ? r->throughput[k] + from : NULL,
                                        s->emission[k] + from,
                                        s->target.direct[k] + from,
                                        s->target.indirect[k] + from,
                                        {out, all ? out + SL_RADIANCE_EMISSION * pixels : NULL,
                                         all ? out + SL_RADIANCE_DIRECT * pixels : NULL,
                                         all ? out + SL_RADIANCE_INDIRECT * pixels : NULL}};
        d->compose(&channel);
    }
}

static void draw_strip(void *context, size_t index, unsigned worker) {
    const drawing *d = context;
    strip *s = &d->worker[worker];
    sl_counters *counters = &d->counters[index];
    const sl_receivers rows = rows_of(d, s, index);
    const size_t width = (size_t)rows.width, pixels = width * (size_t)rows.height;
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED,
             sl_resolver_run(d->resolver, worker, (size_t)rows.first_row * width, pixels, &s->gbuffer));
    memset(s->light, 0, (s->shines ? LIGHT_PLANES : LIGHT_PLANES - 3) * d->room * sizeof *s->light);
    s->shines = d->pass->curved != NULL; /* which may show what shines */
    for (size_t y = 0; y < (size_t)rows.height; y++)
        s->shines |= sl_emission_add_row(&d->emission, &rows, y, s->emission);
    if (!d->emission.none) sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, pixels);
    light_strip(d, s, &rows, counters);
    sl_curved_mirrors_reflect(d->pass->curved, &rows, s->emission, s->target.direct, s->target.indirect,
                              counters);
    for (size_t row = 0; row < (size_t)rows.height; row++) compose_row(d, s, &rows, row);
}

/* ---- the picture ---- */

static sl_status prepare(drawing *d, size_t strips, sl_error *error) {
    const sl_light_pass *light = d->pass->light;
    const sl_receivers *all = d->outline;
    sl_status status = sl_resolver_create(d->pass->raster, all->path_count, all->view, all->path,
                                          all->gbuffer->id, d->workers, &d->resolver, error);
    if (status == SL_OK) status = sl_receiver_kinds_find(light->scene, sl_grey(0.0f), &d->kinds, error);
    d->trick = sl_rgb_max(light->trick_albedo) > 0.0f;
    if (status == SL_OK && d->trick)
        status = sl_receiver_kinds_find(light->scene, light->trick_albedo, &d->tricked, error);
    if (status == SL_OK && light->photons && light->photons->count)
        status = sl_photon_sums_create(light, &d->sums, error);
    if (status != SL_OK) return status;
    d->counters = sl_allocate(strips, sizeof *d->counters);
    if (!d->counters || !allocate_workers(d)) return sl_fail_memory(error, "the picture");
    return sl_image_create_unset(all->width, all->height,
                                 d->pass->layers ? SL_RADIANCE_CHANNELS : SL_RADIANCE_EMISSION, layer_names,
                                 &d->image, error);
}

sl_status sl_radiance_draw_strips(const sl_strip_pass *pass, sl_image **image, sl_counters *counters,
                                  sl_error *error) {
    const sl_receivers *all = pass->outline;
    const size_t strips = (size_t)((all->height + SL_TILE_HEIGHT - 1) / SL_TILE_HEIGHT);
    drawing d = {.pass = pass,
                 .outline = all,
                 .emission = sl_emission_of(pass->light->scene, all),
                 .direct = sl_direct_light_of(pass->light),
                 .compose = sl_compose_kernel_for(sl_isa_best()),
                 .workers = sl_thread_count(pass->light->threads),
                 .room = SL_TILE_HEIGHT * (size_t)all->width + APART};
    sl_status status = prepare(&d, strips, error);
    if (status == SL_OK) {
        sl_parallel_for(d.workers, strips, draw_strip, &d);
        for (size_t i = 0; i < strips; i++) sl_counters_add(counters, &d.counters[i]);
        *image = d.image;
    }
    release(&d);
    return status;
}

/* Light seen directly, L S* E: it takes no light pass, only what each pixel shows. */

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
    return sl_environment_radiance(environment, sl_view_direction(&r->view[path], (double)x + 0.5,
                                                                  (double)(r->first_row + (int)y) + 0.5));
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

/* Tells if some pixel shows a planar mirror beyond the nesting limit. */
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
    return (sl_emission){scene, wanted ? sl_environment_mean(&scene->environment) : sl_grey(0.0f),
                         !sky && scene->emitter_count == 0};
}
