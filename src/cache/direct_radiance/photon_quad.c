/* The polygon that a photon stands for: where the corner rays of its part of the picture meet its tangent plane. */
#include "cache/direct_radiance/photon_list.h"

/* A corner farther from the light than so many times b is not that surface any more; of parallel light, one that is so many widths away. */
#define LONGEST_RAY 4.0

typedef struct corner_rays {
    sl_vec3d point, normal;
    double longest;    /* of a ray from the light */
    double width;      /* of the picture's part, for parallel light */
    bool directional;
} corner_rays;

static bool meet_plane(const corner_rays *rays, sl_vec3d origin, sl_vec3d direction, sl_vec3d *corner) {
    double towards = sl_dotd(direction, rays->normal), way = sl_dotd(sl_subd(rays->point, origin), rays->normal);
    double t = way / towards; /* may be infinite or NaN */
    if (!(towards < 0.0) || !isfinite(t)) return false;
    *corner = sl_addd(origin, sl_scaled(direction, t));
    if (rays->directional) return sl_lengthd(sl_subd(*corner, rays->point)) <= LONGEST_RAY * rays->width;
    return t > 0.0 && t * sl_lengthd(direction) <= rays->longest;
}

void sl_photon_quad_find(const sl_radiance_map *map, const sl_map_face *face, const sl_photon_sample *s, sl_photon_quad *quad) {
    *quad = (sl_photon_quad){0};
    bool directional = sl_face_is_directional(map, face);
    const sl_texel_rectangle *r = &s->rectangle;
    if (!(r->left < r->right) || !(r->bottom < r->top)) return;
    double width = (face->right - face->left) / face->width * (r->right - r->left);
    double height = (face->top - face->bottom) / face->height * (r->top - r->bottom);
    corner_rays rays = {s->position, s->normal, LONGEST_RAY * s->way, fmax(fabs(width), fabs(height)), directional};
    const double column[4] = {r->left, r->right, r->right, r->left}, row[4] = {r->bottom, r->bottom, r->top, r->top};
    sl_vec3d corner[4];
    for (int c = 0; c < 4; c++) {
        sl_vec3d origin, direction;
        sl_map_face_ray(face, directional, column[c], row[c], &origin, &direction);
        if (!meet_plane(&rays, origin, direction, &corner[c])) return;
    }
    /* Twice the area, along the normal where the corners turn counter-clockwise; a mirrored picture turns them round. */
    sl_vec3d twice = sl_crossd(sl_subd(corner[2], corner[0]), sl_subd(corner[3], corner[1]));
    double area = 0.5 * sl_lengthd(twice);
    if (!(area > 0.0) || !isfinite(area) || !((float)area > 0.0f)) return;
    bool turned = sl_dotd(twice, s->normal) < 0.0;
    for (int c = 0; c < 4; c++) quad->corner[c] = sl_to_float(corner[turned ? 3 - c : c]);
    quad->count = 4;
    quad->area = (float)area;
}
