/* A photon for each surface that a block of the map shows, with the sum of its texels' flux Psi
 * (SL_MAP_FILTER_FLUX): no light is lost, and no photon flashes as a single texel jumps between surfaces. */
#include "cache/direct_radiance/map.h"

/* One surface's: sums of flux and area, and means of all else, weighted by luminance. */
typedef struct {
    sl_vec3d position, normal, shading, to_light;
    double luminance, way, area;
    double flux[3], radiance[3], diffuse[3]; /* diffuse: kd by the flux that each channel has to reflect */
    sl_vec3d first_position, first_normal; /* of the texel that opened it */
    uint32_t object;                       /* likewise */
    bool mirrored;
    bool bent;                             /* others' normals differ from that one */
    const sl_material *material;
    sl_texel_rectangle rectangle;
} surface_sum;

static sl_texel_rectangle join(sl_texel_rectangle a, sl_texel_rectangle b) {
    return (sl_texel_rectangle){fmin(a.left, b.left), fmin(a.bottom, b.bottom), fmax(a.right, b.right),
                                fmax(a.top, b.top)};
}

/* Facets of a curved surface whose normals differ by less than 20 degrees are one group, where they lie one
 * beside the other: a table and the floor below it have one normal, often one object, and nothing of either
 * is halfway between them. (A photon of both moves by half the table's height as texels change sides: of the
 * irradiance of a room where a light glides past a box, the largest change in a frame was 0.55 of the mean,
 * and without such photons 0.19.) */
#define GROUP_COS 0.94
#define GROUP_SINE 0.25

static bool on_surface_of(const surface_sum *group, const sl_map_texel *t, bool lambertian) {
    if (group->object != t->object || group->mirrored != t->mirrored) return false;
    if (!lambertian && group->material != t->material) return false;
    sl_vec3d way = sl_subd(t->position, group->first_position);
    return sl_dotd(group->first_normal, t->normal) >= GROUP_COS &&
           fabs(sl_dotd(group->first_normal, way)) <= GROUP_SINE * sl_lengthd(way);
}

/* Returns a measure that grows as a texel is less of a group's surface: its normal turned away, its place off
 * the group's plane. */
static double strangeness(const surface_sum *group, const sl_map_texel *t) {
    const sl_vec3d way = sl_subd(t->position, group->first_position);
    const double length = sl_lengthd(way),
                 off = length > 0.0 ? fabs(sl_dotd(group->first_normal, way)) / length : 0.0;
    return off - sl_dotd(group->first_normal, t->normal);
}

/* Returns the group that the texel joins: the first one of its surface, or a new one, or where there are four
 * already the one most like it, to which it is a stranger. */
static surface_sum *group_of(surface_sum group[SL_PHOTON_GROUPS], const sl_map_texel *t, bool lambertian,
                               bool *stranger) {
    surface_sum *nearest = group;
    *stranger = false;
    for (surface_sum *g = group; g < group + SL_PHOTON_GROUPS; g++) {
        if (!(g->luminance > 0.0) || on_surface_of(g, t, lambertian)) return g;
        if (strangeness(g, t) < strangeness(nearest, t)) nearest = g;
    }
    *stranger = true;
    return nearest;
}

static sl_vec3d unit_or(sl_vec3d a, sl_vec3d fallback) {
    double length = sl_lengthd(a);
    return length > 0.0 && isfinite(length) ? sl_scaled(a, 1.0 / length) : fallback;
}

static void add_scaled(sl_vec3d *sum, sl_vec3d a, double s) { *sum = sl_addd(*sum, sl_scaled(a, s)); }

/* Adds a texel. A stranger adds its flux and its area, so that no light is lost, and does not move the
 * photon: between a roof and the lawn there is a room. */
static void add_texel(surface_sum *sum, const sl_map_texel *t, bool stranger, double of_block) {
    double weight = stranger ? 0.0 : t->luminance;
    add_scaled(&sum->position, t->position, weight);
    add_scaled(&sum->normal, t->normal, weight);
    add_scaled(&sum->to_light, t->to_light, weight);
    sum->luminance += weight;
    sum->way += weight * t->way;
    sum->area += t->footprint / fmax(t->cos_alpha, SL_GROUP_COS_MIN);
    for (int k = 0; k < 3; k++) {
        sum->flux[k] += t->flux[k];
        sum->radiance[k] += of_block * t->radiance[k];
        sum->diffuse[k] += t->flux[k] * t->color[k];
    }
    add_scaled(&sum->shading, t->shading, weight);
}

static void finish(sl_photon_maker *list, const sl_map_face *face, const surface_sum *sum) {
    double mean = 1.0 / sum->luminance;
    sl_map_texel s = {.position = sl_scaled(sum->position, mean),
                      .normal = unit_or(sum->normal, sum->first_normal),
                      .way = sum->way * mean,
                      .material = sum->material,
                      .object = sum->object,
                      .bent = sum->bent,
                      .rectangle = sum->rectangle};
    s.shading = unit_or(sum->shading, s.normal);
    s.to_light = unit_or(sum->to_light, s.normal);
    s.cos_alpha = fmax(sl_dotd(s.normal, s.to_light), SL_GROUP_COS_MIN);
    /* A cos alpha, of which the flux weight makes A again. */
    s.footprint = sum->area * s.cos_alpha;
    for (int k = 0; k < 3; k++) {
        s.flux[k] = sum->flux[k];
        s.radiance[k] = sum->radiance[k];
        if (sum->flux[k] > 0.0) s.color[k] = sum->diffuse[k] / sum->flux[k];
    }
    sl_photon_add(list, face, &s);
}

/* Adds a texel to its surface's group. block: the solid angle for which printed weights take a photon. */
static void add_to_groups(const sl_photon_maker *list, const sl_map_face *face, int column, int row,
                          double block, surface_sum group[SL_PHOTON_GROUPS]) {
    sl_map_texel t;
    if (!sl_map_texel_read(list->scene, list->map, face, column, row, NULL, &t)) return;
    const sl_texel_rectangle texel =
        t.mirrored ? (sl_texel_rectangle){0} : (sl_texel_rectangle){column, row, column + 1, row + 1};
    bool stranger;
    surface_sum *g = group_of(group, &t, list->map->lambertian, &stranger);
    if (!(g->luminance > 0.0)) {
        *g = (surface_sum){.first_position = t.position,
                             .first_normal = t.normal,
                             .object = t.object,
                             .mirrored = t.mirrored,
                             .material = t.material,
                             .rectangle = texel};
    }
    add_texel(g, &t, stranger, t.size / block);
    g->bent = g->bent || sl_dotd(g->first_normal, t.normal) < 1.0 - 1e-6;
    if (!stranger) g->rectangle = join(g->rectangle, texel);
}

void sl_photon_groups_take(sl_photon_maker *list, const sl_map_face *f, int column, int row) {
    const int texels = sl_block_texels(f);
    const double block = sl_map_part(list->map, f, column, row, texels);
    surface_sum group[SL_PHOTON_GROUPS] = {{.luminance = 0.0}};
    for (int y = row; y < row + texels; y++) {
        for (int x = column; x < column + texels; x++) add_to_groups(list, f, x, y, block, group);
    }
    for (int g = 0; g < SL_PHOTON_GROUPS && group[g].luminance > 0.0; g++) finish(list, f, &group[g]);
}
