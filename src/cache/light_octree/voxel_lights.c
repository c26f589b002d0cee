#include "cache/light_octree/voxel_lights.h"

#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/light_octree/normal_groups.h"
#include "cache/light_octree/surroundings.h"
#include "cache/light_octree/voxel_lobes.h"

enum { LEAVES_A_TASK = 16 };

/* A worker's own. */
typedef struct voxel_worker {
    sl_gathered_photons gathered;
    sl_lobe_photons photons;      /* both sides: room for twice k */
    sl_surroundings_marks marks;
    sl_voxel_piece *pieces;
    sl_counters counters;
} voxel_worker;

typedef struct sl_voxel_work {
    const sl_scene *scene;
    const sl_octree *octree, *geometry;
    const sl_photon_tree *tree;
    sl_octree *parents;           /* the cut above; NULL at depth 1 */
    sl_surroundings *surroundings; /* clip area alone */
    double cos_acceptance;
    bool by_side;                 /* photons are taken side by side; off: all of them, whatever their normals */
    unsigned workers;
    voxel_worker *worker;
} sl_voxel_work;

double sl_voxel_radius(const sl_octree *octree, size_t neighbours, uint64_t photons) {
    double area = 0.0, voxel = sl_octree_voxel(octree);
    for (size_t i = 0; i < octree->leaf_count; i++) area += (double)octree->leaf[i].area;
    double radius = photons > 0 ? 2.0 * sqrt((double)neighbours * area / (SL_PI * (double)photons)) : 0.0;
    return radius > voxel ? radius : voxel;
}

/* ---- P3: photons and their area (section 2.2) ---- */

typedef struct voxel_gather {
    sl_ellipsoid ellipsoid;       /* R; f = 1 without a normal */
    double kappa;
    size_t found;
    bool coincident;
    sl_lobe_photons front, back;  /* by the side of n_v; all in front where sides are not told apart */
    sl_vec3d mean_normal, mean_place; /* of the photons, turned to n_v's side; about the centre */
} voxel_gather;

static sl_photon_query query_of(const sl_voxel_work *work, const sl_voxel_light_options *o, sl_vec3 centre, sl_vec3 normal, double radius) {
    bool has_normal = sl_dot(normal, normal) > 0.0f;
    return (sl_photon_query){.centre = centre,
                             .normal = normal,
                             .flatness = has_normal ? o->flatness : 1.0,
                             .radius = radius,
                             .minimum = 1e-3 * radius,
                             .cos_acceptance = has_normal && work->by_side ? work->cos_acceptance : -1.0,
                             .both_sides = has_normal && work->by_side,
                             .neighbours = o->neighbours};
}

/* Two passes, so that each side's photons stand together in order of their ids. */
static void split_sides(const sl_voxel_work *work, const sl_photon_query *query, voxel_worker *w, voxel_gather *gather) {
    const sl_photon_list *list = sl_photon_tree_list(work->tree);
    w->photons.count = 0;
    size_t front = 0, seen = 0;
    sl_vec3d normals = {0}, places = {0};
    for (int back = 0; back < 2 && seen < w->gathered.count; back++) {
        for (size_t i = 0; i < w->gathered.count; i++) {
            const sl_photon *p = &list->photon[w->gathered.place[i]];
            sl_vec3 n = sl_octahedral_decode(p->normal);
            bool behind = query->both_sides && sl_dot(n, query->normal) < 0.0f;
            if (behind != (back == 1)) continue;
            seen++;
            sl_lobe_photons_add(&w->photons, sl_octahedral_decode(p->direction), n, p->flux);
            sl_vec3 place = sl_sub(sl_v3(p->position[0], p->position[1], p->position[2]), query->centre);
            places = sl_addd(places, sl_to_double(place));
            normals = sl_addd(normals, sl_scaled(sl_to_double(n), behind ? -1.0 : 1.0));
        }
        if (back == 0) front = w->photons.count;
    }
    gather->front = sl_lobe_photons_from(&w->photons, 0, front);
    gather->back = sl_lobe_photons_from(&w->photons, front, w->photons.count - front);
    double count = w->gathered.count > 0 ? (double)w->gathered.count : 1.0;
    gather->mean_normal = normals;
    gather->mean_place = sl_scaled(places, 1.0 / count);
}

