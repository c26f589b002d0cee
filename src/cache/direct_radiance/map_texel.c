/* From a texel of the map to the light that leaves the surface there. */
#include "cache/direct_radiance/map_texel.h"

#include "base/math.h"

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

void sl_map_face_ray(const sl_map_face *face, bool directional, double column, double row, sl_vec3d *origin, sl_vec3d *direction) {
    double u = face->left + (face->right - face->left) * (column / (double)face->width);
    double v = face->bottom + (face->top - face->bottom) * (row / (double)face->height);
    sl_vec3d x = sl_to_double(face->frame.x), y = sl_to_double(face->frame.y), z = sl_to_double(face->frame.z);
    sl_vec3d aside = sl_addd(sl_scaled(x, u), sl_scaled(y, v)), eye = sl_to_double(face->eye);
    *origin = directional ? sl_addd(eye, aside) : eye;
    *direction = directional ? z : sl_addd(z, aside);
}

/* Way, direction of arrival and perpendicular area of a texel. */
static bool find_way(const sl_radiance_map *map, const sl_map_face *face, size_t i, sl_map_texel *t) {
    t->way = (double)map->path[i];
    t->footprint = (double)map->block_angle[i]; /* of a directional light: an area already */
    if (map->spread && map->spread[i] > 0.0f) {
        t->footprint = (double)map->spread[i];
        t->to_light = plane_at(map->arrival, i);
        if (!make_unit(&t->to_light)) return false;
    } else if (map->lights->light[face->light].kind == SL_MAP_LIGHT_DIRECTIONAL) {
        t->to_light = sl_to_double(sl_neg(face->frame.z));
    } else {
        t->to_light = sl_subd(sl_to_double(face->eye), t->position);
        t->way = sl_lengthd(t->to_light);
        t->to_light = sl_scaled(t->to_light, 1.0 / t->way); /* at the light itself NaN, and near: dropped */
        t->footprint *= t->way * t->way;
    }
    return t->footprint > 0.0 && isfinite(t->footprint) && t->way >= 0.0;
}

/* The direction in which the texel's light left the light. Its image in a mirror shines as it does itself: the mirror's plane lies halfway
 * between. What came by curved mirrors left along the picture's ray, and arrives from somewhere else. */
static sl_vec3 as_it_left(const sl_radiance_map *map, const sl_map_face *face, size_t i, const sl_map_texel *t) {
    const sl_map_light *light = &map->lights->light[face->light];
    sl_vec3d direction = sl_scaled(t->to_light, -1.0), origin;
    if (map->spread && map->spread[i] > 0.0f) {
        size_t texel = i - face->first, width = (size_t)face->width;
        sl_map_face_ray(face, false, (double)(texel % width) + 0.5, (double)(texel / width) + 0.5, &origin, &direction);
    }
    sl_vec3d across = sl_subd(sl_to_double(light->position), sl_to_double(face->eye));
    if (face->mirror != SL_NO_INDEX && make_unit(&across)) {
        direction = sl_subd(direction, sl_scaled(across, 2.0 * sl_dotd(direction, across)));
    }
    return sl_normalize_or(sl_to_float(direction), sl_v3(0.0f, 0.0f, 1.0f));
}

/* I dOmega: what leaves the light within the texel, less the mirrors' share. */
static bool find_arriving(const sl_radiance_map *map, const sl_map_face *face, size_t i, sl_map_texel *t) {
    const sl_map_light *light = &map->lights->light[face->light];
    bool by_direction = light->kind == SL_MAP_LIGHT_SPOT || light->kind == SL_MAP_LIGHT_AREA;
    sl_rgb intensity = by_direction ? sl_map_light_intensity(light, as_it_left(map, face, i, t)) : light->intensity;
    intensity = sl_rgb_mul(intensity, face->reflectance);
    if (map->spread && map->spread[i] > 0.0f) {
        intensity = sl_rgb_mul(intensity, (sl_rgb){map->carried[0][i], map->carried[1][i], map->carried[2][i]});
    }
    const double c[3] = {(double)intensity.r, (double)intensity.g, (double)intensity.b};
    bool any = false;
    for (int k = 0; k < 3; k++) {
        t->arriving[k] = c[k] > 0.0 ? c[k] * (double)map->block_angle[i] : 0.0;
        any |= t->arriving[k] > 0.0;
        if (!isfinite(t->arriving[k])) return false;
    }
    return any;
}

/* Psi = L_o A = rho I dOmega / pi cos_s / cos_alpha, where cos_s is the shading normal's cosine, in L_o, and cos_alpha the geometric
 * one's, in A: 1 to another on facets. On rounded silhouettes the quotient can be huge. No surface sends on more than arrives:
 * pi Psi <= I dOmega bounds it, in all channels by one factor, so that the hue stays. */
static void find_flux(const sl_radiance_map *map, sl_map_texel *t) {
    double share = 1.0, reflected[3];
    if (map->lambertian) {
        double area = t->footprint / t->cos_alpha;
        for (int k = 0; k < 3; k++) {
            t->flux[k] = t->color[k] > 0.0 ? t->color[k] * area : 0.0;
            double most = t->arriving[k] * (1.0 / SL_PI);
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
        for (int k = 0; k < 3; k++) reflected[k] *= t->flux[k] = t->arriving[k] * share;
    }
    t->luminance = sl_luminance_of(reflected);
}

bool sl_map_texel_read(const sl_scene *scene, const sl_radiance_map *map, const sl_map_face *face, int column, int row,
                       const double *color, sl_map_texel *t) {
    size_t i = sl_map_texel_index(face, column, row);
    if (map->triangle[i] == SL_NO_INDEX) return false;
    t->position = plane_at(map->position, i);
    if (!is_finite(t->position) || !find_way(map, face, i, t)) return false;
    bool directional = map->lights->light[face->light].kind == SL_MAP_LIGHT_DIRECTIONAL;
    if (!directional && t->way < SL_PHOTON_NEAREST_LIGHT * (double)sl_scene_core_diagonal(scene)) return false;

    t->normal = plane_at(map->geometric, i);
    if (!make_unit(&t->normal)) return false;
    t->shading = t->normal;
    if (map->normal[0]) {
        sl_vec3d shading = plane_at(map->normal, i);
        if (make_unit(&shading)) t->shading = shading;
    }
    t->cos_alpha = fmax(sl_dotd(t->normal, t->to_light), SL_TEXEL_COS_MIN);
    t->material = &scene->materials[scene->material_index[map->triangle[i]]];
    t->object = scene->object_index[map->triangle[i]];
    for (int k = 0; k < 3; k++) {
        t->color[k] = color ? color[k] : (double)map->color[k][i];
        if (!(t->color[k] >= 0.0) || !isfinite(t->color[k])) return false;
    }
    if (!find_arriving(map, face, i, t)) return false;
    find_flux(map, t);
    return t->luminance > 0.0 && isfinite(t->luminance);
}
