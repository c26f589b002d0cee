#include "app/load_options.h"

#include <string.h>

static const double degree = 0.017453292519943295;

void sl_load_options_table(sl_load_request *r, sl_option *options) {
    sl_viewpoint *v = &r->view;
    const sl_option own[] = {
        {"eye", 0, SL_OPTION_VECTOR, r->eye, &v->has_eye, "X,Y,Z",
         "where the camera stands, as softlux info tells places [the scene's]", 0, 0, NULL},
        {"target", 0, SL_OPTION_VECTOR, r->target, &v->has_target, "X,Y,Z",
         "what it looks at [the scene's; with --eye the middle of its box]", 0, 0, NULL},
        {"up", 0, SL_OPTION_VECTOR, r->up, &v->has_up, "X,Y,Z",
         "what is up in the picture [the scene's; with --eye or --target 0,1,0]", 0, 0, NULL},
        {"fov", 0, SL_OPTION_REAL, &r->fov_degrees, &v->has_fov, "DEGREES",
         "field of view from top to bottom [the scene's]", 0.01, 179.0, NULL},
        {"up-axis", 0, SL_OPTION_CHOICE, &r->up_axis, NULL, "AXIS",
         "of a mesh file, y or z points up [auto: as its format says; else by its shape]", 0, 0, "auto|y|z"},
        {"allow-outside", 0, SL_OPTION_FLAG, &r->allow_outside, NULL, NULL,
         "files that the scene names may lie outside of its folder", 0, 0, NULL},
    };
    _Static_assert(sizeof own / sizeof own[0] == SL_LOAD_OPTIONS, "as many as are promised");
    memcpy(options, own, sizeof own);
}

static void to_floats(const double from[3], float to[3]) {
    for (int i = 0; i < 3; i++) to[i] = (float)from[i];
}

sl_load_options sl_load_options_taken(sl_load_request *r) {
    sl_viewpoint *v = &r->view;
    to_floats(r->eye, v->eye);
    to_floats(r->target, v->target);
    to_floats(r->up, v->up);
    v->vertical_fov_rad = (float)(r->fov_degrees * degree);
    bool any = v->has_eye || v->has_target || v->has_up || v->has_fov;
    return (sl_load_options){r->allow_outside, (sl_up_axis)r->up_axis, any ? v : NULL};
}