static voxel_gather gather_photons(const sl_voxel_work *work, const sl_photon_query *query, voxel_worker *w) {
    sl_photon_tree_gather(work->tree, query, &w->gathered);
    size_t found = w->gathered.count;
    voxel_gather gather = {.found = found,
                           .kappa = w->gathered.full && found > 0 ? (double)(found - 1) / (double)found : 1.0,
                           .coincident = w->gathered.radius <= query->minimum,
                           .ellipsoid = {sl_to_double(query->centre), sl_to_double(query->normal), query->flatness, w->gathered.radius}};
    split_sides(work, query, w, &gather);
    return gather;
}

/* A for the photons in front and behind; returns that of all surfaces together. What is next to nothing (photons beside the geometry) is
 * taken for the disc. */
static double areas_of(const sl_voxel_work *work, const sl_voxel_light_options *o, const voxel_gather *gather, voxel_worker *w,
                     double area[2]) {
    const sl_ellipsoid *e = &gather->ellipsoid;
    double disc = sl_disc_area(e);
    double all = 0.0;
    area[0] = area[1] = disc;
    if (o->area == SL_PHOTON_AREA_SECTION) {
        double length = sl_lengthd(gather->mean_normal);
        if (length > 0.0) {
            sl_vec3d n = sl_scaled(gather->mean_normal, 1.0 / length);
            area[0] = area[1] = sl_section_area(e, n, sl_dotd(n, gather->mean_place));
        }
    } else if (o->area == SL_PHOTON_AREA_CLIP) {
        sl_strewn_area strewn = sl_surroundings_area(work->surroundings, e, work->by_side ? work->cos_acceptance : -1.0, &w->marks);
        bool together = strewn.sheet || !work->by_side;
        all = strewn.front + strewn.back;
        area[0] = together ? all : strewn.front;
        area[1] = together ? all : strewn.back;
    }
    for (int side = 0; side < 2; side++) {
        if (!(area[side] > 1e-3 * disc)) area[side] = disc;
    }
    return all > 1e-3 * disc ? all : area[0];
}

/* ---- P4: lights ---- */

typedef struct voxel_result {
    int lights;
    double irradiance[2];      /* E, luminance, on either side */
    sl_lobe_spread spread;
    double surface;            /* area of all the surfaces that the photons were strewn over */
    double density;            /* flux over that area: luminance */
} voxel_result;

static double luminance_of(const sl_lobe_photons *photons) {
    double sum = 0.0;
    for (size_t i = 0; i < photons->count; i++) sum += photons->luminance[i];
    return sum;
}

/* How many of n lights the front gets: by irradiance, and at least one for each side that is lit. One light, or one value, is the
 * brighter side's. */
static int front_share(const double irradiance[2], int lights) {
    double front = irradiance[0], back = irradiance[1];
    if (!(back > 0.0)) return lights;
    if (!(front > 0.0)) return 0;
    if (lights < 2) return front >= back ? lights : 0;
    int share = (int)floor((double)lights * (front / (front + back)) + 0.5);
    return share < 1 ? 1 : share > lights - 1 ? lights - 1 : share;
}

static voxel_result make_lights(const sl_voxel_work *work, const sl_voxel_light_options *o, const voxel_gather *gather, voxel_worker *w,
                                sl_vec3 normal, sl_directional_light *light) {
    double area[2], scale[2];
    voxel_result result = {0};
    result.surface = areas_of(work, o, gather, w, area);
    result.density = gather->kappa * (luminance_of(&gather->front) + luminance_of(&gather->back)) / result.surface;
    const sl_lobe_photons *photons[2] = {&gather->front, &gather->back};
    for (int side = 0; side < 2; side++) {
        scale[side] = gather->kappa / area[side];
        result.irradiance[side] = scale[side] * luminance_of(photons[side]);
    }
    if (o->lobes == SL_LOBES_HARMONICS) { /* one function of direction holds both */
        sl_lobes_of_photons(photons[0], o, scale[0], normal, 1, light, &result.spread);
        sl_lobes_of_photons(photons[1], o, scale[1], normal, 1, light, &result.spread);
        result.lights = result.irradiance[0] + result.irradiance[1] > 0.0 ? sl_lobe_texels(o) : 0;
    } else {
        int room = sl_lobe_texels(o), front = front_share(result.irradiance, room);
        result.lights = sl_lobes_of_photons(photons[0], o, scale[0], normal, front, light, &result.spread);
        int back = front_share(result.irradiance, room) < room ? room - result.lights : 0;
        result.lights += sl_lobes_of_photons(photons[1], o, scale[1], sl_neg(normal), back, light + result.lights, &result.spread);
    }
    return result;
}

