/* A path leaves a light, is stored where it meets a surface, and is scattered there or absorbed. The 4,096
 * paths of a chunk go in step, bounce by bounce. */
#include "cache/photons/photons.h"

#include <string.h>

#include "base/batch.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/octahedral.h"
#include "base/parallel.h"
#include "base/random.h"
#include "trace/bsdf.h"
#include "trace/emission.h"

enum {
    CHUNKS_AT_ONCE = 16,
    BOUNCES_MAX = 64,
    NUMBERS_A_BOUNCE = 8
};
static const float survival_max = 0.99f, adjoint_max = 32.0f;

/* ---- directions in 32 bits ---- */

/* 65,534 steps instead of 65,535 make the axes exact. */
static const float octahedral_steps = 32767.0f;

static uint32_t octahedral_step(float v) {
    float step = (v + 1.0f) * octahedral_steps + 0.5f;
    return step > 0.0f ? step < 65534.0f ? (uint32_t)step : 65534u : 0u;
}

uint32_t sl_octahedral_encode(sl_vec3 unit) {
    float size = fabsf(unit.x) + fabsf(unit.y) + fabsf(unit.z), u = 0.0f, v = 0.0f;
    if (size > 0.0f && size <= FLT_MAX) sl_octahedral_place(unit, &u, &v);
    return octahedral_step(u) << 16 | octahedral_step(v);
}

sl_vec3 sl_octahedral_decode(uint32_t code) {
    float u = (float)(code >> 16) / octahedral_steps - 1.0f,
          v = (float)(code & 0xffffu) / octahedral_steps - 1.0f;
    return sl_normalize_or(sl_octahedral_point(u, v), sl_v3(0.0f, 0.0f, 1.0f));
}

/* ---- one chunk ------------------------------------------------------------------------------- */

typedef struct light_path {
    sl_vec3 origin, direction;
    sl_rgb flux;
    uint32_t skip;
    sl_rgb sky_share;  /* of the flux: stored at the first hit already; 0: nothing is */
    bool specular_alone;
    uint64_t key;
} light_path;

/* A chunk's paths under way; a worker's. */
typedef struct path_block {
    light_path path[SL_PHOTON_CHUNK];
    uint16_t alive[SL_PHOTON_CHUNK];
    uint32_t places[SL_PHOTON_CHUNK];
} path_block;

typedef struct chunk_result {
    size_t count;
    double cut_flux;
    sl_counters counters;
    bool out_of_memory;
} chunk_result;

/* A chunk's photons, bounce by bounce. */
typedef struct photon_chunk {
    chunk_result result;
    size_t capacity;
    sl_photon *photon;
    uint16_t *path;              /* of each photon */
} photon_chunk;

typedef struct photon_job {
    const sl_scene *scene;
    const sl_tracer *tracer;
    const sl_light_sampler *lights;
    sl_photon_store store;
    float polished;
    const sl_environment *sky;
    uint64_t seed, first_chunk;
    path_block *blocks;          /* a worker each */
    photon_chunk *chunks;        /* CHUNKS_AT_ONCE, as are */
    chunk_result *results;
} photon_job;

static bool make_room(photon_chunk *c) {
    const size_t count = c->result.count;
    if (count < c->capacity) return true;
    const size_t capacity = c->capacity > 0 ? 2 * c->capacity : 2 * SL_PHOTON_CHUNK;
    if (!sl_regrow(&c->photon, count, capacity, sizeof *c->photon) ||
        !sl_regrow(&c->path, count, capacity, sizeof *c->path)) {
        c->result.out_of_memory = true;
        return false;
    }
    c->capacity = capacity;
    return true;
}

static void random_numbers(uint64_t key, unsigned bounce, unsigned count, float *number) {
    for (unsigned i = 0; i < count; i++)
        number[i] = sl_random_unit(key, (uint64_t)bounce * NUMBERS_A_BOUNCE + i);
}

/* Paths of a chunk are spread evenly over the lights' powers, from a start that fills the gaps of other
 * chunks: in 2^m chunks a light gets its share of all 4096 2^m paths, rounded up or down. */
static double chunk_offset(uint64_t seed, uint64_t chunk) {
    uint32_t start = sl_random_bits(sl_random_key(seed, UINT64_MAX), 0);
    return (double)(uint32_t)(sl_van_der_corput((uint32_t)chunk) + start) * 0x1p-32;
}

static float share(float part, float whole) {
    return part > 0.0f && whole > 0.0f ? fminf(part / whole, 1.0f) : 0.0f;
}

/* SL_STORE_INDIRECT leaves direct light to others. What comes from a smooth sky is direct light that samples
 * are bad at, and photons are good at. */
