/* Which sets of lights a voxel has. Voxels are split by normal, which the paper does not do: one at an edge
 * holds surfaces that see different light. */
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/light_octree/voxel_lights.h"
#include "scene/bump.h"

/* ---- groups of normals in a voxel ---- */

typedef struct normal_group {
    sl_vec3 normal, centroid; /* by area, of what lies in the voxel */
    bool flat;                /* all its pieces are, and of one normal */
} normal_group;

static const double COS_45 = 0.70710678118654752;
/* 0.8 degrees, which directions of 8 + 8 bits are off by, too. */
static const double COS_FLAT = 0.9999;

/* Is light to be seen by this one normal alone? Gloss and bumps want its directions. */
static bool is_flat_triangle(const sl_scene *scene, uint32_t triangle) {
    const sl_material *m = &scene->materials[scene->material_index[triangle]];
    sl_vec3 n = sl_scene_geometric_normal(scene, triangle);
    bool flat = !sl_material_is_glossy(m) && !sl_material_is_bumpy(m);
    for (int k = 0; flat && k < 3; k++)
        flat = fabs((double)sl_dot(n, sl_scene_normal(scene, scene->vertex[k][triangle]))) >= COS_FLAT;
    return flat;
}

static size_t collect(const sl_cell_space *space, const sl_octree *octree, const sl_octree_leaf *leaf,
                      const uint32_t cell[3], sl_voxel_piece *pieces) {
    size_t count = 0;
    sl_vec3d base = sl_v3d(cell[0], cell[1], cell[2]);
    for (uint32_t i = 0; i < leaf->triangle_count; i++) {
        uint32_t number = octree->triangle[leaf->first_triangle + i];
        sl_cell_triangle t = sl_cell_space_triangle(space, number);
        sl_triangle_part part;
        double area = sl_clip_to_cell(space, &t, cell, 0.0, &part), length = sl_lengthd(t.normal);
        area *= sl_takes_photons(&space->scene->materials[space->scene->material_index[number]]) ? part.area
                                                                                                 : 0.0;
        if (!(area > 0.0 && length > 0.0)) continue;
        pieces[count++] = (sl_voxel_piece){sl_scaled(t.normal, 1.0 / length),
                                           sl_scaled(sl_subd(part.centroid, base), area), area, -1,
                                           is_flat_triangle(space->scene, number)};
    }
    return count;
}

/* Of a voxel: layers of one normal that lie farther apart are two groups. A flat gather as wide as the voxel
 * is no thicker. */
static const double layers_apart = 0.25;

typedef struct group_sum {
    sl_vec3d seed, vector, moment;
    double height;            /* of the seed along its normal */
    double area;
    bool flat;
} group_sum;

static void join_group(group_sum *sums, int group, sl_voxel_piece *piece) {
    piece->group = group;
    sums[group].flat =
        sums[group].flat && piece->flat && sl_dotd(piece->normal, sums[group].seed) >= COS_FLAT;
    sums[group].area += piece->area;
    sums[group].vector = sl_addd(sums[group].vector, sl_scaled(piece->normal, piece->area));
    sums[group].moment = sl_addd(sums[group].moment, piece->moment);
}

/* Above the seed, in cells. */
static double height_above(const group_sum *sum, const sl_voxel_piece *piece) {
    return sl_dotd(sum->seed, piece->moment) / piece->area - sum->height;
}

static bool belongs_to(const group_sum *sum, const sl_voxel_piece *piece) {
    return sl_dotd(piece->normal, sum->seed) >= COS_45 && fabs(height_above(sum, piece)) <= layers_apart;
}

static void join_nearest(group_sum *sums, int groups, sl_voxel_piece *piece) {
    int best = 0;
    double most = -INFINITY;
    for (int g = 0; g < groups; g++) {
        double nearness = sl_dotd(sums[g].seed, piece->normal) - fabs(height_above(&sums[g], piece));
        if (nearness > most) best = g;
        most = fmax(most, nearness);
    }
    join_group(sums, best, piece);
}

