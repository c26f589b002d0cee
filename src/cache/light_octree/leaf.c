/* One set of lights, step by step: photons around a voxel are gathered, the area that they were strewn over
 * is found, and K-means condenses their directions to a few virtual directional lights. */
#include <string.h>

#include "base/counters.h"
#include "base/math.h"
#include "cache/light_octree/voxel_lights.h"

/* ---- Photons: the k nearest to the centroid of the voxel's surfaces, in a flat ellipsoid ---- */

sl_photon_query sl_voxel_query(const sl_voxel_lights *lights, sl_vec3 centre, sl_vec3 normal) {
    const sl_light_octree_settings *o = &lights->options;
    bool has_normal = sl_dot(normal, normal) > 0.0f, by_side = has_normal && lights->by_side;
    return (sl_photon_query){.centre = centre,
                             .normal = normal,
                             .flatness = has_normal ? o->flatness : 1.0,
                             .radius = lights->radius,
                             .minimum = 1e-3 * lights->radius,
                             .cos_acceptance = by_side ? lights->cos_acceptance : -1.0,
                             .both_sides = by_side,
                             .neighbours = (size_t)o->neighbours};
}

/* Takes the photons of one side, in order of their ids, and their places on the ellipsoid's disc; a caustic's
 * tell of light, not of surface. */
static void take_side(const sl_voxel_lights *lights, const sl_photon_query *query, bool back,
                      sl_voxel_worker *w, sl_voxel_gather *gather) {
    const sl_photon_list *list = sl_photon_tree_list(lights->tree);
    sl_frame frame = sl_frame_from_normal(query->normal);
    for (size_t i = 0; i < w->gathered.count; i++) {
        const sl_photon *p = &list->photon[w->gathered.place[i]];
        sl_vec3 n = sl_octahedral_decode(p->normal);
        bool behind = query->both_sides && sl_dot(n, query->normal) < 0.0f;
        if (behind != back) continue;
        sl_lobe_photons_add(&gather->side[back], sl_octahedral_decode(p->direction), n, p->flux);
        sl_vec3 place = sl_sub(sl_v3(p->position[0], p->position[1], p->position[2]), query->centre);
        gather->mean_place = sl_addd(gather->mean_place, sl_to_double(place));
        gather->mean_normal = sl_addd(gather->mean_normal, sl_scaled(sl_to_double(n), behind ? -1.0 : 1.0));
        gather->taken++;
        if (!(p->flags & SL_PHOTON_CAUSTIC))
            sl_place_sums_add(&gather->places[back], (double)sl_dot(place, frame.x),
                              (double)sl_dot(place, frame.y));
    }
}

static void take_photons(const sl_voxel_lights *lights, const sl_photon_query *query, sl_voxel_worker *w,
                         sl_voxel_gather *gather) {
    for (int side = 0; side < 2; side++) {
        gather->side[side] = sl_lobe_photons_in(&w->photons, side ? gather->side[0].count : 0);
        if (gather->taken < w->gathered.count) take_side(lights, query, side, w, gather);
    }
    double count = w->gathered.count > 0 ? (double)w->gathered.count : 1.0;
    gather->mean_place = sl_scaled(gather->mean_place, 1.0 / count);
}

/* Where the k-th photon set the radius kappa is (k - 1) / k, since k / A would be k / (k - 1) times too much
 * on average; else it is 1. */
sl_voxel_gather sl_voxel_gather_photons(const sl_voxel_lights *lights, const sl_photon_query *query,
                                        sl_voxel_worker *w) {
    sl_photon_tree_gather(lights->tree, query, &w->gathered);
    size_t found = w->gathered.count;
    sl_voxel_gather gather = {.found = found,
                              .kappa =
                                  w->gathered.full && found > 0 ? (double)(found - 1) / (double)found : 1.0,
                              .ellipsoid = {sl_to_double(query->centre), sl_to_double(query->normal),
                                            query->flatness, w->gathered.radius}};
    take_photons(lights, query, w, &gather);
    return gather;
}

