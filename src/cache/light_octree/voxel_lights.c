#include "cache/light_octree/voxel_lights.h"

#include <string.h>

#include "base/counters.h"
#include "base/math.h"
#include "base/parallel.h"
#include "cache/light_octree/voxel_work.h"

double sl_voxel_radius(const sl_octree *octree, size_t neighbours, uint64_t photons) {
    double area = 0.0, voxel = sl_octree_voxel(octree);
    for (size_t i = 0; i < octree->leaf_count; i++) area += (double)octree->leaf[i].area;
    double radius = photons > 0 ? 1.4 * sqrt((double)neighbours * area / (SL_PI * (double)photons)) : 0.0;
    return radius > voxel ? radius : voxel;
}

/* ---- a set of lights: parts of sl_voxel_light_set() ---- */

double sl_luminance_of_photons(const sl_lobe_photons *photons) {
    double sum = 0.0;
    for (size_t i = 0; i < photons->count; i++) sum += photons->luminance[i];
    return sum;
}

/* Returns how many of n lights the front gets: by irradiance, and at least one for each side that is lit. One
 * light, or one value, is the brighter side's. */
int sl_lights_of_front(const double irradiance[2], int lights) {
    double front = irradiance[0], back = irradiance[1];
    if (!(back > 0.0)) return lights;
    if (!(front > 0.0)) return 0;
    if (lights < 2) return front >= back ? lights : 0;
    int share = (int)floor((double)lights * (front / (front + back)) + 0.5);
    return share < 1 ? 1 : share > lights - 1 ? lights - 1 : share;
}

static void scale_lights(sl_directional_light *light, int count, double factor) {
    for (int i = 0; i < count; i++) {
        for (int c = 0; c < 3; c++) light[i].color[c] = (float)((double)light[i].color[c] * factor);
    }
}

sl_photon_query sl_voxel_query_of_set(const sl_voxel_work *work, const sl_voxel_light_options *o,
                                    const sl_voxel_set *set, sl_vec3 centre, double radius) {
    sl_photon_query query = sl_voxel_query(work, o, centre, set->normal, radius);
    query.both_sides = query.both_sides && !set->opposed;
    return query;
}

/* Too few photons tell no directions: those of the cell above, twice as large, are scaled to the voxel's own
 * irradiance. */
void sl_voxel_take_directions_of_parent(const sl_voxel_lights *lights, sl_voxel_set *set, sl_voxel_worker *w,
                                        sl_voxel_result *own, sl_directional_light *light) {
    const sl_voxel_work *work = lights->work;
    const sl_voxel_light_options *o = &lights->options;
    if (work->octree->depth < 2) return;
    sl_vec3 centre = sl_octree_parent_centroid(work->octree, set->leaf);
    sl_photon_query query =
        sl_voxel_query_of_set(work, o, set, centre, 2.0 * o->radius);
    sl_voxel_gather gather = sl_voxel_gather_photons(work, &query, w);
    if (gather.found <= set->photons) return;
    sl_directional_light wider[SL_VOXEL_LIGHTS_MAX] = {{{0}, 0}};
    sl_voxel_result result = sl_voxel_make_lights(work, o, &gather, w, set, wider);
    double from = result.irradiance[0] + result.irradiance[1], to = own->irradiance[0] + own->irradiance[1];
    if (!(from > 0.0 && to > 0.0)) return;
    scale_lights(wider, result.lights, to / from);
    memcpy(light, wider, (size_t)lights->texels * sizeof *light);
    own->lights = result.lights;
    own->spread = result.spread;
    own->irradiance[0] = result.irradiance[0] * (to / from);
    own->irradiance[1] = result.irradiance[1] * (to / from);
    set->from_parent = true;
}