static void scale_lights(sl_directional_light *light, int count, double factor) {
    for (int i = 0; i < count; i++) {
        for (int c = 0; c < 3; c++) light[i].color[c] = (float)((double)light[i].color[c] * factor);
    }
}

/* Too few photons to tell directions by: those of the cell above, twice as large, scaled to the voxel's own irradiance. */
static void borrow_directions(const sl_voxel_work *work, const sl_voxel_lights *lights, const sl_voxel_set *set, voxel_worker *w,
                              voxel_result *own, sl_directional_light *light, bool *borrowed) {
    const sl_voxel_light_options *o = &lights->options;
    uint32_t parent = work->parents ? sl_octree_find(work->parents, work->octree->leaf[set->leaf].morton >> 3) : SL_NO_INDEX;
    if (parent == SL_NO_INDEX) return;
    sl_photon_query query = query_of(work, o, work->parents->leaf[parent].centroid, set->normal, 2.0 * o->radius);
    voxel_gather gather = gather_photons(work, &query, w);
    if (gather.found <= set->photons) return;
    sl_directional_light wider[SL_LOBE_HARMONICS_MAX] = {{{0}, 0}};
    voxel_result result = make_lights(work, o, &gather, w, set->normal, wider);
    double from = result.irradiance[0] + result.irradiance[1], to = own->irradiance[0] + own->irradiance[1];
    if (!(from > 0.0 && to > 0.0)) return;
    scale_lights(wider, result.lights, to / from);
    memcpy(light, wider, (size_t)lights->texels * sizeof *light);
    own->lights = result.lights;
    own->spread = result.spread;
    own->irradiance[0] = result.irradiance[0] * (to / from);
    own->irradiance[1] = result.irradiance[1] * (to / from);
    *borrowed = true;
}

static float power_ratio(const voxel_gather *gather) {
    double most = 0.0, sum = luminance_of(&gather->front) + luminance_of(&gather->back);
    size_t count = gather->front.count + gather->back.count;
    for (size_t i = 0; i < gather->front.count; i++) most = gather->front.luminance[i] > most ? gather->front.luminance[i] : most;
    for (size_t i = 0; i < gather->back.count; i++) most = gather->back.luminance[i] > most ? gather->back.luminance[i] : most;
    return sum > 0.0 ? (float)(most * (double)count / sum) : 0.0f;
}

static void report_set(sl_voxel_set *set, const voxel_result *result) {
    const sl_lobe_spread *s = &result->spread;
    set->lights = (uint8_t)result->lights;
    set->area = (float)result->surface;
    set->density = (float)result->density;
    set->irradiance = (float)(result->irradiance[0] + result->irradiance[1]);
    set->rms_angle = s->weight > 0.0 ? (float)(2.0 * sl_asin(0.5 * sqrt(s->cost / s->weight))) : 0.0f;
    set->mean_angle = s->weight > 0.0 ? (float)(s->angle / s->weight) : 0.0f;
    set->both_sides = result->irradiance[0] > 0.0 && result->irradiance[1] > 0.0;
    if (result->irradiance[1] > 0.0 && !(result->irradiance[0] > 0.0)) set->normal = sl_neg(set->normal);
}

static void compute_set(sl_voxel_lights *lights, size_t index, voxel_worker *w) {
    const sl_voxel_work *work = lights->work;
    const sl_voxel_light_options *o = &lights->options;
    sl_voxel_set *set = &lights->set[index];
    sl_directional_light *light = lights->light + index * (size_t)lights->texels;
    memset(light, 0, (size_t)lights->texels * sizeof *light);
    set->done = true;
    if (!work->tree) return;
    sl_photon_query query = query_of(work, o, set->centroid, set->normal, o->radius);
    voxel_gather gather = gather_photons(work, &query, w);
    set->photons = (uint32_t)gather.found;
    set->radius = (float)gather.ellipsoid.radius;
    set->power_ratio = power_ratio(&gather);
    sl_count(&w->counters, SL_COUNT_PHOTONS_GATHERED, gather.found);
    if (gather.front.count + gather.back.count == 0) return; /* dark: nothing to cluster */
    bool few = gather.found < SL_VOXEL_FEW, borrowed = false;
    voxel_result result = make_lights(work, o, &gather, w, set->normal, light);
    if (few && o->lobes != SL_LOBES_NONE) borrow_directions(work, lights, set, w, &result, light, &borrowed);
    set->from_parent = borrowed;
    report_set(set, &result);
    if (o->lobes == SL_LOBES_PERPENDICULAR || o->lobes == SL_LOBES_SURFACE) {
        sl_count(&w->counters, SL_COUNT_DIRECTIONAL_LIGHTS, (uint64_t)result.lights);
    }
}

