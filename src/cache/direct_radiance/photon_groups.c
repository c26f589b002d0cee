/* Texels become groups, and groups photons: a block of the map whose texels' flux is summed, surface by
 * surface (SL_MAP_FILTER_FLUX). */
#include "base/error.h"
#include "base/math.h"
#include "cache/direct_radiance/map.h"
#include "raster/textures/textures.h"

/* Facets of a curved surface whose normals differ by less than 20 degrees are one group, where they lie one
 * beside the other: a table and the floor below it have one normal, often one object, and nothing of either
 * is halfway between them. (A photon of both moves by half the table's height as texels change sides: of the
 * irradiance of a room where a light glides past a box, the largest change in a frame was 0.55 of the mean,
 * and without such photons 0.19.) */
#define GROUP_COS 0.94
#define GROUP_SINE 0.25

static bool on_surface_of(const sl_photon_sum *group, const sl_map_texel *t, bool lambertian) {
    if (group->object != t->object || group->mirrored != t->mirrored) return false;
    if (!lambertian && group->material != t->material) return false;
    sl_vec3d way = sl_subd(t->position, group->first_position);
    return sl_dotd(group->first_normal, t->normal) >= GROUP_COS &&
           fabs(sl_dotd(group->first_normal, way)) <= GROUP_SINE * sl_lengthd(way);
}

/* Returns a measure that grows as a texel is less of a group's surface: its normal turned away, its place off
 * the group's plane. */
static double strangeness(const sl_photon_sum *group, const sl_map_texel *t) {
    const sl_vec3d way = sl_subd(t->position, group->first_position);
    const double length = sl_lengthd(way),
                 off = length > 0.0 ? fabs(sl_dotd(group->first_normal, way)) / length : 0.0;
    return off - sl_dotd(group->first_normal, t->normal);
}

/* Returns the group that the texel joins: the first one of its surface, or a new one, or where there are four
 * already the one most like it, to which it is a stranger. */