static sl_rgb sky_share_of(const photon_job *job, const sl_emission *photon) {
    if (!job->sky || !photon->environment || job->store != SL_STORE_INDIRECT) return sl_grey(0.0f);
    sl_vec3 to_sky = sl_neg(photon->direction);
    sl_rgb part = sl_environment_radiance(job->sky, to_sky),
           whole = sl_environment_radiance(&job->scene->environment, to_sky);
    return (sl_rgb){share(part.r, whole.r), share(part.g, whole.g), share(part.b, whole.b)};
}

static unsigned emit_paths(const photon_job *job, uint64_t chunk, path_block *block) {
    double offset = chunk_offset(job->seed, chunk);
    unsigned alive = 0;
    for (unsigned i = 0; i < SL_PHOTON_CHUNK; i++) {
        light_path *p = &block->path[i];
        sl_emission photon;
        float number[SL_EMISSION_NUMBERS];
        p->key = sl_random_key(job->seed, chunk * SL_PHOTON_CHUNK + i);
        random_numbers(p->key, 0, SL_EMISSION_NUMBERS, number);
        uint32_t light = sl_light_sampler_entry(job->lights, ((double)i + offset) / SL_PHOTON_CHUNK);
        double chance = sl_light_sampler_chance(job->lights, light);
        if (!(chance > 0.0) || !sl_light_emit(job->scene, light, number, 1.0 / chance, &photon)) continue;
        if (!sl_rgb_is_finite(photon.flux) || !sl_is_finite(photon.origin)) continue;
        p->origin = photon.origin;
        p->direction = photon.direction;
        p->flux = photon.flux;
        p->sky_share = sky_share_of(job, &photon);
        p->skip = photon.triangle;
        p->specular_alone = true;
        block->alive[alive++] = (uint16_t)i;
    }
    return alive;
}

/* ---- at a surface ---------------------------------------------------------------------------- */

static void store_photon(photon_chunk *c, unsigned path, const light_path *p, sl_rgb flux, unsigned bounces,
                         const sl_surface *surface) {
    if (!make_room(c)) return;
    sl_photon *photon = &c->photon[c->result.count];
    *photon = (sl_photon){.position = {surface->position.x, surface->position.y, surface->position.z},
                          .flux = {flux.r, flux.g, flux.b},
                          .direction = sl_octahedral_encode(sl_neg(p->direction)),
                          .normal = sl_octahedral_encode(surface->geometric_normal),
                          .flags = bounces | (bounces > 0 && p->specular_alone ? SL_PHOTON_CAUSTIC : 0u)};
    c->path[c->result.count++] = (uint16_t)path;
}

static bool is_stored(sl_photon_store store, unsigned bounces, bool specular_alone) {
    switch (store) {
    case SL_STORE_INDIRECT: return bounces > 0;
    case SL_STORE_ALL: return true;
    case SL_STORE_CAUSTIC: return bounces > 0 && specular_alone;
    }
    return false;
}

/* Light that goes from i to o is reflected by the shading normal's cosine with i, but arrives and leaves by
 * the geometric one's (Veach 1997, section 5.3): the ratio of cosines, bounded, since it grows at grazing
 * angles. */
static float adjoint(float up, float down) {
    if (!(up > 0.0f) || !(down > 0.0f)) return 0.0f;
    return up < adjoint_max * down ? up / down : adjoint_max;
}

/* By the cosine about the geometric normal, as light leaves a Lambertian surface, so that the outgoing ratio
 * is sampled away. */
static bool scatter_diffusely(const sl_surface *s, sl_vec3 in, const float number[4], sl_vec3 *out,
                              sl_rgb *weight) {
    *out = sl_direction_around(s->geometric_normal, sqrtf(1.0f - number[1]), number[2]);
    if (!(sl_dot(*out, s->normal) > 0.0f) || !(sl_dot(*out, s->geometric_normal) > 0.0f)) return false;
    *weight = sl_rgb_scale(s->diffuse, adjoint(sl_dot(s->normal, in), sl_dot(s->geometric_normal, in)));
    return true;
}

static bool scatter_by_lobes(const sl_surface *s, const sl_bsdf *bsdf, const float number[4], sl_vec3 *out,
                             sl_rgb *weight) {
    if (!sl_bsdf_sample(bsdf, number[0], number[1], number[2], out)) return false;
    float pdf = sl_bsdf_pdf(bsdf, *out);
    if (!(pdf > 0.0f)) return false;
    *weight = sl_rgb_scale(sl_bsdf_reflect(bsdf, *out, SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY), 1.0f / pdf);
    return sl_dot(*out, s->geometric_normal) > 0.0f;
}

