/* Pass 3: regular samples of the direct radiance map, and what they have in common with the other ways to
 * take them. */
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/direct_radiance/map.h"

/* A receiver that is as near as that to a photon gets nothing from it: its direction would be noise. */
#define NEAREST_RECEIVER 1e-6

/* Photon (i, k) of m x m is the texel at ((i + 1/2) / m, (k + 1/2) / m). With an even number of texels a
 * block that is a texel's corner: the lower left of the four around it is taken. It stands for the whole
 * block, whose solid angle is the texels' together: with the texel's own, the photons would hold m^2 / w^2 of
 * the light. color: instead of the texel's own; or NULL. */
static void take_point(sl_photon_maker *list, const sl_map_face *face, int column, int row,
                       const double *color) {
    int texels = sl_block_texels(face), x = column + (texels - 1) / 2, y = row + (texels - 1) / 2;
    sl_map_texel t;
    if (!sl_map_texel_read(list->scene, list->map, face, x, y, color, &t)) return;
    const double times = sl_map_part(list->map, face, column, row, texels) / t.size;
    t.footprint *= times;
    for (int k = 0; k < 3; k++) t.flux[k] *= times;
    if (!t.mirrored) t.rectangle = (sl_texel_rectangle){column, row, column + texels, row + texels};
    sl_photon_add(list, face, &t);
}

/* The paper's: L_o of the block's level in a MIP map, position and normal from the sample's texel. The mean
 * mixes L_o and not L_o A, so it does not conserve energy, and can light a near surface with a far one's
 * colour. Where nothing is, black. */
static void take_filtered(sl_photon_maker *list, const sl_map_face *face, int column, int row) {
    const sl_radiance_map *map = list->map;
    const int texels = sl_block_texels(face);
    double color[3] = {0.0, 0.0, 0.0};
    for (int y = row; y < row + texels; y++) {
        for (int x = column; x < column + texels; x++) {
            const size_t i = sl_map_texel_index(face, x, y);
            for (int c = 0; c < 3 && map->triangle[i] != SL_NO_INDEX; c++)
                color[c] += (double)map->color[c][i] / ((double)texels * (double)texels);
        }
    }
    take_point(list, face, column, row, color);
}

static void take_block(sl_photon_maker *list, sl_map_filter filter, const sl_map_face *face, int column,
                       int row) {
    const size_t before = list->photons->count;
    if (filter == SL_MAP_FILTER_POINT) take_point(list, face, column, row, NULL);
    else if (filter == SL_MAP_FILTER_RADIANCE) take_filtered(list, face, column, row);
    else sl_photon_groups_take(list, face, column, row);
    if (list->photons->count == before) list->photons->dropped++;
}

/* Returns M: of one light, or of all (SL_NO_INDEX). */
static size_t count_blocks(const sl_radiance_map *map, uint32_t light) {
    size_t blocks = 0;
    for (const sl_map_face *f = map->face; f < map->face + map->face_count; f++)
        if (light == SL_NO_INDEX || f->light == light) blocks += (size_t)f->columns * (size_t)f->rows;
    return blocks;
}

/* Room for the most that the samples can be: four groups a block. */
static sl_status create(const sl_radiance_map *map, bool polygons, size_t room, sl_map_photons **photons,
                        sl_error *error) {
    sl_map_photons *p = sl_allocate(1, sizeof *p);
    if (!p) return sl_fail_memory(error, "sample photons");
    p->photon = sl_allocate(room, sizeof *p->photon);
    if (!map->lambertian) p->lobe = sl_allocate(room, sizeof *p->lobe);
    if (polygons) p->polygon = sl_allocate(room, sizeof *p->polygon);
    if (!p->photon || (!map->lambertian && !p->lobe) || (polygons && !p->polygon)) {
        sl_map_photons_destroy(p);
        return sl_fail_memory(error, "sample photons");
    }
    p->room = room;
    *photons = p;
    return SL_OK;
}