/* ---- batches of leaves ---- */

typedef struct leaf_batch {
    sl_voxel_lights *lights;
    size_t first, end;
} leaf_batch;

static void compute_task(void *context, size_t index, unsigned worker) {
    const leaf_batch *batch = context;
    sl_voxel_lights *lights = batch->lights;
    voxel_worker *w = &lights->work->worker[worker];
    size_t first = batch->first + index * LEAVES_A_TASK, end = first + LEAVES_A_TASK < batch->end ? first + LEAVES_A_TASK : batch->end;
    for (size_t leaf = first; leaf < end; leaf++) {
        bool lit = false;
        for (uint32_t set = lights->first_set[leaf]; set < lights->first_set[leaf + 1]; set++) {
            compute_set(lights, set, w);
            lit |= lights->set[set].lights > 0;
        }
        sl_count(&w->counters, SL_COUNT_LEAVES, 1);
        sl_count(&w->counters, SL_COUNT_LEAVES_WITHOUT_PHOTONS, !lit);
    }
}

void sl_voxel_lights_compute(sl_voxel_lights *lights, size_t first, size_t count, unsigned threads, sl_counters *counters) {
    if (first >= lights->leaf_count) return;
    if (count > lights->leaf_count - first) count = lights->leaf_count - first;
    leaf_batch batch = {lights, first, first + count};
    sl_voxel_work *work = lights->work;
    threads = sl_thread_count(threads);
    if (threads > work->workers) threads = work->workers;
    sl_parallel_for(threads, (count + LEAVES_A_TASK - 1) / LEAVES_A_TASK, compute_task, &batch);
    for (unsigned i = 0; i < work->workers; i++) {
        sl_counters_add(counters, &work->worker[i].counters);
        work->worker[i].counters = (sl_counters){{0}};
    }
}

/* ---- memory ---- */

static sl_status check_options(const sl_voxel_light_options *o, sl_error *error) {
    bool good = o->neighbours >= 2 && o->neighbours <= 1 << 20 && o->radius > 0.0 && o->radius <= DBL_MAX && o->flatness > 0.0 &&
                o->flatness <= 1.0 && o->acceptance >= 0.0 && o->lights >= 1 && o->lights <= SL_VOXEL_LIGHTS_MAX &&
                o->spread_tolerance >= 0.0;
    if (o->lobes == SL_LOBES_HARMONICS) good &= o->harmonics_order == 2 || o->harmonics_order == 3;
    if (good) return SL_OK;
    return sl_fail(error, SL_ERROR_USAGE,
                   "lights of voxels: %zu neighbours (2 at least), radius %g (> 0), flatness %g (0 to 1), %d lights (1 to %d)", o->neighbours,
                   o->radius, o->flatness, o->lights, (int)SL_VOXEL_LIGHTS_MAX);
}

static sl_status create_worker(const sl_voxel_lights *lights, size_t pieces, voxel_worker *w, sl_error *error) {
    size_t k = lights->options.neighbours;
    w->gathered.place = sl_allocate(k, sizeof *w->gathered.place);
    w->gathered.distance = sl_allocate(k, sizeof *w->gathered.distance);
    if (lights->work->surroundings) w->marks.mark = sl_allocate(lights->work->scene->triangle_count, sizeof *w->marks.mark);
    if (pieces > 0) w->pieces = sl_allocate(pieces, sizeof *w->pieces);
    bool good = w->gathered.place && w->gathered.distance && (w->marks.mark || !lights->work->surroundings) && (w->pieces || pieces == 0);
    return good ? sl_lobe_photons_create(k, &w->photons, error) : sl_fail_memory(error, "gathered photons");
}

