/* Which sets of lights a voxel has, by what lies in it. Voxels are split by normal, which the paper does not
 * do: one at an edge holds surfaces that see different light. */
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/light_octree/voxel_lights.h"
#include "scene/bump.h"

static const double COS_45 = 0.70710678118654752;
/* 0.8 degrees, which directions of 8 + 8 bits are off by, too. */
static const double COS_FLAT = 0.9999;
/* Of a voxel: layers of one normal that lie farther apart are two groups. A flat gather as wide as the voxel
 * is no thicker. */
static const double LAYERS_APART = 0.25;

/* ---- what lies in a voxel ---- */

/* A triangle's part. */
typedef struct voxel_piece {
    sl_vec3d normal, centroid; /* unit; in cells, about the voxel's first corner */
    double area;               /* square cells */
    int group;
    bool flat;                 /* one shading normal, and it reflects light of all directions alike */
} voxel_piece;

typedef struct grouping {
    const sl_voxel_lights *lights;
    sl_cell_space space;
    size_t room;                               /* pieces of a worker */
    voxel_piece *pieces;
    sl_voxel_set (*sets)[SL_VOXEL_SETS_MAX];   /* of each leaf */
    uint8_t *count;
} grouping;

/* Tells whether it lies in a face of the cell: both voxels there have it. */
static bool in_face(const sl_triangle_part *part, sl_vec3d low, double face) {
    for (int axis = 0; axis < 3; axis++) {
        double lower = INFINITY, upper = -INFINITY;
        for (int k = 0; k < part->count; k++) {
            double x = sl_along(part->corner[k], axis) - sl_along(low, axis);
            lower = fmin(lower, x);
            upper = fmax(upper, x);
        }
        if (upper <= face || lower >= 1.0 - face) return true;
    }
    return false;
}

/* Finds a triangle's part in a cell. Returns the share of its area that belongs to that cell: half, if it
 * lies in a face. */
static double clip_to_cell(const sl_cell_space *space, const sl_cell_triangle *triangle,
                           const uint32_t cell[3], double dilate, sl_triangle_part *part) {
    sl_vec3d low = sl_v3d(cell[0], cell[1], cell[2]), high = sl_addd(low, sl_v3d(1.0, 1.0, 1.0));
    double g = dilate + space->tolerance;
    sl_vec3d margin = sl_v3d(g, g, g);
    sl_triangle_in_box(triangle, sl_subd(low, margin), sl_addd(high, margin), part);
    if (part->count == 0 || dilate > 0.0) return 1.0;
    if (in_face(part, low, 2.0 * space->tolerance)) return 0.5;
    sl_triangle_part within;
    sl_triangle_in_box(triangle, low, high, &within); /* else neighbours would share the margin */
    if (within.count > 0) *part = within;
    return 1.0;
}

/* Tells whether light is to be seen by this one normal alone. Gloss and bumps want its directions. */
static bool is_flat_triangle(const sl_scene *scene, uint32_t triangle) {
    const sl_material *m = sl_triangle_material(scene, triangle);
    sl_vec3 n = sl_scene_geometric_normal(scene, triangle);
    bool flat = !sl_material_is_glossy(m) && !sl_material_is_bumpy(m);
    for (int k = 0; flat && k < 3; k++)
        flat = fabs((double)sl_dot(n, sl_scene_normal(scene, scene->vertex[k][triangle]))) >= COS_FLAT;
    return flat;
}

/* Lists a voxel's pieces of surfaces that take photons. By area, so that normals and centroids do not depend
 * on how a surface is cut into triangles; where surfaces only touch the voxel, all that touch count alike.
 * Returns their area. */