sl_status sl_map_photons_take(const sl_scene *scene, const sl_radiance_map *map,
                              const sl_radiance_map_settings *settings, sl_map_photons **photons,
                              sl_counters *counters, sl_error *error) {
    bool polygons = settings->weight == SL_WEIGHT_POLYGON;
    sl_status status =
        create(map, polygons, SL_PHOTON_GROUPS * count_blocks(map, SL_NO_INDEX), photons, error);
    if (status != SL_OK) return status;
    sl_map_photons *p = *photons;
    p->nearest = (float)(NEAREST_RECEIVER * (double)scene->scale);
    p->box_diagonal = scene->diagonal;

    sl_photon_maker list = {.scene = scene, .map = map, .photons = p};
    for (const sl_map_face *f = map->face; f < map->face + map->face_count; f++) {
        if (f == map->face || f[-1].light != f->light) list.samples = count_blocks(map, f->light);
        for (int row = 0; row < f->height; row += sl_block_texels(f)) {
            for (int column = 0; column < f->width; column += sl_block_texels(f))
                take_block(&list, settings->filter, f, column, row);
        }
    }
    sl_count(counters, SL_COUNT_MAP_PHOTONS, p->count);
    sl_count(counters, SL_COUNT_MAP_PHOTONS_DROPPED, p->dropped);
    return SL_OK;
}

void sl_map_photons_destroy(sl_map_photons *photons) {
    if (!photons) return;
    SL_FREE_ALL(photons->photon, photons->lobe, photons->polygon, photons);
}

size_t sl_map_photons_bytes(const sl_map_photons *photons) {
    if (!photons) return 0;
    size_t each = sizeof *photons->photon + (photons->lobe ? sizeof *photons->lobe : 0) +
                  (photons->polygon ? sizeof *photons->polygon : 0);
    return sizeof *photons + photons->room * each;
}

/* From a texel of the map to the light that leaves the surface there. */

static sl_vec3d plane_at(float *const plane[3], size_t i) {
    return sl_v3d((double)plane[0][i], (double)plane[1][i], (double)plane[2][i]);
}

static bool is_finite(sl_vec3d a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }

/* Unit vector; false where a has no direction. */
static bool make_unit(sl_vec3d *a) {
    double length = sl_lengthd(*a);
    if (!(length > 0.0) || !isfinite(length)) return false;
    *a = sl_scaled(*a, 1.0 / length);
    return is_finite(*a);
}

void sl_map_face_ray(const sl_map_face *face, bool directional, double column, double row, sl_vec3d *origin,
                     sl_vec3d *direction) {
    double u = face->left + (face->right - face->left) * (column / (double)face->width);
    double v = face->bottom + (face->top - face->bottom) * (row / (double)face->height);
    sl_vec3d x = sl_to_double(face->frame.x), y = sl_to_double(face->frame.y),
             z = sl_to_double(face->frame.z);
    sl_vec3d aside = sl_addd(sl_scaled(x, u), sl_scaled(y, v)), eye = sl_to_double(face->eye);
    *origin = directional ? sl_addd(eye, aside) : eye;
    *direction = directional ? z : sl_addd(z, aside);
}

sl_vec3 sl_map_face_departure(const sl_map_face *face, size_t texel) {
    const size_t width = (size_t)face->width;
    sl_vec3d origin, direction;
    sl_map_face_ray(face, false, (double)(texel % width) + 0.5, (double)(texel / width) + 0.5, &origin,
                    &direction);
    return sl_normalize_or(sl_to_float(direction), sl_v3(0.0f, 0.0f, 1.0f));
}

/* Way, direction of arrival and perpendicular area of a texel. */
static bool find_way(const sl_radiance_map *map, const sl_map_face *face, size_t i, sl_map_texel *t) {
    const bool parallel = sl_face_is_directional(map, face);
    t->way = (double)map->path[i];
    if (t->mirrored) {
        t->to_light = plane_at(map->arrival, i);
        if (!make_unit(&t->to_light)) return false;
    } else if (parallel) {
        t->to_light = sl_to_double(sl_neg(face->frame.z));
    } else {
        t->to_light = sl_subd(sl_to_double(face->eye), t->position);
        t->way = sl_lengthd(t->to_light);
        t->to_light = sl_scaled(t->to_light, 1.0 / t->way); /* at the light itself NaN, and near: dropped */
    }
    t->footprint = t->size * (parallel ? 1.0 : t->way * t->way);
    return t->footprint > 0.0 && isfinite(t->footprint) && t->way >= 0.0;
}

