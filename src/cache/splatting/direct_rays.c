/* Direct light of pixels by shadow rays.
 *
 * Lights without extent get one ray each. For the diffuse lobe, light from emissive triangles is the exact polygon irradiance
 * (Lambert's formula) times the visible share, sum(V f) / sum(f) over the light samples: where nothing is in the way there is
 * no noise at all (the ratio estimator of Heitz, Hill and McGuire 2018). Pixels that see a part of the lights only, and
 * those near them, the penumbrae, get four times as many samples more: nearly all of the noise is there. With many emitters, for the environment and for the
 * glossy lobe, it is the plain estimator. */
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/random.h"
#include "cache/gather/hemisphere_tables.h"
#include "cache/splatting/direct_internal.h"

enum {
    PENUMBRA_FACTOR = 4,
    /* Penumbrae are found by few samples, which may all agree by chance; refining only where they do not would darken the faint
     * edges of shadows and brighten the others. So pixels this near to a known penumbra are refined as well. */
    PENUMBRA_MARGIN = 2
};

/* ---- one row: rays are queued, traced sixteen at a time, and their light added to their pixels in the order of the queue ---- */

typedef struct {
    sl_rgb plain;          /* diffuse irradiance of visible samples: delta lights, environment, inexact emitters */
    sl_rgb glossy;         /* radiance by the glossy lobe */
    sl_rgb seen, all;      /* emitter samples: visible, and whether or not */
    uint32_t seen_count, pilot_count; /* of the first emitter samples */
} pixel_sums;

typedef struct {
    const sl_direct *direct;
    sl_counters *counters;
    pixel_sums *sums;
    bool refining;
    sl_ray16 rays;
    unsigned count;
    int pixel[SL_PACKET];
    sl_rgb irradiance[SL_PACKET], glossy[SL_PACKET];
    bool from_emitter[SL_PACKET];
} shadow_queue;

static void add(sl_rgb *sum, sl_rgb term) { *sum = sl_rgb_add(*sum, term); }

static void flush(shadow_queue *q) {
    if (q->count == 0) return;
    uint32_t occluded = sl_trace_occluded(q->direct->tracer, &q->rays, q->count, true, q->counters);
    for (unsigned i = 0; i < q->count; i++) {
        pixel_sums *sums = &q->sums[q->pixel[i]];
        bool ratio = q->from_emitter[i] && q->direct->exact;
        bool pilot = ratio && !q->refining;
        if (ratio) add(&sums->all, q->irradiance[i]);
        if (pilot) sums->pilot_count++; /* while refining, neighbouring rows read the counts */
        if (occluded >> i & 1u) continue;
        if (pilot) sums->seen_count++;
        add(ratio ? &sums->seen : &sums->plain, q->irradiance[i]);
        add(&sums->glossy, q->glossy[i]);
    }
    q->count = 0;
}

/* An emitter sample that the closed form counts and nobody sees. */
static void add_hidden(shadow_queue *q, int pixel, sl_rgb irradiance) {
    add(&q->sums[pixel].all, irradiance);
    if (!q->refining) q->sums[pixel].pilot_count++;
}

