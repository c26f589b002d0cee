/* A voxel's photons, side by side, and the area A that they were strewn over: E = kappa sum Phi_i / A.
 * Where the k-th photon set the radius kappa is (k - 1) / k, since k / A would be k / (k - 1) times too much
 * on average; else it is 1. */
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/light_octree/voxel_work.h"

sl_photon_query sl_voxel_query(const sl_voxel_work *work, const sl_voxel_light_options *o, sl_vec3 centre,
                               sl_vec3 normal, double radius) {
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

/* The hull of a caustic tells of light, and not of surface. */
static bool tells_of_surface(const sl_photon *p) { return !(p->flags & SL_PHOTON_CAUSTIC); }

static void put_on_disc(sl_photon_places *p, float x, float y, double distance) {
    p->x[p->count] = x;
    p->y[p->count] = y;
    p->distance[p->count++] = distance;
}

/* Two passes, so that each side's photons stand together in order of their ids. */
static void split_sides(const sl_voxel_work *work, const sl_photon_query *query, sl_voxel_worker *w,
                        sl_voxel_gather *gather) {
    const sl_photon_list *list = sl_photon_tree_list(work->tree);
    sl_photon_places *on_disc = &w->places;
    w->photons.count = on_disc->count = on_disc->front = 0;
    size_t front = 0, seen = 0;
    sl_vec3d normals = {0}, places = {0};
    sl_frame frame = sl_frame_from_normal(query->normal);
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
            if (on_disc->x && tells_of_surface(p))
                put_on_disc(on_disc, sl_dot(place, frame.x), sl_dot(place, frame.y), w->gathered.distance[i]);
        }
        if (back == 0) {
            front = w->photons.count;
            on_disc->front = on_disc->count;
        }
    }
    gather->front = sl_lobe_photons_from(&w->photons, 0, front);
    gather->back = sl_lobe_photons_from(&w->photons, front, w->photons.count - front);
    double count = w->gathered.count > 0 ? (double)w->gathered.count : 1.0;
    gather->mean_normal = normals;
    gather->mean_place = sl_scaled(places, 1.0 / count);
}

/* ---- the photons in the voxel, without a search ---- */

/* The map as a histogram: each voxel counts the photons that lie in it, as in the paper's figure 16a. Where a
 * voxel clips a sliver of a plane it counts few, and such voxels make bands; the k nearest about the centroid
 * do not know what a voxel clips. */
static uint32_t leaf_of(const sl_octree *octree, const sl_photon *p) {
    sl_vec3 at = sl_v3(p->position[0], p->position[1], p->position[2]);
    const sl_octree_root root = {octree->origin, octree->edge};
    return sl_octree_root_holds(&root, at) ? sl_octree_find(octree, sl_octree_morton_at(octree, at))
                                           : SL_NO_INDEX;
}

void sl_own_photons_release(sl_own_photons *own) {
    sl_free(own->first);
    sl_free(own->place);
    *own = (sl_own_photons){NULL, NULL, 0};
}

/* Counting sort by leaf, in order of ids. */
sl_status sl_own_photons_find(const sl_octree *octree, const sl_photon_tree *tree, sl_own_photons *own,
                              sl_error *error) {
    const sl_photon_list *list = sl_photon_tree_list(tree);
    size_t leaves = octree->leaf_count;
    uint32_t *leaf = sl_allocate(list->count, sizeof *leaf), *by_id = sl_allocate(list->count, sizeof *by_id);
    own->first = sl_allocate(leaves + 2, sizeof *own->first);
    own->place = sl_allocate(list->count, sizeof *own->place);
    bool good = leaf && by_id && own->first && own->place;
    for (size_t i = 0; good && i < list->count; i++) by_id[sl_photon_tree_id(tree, i)] = (uint32_t)i;
    for (size_t id = 0; good && id < list->count; id++) {
        leaf[id] = leaf_of(octree, &list->photon[by_id[id]]);
        if (leaf[id] != SL_NO_INDEX) own->first[leaf[id] + 2]++; /* else rounding has put it outside */
    }
    for (size_t i = 0; good && i < leaves; i++) {
        own->most = own->first[i + 2] > own->most ? own->first[i + 2] : own->most;
        own->first[i + 2] += own->first[i + 1];
    }
    for (size_t id = 0; good && id < list->count; id++) {
        if (leaf[id] != SL_NO_INDEX) own->place[own->first[leaf[id] + 1]++] = by_id[id];
    }
    sl_free(leaf);
    sl_free(by_id);
    if (!good) sl_own_photons_release(own);
    return good ? SL_OK : sl_fail_memory(error, "the photons of voxels");
}

