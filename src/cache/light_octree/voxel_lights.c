/* The lights of all voxels: memory for them, batches of leaves, and what can be said of them all. */
#include "cache/light_octree/voxel_lights.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"

double sl_voxel_radius(const sl_octree *octree, size_t neighbours, uint64_t photons) {
    double area = 0.0, voxel = sl_octree_voxel(octree);
    for (size_t i = 0; i < octree->leaf_count; i++) area += (double)octree->leaf[i].area;
    double radius = photons > 0 ? 1.4 * sqrt((double)neighbours * area / (SL_PI * (double)photons)) : 0.0;
    return radius > voxel ? radius : voxel;
}

/* ---- the photons of every leaf ---- */

static uint32_t leaf_of(const sl_octree *octree, const sl_photon *p) {
    sl_vec3 at = sl_v3(p->position[0], p->position[1], p->position[2]);
    const sl_octree_root root = {octree->origin, octree->edge};
    return sl_octree_root_holds(&root, at) ? sl_octree_find(octree, sl_octree_morton_at(octree, at))
                                           : SL_NO_INDEX;
}

/* Counting sort by leaf. */
static sl_status find_own_photons(sl_voxel_lights *lights, sl_error *error) {
    const sl_photon_list *list = sl_photon_tree_list(lights->tree);
    struct sl_own_photons *own = &lights->own;
    uint32_t *leaf = sl_allocate(list->count, sizeof *leaf);
    own->first = sl_allocate(lights->leaf_count + 2, sizeof *own->first);
    own->place = sl_allocate(list->count, sizeof *own->place);
    bool good = leaf && own->first && own->place;
    for (size_t i = 0; good && i < list->count; i++) {
        leaf[i] = leaf_of(lights->octree, &list->photon[i]);
        if (leaf[i] != SL_NO_INDEX) own->first[leaf[i] + 2]++; /* else rounding has put it outside */
    }
    for (size_t i = 0; good && i < lights->leaf_count; i++) {
        own->most = own->first[i + 2] > own->most ? own->first[i + 2] : own->most;
        own->first[i + 2] += own->first[i + 1];
    }
    for (size_t i = 0; good && i < list->count; i++) {
        if (leaf[i] != SL_NO_INDEX) own->place[own->first[leaf[i] + 1]++] = (uint32_t)i;
    }
    sl_free(leaf);
    return good ? SL_OK : sl_fail_memory(error, "the photons of voxels");
}

/* ---- memory ---- */

static sl_status check_options(const sl_voxel_light_options *o, sl_error *error) {
    bool good = o->neighbours >= 2 && o->neighbours <= 1 << 20 && o->radius > 0.0 && o->radius <= DBL_MAX &&
                o->flatness > 0.0 && o->flatness <= 1.0 && o->acceptance >= 0.0 && o->lights >= 1 &&
                o->lights <= SL_VOXEL_LIGHTS_MAX;
    if (good) return SL_OK;
    return sl_fail(error, SL_ERROR_USAGE,
                   "lights of voxels: %zu neighbours (2 at least), radius %g (> 0), flatness %g (0 to 1), %d "
                   "lights (1 to %d)",
                   o->neighbours, o->radius, o->flatness, o->lights, (int)SL_VOXEL_LIGHTS_MAX);
}

/* Returns the most photons that a set can take. */
static size_t most_photons(const sl_voxel_lights *lights) {
    size_t k =
        lights->options.neighbours < SL_NEIGHBOURS_MAX ? lights->options.neighbours : SL_NEIGHBOURS_MAX;
    return lights->options.own_photons ? lights->own.most : k;
}

static sl_status create_worker(const sl_voxel_lights *lights, size_t pieces, sl_voxel_worker *w,
                               sl_error *error) {
    size_t k = most_photons(lights);
    bool clip = sl_voxel_lights_clip(&lights->options);
    w->gathered.place = sl_allocate(k, sizeof *w->gathered.place);
    w->gathered.distance = sl_allocate(k, sizeof *w->gathered.distance);
    w->gathered.keys = sl_allocate(sl_photon_keys(k), sizeof *w->gathered.keys);
    w->marks.mark = sl_allocate(clip ? lights->scene->triangle_count : 0, sizeof *w->marks.mark);
    w->pieces = sl_allocate(pieces, sizeof *w->pieces);
    bool good = w->gathered.place && w->gathered.distance && w->gathered.keys && w->marks.mark && w->pieces;
    return good ? sl_lobe_photons_create(k, &w->photons, error) : sl_fail_memory(error, "gathered photons");
}

static sl_status create_workers(sl_voxel_lights *lights, sl_error *error) {
    size_t pieces = 0;
    lights->worker = sl_allocate(lights->workers, sizeof *lights->worker);
    if (!lights->worker) return sl_fail_memory(error, "lights of voxels");
    for (size_t i = 0; lights->options.split_by_normal && i < lights->leaf_count; i++) {
        size_t here = lights->octree->leaf[i].triangle_count;
        pieces = here > pieces ? here : pieces;
    }
    sl_status status = SL_OK;
    for (unsigned i = 0; status == SL_OK && i < lights->workers; i++)
        status = create_worker(lights, pieces, &lights->worker[i], error);
    return status;
}

