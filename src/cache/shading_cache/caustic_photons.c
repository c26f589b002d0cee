#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/random.h"
#include "cache/shading_cache/caustic_map.h"
#include "trace/bidirectional/subpath.h"

/* Photons are emitted round by round until there are enough, or it seems that there will be none. */
enum { TASK = 4096, ROUND = 16, ROUNDS_MAX = 32, ROUNDS_IN_VAIN = 4, ENOUGH = 200000 };

bool sl_material_is_specular(const sl_material *m) {
    if (sl_material_is_mirror(m)) return true;
    return sl_material_is_glossy(m) && !sl_material_is_diffuse(m) && m->exponent >= SL_POLISHED;
}

typedef struct task_result {
    sl_caustic_photon *photon;
    size_t count;
    bool failed;
} task_result;

typedef struct emission {
    sl_path_maker maker;
    uint64_t key;
    uint32_t first;            /* of the round */
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

static void emit_task(void *context, size_t task, unsigned worker) {
    const emission *e = context;
    task_result *out = &e->result[task];
    sl_subpath *paths[SL_PACKET];
    sl_counters uncounted = {{0}};
    out->count = 0;
    out->photon = sl_allocate_unset(TASK, sizeof *out->photon);
    out->failed = !out->photon;
    if (out->failed) return;
    for (unsigned i = 0; i < SL_PACKET; i++) paths[i] = &e->scratch[worker * SL_PACKET + i];
    for (uint32_t at = 0; at < TASK; at += SL_PACKET) {
        uint64_t key[SL_PACKET];
        uint32_t index[SL_PACKET];
        for (uint32_t i = 0; i < SL_PACKET; i++) {
            key[i] = e->key;
            index[i] = e->first + (uint32_t)task * TASK + at + i;
        }
        sl_walk_from_lights(&e->maker, SL_PACKET, key, index, paths, &uncounted);
        for (uint32_t i = 0; i < SL_PACKET; i++) {
            const sl_path_vertex *v = end_of_caustic(&e->maker, paths[i]);
            if (!v || !sl_rgb_is_finite(v->weight)) continue;
            out->photon[out->count++] = (sl_caustic_photon){
                .position = v->origin, .to_light = v->back, .normal = v->geometric_normal, .flux = v->weight, .id = index[i]};
        }
    }
}

/* Adds a round's photons in the order of emission. */
static sl_status keep_round(emission *e, sl_caustic_map *map, size_t *capacity, sl_error *error) {
    size_t wanted = map->count;
    bool failed = false;
    for (size_t t = 0; t < ROUND; t++) {
        wanted += e->result[t].count;
        failed |= e->result[t].failed;
    }
    if (!failed && wanted > *capacity) {
        *capacity = 2 * wanted;
        sl_caustic_photon *longer = sl_allocate_unset(*capacity, sizeof *longer);
        failed = !longer;
        for (size_t i = 0; longer && i < map->count; i++) longer[i] = map->photon[i];
        if (longer) {
            sl_free(map->photon);
            map->photon = longer;
        }
    }
    for (size_t t = 0; t < ROUND; t++) {
        for (size_t i = 0; !failed && i < e->result[t].count; i++) map->photon[map->count++] = e->result[t].photon[i];
        sl_free(e->result[t].photon);
        e->result[t] = (task_result){.photon = NULL};
    }
    map->emitted += (size_t)ROUND * TASK;
    return failed ? sl_fail_memory(error, "caustic photons") : SL_OK;
}

static sl_status emit(emission *e, unsigned threads, sl_caustic_map *map, sl_error *error) {
    sl_status status = SL_OK;
    size_t capacity = 0;
    for (uint32_t round = 0; round < ROUNDS_MAX && map->count < ENOUGH && status == SL_OK; round++) {
        if (round >= ROUNDS_IN_VAIN && map->count == 0) break;
        e->first = round * ROUND * TASK;
        sl_parallel_for(threads, ROUND, emit_task, e);
        status = keep_round(e, map, &capacity, error);
    }
    /* Weights are over the scene's radius squared. */
    double scale = map->emitted > 0 ? e->maker.radius * e->maker.radius / (double)map->emitted : 0.0;
    for (size_t i = 0; i < map->count; i++) map->photon[i].flux = sl_rgb_scale(map->photon[i].flux, (float)scale);
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
    if (sequence && e.scratch && e.result) {
        /* Light goes on from mirrors and lobes, and stays on what is diffuse. */
        sl_transport transport;
        sl_transport_named("full", &transport);
        transport.bounces = (uint32_t)settings->cache.path_depth;
        transport.bounce_lobes = SL_LOBE_GLOSSY | SL_LOBE_MIRROR;
        sl_sequence_make(sequence);
        sl_path_maker_init(&e.maker, settings->scene, *settings->tracer, lights, sequence, &transport);
        status = emit(&e, threads, map, error);
        if (status == SL_OK) sl_caustic_tree_build(map->photon, map->count);
        else sl_caustic_map_release(map);
    } else {
        status = sl_fail_memory(error, "caustic photons");
    }
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
