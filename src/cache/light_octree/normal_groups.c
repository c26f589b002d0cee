#include "cache/light_octree/normal_groups.h"

#include "scene/bump.h"

static const double COS_45 = 0.70710678118654752;
/* 0.8 degrees, which directions of 8 + 8 bits are off by, too. */
static const double COS_FLAT = 0.9999;

/* Is light to be seen by this one normal alone? Gloss and bumps want its directions. */
static bool is_flat(const sl_scene *scene, uint32_t triangle) {
    const sl_material *m = &scene->materials[scene->material_index[triangle]];
    sl_vec3 n = sl_scene_geometric_normal(scene, triangle);
    bool flat = !sl_material_is_glossy(m) && !sl_material_is_bumpy(m);
    for (int k = 0; flat && k < 3; k++)
        flat = fabs((double)sl_dot(n, sl_scene_normal(scene, scene->vertex[k][triangle]))) >= COS_FLAT;
    return flat;
}

size_t sl_voxel_pieces_max(const sl_octree *octree) {
    size_t most = 0;
    for (size_t i = 0; i < octree->leaf_count; i++)
        most = octree->leaf[i].triangle_count > most ? octree->leaf[i].triangle_count : most;
    return most;
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
                                           is_flat(space->scene, number)};
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

int sl_normal_groups(const sl_cell_space *space, const sl_octree *octree, size_t index,
                     sl_voxel_piece *pieces, sl_normal_group groups[SL_VOXEL_SETS_MAX]) {
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
        groups[g].area = (float)(sums[g].area / (space->scale * space->scale));
    }
    return count;
}