static void destroy_work(sl_voxel_work *work) {
    if (!work) return;
    for (unsigned i = 0; work->worker && i < work->workers; i++) {
        voxel_worker *w = &work->worker[i];
        sl_free(w->gathered.place);
        sl_free(w->gathered.distance);
        sl_free(w->marks.mark);
        sl_free(w->pieces);
        sl_lobe_photons_release(&w->photons);
    }
    sl_free(work->worker);
    sl_octree_destroy(work->parents);
    sl_surroundings_destroy(work->surroundings);
    sl_free(work);
}

static sl_status create_work(sl_voxel_lights *lights, unsigned threads, sl_error *error) {
    sl_voxel_work *work = lights->work;
    const sl_voxel_light_options *o = &lights->options;
    work->by_side = o->acceptance < 3.1415;
    work->cos_acceptance = work->by_side ? sl_cos(o->acceptance) : -1.0;
    work->workers = sl_thread_count(threads);
    work->worker = sl_allocate(work->workers, sizeof *work->worker);
    if (!work->worker) return sl_fail_memory(error, "lights of voxels");
    sl_status status = SL_OK;
    if (work->octree->depth > 1) status = sl_octree_cut(work->octree, work->octree->depth - 1, &work->parents, error);
    if (status == SL_OK && o->area == SL_PHOTON_AREA_CLIP) {
        status = sl_surroundings_create(work->scene, work->geometry, o->radius / 8.0, work->workers, &work->surroundings, error);
    }
    size_t pieces = o->split_by_normal ? sl_voxel_pieces_max(work->octree, work->geometry) : 0;
    for (unsigned i = 0; status == SL_OK && i < work->workers; i++) status = create_worker(lights, pieces, &work->worker[i], error);
    return status;
}

/* ---- sets ---- */

typedef struct group_task {
    sl_voxel_lights *lights;
    sl_cell_space space;
    sl_normal_group (*groups)[SL_VOXEL_SETS_MAX];
    uint8_t *count;
} group_task;

static void group_leaves(void *context, size_t index, unsigned worker) {
    const group_task *task = context;
    const sl_voxel_work *work = task->lights->work;
    size_t end = (index + 1) * LEAVES_A_TASK < task->lights->leaf_count ? (index + 1) * LEAVES_A_TASK : task->lights->leaf_count;
    for (size_t leaf = index * LEAVES_A_TASK; leaf < end; leaf++) {
        task->count[leaf] = (uint8_t)sl_normal_groups(&task->space, work->octree, work->geometry, leaf, work->worker[worker].pieces,
                                                      task->groups[leaf]);
    }
}

/* One set for a leaf of one group: then its own normal and centroid are as good. */
static sl_status make_sets(sl_voxel_lights *lights, const group_task *groups, sl_error *error) {
    const sl_octree *octree = lights->work->octree;
    lights->first_set = sl_allocate(lights->leaf_count + 1, sizeof *lights->first_set);
    if (!lights->first_set) return sl_fail_memory(error, "lights of voxels");
    size_t sets = 0;
    for (size_t i = 0; i < lights->leaf_count; i++) {
        lights->first_set[i] = (uint32_t)sets;
        sets += groups && groups->count[i] > 1 ? groups->count[i] : 1;
    }
    lights->first_set[lights->leaf_count] = (uint32_t)sets;
    lights->set_count = sets;
    lights->set = sl_allocate(sets, sizeof *lights->set);
    lights->light = sl_allocate(sets * (size_t)lights->texels, sizeof *lights->light);
    if (!lights->set || !lights->light) return sl_fail_memory(error, "lights of voxels");
    for (size_t i = 0; i < lights->leaf_count; i++) {
        uint32_t first = lights->first_set[i], count = lights->first_set[i + 1] - first;
        for (uint32_t g = 0; g < count; g++) {
            sl_voxel_set *set = &lights->set[first + g];
            set->leaf = (uint32_t)i;
            set->normal = count > 1 ? groups->groups[i][g].normal : octree->leaf[i].normal;
            set->centroid = count > 1 ? groups->groups[i][g].centroid : octree->leaf[i].centroid;
        }
    }
    return SL_OK;
}