/* Returns whether a group was started and is worth keeping; what is not goes to others at the end. */
static bool start_group(group_sum *sums, int groups, sl_voxel_piece *pieces, size_t count, double least) {
    size_t seed = count;
    for (size_t i = 0; i < count; i++) {
        if (pieces[i].group < 0 && (seed == count || pieces[i].area > pieces[seed].area)) seed = i;
    }
    if (seed == count) return false;
    sums[groups] = (group_sum){.seed = pieces[seed].normal, .flat = true};
    sums[groups].height = height_above(&sums[groups], &pieces[seed]);
    double area = 0.0;
    for (size_t i = 0; i < count; i++) {
        if (pieces[i].group < 0 && belongs_to(&sums[groups], &pieces[i])) area += pieces[i].area;
    }
    if (groups > 0 && area < least) return false;
    for (size_t i = 0; i < count; i++) {
        if (pieces[i].group < 0 && belongs_to(&sums[groups], &pieces[i]))
            join_group(sums, groups, &pieces[i]);
    }
    return true;
}

/* Greedy: the largest piece not yet in a group starts one, and all within 45 degrees of it join that lie at
 * about its height: a floor and the ground below it see different light. What is left after
 * SL_VOXEL_SETS_MAX, and groups below a hundredth of the area, go to the nearest. Returns how many, largest
 * first seed first; 0 where nothing has an area. */
static int group_normals(const sl_cell_space *space, const sl_octree *octree, size_t index,
                         sl_voxel_piece *pieces, normal_group groups[SL_VOXEL_SETS_MAX]) {
    uint32_t cell[3];
    sl_morton_decode(octree->leaf[index].morton, cell);
    double total = 0.0;
    sl_vec3d base = sl_v3d(cell[0], cell[1], cell[2]);
    size_t pieces_here = collect(space, octree, &octree->leaf[index], cell, pieces);
    for (size_t i = 0; i < pieces_here; i++) total += pieces[i].area;
    group_sum sums[SL_VOXEL_SETS_MAX];
    int count = 0;
    while (count < SL_VOXEL_SETS_MAX &&
           start_group(sums, count, pieces, pieces_here, 0.01 * total))
        count++;
    for (size_t i = 0; count > 0 && i < pieces_here; i++) {
        if (pieces[i].group < 0) join_nearest(sums, count, &pieces[i]);
    }
    for (int g = 0; g < count; g++) {
        double length = sl_lengthd(sums[g].vector);
        sl_vec3d centre = sl_addd(base, sl_scaled(sums[g].moment, 1.0 / sums[g].area));
        groups[g].normal =
            sl_to_float(length > 0.2 * sums[g].area ? sl_scaled(sums[g].vector, 1.0 / length) : sums[g].seed);
        groups[g].centroid = sl_to_float(sl_addd(sl_scaled(centre, 1.0 / space->scale), space->origin));
        groups[g].flat = sums[g].flat;
    }
    return count;
}

/* ---- all voxels ---- */

typedef struct group_task {
    sl_voxel_lights *lights;
    sl_cell_space space;
    normal_group (*groups)[SL_VOXEL_SETS_MAX];
    uint8_t *count;
} group_task;

static void group_leaves(void *context, size_t index, unsigned worker) {
    const group_task *task = context;
    const sl_voxel_lights *lights = task->lights;
    size_t end = (index + 1) * SL_LEAVES_A_TASK < lights->leaf_count ? (index + 1) * SL_LEAVES_A_TASK
                                                                     : lights->leaf_count;
    for (size_t leaf = index * SL_LEAVES_A_TASK; leaf < end; leaf++) {
        task->count[leaf] = (uint8_t)group_normals(&task->space, lights->octree, leaf,
                                                   lights->worker[worker].pieces, task->groups[leaf]);
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
    const sl_octree *octree = lights->octree;
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
    group_task task = {.lights = lights,
                       .space = sl_cell_space_of(lights->scene, lights->octree->origin, lights->octree->edge,
                                                 lights->octree->depth),
                       .groups = sl_allocate(lights->leaf_count, sizeof *task.groups),
                       .count = sl_allocate(lights->leaf_count, 1)};
    sl_status status = task.groups && task.count ? SL_OK : sl_fail_memory(error, "normals of voxels");
    if (status == SL_OK) {
        sl_parallel_for(lights->workers, (lights->leaf_count + SL_LEAVES_A_TASK - 1) / SL_LEAVES_A_TASK,
                        group_leaves, &task);
        status = make_sets(lights, &task, error);
    }
    sl_free(task.groups);
    sl_free(task.count);
    return status;
}

sl_status sl_voxel_sets_create(sl_voxel_lights *lights, sl_error *error) {
    return lights->options.split_by_normal ? split_sets(lights, error) : make_sets(lights, NULL, error);
}
