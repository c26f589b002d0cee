/* The lights of all voxels: memory for them, batches of leaves, and what can be said of them all. */
#include "cache/light_octree/voxel_lights.h"

#include "base/batch.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"

/* ---- memory ---- */

static double radius_of(const sl_voxel_lights *lights) {
    const sl_light_octree_settings *o = &lights->options;
    double area = 0.0, photons = lights->tree ? (double)sl_photon_tree_list(lights->tree)->count : 0.0;
    if (o->radius > 0.0) return o->radius;
    for (size_t i = 0; i < lights->set_count; i++) area += (double)lights->set[i].surface;
    double radius = photons > 0.0 ? 1.4 * sqrt(o->neighbours * area / (SL_PI * photons)) : 0.0;
    return fmax(radius, sl_octree_voxel(lights->octree));
}

static sl_status create_workers(sl_voxel_lights *lights, sl_error *error) {
    bool clip = sl_voxel_lights_clip(&lights->options), good = true;
    lights->worker = sl_allocate_unset(lights->workers, sizeof *lights->worker);
    for (unsigned i = 0; lights->worker && i < lights->workers; i++) {
        sl_voxel_worker *w = &lights->worker[i];
        w->gathered = (sl_gathered_photons){.place = w->place, .distance = w->distance, .keys = w->keys};
        w->marks = (sl_triangle_marks){
            sl_allocate(clip ? lights->scene->triangle_count : 0, sizeof *w->marks.mark), 0};
        good = good && w->marks.mark;
    }
    return lights->worker && good ? SL_OK : sl_fail_memory(error, "gathered photons");
}

sl_status sl_voxel_lights_create(const sl_scene *scene, const sl_octree *octree, const sl_photon_tree *tree,
                                 const sl_light_octree_settings *options, unsigned threads,
                                 sl_voxel_lights **result, sl_error *error) {
    *result = NULL;
    sl_voxel_lights *lights = sl_allocate(1, sizeof *lights);
    if (!lights) return sl_fail_memory(error, "lights of voxels");
    *lights = (sl_voxel_lights){.options = *options,
                                .split = !options->whole_voxels && !options->own_photons,
                                .leaf_count = octree->leaf_count,
                                .texels = sl_lobe_texels(options),
                                .scene = scene,
                                .octree = octree,
                                .tree = tree && sl_photon_tree_list(tree)->count > 0 ? tree : NULL,
                                .by_side = options->acceptance < 3.1415,
                                .workers = sl_thread_count(threads)};
    lights->cos_acceptance = lights->by_side ? sl_cos(options->acceptance) : -1.0;
    sl_status status = create_workers(lights, error);
    if (status == SL_OK) status = sl_voxel_sets_create(lights, error);
    lights->radius = status == SL_OK ? radius_of(lights) : 0.0;
    if (status != SL_OK) sl_voxel_lights_destroy(lights);
    else *result = lights;
    return status;
}

void sl_voxel_lights_destroy(sl_voxel_lights *lights) {
    if (!lights) return;
    for (unsigned i = 0; lights->worker && i < lights->workers; i++) sl_free(lights->worker[i].marks.mark);
    SL_FREE_ALL(lights->worker, lights->first_set, lights->set, lights->light, lights);
}

size_t sl_voxel_lights_bytes(const sl_voxel_lights *lights) {
    bool clip = sl_voxel_lights_clip(&lights->options);
    size_t bytes = sizeof *lights + (lights->leaf_count + 1) * sizeof *lights->first_set;
    bytes += lights->set_count * (sizeof *lights->set + (size_t)lights->texels * sizeof *lights->light);
    size_t marks = clip ? lights->scene->triangle_count * sizeof(uint32_t) : 0;
    return bytes + lights->workers * (sizeof *lights->worker + marks);
}

/* ---- batches of leaves ---- */

typedef struct leaf_batch {
    sl_voxel_lights *lights;
    size_t first; /* set */
} leaf_batch;

static void light_set(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    (void)result;
    const leaf_batch *batch = context;
    sl_voxel_light_set(batch->lights, batch->first + index, &batch->lights->worker[worker], counters);
}

static void count_leaf(const sl_voxel_lights *lights, size_t leaf, sl_counters *counters) {
    bool lit = false;
    for (uint32_t set = lights->first_set[leaf]; set < lights->first_set[leaf + 1]; set++)
        lit |= lights->set[set].lights > 0;
    sl_count(counters, SL_COUNT_LEAVES, 1);
    sl_count(counters, SL_COUNT_LEAVES_WITHOUT_PHOTONS, !lit);
}

void sl_voxel_lights_compute(sl_voxel_lights *lights, size_t first, size_t count, unsigned threads,
                             sl_counters *counters) {
    if (first >= lights->leaf_count) return;
    if (count > lights->leaf_count - first) count = lights->leaf_count - first;
    leaf_batch leaves = {lights, lights->first_set[first]};
    const size_t end = first + count, texels = (size_t)lights->texels;
    const sl_batch_plane lit = {lights->light + leaves.first * texels, texels * sizeof *lights->light};
    const sl_batch batch = {.count = lights->first_set[end] - leaves.first, .work = light_set,
                            .context = &leaves, .results = lights->set + leaves.first,
                            .result_bytes = sizeof *lights->set, .shared = true, .planes = &lit,
                            .plane_count = 1};
    threads = sl_thread_count(threads);
    sl_batch_run(&batch, threads < lights->workers ? threads : lights->workers, counters);
    for (size_t leaf = first; leaf < end; leaf++) count_leaf(lights, leaf, counters);
}

/* ---- statistics ---- */

sl_voxel_statistics sl_voxel_lights_statistics(const sl_voxel_lights *lights) {
    sl_voxel_statistics s = {.sets = lights->set_count};
    double weight = 0.0;
    for (size_t i = 0; i < lights->set_count; i++) {
        const sl_voxel_set *set = &lights->set[i];
        s.photons += set->photons;
        if (set->lights == 0) continue;
        double e = (double)set->irradiance, rms = (double)set->rms_angle;
        s.lit++;
        s.lights += set->lights;
        s.mean_radius += (double)set->radius;
        s.rms_angle += e * rms * rms;
        s.flux += (double)set->density * (double)set->surface;
        weight += e;
    }
    double lit = s.lit > 0 ? (double)s.lit : 1.0;
    s.mean_photons = s.sets > 0 ? (double)s.photons / (double)s.sets : 0.0;
    s.mean_radius /= lit;
    s.rms_angle = weight > 0.0 ? sqrt(s.rms_angle / weight) : 0.0;
    return s;
}