/* The next direction, and by what the flux would be multiplied if no path were ended. False: absorbed. */
static bool scatter(const sl_surface *s, sl_vec3 in, const float number[4], sl_vec3 *out, sl_rgb *weight) {
    if (sl_material_is_mirror(s->material)) {
        *out = sl_normalize_or(sl_reflect(in, s->normal), s->normal);
        *weight = s->material->mirror;
        if (!(sl_dot(*out, s->geometric_normal) > 0.0f)) return false;
    } else {
        sl_bsdf bsdf = sl_bsdf_make(s, in, SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY);
        if (bsdf.black) return false;
        if (!(bsdf.diffuse_share < 1.0f)) return scatter_diffusely(s, in, number, out, weight);
        if (!scatter_by_lobes(s, &bsdf, number, out, weight)) return false;
    }
    sl_vec3 n = s->normal, g = s->geometric_normal;
    bool flat = n.x == g.x && n.y == g.y && n.z == g.z;
    if (!flat)
        *weight =
            sl_rgb_scale(*weight, adjoint(sl_dot(n, in) * sl_dot(g, *out), sl_dot(g, in) * sl_dot(n, *out)));
    return true;
}

/* Stores and scatters. False: the path ends. */
static bool meet_surface(const photon_job *job, light_path *p, unsigned path, unsigned bounces,
                         uint32_t triangle, float w1, float w2, photon_chunk *c) {
    sl_vec3 to_light = sl_neg(p->direction);
    sl_surface surface;
    sl_scene_surface(job->scene, triangle, w1, w2, to_light, &surface);
    if (!sl_is_finite(surface.position)) return false;
    if (!sl_is_specular(surface.material, job->polished)) {
        bool wanted = sl_takes_photons(surface.material);
        if (wanted && is_stored(job->store, bounces, p->specular_alone))
            store_photon(c, path, p, p->flux, bounces, &surface);
        else if (wanted && sl_rgb_max(p->sky_share) > 0.0f)
            store_photon(c, path, p, sl_rgb_mul(p->flux, p->sky_share), bounces, &surface);
        if (job->store == SL_STORE_CAUSTIC) return false;
        p->specular_alone = false;
    }
    float number[4];
    sl_vec3 direction;
    sl_rgb weight;
    random_numbers(p->key, bounces + 1, 4, number);
    if (!scatter(&surface, to_light, number, &direction, &weight)) return false;
    if (!sl_rgb_is_finite(weight) || sl_rgb_is_black(weight)) return false;
    if (bounces == BOUNCES_MAX) {
        c->result.cut_flux += (double)sl_luminance(sl_rgb_mul(p->flux, weight));
        return false;
    }
    /* Russian roulette: flux stays as it is where colours are grey. */
    float survival = fminf(sl_rgb_max(weight), survival_max);
    if (!(number[3] < survival)) return false;
    p->flux = sl_rgb_scale(sl_rgb_mul(p->flux, weight), 1.0f / survival);
    p->origin = sl_surface_lift(job->scene, triangle, &surface);
    p->direction = direction;
    p->skip = triangle;
    return sl_rgb_is_finite(p->flux) && sl_is_finite(p->origin);
}

/* ---- bounce by bounce ------------------------------------------------------------------------ */

static void put_ray(sl_ray16 *rays, unsigned i, const light_path *p) {
    sl_ray16_set(rays, i, p->origin, p->direction, 0.0f, INFINITY, p->skip);
}

static unsigned bounce_paths(const photon_job *job, path_block *block, unsigned alive, unsigned bounces,
                             photon_chunk *c) {
    unsigned left = 0;
    for (unsigned first = 0; first < alive; first += SL_PACKET) {
        unsigned n = alive - first < SL_PACKET ? alive - first : SL_PACKET;
        sl_ray16 rays;
        sl_hit16 hits;
        for (unsigned i = 0; i < n; i++) put_ray(&rays, i, &block->path[block->alive[first + i]]);
        sl_trace(job->tracer, &rays, n, false, &hits, &c->result.counters);
        for (unsigned i = 0; i < n; i++) {
            unsigned path = block->alive[first + i];
            if (hits.triangle[i] == SL_NO_INDEX) continue;
            if (!meet_surface(job, &block->path[path], path, bounces, hits.triangle[i], hits.w1[i],
                              hits.w2[i], c))
                continue;
            block->alive[left++] = (uint16_t)path; /* left <= first + i */
        }
    }
    return left;
}