static float power_ratio(const sl_voxel_gather *gather) {
    double most = 0.0, sum = sl_luminance_of_photons(&gather->front) + sl_luminance_of_photons(&gather->back);
    size_t count = gather->front.count + gather->back.count;
    for (size_t i = 0; i < gather->front.count; i++)
        most = gather->front.luminance[i] > most ? gather->front.luminance[i] : most;
    for (size_t i = 0; i < gather->back.count; i++)
        most = gather->back.luminance[i] > most ? gather->back.luminance[i] : most;
    return sum > 0.0 ? (float)(most * (double)count / sum) : 0.0f;
}

void sl_voxel_report_gather(sl_voxel_set *set, const sl_voxel_gather *gather, sl_counters *counters) {
    set->photons = (uint32_t)gather->found;
    set->radius = (float)gather->ellipsoid.radius;
    set->power_ratio = power_ratio(gather);
    set->from_parent = false;
    sl_count(counters, SL_COUNT_PHOTONS_GATHERED, gather->found);
}

void sl_voxel_report_lights(sl_voxel_set *set, const sl_voxel_light_options *o, const sl_voxel_result *result,
                            sl_counters *counters) {
    const sl_lobe_spread *s = &result->spread;
    set->lights = (uint8_t)result->lights;
    set->area = (float)result->surface;
    set->density = (float)result->density;
    set->irradiance = (float)(result->irradiance[0] + result->irradiance[1]);
    set->rms_angle = s->weight > 0.0 ? (float)(2.0 * sl_asin(0.5 * sqrt(s->cost / s->weight))) : 0.0f;
    set->both_sides = result->irradiance[0] > 0.0 && result->irradiance[1] > 0.0;
    if (result->irradiance[1] > 0.0 && !(result->irradiance[0] > 0.0)) {
        set->normal = sl_neg(set->normal);
        set->height = -set->height;
    }
    if (o->lobes != SL_LOBES_NONE) sl_count(counters, SL_COUNT_DIRECTIONAL_LIGHTS, (uint64_t)result->lights);
}

/* ---- batches of leaves ---- */

typedef struct leaf_batch {
    sl_voxel_lights *lights;
    size_t first, end;
} leaf_batch;

static void compute_task(void *context, size_t index, unsigned worker) {
    const leaf_batch *batch = context;
    sl_voxel_lights *lights = batch->lights;
    sl_voxel_worker *w = &lights->work->worker[worker];
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
    sl_voxel_work *work = lights->work;
    for (unsigned i = 0; i < work->workers; i++) {
        sl_counters_add(counters, &work->worker[i].counters);
        work->worker[i].counters = (sl_counters){{0}};
    }
}

void sl_voxel_lights_compute(sl_voxel_lights *lights, size_t first, size_t count, unsigned threads,
                             sl_counters *counters) {
    if (first >= lights->leaf_count) return;
    if (count > lights->leaf_count - first) count = lights->leaf_count - first;
    leaf_batch batch = {lights, first, first + count};
    sl_voxel_work *work = lights->work;
    threads = sl_thread_count(threads);
    if (threads > work->workers) threads = work->workers;
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
        s->from_parent += set->from_parent;
        s->coincident += set->photons > 0 && (double)set->radius <= 1e-3 * lights->options.radius;
        if (set->lights == 0) continue;
        double e = (double)set->irradiance, rms = (double)set->rms_angle;
        uint32_t in_leaf = lights->first_set[set->leaf + 1] - lights->first_set[set->leaf];
        s->lit++;
        s->lights += set->lights;
        s->mean_radius += (double)set->radius;
        s->max_power_ratio =
            (double)set->power_ratio > s->max_power_ratio ? (double)set->power_ratio : s->max_power_ratio;
        s->rms_angle += e * rms * rms;
        s->flux += (double)set->density * (double)octree->leaf[set->leaf].area / (double)in_leaf;
        weight += e;
    }
    double lit = s->lit > 0 ? (double)s->lit : 1.0;
    s->mean_photons = s->sets > 0 ? (double)s->photons / (double)s->sets : 0.0;
    s->mean_radius /= lit;
    s->rms_angle = weight > 0.0 ? sqrt(s->rms_angle / weight) : 0.0;
}