/* light: irradiance on a plane that faces the light. */
static void enqueue(shadow_queue *q, int pixel, const sl_receiver *at, sl_vec3 to_light, float distance, sl_rgb light,
                    bool from_emitter) {
    float cosine = sl_dot(at->normal, to_light);
    if (!(cosine > 0.0f)) return;
    if (!(sl_dot(at->geometric_normal, to_light) > 0.0f)) { /* the surface itself is in the way, no ray needed */
        if (from_emitter && q->direct->exact) add_hidden(q, pixel, sl_rgb_scale(light, cosine));
        return;
    }
    unsigned i = q->count++;
    /* The ray starts off the surface and aims at the light itself from there, so that a near light's own surface cannot come
     * between; its end stops short of the light. */
    sl_vec3 origin = sl_mad(at->position, at->offset, at->geometric_normal);
    bool far_away = isinf(distance);
    sl_vec3 aim = far_away ? to_light : sl_sub(sl_mad(at->position, distance, to_light), origin);
    q->rays.origin_x[i] = origin.x, q->rays.origin_y[i] = origin.y, q->rays.origin_z[i] = origin.z;
    q->rays.direction_x[i] = aim.x, q->rays.direction_y[i] = aim.y, q->rays.direction_z[i] = aim.z;
    q->rays.near[i] = 0.0f;
    q->rays.far[i] = far_away ? INFINITY : 0.9999f;
    q->rays.skip[i] = at->triangle;
    q->pixel[i] = pixel;
    q->irradiance[i] = sl_rgb_scale(light, cosine);
    q->glossy[i] = sl_rgb_mul(q->irradiance[i], sl_phong(at, to_light));
    q->from_emitter[i] = from_emitter;
    if (q->count == SL_PACKET) flush(q);
}

static void queue_delta_lights(shadow_queue *q, int pixel, const sl_receiver *at) {
    const sl_scene *scene = q->direct->scene;
    for (size_t i = 0; i < scene->light_count; i++) {
        sl_vec3 to_light;
        float distance;
        sl_rgb irradiance;
        if (sl_light_illuminate(&scene->lights[i], at->position, &to_light, &distance, &irradiance))
            enqueue(q, pixel, at, to_light, distance, irradiance, false);
    }
}