static void trace_chunk(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    (void)counters; /* its own count if it is committed */
    const photon_job *job = context;
    path_block *block = &job->blocks[worker];
    photon_chunk *c = &job->chunks[index];
    c->result = (chunk_result){0};
    unsigned alive = emit_paths(job, job->first_chunk + index, block);
    for (unsigned bounces = 0; alive > 0 && !c->result.out_of_memory; bounces++)
        alive = bounce_paths(job, block, alive, bounces, c);
    *(chunk_result *)result = c->result;
}

/* Photons in order of path, then bounce: a stable counting sort of what came bounce by bounce. */
static void order_photons(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    (void)counters;
    const photon_job *job = context;
    const photon_chunk *c = &job->chunks[index];
    uint32_t *places = job->blocks[worker].places, sum = 0;
    memset(places, 0, SL_PHOTON_CHUNK * sizeof *places);
    for (size_t i = 0; i < c->result.count; i++) places[c->path[i]]++;
    for (unsigned p = 0; p < SL_PHOTON_CHUNK; p++) {
        uint32_t count = places[p];
        places[p] = sum;
        sum += count;
    }
    for (size_t i = 0; i < c->result.count; i++) ((sl_photon *)result)[places[c->path[i]]++] = c->photon[i];
}

/* ---- the list -------------------------------------------------------------------------------- */

void sl_photon_list_destroy(sl_photon_list *list) {
    if (!list) return;
    sl_light_sampler_destroy(list->lights);
    SL_FREE_ALL(list->photon, list);
}

static bool resize(sl_photon_list *list, size_t capacity) {
    if (!sl_regrow(&list->photon, list->count, capacity, sizeof *list->photon)) return false;
    list->capacity = capacity;
    return true;
}

static sl_status commit(sl_photon_list *list, const chunk_result *r, const sl_photon *ordered,
                        sl_counters *counters, sl_error *error) {
    size_t count = list->count + r->count;
    if (count >= UINT32_MAX)
        return sl_fail(error, SL_ERROR_RESOURCES, "at most %u photons can be stored", UINT32_MAX - 1);
    if (count > list->capacity && !resize(list, count + count / 2)) return sl_fail_memory(error, "photons");
    if (r->count > 0) memcpy(list->photon + list->count, ordered, r->count * sizeof *ordered);
    list->count = count;
    list->emitted += SL_PHOTON_CHUNK;
    list->cut_flux += r->cut_flux;
    sl_counters_add(counters, &r->counters);
    sl_count(counters, SL_COUNT_PHOTONS_EMITTED, SL_PHOTON_CHUNK);
    sl_count(counters, SL_COUNT_PHOTONS_STORED, r->count);
    return SL_OK;
}

/* Divided by the emitted photons, never by the stored ones. */
static void divide_fluxes(sl_photon_list *list) {
    double per_path = list->emitted > 0 ? 1.0 / (double)list->emitted : 0.0;
    for (size_t i = 0; i < list->count; i++) {
        for (int c = 0; c < 3; c++)
            list->photon[i].flux[c] = (float)((double)list->photon[i].flux[c] * per_path);
    }
    list->cut_flux *= per_path;
    if (list->count < list->capacity) resize(list, list->count); /* only to give memory back */
}

static bool is_complete(const sl_photon_list *list, const sl_photon_options *options) {
    uint64_t fallback = options->stored > (1u << 20) / 8 ? 8 * options->stored : 1u << 20;
    return list->count >= options->stored ||
           list->emitted >= (options->emitted_at_most > 0 ? options->emitted_at_most : fallback);
}

/* As many chunks as are surely needed, by how many photons they left so far: what is traced beyond the end is
 * thrown away. The number of threads has no say: ranks may have different ones. */
static size_t chunks_at_once(const sl_photon_list *list, const sl_photon_options *options, size_t allowed) {
    size_t chunks = CHUNKS_AT_ONCE;
    if (list->count > 0) {
        double a_chunk = (double)list->count / (double)(list->emitted / SL_PHOTON_CHUNK);
        double needed = ceil((double)(options->stored - list->count) / a_chunk);
        if (needed < (double)chunks) chunks = needed > 1.0 ? (size_t)needed : 1;
    }
    return chunks < allowed ? chunks : allowed;
}

static bool can_store(const sl_scene *scene, const sl_photon_options *options) {
    sl_photon_store store = options->store;
    bool reflects = false, specular = false, accepts = false;
    for (size_t i = 0; i < scene->material_count; i++) {
        const sl_material *m = &scene->materials[i];
        specular |= sl_is_specular(m, options->polished);
        accepts |= sl_takes_photons(m);
        reflects |= sl_material_is_mirror(m) || sl_material_is_diffuse(m) || sl_material_is_glossy(m);
    }
    return scene->triangle_count > 0 && accepts &&
           (store == SL_STORE_ALL || (store == SL_STORE_CAUSTIC ? specular : reflects));
}