static double collect(const grouping *g, const sl_octree_leaf *leaf, voxel_piece *pieces, size_t *count) {
    const sl_scene *scene = g->space.scene;
    uint32_t cell[3];
    sl_morton_decode(leaf->morton, cell);
    sl_vec3d base = sl_v3d(cell[0], cell[1], cell[2]);
    double area = 0.0;
    size_t found = 0;
    for (uint32_t i = 0; i < leaf->triangle_count; i++) {
        uint32_t number = g->lights->octree->triangle[leaf->first_triangle + i];
        sl_cell_triangle t = sl_cell_space_triangle(&g->space, number);
        sl_triangle_part part;
        double share = clip_to_cell(&g->space, &t, cell, g->lights->octree->dilation, &part),
               length = sl_lengthd(t.normal);
        if (part.count == 0 || !(length > 0.0)) continue;
        if (!sl_takes_photons(sl_triangle_material(scene, number))) share = 0.0;
        pieces[found++] =
            (voxel_piece){sl_scaled(t.normal, 1.0 / length), sl_subd(part.centroid, base), share * part.area,
                          -1, is_flat_triangle(scene, number)};
        area += pieces[found - 1].area;
    }
    *count = 0;
    for (size_t i = 0; i < found; i++) {
        if (!(area > 0.0)) pieces[i].area = 1.0;
        if (pieces[i].area > 0.0) pieces[(*count)++] = pieces[i];
    }
    return area;
}

/* ---- groups of normals in it ---- */

typedef struct group_sum {
    sl_vec3d seed, vector, moment;
    double height;            /* of the seed along its normal */
    double area;
    bool flat;                /* all its pieces are, and of one normal */
} group_sum;

static void join_group(group_sum *sums, int group, voxel_piece *piece) {
    group_sum *s = &sums[group];
    piece->group = group;
    s->flat = s->flat && piece->flat && sl_dotd(piece->normal, s->seed) >= COS_FLAT;
    s->area += piece->area;
    s->vector = sl_addd(s->vector, sl_scaled(piece->normal, piece->area));
    s->moment = sl_addd(s->moment, sl_scaled(piece->centroid, piece->area));
}

/* Above the seed, in cells. */
static double height_above(const group_sum *sum, const voxel_piece *piece) {
    return sl_dotd(sum->seed, piece->centroid) - sum->height;
}

static bool belongs_to(const group_sum *sum, const voxel_piece *piece) {
    return sl_dotd(piece->normal, sum->seed) >= COS_45 && fabs(height_above(sum, piece)) <= LAYERS_APART;
}

