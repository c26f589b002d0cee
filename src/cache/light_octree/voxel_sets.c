/* Which sets of lights a voxel has, and memory for them all. */
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/light_octree/voxel_work.h"

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

static sl_status create_places(size_t k, sl_photon_places *p, sl_error *error) {
    p->x = sl_allocate(2 * k, sizeof *p->x);
    p->distance = sl_allocate(k, sizeof *p->distance);
    if (!p->x || !p->distance) return sl_fail_memory(error, "gathered photons");
    p->y = p->x + k;
    return sl_hull_points_create(k, &p->hull, error);
}

static sl_status create_worker(const sl_voxel_lights *lights, size_t pieces, sl_voxel_worker *w,
                               sl_error *error) {
    size_t k =
        lights->options.own_photons ? lights->work->own.most : sl_voxel_most_neighbours(&lights->options);
    w->gathered.place = sl_allocate(k, sizeof *w->gathered.place);
    w->gathered.distance = sl_allocate(k, sizeof *w->gathered.distance);
    w->gathered.keys = sl_allocate(sl_photon_keys(k), sizeof *w->gathered.keys);
    if (lights->work->clip)
        w->marks.mark = sl_allocate(lights->work->scene->triangle_count, sizeof *w->marks.mark);
    if (pieces > 0) w->pieces = sl_allocate(pieces, sizeof *w->pieces);
    bool good = w->gathered.place && w->gathered.distance && w->gathered.keys &&
                (w->marks.mark || !lights->work->clip) && (w->pieces || pieces == 0);
    sl_status status =
        good ? sl_lobe_photons_create(k, &w->photons, error) : sl_fail_memory(error, "gathered photons");
    return status == SL_OK && lights->work->clip ? create_places(k, &w->places, error) : status;
}

static void destroy_work(sl_voxel_work *work) {
    if (!work) return;
    for (unsigned i = 0; work->worker && i < work->workers; i++) {
        sl_voxel_worker *w = &work->worker[i];
        sl_free(w->gathered.place);
        sl_free(w->gathered.distance);
        sl_free(w->gathered.keys);
        sl_free(w->marks.mark);
        sl_free(w->pieces);
        sl_lobe_photons_release(&w->photons);
        sl_hull_points_release(&w->places.hull);
        sl_free(w->places.x);
        sl_free(w->places.distance);
    }
    sl_free(work->worker);
    sl_own_photons_release(&work->own);
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
    if (status == SL_OK && o->own_photons && work->tree)
        status = sl_own_photons_find(work->octree, work->tree, &work->own, error);
    work->clip = o->area == SL_PHOTON_AREA_CLIP && !o->own_photons;
    size_t pieces = o->split_by_normal ? sl_voxel_pieces_max(work->octree) : 0;
    for (unsigned i = 0; status == SL_OK && i < work->workers; i++)
        status = create_worker(lights, pieces, &work->worker[i], error);
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
    size_t end = (index + 1) * SL_LEAVES_A_TASK < task->lights->leaf_count ? (index + 1) * SL_LEAVES_A_TASK
                                                                           : task->lights->leaf_count;
    for (size_t leaf = index * SL_LEAVES_A_TASK; leaf < end; leaf++) {
        task->count[leaf] = (uint8_t)sl_normal_groups(&task->space, work->octree, leaf,
                                                      work->worker[worker].pieces, task->groups[leaf]);
    }
}

/* Only where no group of the voxel is bent: what bends away from a flat piece takes that piece's light, too.
 */
static bool is_flat(const group_task *groups, size_t leaf) {
    bool flat = groups && groups->count[leaf] > 0;
    for (int g = 0; flat && g < groups->count[leaf]; g++) flat = groups->groups[leaf][g].flat;
    return flat;
}

static void compare_sets(sl_voxel_set *sets, uint32_t count, uint32_t which) {
    for (uint32_t g = 0; g < count; g++) {
        float cosine = sl_dot(sets[g].normal, sets[which].normal);
        sets[which].opposed = sets[which].opposed || cosine < -0.5f;
        sets[which].layered = sets[which].layered || (g != which && cosine > 0.5f);
    }
}

/* As pixels tell their own: from the middle of the voxel. */
static float height_in_voxel(const sl_octree *octree, const sl_voxel_set *set) {
    uint32_t cell[3];
    sl_morton_decode(octree->leaf[set->leaf].morton, cell);
    sl_vec3d at =
        sl_scaled(sl_subd(sl_to_double(set->centroid), octree->origin), 1.0 / sl_octree_voxel(octree));
    return (float)sl_dotd(sl_to_double(set->normal),
                          sl_subd(at, sl_v3d(cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5)));
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
            set->flat = is_flat(groups, i);
            set->centroid = count > 1 ? groups->groups[i][g].centroid : octree->leaf[i].centroid;
        }
        for (uint32_t g = 0; g < count; g++) {
            compare_sets(&lights->set[first], count, g);
            lights->set[first + g].height = height_in_voxel(octree, &lights->set[first + g]);
        }
    }
    return SL_OK;
}

static sl_status split_sets(sl_voxel_lights *lights, sl_error *error) {
    const sl_voxel_work *work = lights->work;
    group_task task = {.lights = lights,
                       .space = sl_cell_space_of(work->scene, work->octree->origin, work->octree->edge,
                                                 work->octree->depth),
                       .groups = sl_allocate(lights->leaf_count, sizeof *task.groups),
                       .count = sl_allocate(lights->leaf_count, 1)};
    sl_status status = task.groups && task.count ? SL_OK : sl_fail_memory(error, "normals of voxels");
    if (status == SL_OK) {
        sl_parallel_for(work->workers, (lights->leaf_count + SL_LEAVES_A_TASK - 1) / SL_LEAVES_A_TASK,
                        group_leaves, &task);
        status = make_sets(lights, &task, error);
    }
    sl_free(task.groups);
    sl_free(task.count);
    return status;
}

sl_status sl_voxel_lights_create(const sl_scene *scene, const sl_octree *octree,
                                 const sl_photon_tree *tree, const sl_voxel_light_options *options,
                                 unsigned threads, sl_voxel_lights **result, sl_error *error) {
    *result = NULL;
    sl_status status = check_options(options, error);
    if (status != SL_OK) return status;
    sl_voxel_lights *lights = sl_allocate(1, sizeof *lights);
    if (!lights) return sl_fail_memory(error, "lights of voxels");
    *lights = (sl_voxel_lights){
        .options = *options, .leaf_count = octree->leaf_count, .texels = sl_lobe_texels(options)};
    lights->work = sl_allocate(1, sizeof *lights->work);
    status = lights->work ? SL_OK : sl_fail_memory(error, "lights of voxels");
    if (status == SL_OK) {
        bool photons = tree && sl_photon_tree_list(tree)->count > 0;
        *lights->work = (sl_voxel_work){
            .scene = scene, .octree = octree, .tree = photons ? tree : NULL};
        status = create_work(lights, threads, error);
    }
    if (status == SL_OK)
        status = options->split_by_normal ? split_sets(lights, error) : make_sets(lights, NULL, error);
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
    size_t marks = work->clip ? work->scene->triangle_count * sizeof(uint32_t) : 0;
    size_t a_photon = work->clip ? 89 : 53; /* with its place for the hull, or without */
    return bytes + work->workers *
                       (sizeof *work->worker + marks + sl_voxel_most_neighbours(&lights->options) * a_photon);
}
