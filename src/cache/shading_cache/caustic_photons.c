#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/random.h"
#include "cache/shading_cache/caustic_map.h"
#include "trace/bidirectional/subpath.h"

/* The first rounds tell which way photons are to be sent, or that there will be none; then they are emitted
 * round by round until there are enough. */
enum { TASK = 4096, ROUND = 16, ROUNDS_FIRST = 4, ROUNDS_MAX = 32, ENOUGH = 120000 };

bool sl_material_is_specular(const sl_material *m) {
    if (sl_material_is_mirror(m)) return true;
    return sl_material_is_glossy(m) && !sl_material_is_diffuse(m) && m->exponent >= SL_POLISHED;
}

typedef struct task_result {
    sl_caustic_photon *photon;
    uint32_t *cell;            /* where they started */
    size_t count;
    bool failed;
} task_result;

typedef struct emission {
    sl_path_maker maker;
    uint64_t key;
    uint32_t first;            /* of the round */
    const sl_caustic_aim *aim; /* NULL: evenly */
    sl_subpath *scratch;       /* sixteen a worker */
    task_result *result;       /* by task of the round */
} emission;

/* The walk's first surface that is not specular, if it is diffuse and something specular came before. */
static const sl_path_vertex *end_of_caustic(const sl_path_maker *m, const sl_subpath *path) {
    for (unsigned i = 1; i < path->count; i++) {
        const sl_path_vertex *v = &path->vertex[i];
        const sl_material *material = &m->scene->materials[m->scene->material_index[v->triangle]];
        if (sl_material_is_specular(material)) continue;
        return i > 1 && sl_material_is_diffuse(material) && sl_rgb_max(v->weight) > 0.0f ? v : NULL;
    }
    return NULL;
}

/* What a packet's photons start with. */
typedef struct packet_start {
    const sl_light_sampler *lights;
    const sl_caustic_aim *aim;
    uint32_t cell[SL_PACKET];
} packet_start;

static float start(void *context, unsigned lane, float where[3], float whither[3]) {
    packet_start *p = context;
    float chosen = where[0];
    uint32_t light = 0;
    sl_light_sampler_choose(p->lights, &chosen, &light);
    float weight = p->aim ? sl_caustic_aim_warp(p->aim, light, whither) : 1.0f;
    p->cell[lane] = sl_aim_cell(light, whither);
    return weight;
}

static void emit_task(void *context, size_t task, unsigned worker) {
    const emission *e = context;
    task_result *out = &e->result[task];
    sl_subpath *paths[SL_PACKET];
    sl_counters uncounted = {{0}};
    out->count = 0;
    out->photon = sl_allocate_unset(TASK, sizeof *out->photon);
    out->cell = sl_allocate_unset(TASK, sizeof *out->cell);
    out->failed = !out->photon || !out->cell;
    if (out->failed) return;
    packet_start starts = {.lights = e->maker.lights, .aim = e->aim};
    sl_path_maker maker = e->maker;
    maker.aim = start;
    maker.aim_context = &starts;
    for (unsigned i = 0; i < SL_PACKET; i++) paths[i] = &e->scratch[worker * SL_PACKET + i];
    for (uint32_t at = 0; at < TASK; at += SL_PACKET) {
        uint64_t key[SL_PACKET];
        uint32_t index[SL_PACKET];
        for (uint32_t i = 0; i < SL_PACKET; i++) {
            key[i] = e->key;
            index[i] = e->first + (uint32_t)task * TASK + at + i;
        }
        sl_walk_from_lights(&maker, SL_PACKET, key, index, paths, &uncounted);
        for (uint32_t i = 0; i < SL_PACKET; i++) {
            const sl_path_vertex *v = end_of_caustic(&e->maker, paths[i]);
            if (!v || !sl_rgb_is_finite(v->weight)) continue;
            out->cell[out->count] = starts.cell[i];
            out->photon[out->count++] = (sl_caustic_photon){.position = v->origin,
                                                            .to_light = v->back,
                                                            .normal = v->geometric_normal,
                                                            .flux = v->weight,
                                                            .id = index[i]};
        }
    }
}

static void forget_round(emission *e) {
    for (size_t t = 0; t < ROUND; t++) {
        sl_free(e->result[t].photon);
        sl_free(e->result[t].cell);
        e->result[t] = (task_result){.photon = NULL};
    }
}

static sl_status emit_round(emission *e, unsigned threads, uint32_t round, sl_error *error) {
    e->first = round * ROUND * TASK;
    sl_parallel_for(threads, ROUND, emit_task, e);
    bool failed = false;
    for (size_t t = 0; t < ROUND; t++) failed |= e->result[t].failed;
    return failed ? sl_fail_memory(error, "caustic photons") : SL_OK;
}