static void join_nearest(group_sum *sums, int groups, voxel_piece *piece) {
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
static bool start_group(group_sum *sums, int groups, voxel_piece *pieces, size_t count, double least) {
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
 * first seed first. */
static int group_pieces(voxel_piece *pieces, size_t count, double area, group_sum *sums) {
    int groups = 0;
    while (groups < SL_VOXEL_SETS_MAX && start_group(sums, groups, pieces, count, 0.01 * area)) groups++;
    for (size_t i = 0; groups > 0 && i < count; i++) {
        if (pieces[i].group < 0) join_nearest(sums, groups, &pieces[i]);
    }
    return groups;
}

/* ---- sets of them ---- */

/* n_v, c_v and area; of a whole voxel no normal where |sum area n| < 0.2 sum area. */
static sl_voxel_set set_of(const grouping *g, size_t leaf, const group_sum *s, bool split, double surface) {
    uint32_t cell[3];
    sl_morton_decode(g->lights->octree->leaf[leaf].morton, cell);
    double length = sl_lengthd(s->vector), area = s->area > 0.0 ? s->area : 1.0, scale = g->space.scale;
    bool turned = length > 0.0 && length >= 0.2 * s->area;
    sl_vec3d normal = turned  ? sl_scaled(s->vector, 1.0 / length)
                      : split ? s->seed
                              : sl_v3d(0.0, 0.0, 0.0),
             at = sl_scaled(s->moment, 1.0 / area), base = sl_v3d(cell[0], cell[1], cell[2]);
    return (sl_voxel_set){
        .leaf = (uint32_t)leaf,
        .normal = sl_to_float(normal),
        .centroid = sl_to_float(sl_addd(sl_scaled(sl_addd(base, at), 1.0 / scale), g->space.origin)),
        .height = (float)sl_dotd(normal, sl_subd(at, sl_v3d(0.5, 0.5, 0.5))),
        .surface = surface > 0.0 ? (float)(s->area / (scale * scale)) : 0.0f};
}

static void compare_sets(sl_voxel_set *sets, int count, int which) {
    for (int g = 0; g < count; g++) {
        float cosine = sl_dot(sets[g].normal, sets[which].normal);
        sets[which].opposed = sets[which].opposed || cosine < -0.5f;
        sets[which].layered = sets[which].layered || (g != which && cosine > 0.5f);
    }
}

static void find_sets(void *context, size_t leaf, unsigned worker) {
    const grouping *g = context;
    voxel_piece *pieces = g->pieces + worker * g->room;
    sl_voxel_set *sets = g->sets[leaf];
    group_sum sums[SL_VOXEL_SETS_MAX];
    size_t count;
    double area = collect(g, &g->lights->octree->leaf[leaf], pieces, &count);
    const bool split = g->lights->split && area > 0.0;
    int groups = split ? group_pieces(pieces, count, area, sums) : 1;
    sums[0] = split ? sums[0] : (group_sum){.seed = {0.0, 0.0, 0.0}};
    for (size_t i = 0; !split && i < count; i++) join_group(sums, 0, &pieces[i]);
    bool flat = split; /* what bends away from a flat piece takes that piece's light, too */
    for (int k = 0; k < groups; k++) {
        sets[k] = set_of(g, leaf, &sums[k], split, area);
        flat = flat && sums[k].flat;
    }
    for (int k = 0; k < groups; k++) {
        sets[k].flat = flat;
        compare_sets(sets, groups, k);
    }
    g->count[leaf] = (uint8_t)groups;
}

static sl_status list_sets(sl_voxel_lights *lights, const grouping *g, sl_error *error) {
    size_t sets = 0;
    lights->first_set = sl_allocate(lights->leaf_count + 1, sizeof *lights->first_set);
    for (size_t i = 0; lights->first_set && i < lights->leaf_count; i++)
        lights->first_set[i + 1] = (uint32_t)(sets += g->count[i]);
    lights->set_count = sets;
    lights->set = sl_allocate(sets, sizeof *lights->set);
    lights->light = sl_allocate(sets * (size_t)lights->texels, sizeof *lights->light);
    if (!lights->first_set || !lights->set || !lights->light)
        return sl_fail_memory(error, "lights of voxels");
    for (size_t i = 0; i < lights->leaf_count; i++)
        memcpy(lights->set + lights->first_set[i], g->sets[i], g->count[i] * sizeof *lights->set);
    return SL_OK;
}

sl_status sl_voxel_sets_create(sl_voxel_lights *lights, sl_error *error) {
    const sl_octree *octree = lights->octree;
    grouping g = {.lights = lights,
                  .space = sl_cell_space_of(lights->scene, octree->origin, octree->edge, octree->depth)};
    for (size_t i = 0; i < lights->leaf_count; i++) {
        size_t here = octree->leaf[i].triangle_count;
        g.room = here > g.room ? here : g.room;
    }
    g.pieces = sl_allocate_unset(lights->workers * g.room, sizeof *g.pieces);
    g.sets = sl_allocate(lights->leaf_count, sizeof *g.sets);
    g.count = sl_allocate(lights->leaf_count, 1);
    sl_status status = g.pieces && g.sets && g.count ? SL_OK : sl_fail_memory(error, "normals of voxels");
    if (status == SL_OK) {
        sl_parallel_for(lights->workers, lights->leaf_count, find_sets, &g);
        status = list_sets(lights, &g, error);
    }
    SL_FREE_ALL(g.pieces, g.sets, g.count);
    return status;
}