/* I dOmega, W: what leaves the light within the texel, less the mirrors' share. What came by mirrors left
 * along the picture's ray, and arrives from somewhere else. */
static bool find_arriving(const sl_radiance_map *map, const sl_map_face *face, size_t i,
                          const sl_map_texel *t, double arriving[3]) {
    const sl_vec3 left = t->mirrored ? sl_map_face_departure(face, i - face->first)
                                     : sl_normalize_or(sl_to_float(sl_scaled(t->to_light, -1.0)),
                                                       sl_v3(0.0f, 0.0f, 1.0f));
    sl_rgb intensity = sl_map_light_intensity(&map->lights->light[face->light], left);
    if (t->mirrored)
        intensity =
            sl_rgb_mul(intensity, (sl_rgb){map->carried[0][i], map->carried[1][i], map->carried[2][i]});
    const double c[3] = {(double)intensity.r, (double)intensity.g, (double)intensity.b};
    bool any = false;
    for (int k = 0; k < 3; k++) {
        arriving[k] = c[k] > 0.0 ? c[k] * t->size : 0.0;
        any |= arriving[k] > 0.0;
        if (!isfinite(arriving[k])) return false;
    }
    return any;
}

/* Psi = L_o A = rho I dOmega / pi cos_s / cos_alpha, where cos_s is the shading normal's cosine, in L_o, and
 * cos_alpha the geometric one's, in A: 1 to another on facets. On rounded silhouettes the quotient can be
 * huge. No surface sends on more than arrives: pi Psi <= I dOmega bounds it, in all channels by one factor,
 * so that the hue stays. */
static void find_flux(const sl_radiance_map *map, const double arriving[3], sl_map_texel *t) {
    double share = 1.0, reflected[3];
    if (map->lambertian) {
        double area = t->footprint / t->cos_alpha;
        for (int k = 0; k < 3; k++) {
            t->flux[k] = t->color[k] > 0.0 ? t->color[k] * area : 0.0;
            double most = arriving[k] * (1.0 / SL_PI);
            if (t->flux[k] * share > most) share = most / t->flux[k];
        }
        for (int k = 0; k < 3; k++) reflected[k] = t->flux[k] *= share;
    } else {
        const sl_rgb s = t->material->specular;
        const double specular[3] = {(double)s.r, (double)s.g, (double)s.b};
        double most = 0.0, tilt = sl_dotd(t->shading, t->to_light) / t->cos_alpha;
        for (int k = 0; k < 3; k++) {
            reflected[k] = t->color[k] + specular[k];
            most = fmax(most, reflected[k]);
        }
        share = tilt > 0.0 ? tilt : 0.0;
        if (most * share > 1.0) share = 1.0 / most;
        for (int k = 0; k < 3; k++) reflected[k] *= t->flux[k] = arriving[k] * share;
    }
    for (int k = 0; k < 3; k++)
        t->radiance[k] = map->lambertian ? t->color[k] : t->flux[k] * (t->cos_alpha / t->footprint);
    t->luminance = sl_luminance_of(reflected);
}