sl_voxel_gather sl_voxel_own_photons(const sl_voxel_work *work, const sl_voxel_set *set,
                                     const sl_photon_query *query, sl_voxel_worker *w) {
    const sl_octree_leaf *leaf = &work->octree->leaf[set->leaf];
    uint32_t first = work->own.first[set->leaf];
    double voxel = sl_octree_voxel(work->octree);
    bool touched = !((double)leaf->area > 1e-6 * voxel * voxel); /* but by rounding nothing is in it */
    w->gathered.count = touched ? 0 : work->own.first[set->leaf + 1] - first;
    for (size_t i = 0; i < w->gathered.count; i++) w->gathered.place[i] = work->own.place[first + i];
    sl_voxel_gather gather = {.found = w->gathered.count, .kappa = 1.0};
    gather.ellipsoid = (sl_ellipsoid){sl_to_double(query->centre), sl_to_double(query->normal),
                                      query->flatness, sqrt((double)leaf->area / SL_PI)};
    split_sides(work, query, w, &gather);
    return gather;
}

/* ---- the nearest photons ---- */

size_t sl_voxel_most_neighbours(const sl_voxel_light_options *o) {
    return o->neighbours < SL_NEIGHBOURS_MAX ? o->neighbours : SL_NEIGHBOURS_MAX;
}

sl_voxel_gather sl_voxel_gather_photons(const sl_voxel_work *work, const sl_photon_query *query,
                                        sl_voxel_worker *w) {
    sl_photon_tree_gather(work->tree, query, &w->gathered);
    size_t found = w->gathered.count;
    sl_voxel_gather gather = {.found = found,
                              .kappa =
                                  w->gathered.full && found > 0 ? (double)(found - 1) / (double)found : 1.0,
                              .ellipsoid = {sl_to_double(query->centre), sl_to_double(query->normal),
                                            query->flatness, w->gathered.radius}};
    split_sides(work, query, w, &gather);
    return gather;
}

/* ---- the area that they were strewn over ---- */

/* Returns what share of a side's surface its photons were strewn over, by their hull. Of nearer ones than
 * were gathered, if the ellipsoid is smaller. */
static double share_by_hull(sl_photon_places *p, const sl_ellipsoid *e, int side, double flat) {
    double limit = e->radius * e->radius * (1.0 + 1e-9);
    size_t first = side ? p->front : 0, end = side ? p->count : p->front;
    p->hull.count = 0;
    for (size_t i = first; i < end; i++) {
        p->hull.x[p->hull.count] = p->x[i];
        p->hull.y[p->hull.count] = p->y[i];
        p->hull.count += p->distance[i] <= limit;
    }
    sl_photon_hull hull = sl_photon_hull_of(&p->hull);
    return sl_photon_hull_share(&hull, p->hull.count, flat);
}

/* The scene's triangles in the ellipsoid, less surface that no photon met. */
static sl_voxel_area clipped_area(const sl_voxel_work *work, const sl_ellipsoid *e, sl_voxel_worker *w) {
    double least_cosine = work->by_side ? work->cos_acceptance : -1.0;
    sl_strewn_area a = sl_surface_in_ellipsoid(work->scene, work->octree, e, least_cosine, &w->marks);
    for (int side = 0; side < 2 && work->by_side && sl_dotd(e->normal, e->normal) > 0.0; side++)
        a.side[side] *= share_by_hull(&w->places, e, side, a.flat[side]);
    return (sl_voxel_area){{a.side[0], a.side[1]},
                           a.together ? fmax(a.side[0], a.side[1]) : a.side[0] + a.side[1]};
}

sl_voxel_area sl_voxel_areas(const sl_voxel_work *work, const sl_voxel_light_options *o,
                             const sl_voxel_gather *gather, sl_voxel_worker *w) {
    const sl_ellipsoid *e = &gather->ellipsoid;
    double disc = sl_disc_area(e);
    sl_voxel_area area = {{disc, disc}, 0.0};
    if (work->clip) area = clipped_area(work, e, w);
    else if (o->area == SL_PHOTON_AREA_SECTION && !o->own_photons) {
        double length = sl_lengthd(gather->mean_normal);
        sl_vec3d n = length > 0.0 ? sl_scaled(gather->mean_normal, 1.0 / length) : e->normal;
        area.side[0] = area.side[1] = sl_section_area(e, n, sl_dotd(n, gather->mean_place));
    }
    for (int side = 0; side < 2; side++) {
        if (!(area.side[side] > 1e-3 * disc)) area.side[side] = disc;
    }
    if (!(area.all > 1e-3 * disc)) area.all = area.side[0];
    return area;
}
