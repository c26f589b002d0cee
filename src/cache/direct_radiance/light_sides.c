#include "cache/direct_radiance/light_sides.h"

#include <math.h>

sl_frame sl_light_frame(const sl_map_light *light) {
    sl_vec3 z = light->kind == SL_MAP_LIGHT_POINT ? sl_v3(0, -1, 0) : light->direction;
    return sl_frame_from_normal(z);
}

sl_frame sl_light_side(const sl_frame *f, int side) {
    switch (side) {
    case 0: return *f;
    case 1: return (sl_frame){f->y, f->z, f->x};
    case 2: return (sl_frame){f->y, f->z, sl_neg(f->x)};
    case 3: return (sl_frame){f->x, f->z, f->y};
    case 4: return (sl_frame){f->x, f->z, sl_neg(f->y)};
    default: return (sl_frame){f->x, f->y, sl_neg(f->z)};
    }
}

/* Of a spot: nearest to its axis are the middles of the sides' upper edges, at 45 degrees, and the back's corners, at
 * acos(-1/sqrt 3); a little more, for rounding. */
bool sl_light_shines_on(const sl_map_light *light, int side) {
    static const float nearest[3] = {2.0f, 0.7071070f, -0.5773500f};
    if (light->kind == SL_MAP_LIGHT_AREA) return side != SL_LIGHT_BACK || light->two_sided;
    if (light->kind != SL_MAP_LIGHT_SPOT) return true;
    return light->cos_outer < nearest[side == SL_LIGHT_AHEAD ? 0 : side == SL_LIGHT_BACK ? 2 : 1];
}

sl_view sl_light_picture_view(const sl_scene *scene, const sl_map_light *light, const sl_light_picture *p) {
    sl_view view = sl_view_pyramid(&p->frame, p->eye, (float)p->left, (float)p->right, (float)p->bottom, (float)p->top, p->width,
                                   p->height, 1e-5f * scene->scale);
    if (light->kind != SL_MAP_LIGHT_AREA) return view;
    /* An oblique near plane: 1/w depth has no use for the row (mirror.h), and the sides keep w positive. */
    sl_vec3 n = p->back ? sl_neg(light->direction) : light->direction;
    float *near = view.clip[2];
    near[0] = n.x;
    near[1] = n.y;
    near[2] = n.z;
    near[3] = -(p->clearance + 4e-6f * scene->scale);
    return view;
}

static float reach_along(sl_vec3 axis, sl_vec3 half) { return fabsf(axis.x * half.x) + fabsf(axis.y * half.y) + fabsf(axis.z * half.z); }

sl_parallel_picture sl_parallel_picture_of(const sl_scene *scene, const sl_map_light *light) {
    sl_vec3 half = sl_scale(sl_sub(scene->box_max, scene->box_min), 0.5f);
    float margin = 1e-3f * scene->diagonal;
    sl_parallel_picture p = {.centre = sl_add(scene->box_min, half), .frame = sl_frame_from_normal(light->direction)};
    p.reach_x = reach_along(p.frame.x, half) + margin;
    p.reach_y = reach_along(p.frame.y, half) + margin;
    p.reach_z = reach_along(p.frame.z, half) + margin;
    return p;
}

static void set_row(float row[4], sl_vec3 axis, float reach) {
    row[0] = axis.x / reach;
    row[1] = axis.y / reach;
    row[2] = axis.z / reach;
}

sl_view sl_parallel_view(const sl_parallel_picture *p, int width, int height) {
    sl_view view = {.origin = p->centre, .width = width, .height = height, .depth = SL_DEPTH_WINDOW, .skip_triangle = SL_NO_INDEX};
    set_row(view.clip[0], p->frame.x, p->reach_x);
    set_row(view.clip[1], p->frame.y, p->reach_y);
    set_row(view.clip[2], p->frame.z, p->reach_z);
    view.clip[3][3] = 1.0f;
    return view;
}