/* The map as a histogram: each voxel counts the photons that lie in it, as in the paper's figure 16a, of the
 * SL_NEIGHBOURS_MAX nearest to its middle. Where a voxel clips a sliver of a plane it counts few, and such
 * voxels make bands; the k nearest about the centroid do not know what a voxel clips. */
static sl_voxel_gather own_photons(const sl_voxel_lights *lights, const sl_voxel_set *set,
                                   const sl_photon_query *query, sl_voxel_worker *w) {
    const sl_octree *octree = lights->octree;
    const sl_photon_list *list = sl_photon_tree_list(lights->tree);
    const uint64_t morton = octree->leaf[set->leaf].morton;
    double voxel = sl_octree_voxel(octree);
    uint32_t cell[3];
    sl_morton_decode(morton, cell);
    sl_vec3d middle = sl_scaled(sl_v3d(cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5), voxel);
    bool touched = !((double)set->surface > 1e-6 * voxel * voxel); /* but by rounding nothing is in it */
    sl_photon_tree_gather(lights->tree,
                          &(sl_photon_query){.centre = sl_to_float(sl_addd(octree->origin, middle)),
                                             .flatness = 1.0,
                                             .radius = touched ? 0.0 : 0.87 * voxel,
                                             .cos_acceptance = -1.0,
                                             .neighbours = SL_NEIGHBOURS_MAX},
                          &w->gathered);
    size_t around = w->gathered.count;
    w->gathered.count = 0;
    for (size_t i = 0; i < around; i++) {
        const float *p = list->photon[w->place[i]].position;
        if (sl_octree_morton_at(octree, sl_v3(p[0], p[1], p[2])) == morton)
            w->place[w->gathered.count++] = w->place[i];
    }
    sl_voxel_gather gather = {.found = w->gathered.count, .kappa = 1.0};
    gather.ellipsoid = (sl_ellipsoid){sl_to_double(query->centre), sl_to_double(query->normal),
                                      query->flatness, sqrt((double)set->surface / SL_PI)};
    take_photons(lights, query, w, &gather);
    return gather;
}

/* ---- The area A that they were strewn over ---- */

/* The scene's triangles in the ellipsoid, less surface that no photon met. */
static sl_voxel_area clipped_area(const sl_voxel_lights *lights, const sl_voxel_gather *gather,
                                  sl_voxel_worker *w) {
    const sl_ellipsoid *e = &gather->ellipsoid;
    double least_cosine = lights->by_side ? lights->cos_acceptance : -1.0;
    sl_strewn_area a = sl_surface_in_ellipsoid(lights->scene, lights->octree, e, least_cosine, &w->marks);
    for (int side = 0; side < 2 && lights->by_side && sl_dotd(e->normal, e->normal) > 0.0; side++)
        a.side[side] *= sl_strewn_share(&gather->places[side], a.flat[side]);
    return (sl_voxel_area){{a.side[0], a.side[1]},
                           a.together ? fmax(a.side[0], a.side[1]) : a.side[0] + a.side[1]};
}