/* A Kronecker sequence (golden ratios of three dimensions), shifted by random numbers of the pixel (Cranley-Patterson rotation). */
static void sample_point(uint64_t key, uint32_t index, float u[3]) {
    static const double golden[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    for (uint64_t d = 0; d < 3; d++) {
        double p = (double)sl_random_unit(key, d) + (double)index * golden[d];
        float fraction = (float)(p - floor(p));
        u[d] = fraction < 1.0f ? fraction : 0x1.fffffep-1f; /* rounded up to the open end */
    }
}

/* One emitter and a point of it; radiance is over the whole probability. */
static bool sample_emitters(const sl_direct *direct, const sl_emitter_choice *choice, sl_vec3 p, const float u[3],
                            sl_light_sample *light) {
    if (direct->sampler) return sl_light_sampler_sample(direct->sampler, p, u[0], u[1], u[2], light);
    float chance;
    if (choice->count == 0) return false;
    uint32_t emitter = (uint32_t)sl_emitters_choose(choice, u[0], &chance);
    if (!(chance > 0.0f) || !sl_emitter_sample(direct->scene, emitter, p, u[1], u[2], light)) return false;
    light->radiance = sl_rgb_scale(light->radiance, 1.0f / chance);
    return true;
}

/* Samples [first, end) of a pixel towards emitters, each worth 1/weight. */
static void queue_emitters(shadow_queue *q, int pixel, const sl_receiver *at, uint64_t key, uint32_t first, uint32_t end,
                           float weight) {
    if (q->direct->emitters.count == 0) return;
    sl_emitter_choice choice;
    sl_emitters_weigh(&q->direct->emitters, at->position, at->normal, &choice);
    for (uint32_t s = first; s < end; s++) {
        float u[3];
        sl_light_sample light;
        sample_point(key, s, u);
        if (!sample_emitters(q->direct, &choice, at->position, u, &light) || light.triangle == at->triangle) continue;
        enqueue(q, pixel, at, light.to_light, light.distance, sl_rgb_scale(light.radiance, 1.0f / weight), true);
    }
}

static void queue_environment(shadow_queue *q, int pixel, const sl_receiver *at, uint64_t key) {
    uint32_t samples = q->direct->settings.light_samples;
    for (uint32_t s = 0; s < samples; s++) {
        float u[3], pdf;
        sl_rgb radiance;
        sample_point(key, s, u);
        sl_vec3 direction = sl_environment_sample(q->direct->settings.sun, u[1], u[2], &radiance, &pdf);
        if (!(pdf > 0.0f)) continue;
        enqueue(q, pixel, at, direction, INFINITY, sl_rgb_scale(radiance, 1.0f / (pdf * (float)samples)), false);
    }
}

/* ---- combining ---- */

/* Unoccluded irradiance of all emitters at a point, in closed form. */
static sl_rgb exact_irradiance(const sl_scene *scene, const sl_receiver *at) {
    sl_rgb sum = sl_grey(0.0f);
    sl_vec3d p = sl_to_double(at->position), n = sl_to_double(at->normal);
    for (size_t i = 0; i < scene->emitter_count; i++) {
        const sl_emitter *e = &scene->emitters[i];
        if (e->triangle == at->triangle) continue;
        sl_vec3d corners[3];
        for (int c = 0; c < 3; c++) corners[c] = sl_to_double(sl_scene_position(scene, scene->vertex[c][e->triangle]));
        double factor = sl_polygon_irradiance(p, n, corners, 3, NULL);
        if (e->two_sided && !(factor > 0.0)) {
            sl_vec3d swapped[3] = {corners[0], corners[2], corners[1]};
            factor = sl_polygon_irradiance(p, n, swapped, 3, NULL);
        }
        if (factor > 0.0) add(&sum, sl_rgb_scale(e->radiance, (float)factor));
    }
    return sum;
}

static float visible(float exact, float seen, float all) { return all > 0.0f ? exact * (seen / all) : 0.0f; }

static sl_rgb diffuse_irradiance(const sl_direct *direct, const sl_receiver *at, const pixel_sums *sums) {
    if (!direct->exact || !(sl_rgb_max(sums->seen) > 0.0f)) return sums->plain;
    sl_rgb exact = exact_irradiance(direct->scene, at);
    return sl_rgb_add(sums->plain, (sl_rgb){visible(exact.r, sums->seen.r, sums->all.r),
                                            visible(exact.g, sums->seen.g, sums->all.g),
                                            visible(exact.b, sums->seen.b, sums->all.b)});
}

/* ---- rows: first all pixels of a strip and of PENUMBRA_MARGIN rows around it, then the penumbrae among them ---- */

typedef struct {
    const sl_direct *direct;
    const sl_gbuffer *gbuffer;
    int first, row0, row1; /* sums begin at row `first`; light is wanted for rows [row0, row1) */
    float *r, *g, *b;
    pixel_sums *sums;
    sl_counters *counters; /* one a row */
} rows_context;

static uint64_t pixel_key(const sl_direct *direct, size_t i) { return sl_random_key(direct->settings.seed ^ 0xd1ecu, i); }

static shadow_queue row_queue(const rows_context *c, size_t index) {
    return (shadow_queue){.direct = c->direct, .counters = &c->counters[index],
                          .sums = c->sums + index * (size_t)c->gbuffer->width};
}

static void sample_row(void *context, size_t index, unsigned worker) {
    (void)worker;
    const rows_context *c = context;
    const sl_gbuffer *g = c->gbuffer;
    const sl_direct *direct = c->direct;
    uint32_t samples = direct->settings.light_samples;
    size_t row = (size_t)(c->first + (int)index) * (size_t)g->width;
    shadow_queue queue = row_queue(c, index);
    for (int x = 0; x < g->width; x++) {
        size_t i = row + (size_t)x;
        if (!sl_pixel_reflects(g, direct->scene, i)) continue;
        sl_receiver at = sl_receiver_at(direct, g, i);
        queue_delta_lights(&queue, x, &at);
        queue_emitters(&queue, x, &at, pixel_key(direct, i), 0, samples, (float)samples);
        if (direct->settings.sun) queue_environment(&queue, x, &at, sl_hash64(pixel_key(direct, i)));
    }
    flush(&queue);
}

static bool is_partly_lit(const pixel_sums *s) { return s->seen_count > 0 && s->seen_count < s->pilot_count; }

/* seen_count and pilot_count stay those of the first samples while others refine, so that rows can be refined in any order. */
static bool near_penumbra(const rows_context *c, int x, int y) {
    int width = c->gbuffer->width, height = c->gbuffer->height;
    for (int v = y - PENUMBRA_MARGIN; v <= y + PENUMBRA_MARGIN; v++) {
        for (int u = x - PENUMBRA_MARGIN; u <= x + PENUMBRA_MARGIN; u++) {
            if (u < 0 || v < 0 || u >= width || v >= height) continue;
            if (is_partly_lit(&c->sums[(size_t)(v - c->first) * (size_t)width + (size_t)u])) return true;
        }
    }
    return false;
}

/* The diffuse lobe alone: of the glossy one nothing is known of where its noise is. Both sums of the ratio grow, so weights do not
 * matter. */
static void refine_penumbrae(const rows_context *c, shadow_queue *q, int y) {
    const sl_direct *direct = c->direct;
    const sl_gbuffer *g = c->gbuffer;
    uint32_t samples = direct->settings.light_samples;
    if (!direct->exact) return;
    q->refining = true;
    for (int x = 0; x < g->width; x++) {
        size_t i = (size_t)y * (size_t)g->width + (size_t)x;
        if (q->sums[x].pilot_count == 0 || !near_penumbra(c, x, y)) continue;
        if (sl_material_is_glossy(&direct->scene->materials[g->material[i]])) continue;
        sl_receiver at = sl_receiver_at(direct, g, i);
        queue_emitters(q, x, &at, pixel_key(direct, i), samples, (1 + PENUMBRA_FACTOR) * samples, (float)samples);
    }
    flush(q);
}

static void finish_row(void *context, size_t index, unsigned worker) {
    (void)worker;
    rows_context *c = context;
    const sl_gbuffer *g = c->gbuffer;
    int y = c->first + (int)index;
    if (y < c->row0 || y >= c->row1) return;
    shadow_queue queue = row_queue(c, index);
    refine_penumbrae(c, &queue, y);
    for (int x = 0; x < g->width; x++) {
        size_t i = (size_t)y * (size_t)g->width + (size_t)x;
        if (!sl_pixel_reflects(g, c->direct->scene, i)) continue;
        sl_receiver at = sl_receiver_at(c->direct, g, i);
        sl_rgb e = diffuse_irradiance(c->direct, &at, &queue.sums[x]);
        c->r[i] = g->diffuse_r[i] * (float)(1.0 / SL_PI) * e.r + queue.sums[x].glossy.r;
        c->g[i] = g->diffuse_g[i] * (float)(1.0 / SL_PI) * e.g + queue.sums[x].glossy.g;
        c->b[i] = g->diffuse_b[i] * (float)(1.0 / SL_PI) * e.b + queue.sums[x].glossy.b;
    }
    sl_count(&c->counters[index], SL_COUNT_FRAGMENTS_SHADED, (uint64_t)g->width);
}

sl_status sl_direct_by_rays(const sl_direct *direct, const sl_gbuffer *gbuffer, int row0, int row1, float *r, float *g,
                         float *b, sl_counters *counters, sl_error *error) {
    int first = row0 > PENUMBRA_MARGIN ? row0 - PENUMBRA_MARGIN : 0;
    int end = row1 + PENUMBRA_MARGIN < gbuffer->height ? row1 + PENUMBRA_MARGIN : gbuffer->height;
    size_t rows = (size_t)(end - first);
    pixel_sums *sums = sl_allocate(rows * (size_t)gbuffer->width, sizeof *sums);
    sl_counters *costs = sl_allocate(rows, sizeof *costs);
    sl_status status = sums && costs ? SL_OK : sl_fail_memory(error, "direct light");
    if (status == SL_OK) {
        rows_context context = {direct, gbuffer, first, row0, row1, r, g, b, sums, costs};
        sl_parallel_for(direct->settings.threads, rows, sample_row, &context);
        sl_parallel_for(direct->settings.threads, rows, finish_row, &context);
        for (size_t i = 0; i < rows; i++) sl_counters_add(counters, &costs[i]);
    }
    sl_free(sums);
    sl_free(costs);
    return status;
}