sl_status sl_voxel_lights_create(const sl_scene *scene, const sl_octree *octree, const sl_photon_tree *tree,
                                 const sl_voxel_light_options *options, unsigned threads,
                                 sl_voxel_lights **result, sl_error *error) {
    *result = NULL;
    sl_status status = check_options(options, error);
    if (status != SL_OK) return status;
    sl_voxel_lights *lights = sl_allocate(1, sizeof *lights);
    if (!lights) return sl_fail_memory(error, "lights of voxels");
    *lights = (sl_voxel_lights){.options = *options,
                                .leaf_count = octree->leaf_count,
                                .texels = sl_lobe_texels(options),
                                .scene = scene,
                                .octree = octree,
                                .tree = tree && sl_photon_tree_list(tree)->count > 0 ? tree : NULL,
                                .by_side = options->acceptance < 3.1415,
                                .workers = sl_thread_count(threads)};
    lights->cos_acceptance = lights->by_side ? sl_cos(options->acceptance) : -1.0;
    if (options->own_photons && lights->tree) status = find_own_photons(lights, error);
    if (status == SL_OK) status = create_workers(lights, error);
    if (status == SL_OK) status = sl_voxel_sets_create(lights, error);
    if (status != SL_OK) sl_voxel_lights_destroy(lights);
    else *result = lights;
    return status;
}

void sl_voxel_lights_destroy(sl_voxel_lights *lights) {
    if (!lights) return;
    for (unsigned i = 0; lights->worker && i < lights->workers; i++) {
        sl_voxel_worker *w = &lights->worker[i];
        sl_free(w->gathered.place);
        sl_free(w->gathered.distance);
        sl_free(w->gathered.keys);
        sl_free(w->marks.mark);
        sl_free(w->pieces);
        sl_lobe_photons_release(&w->photons);
    }
    sl_free(lights->worker);
    sl_free(lights->own.first);
    sl_free(lights->own.place);
    sl_free(lights->first_set);
    sl_free(lights->set);
    sl_free(lights->light);
    sl_free(lights);
}

size_t sl_voxel_lights_bytes(const sl_voxel_lights *lights) {
    bool clip = sl_voxel_lights_clip(&lights->options);
    size_t bytes = sizeof *lights + (lights->leaf_count + 1) * sizeof *lights->first_set, a_photon = 53;
    bytes += lights->set_count * (sizeof *lights->set + (size_t)lights->texels * sizeof *lights->light);
    size_t marks = clip ? lights->scene->triangle_count * sizeof(uint32_t) : 0;
    return bytes + lights->workers * (sizeof *lights->worker + marks + most_photons(lights) * a_photon);
}

/* ---- batches of leaves ---- */

typedef struct leaf_batch {
    sl_voxel_lights *lights;
    size_t first, end;
} leaf_batch;

static void compute_task(void *context, size_t index, unsigned worker) {
    const leaf_batch *batch = context;
    sl_voxel_lights *lights = batch->lights;
    sl_voxel_worker *w = &lights->worker[worker];
    size_t first = batch->first + index * SL_LEAVES_A_TASK,
           end = first + SL_LEAVES_A_TASK < batch->end ? first + SL_LEAVES_A_TASK : batch->end;
    for (size_t leaf = first; leaf < end; leaf++) {
        bool lit = false;
        for (uint32_t set = lights->first_set[leaf]; set < lights->first_set[leaf + 1]; set++) {
            sl_voxel_light_set(lights, set, w);
            lit |= lights->set[set].lights > 0;
        }
        sl_count(&w->counters, SL_COUNT_LEAVES, 1);
        sl_count(&w->counters, SL_COUNT_LEAVES_WITHOUT_PHOTONS, !lit);
    }
}

void sl_voxel_lights_count(sl_voxel_lights *lights, sl_counters *counters) {
    for (unsigned i = 0; i < lights->workers; i++) {
        sl_counters_add(counters, &lights->worker[i].counters);
        lights->worker[i].counters = (sl_counters){{0}};
    }
}

void sl_voxel_lights_compute(sl_voxel_lights *lights, size_t first, size_t count, unsigned threads,
                             sl_counters *counters) {
    if (first >= lights->leaf_count) return;
    if (count > lights->leaf_count - first) count = lights->leaf_count - first;
    leaf_batch batch = {lights, first, first + count};
    threads = sl_thread_count(threads);
    if (threads > lights->workers) threads = lights->workers;
    sl_parallel_for(threads, (count + SL_LEAVES_A_TASK - 1) / SL_LEAVES_A_TASK, compute_task, &batch);
    sl_voxel_lights_count(lights, counters);
}

/* ---- statistics ---- */

void sl_voxel_lights_statistics(const sl_voxel_lights *lights, const sl_octree *octree,
                                sl_voxel_statistics *s) {
    *s = (sl_voxel_statistics){0};
    double weight = 0.0;
    for (size_t i = 0; i < lights->set_count; i++) {
        const sl_voxel_set *set = &lights->set[i];
        if (!set->done) continue;
        s->sets++;
        s->photons += set->photons;
        if (set->lights == 0) continue;
        double e = (double)set->irradiance, rms = (double)set->rms_angle;
        uint32_t in_leaf = lights->first_set[set->leaf + 1] - lights->first_set[set->leaf];
        s->lit++;
        s->lights += set->lights;
        s->mean_radius += (double)set->radius;
        s->rms_angle += e * rms * rms;
        s->flux += (double)set->density * (double)octree->leaf[set->leaf].area / (double)in_leaf;
        weight += e;
    }
    double lit = s->lit > 0 ? (double)s->lit : 1.0;
    s->mean_photons = s->sets > 0 ? (double)s->photons / (double)s->sets : 0.0;
    s->mean_radius /= lit;
    s->rms_angle = weight > 0.0 ? sqrt(s->rms_angle / weight) : 0.0;
}