/* Takes what is next to nothing (photons beside the geometry) for the disc. */
sl_voxel_area sl_voxel_areas(const sl_voxel_lights *lights, const sl_voxel_gather *gather,
                             sl_voxel_worker *w) {
    const sl_ellipsoid *e = &gather->ellipsoid;
    double disc = sl_disc_area(e);
    sl_voxel_area area = {{disc, disc}, 0.0};
    if (sl_voxel_lights_clip(&lights->options)) area = clipped_area(lights, gather, w);
    else if (lights->options.area == SL_PHOTON_AREA_SECTION && !lights->options.own_photons) {
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

/* ---- Virtual directional lights: clusters of the photons' directions ---- */

static double luminance_of(const sl_lobe_photons *photons) {
    double sum = 0.0;
    for (size_t i = 0; i < photons->count; i++) sum += photons->luminance[i];
    return sum;
}

/* Returns how many of n lights the front gets: by irradiance, and at least one for each side that is lit. One
 * light, or one value, is the brighter side's. */
static int lights_of_front(const double irradiance[2], int lights) {
    double front = irradiance[0], back = irradiance[1];
    if (!(back > 0.0)) return lights;
    if (!(front > 0.0)) return 0;
    if (lights < 2) return front >= back ? lights : 0;
    int share = (int)floor((double)lights * (front / (front + back)) + 0.5);
    return share < 1 ? 1 : share > lights - 1 ? lights - 1 : share;
}

/* E = kappa sum Phi_i / A from the photons on either side, which share the n lights by E. On a flat matt
 * surface one light along the normal says all; else clusters of photons' directions omega_i become lights
 * (d_j, c_j):
 *
 *     V_j = sum kappa Y(Phi_i) / (A max(n_i . omega_i, epsilon)) omega_i,   d_j = V_j / |V_j|,
 *     c_j = |V_j| sum Phi_i / sum Y(Phi_i)          (voxel_lobes.c; the clusters: cluster_kernels.c) */
static void make_lights(const sl_voxel_lights *lights, const sl_voxel_gather *gather, sl_voxel_worker *w,
                        sl_voxel_set *set, sl_directional_light *light) {
    const sl_light_octree_settings *o = &lights->options;
    sl_voxel_area area = sl_voxel_areas(lights, gather, w);
    double both = luminance_of(&gather->side[0]) + luminance_of(&gather->side[1]), scale[2], irradiance[2];
    for (int side = 0; side < 2; side++) {
        scale[side] = gather->kappa / area.side[side];
        irradiance[side] = scale[side] * luminance_of(&gather->side[side]);
    }
    bool flat = set->flat && o->lobes == SL_LOBES_PERPENDICULAR;
    int room = sl_lobe_texels(o), front = lights_of_front(irradiance, room);
    sl_lobe_spread spread = {0};
    int used =
        sl_lobes_of_photons(&gather->side[0], o, scale[0], set->normal, flat, front, light, &spread);
    int back = front < room ? room - used : 0;
    used += sl_lobes_of_photons(&gather->side[1], o, scale[1], sl_neg(set->normal), flat, back, light + used,
                                &spread);
    set->lights = (uint8_t)used;
    set->area = (float)area.all;
    set->density = (float)(gather->kappa * both / area.all);
    set->irradiance = (float)(irradiance[0] + irradiance[1]);
    set->rms_angle =
        spread.weight > 0.0 ? (float)(2.0 * sl_asin(0.5 * sqrt(spread.cost / spread.weight))) : 0.0f;
    if (!(irradiance[1] > 0.0) || irradiance[0] > 0.0) return;
    set->normal = sl_neg(set->normal); /* to the side on which the photons lie */
    set->height = -set->height;
}

/* ---- A set ---- */

void sl_voxel_light_set(sl_voxel_lights *lights, size_t index, sl_voxel_worker *w, sl_counters *counters) {
    const sl_light_octree_settings *o = &lights->options;
    sl_voxel_set *set = &lights->set[index];
    sl_directional_light *light = lights->light + index * (size_t)lights->texels;
    memset(light, 0, (size_t)lights->texels * sizeof *light);
    if (!lights->tree) return;
    sl_photon_query query = sl_voxel_query(lights, set->centroid, set->normal);
    /* where another set faces it, that side is its own */
    query.both_sides = query.both_sides && !set->opposed;
    sl_voxel_gather gather = o->own_photons ? own_photons(lights, set, &query, w)
                                            : sl_voxel_gather_photons(lights, &query, w);
    set->photons = (uint32_t)gather.found;
    set->radius = (float)gather.ellipsoid.radius;
    sl_count(counters, SL_COUNT_PHOTONS_GATHERED, gather.found);
    if (gather.side[0].count + gather.side[1].count == 0) return; /* dark: nothing to cluster */
    make_lights(lights, &gather, w, set, light);
    if (o->lobes != SL_LOBES_NONE) sl_count(counters, SL_COUNT_DIRECTIONAL_LIGHTS, set->lights);
}