bool sl_map_texel_read(const sl_scene *scene, const sl_radiance_map *map, const sl_map_face *face, int column,
                       int row, const double *color, sl_map_texel *t) {
    const size_t i = sl_map_texel_index(face, column, row);
    double arriving[3];
    *t = (sl_map_texel){0};
    if (map->triangle[i] == SL_NO_INDEX) return false;
    t->size = sl_map_part(map, face, column, row, 1);
    t->position = plane_at(map->position, i);
    t->mirrored = map->arrival[0] && sl_lengthd(plane_at(map->arrival, i)) > 0.0;
    if (!is_finite(t->position) || !find_way(map, face, i, t)) return false;
    if (!sl_face_is_directional(map, face) &&
        t->way < SL_PHOTON_NEAREST_LIGHT * (double)sl_scene_central_diagonal(scene))
        return false;

    t->normal = plane_at(map->geometric, i);
    if (!make_unit(&t->normal)) return false;
    t->shading = t->normal;
    if (map->normal[0]) {
        sl_vec3d shading = plane_at(map->normal, i);
        if (make_unit(&shading)) t->shading = shading;
    }
    t->cos_alpha = fmax(sl_dotd(t->normal, t->to_light), SL_TEXEL_COS_MIN);
    t->material = sl_triangle_material(scene, map->triangle[i]);
    t->object = scene->object_index[map->triangle[i]];
    for (int k = 0; k < 3; k++) {
        t->color[k] = color ? color[k] : (double)map->color[k][i];
        if (!(t->color[k] >= 0.0) || !isfinite(t->color[k])) return false;
    }
    if (!find_arriving(map, face, i, t, arriving)) return false;
    find_flux(map, arriving, t);
    return t->luminance > 0.0 && isfinite(t->luminance);
}

/* Samples become photons: the footprint's printed form, the lobe and the polygon beside it. */

static sl_rgb rgb_of(const double c[3]) { return (sl_rgb){(float)c[0], (float)c[1], (float)c[2]}; }

/* Returns A of (13) with A' of (12) and w := m; a directional light's A' is its block's area. */
static double printed_area(const sl_photon_maker *list, const sl_map_face *face, const sl_map_texel *s) {
    double footprint;
    if (sl_face_is_directional(list->map, face)) {
        footprint = (face->right - face->left) / face->columns * ((face->top - face->bottom) / face->rows);
    } else {
        footprint = sl_printed_footprint(s->way, sl_atan(face->right) - sl_atan(face->left), face->columns);
    }
    return sl_printed_tilted_footprint(footprint, s->cos_alpha);
}

static bool photon_is_sound(const sl_map_photon *p) {
    return sl_is_finite(p->position) && sl_is_finite(p->normal) && sl_rgb_is_finite(p->flux) &&
           sl_rgb_is_finite(p->radiance) && isfinite(p->printed_area) && isfinite(p->footprint) &&
           p->footprint > 0.0f && p->cos_alpha > 0.0f && sl_rgb_max(p->flux) > 0.0f;
}

/* The polygon that a photon stands for: where the corner rays of its part of the picture meet its tangent
 * plane. */

/* A corner farther from the light than so many times b is not that surface any more; of parallel light, one
 * that is so many widths away. */
#define LONGEST_RAY 4.0

typedef struct corner_rays {
    sl_vec3d point, normal;
    double longest;    /* of a ray from the light */
    double width;      /* of the picture's part, for parallel light */
    bool directional;
} corner_rays;

static bool meet_plane(const corner_rays *rays, sl_vec3d origin, sl_vec3d direction, sl_vec3d *corner) {
    double towards = sl_dotd(direction, rays->normal),
           way = sl_dotd(sl_subd(rays->point, origin), rays->normal);
    double t = way / towards; /* may be infinite or NaN */
    if (!(towards < 0.0) || !isfinite(t)) return false;
    *corner = sl_addd(origin, sl_scaled(direction, t));
    if (rays->directional) return sl_lengthd(sl_subd(*corner, rays->point)) <= LONGEST_RAY * rays->width;
    return t > 0.0 && t * sl_lengthd(direction) <= rays->longest;
}

static sl_polygon_light triangle_of(sl_vec3 a, sl_vec3 b, sl_vec3 c, sl_vec3 normal) {
    const sl_vec3 winding = sl_cross(sl_sub(b, a), sl_sub(c, a));
    const bool turned = sl_dot(winding, normal) < 0.0f;
    sl_polygon_light t = {
        .corner = {a, turned ? c : b, turned ? b : c}, .normal = normal, .area = 0.5f * sl_length(winding)};
    sl_polygon_light_bound(&t);
    return t;
}