/* Returns the photons of all chunks, those of chunk i from i * *most on; NULL: no memory. */
static sl_photon *ordered_photons(photon_job *job, size_t chunks, unsigned threads, size_t *most,
                                  sl_counters *counters) {
    *most = 0;
    for (size_t i = 0; i < chunks; i++) {
        if (job->results[i].out_of_memory) return NULL;
        *most = job->results[i].count > *most ? job->results[i].count : *most;
    }
    sl_photon *ordered = sl_allocate_unset(chunks * *most, sizeof *ordered);
    const sl_batch batch = {.count = chunks, .work = order_photons, .context = job, .results = ordered,
                            .result_bytes = *most * sizeof *ordered, .shared = true};
    if (ordered) sl_batch_run(&batch, threads, counters);
    return ordered;
}

/* Some chunks, committed in order up to the one with which the list is complete. */
static sl_status trace_some(photon_job *job, const sl_photon_options *options, unsigned threads,
                            size_t *chunks, sl_photon_list *list, sl_counters *counters, sl_error *error) {
    size_t now = chunks_at_once(list, options, *chunks < CHUNKS_AT_ONCE ? *chunks : CHUNKS_AT_ONCE),
           most;
    job->first_chunk = (options->first + list->emitted) / SL_PHOTON_CHUNK;
    const sl_batch batch = {.count = now, .work = trace_chunk, .context = job, .results = job->results,
                            .result_bytes = sizeof *job->results, .shared = true};
    sl_batch_run(&batch, threads, counters);
    sl_photon *ordered = ordered_photons(job, now, threads, &most, counters);
    sl_status status = ordered ? SL_OK : sl_fail_memory(error, "photons");
    for (size_t i = 0; i < now && status == SL_OK && !is_complete(list, options); i++)
        status = commit(list, &job->results[i], ordered + i * most, counters, error);
    sl_free(ordered);
    *chunks -= now;
    return status;
}

static sl_status trace_chunks(photon_job *job, const sl_photon_options *options, size_t chunks,
                              sl_photon_list *list, bool *done, sl_counters *counters, sl_error *error) {
    unsigned threads = sl_thread_count(options->threads);
    job->blocks = sl_allocate(threads, sizeof *job->blocks);
    job->chunks = sl_allocate(CHUNKS_AT_ONCE, sizeof *job->chunks);
    job->results = sl_allocate(CHUNKS_AT_ONCE, sizeof *job->results);
    const bool room = job->blocks && job->chunks && job->results;
    sl_status status = room ? SL_OK : sl_fail_memory(error, "photon paths");
    while (status == SL_OK && chunks > 0 && !is_complete(list, options)) {
        status = trace_some(job, options, threads, &chunks, list, counters, error);
    }
    for (size_t i = 0; job->chunks && i < CHUNKS_AT_ONCE; i++) {
        SL_FREE_ALL(job->chunks[i].photon, job->chunks[i].path);
    }
    SL_FREE_ALL(job->chunks, job->results, job->blocks);
    *done = status == SL_OK && is_complete(list, options);
    if (*done) divide_fluxes(list);
    return status;
}

sl_status sl_photons_trace(const sl_scene *scene, const sl_tracer *tracer, const sl_photon_options *options,
                           size_t chunks, sl_photon_list **list, bool *done, sl_counters *counters,
                           sl_error *error) {
    *done = false;
    if (!*list && !(*list = sl_allocate(1, sizeof **list))) return sl_fail_memory(error, "photons");
    sl_photon_list *l = *list;
    if (!l->lights) {
        sl_status status = sl_light_sampler_create(scene, &l->lights, error);
        if (status != SL_OK) return status;
        l->emitted_flux = sl_light_sampler_power(l->lights);
    }
    sl_status status = SL_OK;
    if (!(l->emitted_flux > 0.0) || !can_store(scene, options)) {
        *done = true;
    } else {
        photon_job job = {.scene = scene,
                          .tracer = tracer,
                          .lights = l->lights,
                          .store = options->store,
                          .polished = options->polished,
                          .sky = options->sky,
                          .seed = options->seed};
        status = trace_chunks(&job, options, chunks, l, done, counters, error);
    }
    if (*done) {
        sl_light_sampler_destroy(l->lights);
        l->lights = NULL;
    }
    return status;
}
