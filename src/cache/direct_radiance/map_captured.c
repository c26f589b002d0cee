/* How much of a light's flux leaves inside its map's pictures: in closed form for points and areas. */
#include <math.h>

#include "base/math.h"
#include "cache/direct_radiance/footprint.h"
#include "cache/direct_radiance/light_sides.h"
#include "cache/direct_radiance/map_faces.h"

/* Form factor of a face towards a plane at its eye: Lambert's formula, of a rectangle that lies above the plane. */
static double cosine_share(const sl_map_face *f, sl_vec3 normal) {
    const sl_vec3d n = {(double)sl_dot(normal, f->frame.x), (double)sl_dot(normal, f->frame.y), (double)sl_dot(normal, f->frame.z)};
    const sl_vec3d corner[4] = {{f->left, f->bottom, 1}, {f->right, f->bottom, 1}, {f->right, f->top, 1}, {f->left, f->top, 1}};
    double sum = 0.0;
    for (int k = 0; k < 4; k++) {
        const sl_vec3d a = corner[k], b = corner[(k + 1) % 4];
        const sl_vec3d across = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
        double length = sqrt(sl_dotd(across, across));
        if (length > 0.0) sum += sl_atan2(length, sl_dotd(a, b)) * sl_dotd(across, n) / length;
    }
    return fabs(sum) / (2.0 * SL_PI);
}

/* A spot's: its intensity at the middles of many cells, times their solid angles. */
static double spot_flux(const sl_map_light *light, const sl_map_face *f) {
    enum { CELLS = 96 };
    double sum = 0.0, wide = (f->right - f->left) / CELLS, high = (f->top - f->bottom) / CELLS;
    for (int i = 0; i < CELLS * CELLS; i++) {
        double x = f->left + wide * (0.5 + (double)(i % CELLS)), y = f->bottom + high * (0.5 + (double)(i / CELLS));
        double squared = 1.0 + x * x + y * y, inverse = 1.0 / sqrt(squared);
        sl_vec3 d = sl_frame_to_world(&f->frame, sl_v3((float)(x * inverse), (float)(y * inverse), (float)inverse));
        sum += (double)sl_rgb_mean(sl_map_light_intensity(light, d)) * wide * high * inverse / squared;
    }
    return sum;
}

/* The cone's half angle is at most that of the frustum. */
static bool holds_cone(const sl_map_light *light, const sl_map_face *face, int count, int dark) {
    double c = (double)light->cos_outer, reach = face->right;
    bool ahead = sl_dot(face->frame.z, light->direction) > 0.999999f;
    if (count == 1 && dark == 0) return ahead && c > 0.0 && 1.0 - c * c <= reach * reach * c * c * (1.0 + 1e-6);
    return count + dark == SL_LIGHT_SIDES || (ahead && c >= 0.0); /* a cube; a hemicube */
}

static double share_of(const sl_map_light *light, const sl_planned_face *face, int count, int dark, double flux) {
    double sum = 0.0;
    if (light->kind == SL_MAP_LIGHT_SPOT && holds_cone(light, &face->face, count, dark)) return 1.0;
    for (int i = 0; i < count; i++) {
        const sl_map_face *f = &face[i].face;
        sum += light->kind == SL_MAP_LIGHT_POINT  ? sl_rectangle_solid_angle(f->left, f->bottom, f->right, f->top) / (4.0 * SL_PI)
               : light->kind == SL_MAP_LIGHT_AREA ? cosine_share(f, light->direction) / (light->two_sided ? 2.0 : 1.0)
                                                  : spot_flux(light, f) / flux;
    }
    return sum < 1.0 ? sum : 1.0;
}

double sl_radiance_map_captured(const sl_radiance_map *map, uint32_t light) {
    const sl_map_light *l = &map->lights->light[light];
    sl_face_shape shape = {map->shape, map->fov, 2, 1};
    sl_planned_face face[SL_LIGHT_FACES_MAX];
    const float clearance[2] = {0};
    double flux = (double)sl_rgb_mean(sl_map_light_flux(l));
    int dark;
    if (l->kind == SL_MAP_LIGHT_DIRECTIONAL || !(flux > 0.0)) return 1.0;
    int count = sl_light_faces(NULL, l, &shape, sl_v3(0, -1, 0), clearance, face, &dark);
    return count ? share_of(l, face, count, dark, flux) : 0.0;
}