sl_photon_polygon sl_photon_polygon_of(const sl_vec3 corner[4], sl_vec3 normal, float area, float depth) {
    sl_photon_polygon polygon = {.over_area = 1.0f / area, .depth = depth};
    for (int c = 0; c < 4; c++) polygon.corner[c] = corner[c];
    for (int t = 0; t < 2; t++)
        polygon.triangle[t] = triangle_of(corner[0], corner[1 + t], corner[2 + t], normal);
    return polygon;
}

/* Texels of several surfaces in one photon have a mean plane that may pass close to the light, where the
 * polygon is far smaller than what they cover: its radiance would be that much too large. Its plane misses
 * the surface by 0.09 of the radius, as in indirect.c; or by rounding. */
static sl_photon_polygon find_polygon(const sl_radiance_map *map, const sl_map_face *face,
                                      const sl_map_texel *s) {
    const sl_photon_polygon none = {.over_area = 0.0f};
    bool directional = sl_face_is_directional(map, face);
    const sl_texel_rectangle *r = &s->rectangle; /* empty where the light came by mirrors */
    if (!(r->left < r->right) || !(r->bottom < r->top)) return none;
    double width = (face->right - face->left) / face->width * (r->right - r->left);
    double height = (face->top - face->bottom) / face->height * (r->top - r->bottom);
    corner_rays rays = {s->position, s->normal, LONGEST_RAY * s->way, fmax(fabs(width), fabs(height)),
                        directional};
    const double column[4] = {r->left, r->right, r->right, r->left},
                 row[4] = {r->bottom, r->bottom, r->top, r->top};
    sl_vec3d corner[4];
    for (int c = 0; c < 4; c++) {
        sl_vec3d origin, direction;
        sl_map_face_ray(face, directional, column[c], row[c], &origin, &direction);
        if (!meet_plane(&rays, origin, direction, &corner[c])) return none;
    }
    /* Twice the area, along the normal where the corners turn counter-clockwise; a mirrored picture turns
     * them round. */
    sl_vec3d twice = sl_crossd(sl_subd(corner[2], corner[0]), sl_subd(corner[3], corner[1]));
    double area = 0.5 * sl_lengthd(twice);
    if (!isfinite(area) || !((float)area > 0.0f) || 2.0 * area * s->cos_alpha < s->footprint) return none;
    bool turned = sl_dotd(twice, s->normal) < 0.0;
    sl_vec3 in_turn[4];
    for (int c = 0; c < 4; c++) in_turn[c] = sl_to_float(corner[turned ? 3 - c : c]);
    return sl_photon_polygon_of(in_turn, sl_to_float(s->normal), (float)area,
                                sqrtf((float)area) * (s->bent ? 0.05f : 1e-4f));
}

void sl_photon_add(sl_photon_maker *list, const sl_map_face *face, const sl_map_texel *s) {
    sl_map_photons *photons = list->photons;
    if (photons->count == photons->room) return;
    sl_map_photon *photon = &photons->photon[photons->count];
    *photon = (sl_map_photon){.position = sl_to_float(s->position),
                              .footprint = (float)s->footprint,
                              .flux = rgb_of(s->flux),
                              .cos_alpha = (float)fmin(s->cos_alpha, 1.0),
                              .normal = sl_to_float(s->normal),
                              .printed_area = (float)printed_area(list, face, s),
                              .radiance = rgb_of(s->radiance),
                              .samples = (uint32_t)list->samples};
    if (!photon_is_sound(photon)) return;
    if (photons->lobe) {
        /* the material without its texture, which the map's true colour has */
        photons->lobe[photons->count] =
            (sl_photon_lobe){rgb_of(s->color), s->material->specular, s->material->exponent,
                             sl_to_float(s->to_light), sl_to_float(s->shading)};
    }
    if (photons->polygon) photons->polygon[photons->count] = find_polygon(list->map, face, s);
    photons->count++;
}