/* Adds a round's photons in the order of emission. */
static sl_status keep_round(emission *e, sl_caustic_map *map, size_t *capacity, sl_error *error) {
    size_t wanted = map->count;
    for (size_t t = 0; t < ROUND; t++) wanted += e->result[t].count;
    if (wanted > *capacity) {
        *capacity = 2 * wanted;
        sl_caustic_photon *longer = sl_allocate_unset(*capacity, sizeof *longer);
        if (!longer) return sl_fail_memory(error, "caustic photons");
        for (size_t i = 0; i < map->count; i++) longer[i] = map->photon[i];
        sl_free(map->photon);
        map->photon = longer;
    }
    for (size_t t = 0; t < ROUND; t++) {
        for (size_t i = 0; i < e->result[t].count; i++) map->photon[map->count++] = e->result[t].photon[i];
    }
    map->emitted += (size_t)ROUND * TASK;
    return SL_OK;
}

/* True: some photons end in caustics. */
static bool count_hits(const emission *e, double *hits) {
    bool any = false;
    for (size_t t = 0; t < ROUND; t++) {
        for (size_t i = 0; i < e->result[t].count; i++) hits[e->result[t].cell[i]] += 1.0;
        any |= e->result[t].count > 0;
    }
    return any;
}

static sl_status emit(emission *e, unsigned threads, double *hits, sl_caustic_aim *aim, sl_caustic_map *map,
                      sl_error *error) {
    sl_status status = SL_OK;
    bool any = false;
    for (uint32_t round = 0; round < ROUNDS_FIRST && status == SL_OK; round++) {
        status = emit_round(e, threads, round, error);
        if (status == SL_OK) any |= count_hits(e, hits);
        forget_round(e);
    }
    if (status != SL_OK || !any) return status;
    sl_caustic_aim_make(hits, aim);
    e->aim = aim;
    size_t capacity = 0;
    for (uint32_t round = ROUNDS_FIRST; round < ROUNDS_MAX && map->count < ENOUGH && status == SL_OK;
         round++) {
        status = emit_round(e, threads, round, error);
        if (status == SL_OK) status = keep_round(e, map, &capacity, error);
        forget_round(e);
    }
    /* Weights are over the scene's radius squared. */
    double scale = e->maker.radius * e->maker.radius / (double)map->emitted;
    for (size_t i = 0; i < map->count; i++)
        map->photon[i].flux = sl_rgb_scale(map->photon[i].flux, (float)scale);
    return status;
}

static bool anything_specular(const sl_scene *scene) {
    for (size_t m = 0; m < scene->material_count; m++) {
        if (sl_material_is_specular(&scene->materials[m])) return true;
    }
    return false;
}

sl_status sl_caustic_map_make(const sl_renderer_settings *settings, sl_caustic_map *map, sl_error *error) {
    *map = (sl_caustic_map){.photon = NULL};
    if (!anything_specular(settings->scene)) return SL_OK;
    unsigned threads = settings->threads > 0 ? settings->threads : 1;
    sl_light_sampler *lights;
    sl_status status = sl_light_sampler_create(settings->scene, &lights, error);
    if (status != SL_OK) return status;
    sl_sequence *sequence = sl_allocate(1, sizeof *sequence);
    emission e = {.key = sl_random_key(settings->seed, 0x63617573746963u)};
    e.scratch = sl_allocate_unset((size_t)threads * SL_PACKET, sizeof *e.scratch);
    e.result = sl_allocate(ROUND, sizeof *e.result);
    double *hits = sl_allocate(SL_AIM_ALL, sizeof *hits);
    sl_caustic_aim *aim = sl_allocate(1, sizeof *aim);
    if (sequence && e.scratch && e.result && hits && aim) {
        /* Light goes on from mirrors and lobes, and stays on what is diffuse. */
        sl_transport transport;
        sl_transport_named("full", &transport);
        transport.bounces = (uint32_t)settings->cache.path_depth;
        transport.bounce_lobes = SL_LOBE_GLOSSY | SL_LOBE_MIRROR;
        sl_sequence_make(sequence);
        sl_path_maker_init(&e.maker, settings->scene, *settings->tracer, lights, sequence, &transport);
        status = emit(&e, threads, hits, aim, map, error);
        if (status == SL_OK) sl_caustic_tree_build(map->photon, map->count);
        else sl_caustic_map_release(map);
    } else {
        status = sl_fail_memory(error, "caustic photons");
    }
    sl_free(hits);
    sl_free(aim);
    sl_free(sequence);
    sl_free(e.scratch);
    sl_free(e.result);
    sl_light_sampler_destroy(lights);
    return status;
}

void sl_caustic_map_release(sl_caustic_map *map) {
    sl_free(map->photon);
    *map = (sl_caustic_map){.photon = NULL};
}