static sl_status split_sets(sl_voxel_lights *lights, sl_error *error) {
    const sl_voxel_work *work = lights->work;
    group_task task = {.lights = lights,
                       .space = sl_cell_space_of(work->scene, work->geometry->origin, work->geometry->edge, work->geometry->depth),
                       .groups = sl_allocate(lights->leaf_count, sizeof *task.groups),
                       .count = sl_allocate(lights->leaf_count, 1)};
    sl_status status = task.groups && task.count ? SL_OK : sl_fail_memory(error, "normals of voxels");
    if (status == SL_OK) {
        sl_parallel_for(work->workers, (lights->leaf_count + LEAVES_A_TASK - 1) / LEAVES_A_TASK, group_leaves, &task);
        status = make_sets(lights, &task, error);
    }
    sl_free(task.groups);
    sl_free(task.count);
    return status;
}

sl_status sl_voxel_lights_create(const sl_scene *scene, const sl_octree *octree, const sl_octree *geometry, const sl_photon_tree *tree,
                                 const sl_voxel_light_options *options, unsigned threads, sl_voxel_lights **result, sl_error *error) {
    *result = NULL;
    sl_status status = check_options(options, error);
    if (status != SL_OK) return status;
    sl_voxel_lights *lights = sl_allocate(1, sizeof *lights);
    if (!lights) return sl_fail_memory(error, "lights of voxels");
    *lights = (sl_voxel_lights){.options = *options, .leaf_count = octree->leaf_count, .texels = sl_lobe_texels(options)};
    lights->work = sl_allocate(1, sizeof *lights->work);
    status = lights->work ? SL_OK : sl_fail_memory(error, "lights of voxels");
    if (status == SL_OK) {
        bool photons = tree && sl_photon_tree_list(tree)->count > 0;
        *lights->work = (sl_voxel_work){.scene = scene, .octree = octree, .geometry = geometry, .tree = photons ? tree : NULL};
        status = create_work(lights, threads, error);
    }
    if (status == SL_OK) status = options->split_by_normal ? split_sets(lights, error) : make_sets(lights, NULL, error);
    if (status != SL_OK) sl_voxel_lights_destroy(lights);
    else *result = lights;
    return status;
}

void sl_voxel_lights_destroy(sl_voxel_lights *lights) {
    if (!lights) return;
    destroy_work(lights->work);
    sl_free(lights->first_set);
    sl_free(lights->set);
    sl_free(lights->light);
    sl_free(lights);
}

size_t sl_voxel_lights_bytes(const sl_voxel_lights *lights) {
    const sl_voxel_work *work = lights->work;
    size_t bytes = sizeof *lights + sizeof *work + (lights->leaf_count + 1) * sizeof *lights->first_set;
    bytes += lights->set_count * (sizeof *lights->set + (size_t)lights->texels * sizeof *lights->light);
    bytes += work->parents ? sl_octree_bytes(work->parents) : 0;
    bytes += work->surroundings ? sl_surroundings_bytes(work->surroundings) : 0;
    size_t marks = work->surroundings ? work->scene->triangle_count * sizeof(uint32_t) : 0;
    return bytes + work->workers * (sizeof *work->worker + marks + lights->options.neighbours * 69);
}

/* ---- statistics ---- */

void sl_voxel_lights_statistics(const sl_voxel_lights *lights, const sl_octree *octree, sl_voxel_statistics *s) {
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
        s->max_radius = (double)set->radius > s->max_radius ? (double)set->radius : s->max_radius;
        s->max_power_ratio = (double)set->power_ratio > s->max_power_ratio ? (double)set->power_ratio : s->max_power_ratio;
        s->rms_angle += e * rms * rms;
        s->mean_angle += e * (double)set->mean_angle;
        s->flux += (double)set->density * (double)octree->leaf[set->leaf].area / (double)in_leaf;
        weight += e;
    }
    double lit = s->lit > 0 ? (double)s->lit : 1.0;
    s->mean_photons = s->sets > 0 ? (double)s->photons / (double)s->sets : 0.0;
    s->mean_radius /= lit;
    s->rms_angle = weight > 0.0 ? sqrt(s->rms_angle / weight) : 0.0;
    s->mean_angle = weight > 0.0 ? s->mean_angle / weight : 0.0;
    s->axis_angle = s->rms_angle * sqrt(0.5);
}