static sl_photon_sum *group_of(sl_photon_sum group[SL_PHOTON_GROUPS], const sl_map_texel *t, bool lambertian,
                               bool *stranger) {
    sl_photon_sum *nearest = group;
    *stranger = false;
    for (sl_photon_sum *g = group; g < group + SL_PHOTON_GROUPS; g++) {
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

/* Adds to the reflectances of a photon that is not Lambertian: means by the flux that each colour channel has
 * to reflect. */
static void add_lobe(sl_photon_sum *sum, const sl_map_texel *t) {
    const sl_rgb s = t->material->specular;
    const double specular[3] = {(double)s.r, (double)s.g, (double)s.b};
    double glossy = 0.0;
    for (int k = 0; k < 3; k++) {
        sum->diffuse[k] += t->flux[k] * t->color[k];
        sum->specular[k] += t->flux[k] * specular[k];
        glossy += t->flux[k] * specular[k];
    }
    sum->glossy += glossy;
    sum->exponent += glossy * (double)t->material->exponent;
}

/* Adds a texel. A stranger adds its flux and its area, so that no light is lost, and does not move the
 * photon: between a roof and the lawn there is a room. */
static void add_texel(sl_photon_sum *sum, const sl_radiance_map *map, const sl_map_texel *t, bool stranger,
                      double of_block) {
    double weight = stranger ? 0.0 : t->luminance;
    add_scaled(&sum->position, t->position, weight);
    add_scaled(&sum->normal, t->normal, weight);
    add_scaled(&sum->to_light, t->to_light, weight);
    sum->luminance += weight;
    sum->way += weight * t->way;
    sum->area += t->footprint / fmax(t->cos_alpha, SL_GROUP_COS_MIN);
    for (int k = 0; k < 3; k++) {
        sum->flux[k] += t->flux[k];
        sum->radiance[k] += of_block * sl_printed_radiance(map, t, k);
    }
    if (map->lambertian) return;
    add_scaled(&sum->shading, t->shading, weight);
    add_lobe(sum, t);
}

static void finish(sl_photon_list *list, const sl_map_face *face, const sl_photon_sum *sum) {
    double mean = 1.0 / sum->luminance;
    sl_photon_sample s = {.position = sl_scaled(sum->position, mean),
                          .normal = unit_or(sum->normal, sum->first_normal),
                          .way = sum->way * mean,
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
        if (list->map->lambertian || !(sum->flux[k] > 0.0)) continue;
        s.diffuse[k] = sum->diffuse[k] / sum->flux[k];
        s.specular[k] = sum->specular[k] / sum->flux[k];
    }
    s.exponent = sum->glossy > 0.0 ? sum->exponent / sum->glossy : 0.0;
    sl_photon_add(list, face, &s);
}

void sl_photon_groups_add(const sl_photon_list *list, const sl_map_face *face, int column, int row,
                          double block, sl_photon_groups *groups) {
    double angle = (double)list->map->block_angle[sl_map_texel_index(face, column, row)];
    sl_map_texel t;
    if (!sl_map_texel_read(list->scene, list->map, face, column, row, NULL, &t)) return;
    const sl_texel_rectangle texel =
        t.mirrored ? (sl_texel_rectangle){0} : (sl_texel_rectangle){column, row, column + 1, row + 1};
    bool stranger;
    sl_photon_sum *g = group_of(groups->group, &t, list->map->lambertian, &stranger);
    if (!(g->luminance > 0.0)) {
        *g = (sl_photon_sum){.first_position = t.position,
                             .first_normal = t.normal,
                             .object = t.object,
                             .mirrored = t.mirrored,
                             .material = t.material,
                             .rectangle = texel};
    }
    add_texel(g, list->map, &t, stranger, angle / block);
    g->bent = g->bent || sl_dotd(g->first_normal, t.normal) < 1.0 - 1e-6;
    if (!stranger) g->rectangle = sl_texel_rectangle_join(g->rectangle, texel);
}

bool sl_photon_groups_finish(sl_photon_list *list, const sl_map_face *face, sl_photon_groups *groups) {
    size_t before = list->photons->count;
    for (sl_photon_sum *g = groups->group; g < groups->group + SL_PHOTON_GROUPS && g->luminance > 0.0; g++)
        finish(list, face, g);
    *groups = (sl_photon_groups){.group = {{.luminance = 0.0}}};
    return list->photons->count > before;
}

/* Samples that look at all texels of their block, against photons that flash as single texels jump between
 * surfaces.
 *
 *     radiance   the paper's: L_o from a level of a MIP map, position and normal from the sample's texel. Its
 * mean mixes L_o and not L_o A, so it does not conserve energy, and can light a near surface with a far one's
 * colour. flux       sums of Psi, which do: a photon for each surface that the block shows */

/* ---- radiance ---- */

/* Makes the face's colours with their MIP map; where nothing is, black, alpha 0. */
static sl_status picture_of(const sl_radiance_map *map, const sl_map_face *face, sl_texture_image **image,
                            sl_error *error) {
    sl_status status = sl_texture_image_create(face->width, face->height, true, image, error);
    if (status != SL_OK) return status;
    size_t texels = (size_t)face->width * (size_t)face->height;
    for (size_t i = 0; i < texels; i++) {
        bool covered = map->triangle[face->first + i] != SL_NO_INDEX;
        float *rgba = (*image)->texels + 4 * i;
        for (int c = 0; c < 3; c++) rgba[c] = covered ? map->color[c][face->first + i] : 0.0f;
        rgba[3] = covered ? 1.0f : 0.0f;
    }
    sl_texture_image_build(*image, 1);
    return SL_OK;
}

/* Trilinear, of level log2(texels a block): one texel of the level for each block, where w / m is a power of
 * two. */
static void filtered_color(const sl_texture_image *image, const sl_map_face *face, int column, int row,
                           double color[3]) {
    double texels = (double)sl_block_texels(face);
    float s = (float)(((double)column + 0.5 * texels) / face->width),
          t = (float)(((double)row + 0.5 * texels) / face->height), rgba[4];
    sl_texture_sample(image, s, t, sl_log2f((float)texels), rgba);
    for (int c = 0; c < 3; c++) color[c] = (double)rgba[c];
}

static sl_status filtered_face(sl_photon_list *list, const sl_map_face *f, sl_error *error) {
    sl_texture_image *image;
    sl_status status = picture_of(list->map, f, &image, error);
    if (status != SL_OK) return status;
    for (int row = 0; row < f->height; row += sl_block_texels(f)) {
        for (int column = 0; column < f->width; column += sl_block_texels(f)) {
            double color[3];
            filtered_color(image, f, column, row, color);
            sl_photon_at_point(list, f, column, row, color);
        }
    }
    sl_texture_image_destroy(image);
    return SL_OK;
}

sl_status sl_photons_of_filtered_radiance(sl_photon_list *list, const sl_map_face *face, size_t face_count,
                                          sl_error *error) {
    for (size_t f = 0; f < face_count; f++) {
        sl_status status = filtered_face(list, &face[f], error);
        if (status != SL_OK) return status;
    }
    return SL_OK;
}

/* ---- flux ---- */

static void group_block(sl_photon_list *list, const sl_map_face *f, int column, int row) {
    int texels = sl_block_texels(f);
    sl_photon_groups groups = {.group = {{.luminance = 0.0}}};
    double block = sl_block_angle(list->map, f, column, row);
    for (int y = row; y < row + texels; y++) {
        for (int x = column; x < column + texels; x++) sl_photon_groups_add(list, f, x, y, block, &groups);
    }
    if (!sl_photon_groups_finish(list, f, &groups)) list->photons->dropped++;
}

sl_status sl_photons_of_groups(sl_photon_list *list, const sl_map_face *face, size_t face_count,
                               sl_error *error) {
    (void)error;
    for (const sl_map_face *f = face; f < face + face_count; f++) {
        for (int row = 0; row < f->height; row += sl_block_texels(f)) {
            for (int column = 0; column < f->width; column += sl_block_texels(f))
                group_block(list, f, column, row);
        }
    }
    return SL_OK;
}
