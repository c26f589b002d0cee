#include "cache/light/depth_cube.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"

#include <math.h>
#include <string.h>

/* ---- pictures ---- */

sl_frame sl_light_frame(const sl_light_source *light) {
    sl_vec3 z = light->kind == SL_SOURCE_POINT ? sl_v3(0, -1, 0) : light->direction;
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

/* Of a spot: nearest to its axis are the middles of the sides' upper edges, at 45 degrees, and the back's
 * corners, at acos(-1/sqrt 3); a little more, for rounding. */
bool sl_light_shines_on(const sl_light_source *light, int side) {
    static const float nearest[3] = {2.0f, 0.7071070f, -0.5773500f};
    if (light->kind == SL_SOURCE_AREA) return side != SL_LIGHT_BACK || light->two_sided;
    if (light->kind != SL_SOURCE_SPOT) return true;
    return light->cos_outer < nearest[side == SL_LIGHT_AHEAD ? 0 : side == SL_LIGHT_BACK ? 2 : 1];
}

sl_view sl_pyramid_view(const sl_scene *scene, const sl_light_source *light, const sl_pyramid_picture *p) {
    sl_view view =
        sl_view_pyramid(&p->frame, light->position, (float)p->left, (float)p->right, (float)p->bottom,
                        (float)p->top, p->width, p->height, 1e-5f * scene->scale);
    if (light->kind != SL_SOURCE_AREA) return view;
    /* An oblique near plane: 1/w depth has no use for the row (mirror.h), and the sides keep w positive. */
    sl_vec3 n = p->back ? sl_neg(light->direction) : light->direction;
    float *near = view.clip[2];
    near[0] = n.x;
    near[1] = n.y;
    near[2] = n.z;
    near[3] = -(light->clearance[p->back] + 4e-6f * scene->scale);
    return view;
}

static float extent_along(sl_vec3 axis, sl_vec3 half) {
    return fabsf(axis.x * half.x) + fabsf(axis.y * half.y) + fabsf(axis.z * half.z);
}

sl_parallel_picture sl_parallel_picture_of(const sl_scene *scene, sl_vec3 direction) {
    sl_vec3 half = sl_scale(sl_sub(scene->box_max, scene->box_min), 0.5f);
    float margin = 1e-3f * scene->diagonal;
    sl_parallel_picture p = {.centre = sl_add(scene->box_min, half),
                             .frame = sl_frame_from_normal(direction)};
    p.extent_x = extent_along(p.frame.x, half) + margin;
    p.extent_y = extent_along(p.frame.y, half) + margin;
    p.extent_z = extent_along(p.frame.z, half) + margin;
    return p;
}

static void set_row(float row[4], sl_vec3 axis, float extent) {
    row[0] = axis.x / extent;
    row[1] = axis.y / extent;
    row[2] = axis.z / extent;
}

sl_view sl_parallel_view(const sl_parallel_picture *p, int width, int height) {
    sl_view view = {.origin = p->centre,
                    .width = width,
                    .height = height,
                    .depth = SL_DEPTH_WINDOW,
                    .skip_triangle = SL_NO_INDEX};
    set_row(view.clip[0], p->frame.x, p->extent_x);
    set_row(view.clip[1], p->frame.y, p->extent_y);
    set_row(view.clip[2], p->frame.z, p->extent_z);
    view.clip[3][3] = 1.0f;
    return view;
}

/* ---- what to draw ---- */

/* A pass, which draws one side's picture or half of it. */
typedef struct {
    sl_view view;
    int side;
} side_pass;

enum { PASSES_MAX = 2 + 2 * 4 };

typedef struct {
    const sl_scene *scene;
    const sl_raster *raster;
    const sl_light_source *light;
    unsigned threads;
    sl_counters *counters;
} drawing;

/* Returns a picture of the side, without its lower half (half > 0) or its upper one (half < 0). */
static sl_view view_of_side(const drawing *d, const sl_depth_cube *cube, int side, int half) {
    double tangent = (double)cube->tangent * (double)cube->size / (double)(cube->size - 2);
    bool back = side == SL_LIGHT_BACK || half < 0;
    sl_pyramid_picture picture = {sl_light_side(&cube->frame, side),
                                -tangent,
                                tangent,
                                -tangent,
                                tangent,
                                cube->size,
                                cube->size,
                                back};
    sl_view view = sl_pyramid_view(d->scene, d->light, &picture);
    if (half)
        view.scissor = (sl_scissor){0, half > 0 ? cube->size / 2 : 0, cube->size,
                                    half > 0 ? cube->size : cube->size / 2};
    return view;
}

static void propose(const drawing *d, const sl_view *view, int side, bool shines, side_pass *pass,
                    size_t *count) {
    if (shines && sl_raster_meets(d->raster, view)) pass[(*count)++] = (side_pass){*view, side};
    else sl_count(d->counters, SL_COUNT_RASTER_PASSES_SKIPPED, 1);
}

/* An area light's front and back see what lies on their own sides only. */
static size_t passes_of(const drawing *d, const sl_depth_cube *cube, side_pass pass[PASSES_MAX]) {
    const sl_light_source *light = d->light;
    const bool area = light->kind == SL_SOURCE_AREA;
    size_t count = 0;
    for (int side = 0; side < SL_LIGHT_SIDES; side++) {
        bool halves = area && side != SL_LIGHT_AHEAD && side != SL_LIGHT_BACK,
             shines = sl_light_shines_on(light, side);
        sl_view view = view_of_side(d, cube, side, halves ? 1 : 0);
        propose(d, &view, side, shines, pass, &count);
        if (!halves || !light->two_sided) continue;
        view = view_of_side(d, cube, side, -1);
        propose(d, &view, side, shines, pass, &count);
    }
    return count;
}

/* ---- drawing ---- */

/* Megabytes, of which passes write what they draw: only what they leave out is cleared. */
static bool allocate(sl_depth_cube *cube, size_t pictures) {
    size_t zeros = sl_depth_zeros(cube->size), texels = (size_t)cube->size * (size_t)cube->size;
    cube->texels = zeros + pictures * texels;
    cube->depth = sl_allocate_unset(cube->texels, sizeof *cube->depth);
    if (cube->depth) memset(cube->depth, 0, zeros * sizeof *cube->depth);
    return cube->depth != NULL;
}

/* Clears the half of a side that an area light does not see. */
static void clear_other_half(const sl_depth_cube *cube, const side_pass *pass) {
    const sl_scissor *drawn = &pass->view.scissor;
    const size_t width = (size_t)cube->size, half = width / 2;
    float *picture = cube->depth + cube->start[pass->side];
    if (drawn->y0 > 0) memset(picture, 0, half * width * sizeof *picture);
    else if (drawn->y1 == (int)half)
        memset(picture + half * width, 0, (width - half) * width * sizeof *picture);
}

static void give_picture(sl_depth_cube *cube, int side, size_t *next) {
    size_t zeros = sl_depth_zeros(cube->size), texels = (size_t)cube->size * (size_t)cube->size;
    if (cube->mask[side]) return;
    cube->start[side] = (int32_t)(zeros + (*next)++ * texels);
    cube->mask[side] = -1;
}

static sl_status draw_cube(const drawing *d, sl_depth_cube *cube, sl_error *error) {
    side_pass pass[PASSES_MAX];
    sl_view views[PASSES_MAX];
    sl_target targets[PASSES_MAX];
    size_t passes = passes_of(d, cube, pass), pictures = 0;
    for (size_t i = 0; i < passes; i++) give_picture(cube, pass[i].side, &pictures);
    if (!allocate(cube, pictures)) return sl_fail_memory(error, "a depth cube");
    for (size_t i = 0; i < passes; i++) clear_other_half(cube, &pass[i]);
    for (size_t i = 0; i < passes; i++) {
        views[i] = pass[i].view;
        targets[i] = (sl_target){cube->size, cube->size, NULL, cube->depth + cube->start[pass[i].side]};
    }
    return passes ? sl_raster_ids(d->raster, passes, views, d->threads, targets, d->counters, error) : SL_OK;
}

static sl_status draw_parallel(const drawing *d, sl_depth_cube *cube, sl_error *error) {
    sl_parallel_picture p = sl_parallel_picture_of(d->scene, d->light->direction);
    sl_view view = sl_parallel_view(&p, cube->size, cube->size);
    size_t pictures = 0, texels = (size_t)cube->size * (size_t)cube->size;
    cube->directional = true;
    cube->eye = p.centre;
    cube->frame = p.frame;
    cube->extent_x = p.extent_x;
    cube->extent_y = p.extent_y;
    cube->extent_z = p.extent_z;
    give_picture(cube, 0, &pictures);
    if (!allocate(cube, 1)) return sl_fail_memory(error, "a directional light's depths");
    float *depth = cube->depth + cube->start[0];
    sl_target target = {cube->size, cube->size, NULL, depth};
    sl_status status = sl_raster_id(d->raster, &view, d->threads, &target, d->counters, error);
    for (size_t i = 0; i < texels && status == SL_OK; i++) depth[i] = 1.0f - depth[i];
    return status;
}

/* ---- a cube ---- */

/* Returns half the width of the pictures at distance 1: a cone that the one ahead holds wastes none of it. */
static float tangent_of(const sl_light_source *light) {
    if (light->kind != SL_SOURCE_SPOT || sl_light_shines_on(light, 1)) return 1.0f;
    double c = (double)light->cos_outer, tangent = c < 1.0 ? sqrt(1.0 - c * c) / c : 0.0;
    return tangent < 0.001 ? 0.001f : tangent < 1.0 ? (float)tangent : 1.0f;
}

sl_status sl_depth_cube_draw(const sl_scene *scene, const sl_raster *raster, const sl_light_source *light,
                             bool dark, int size, unsigned threads, sl_depth_cube *cube,
                             sl_counters *counters, sl_error *error) {
    const drawing d = {scene, raster, light, threads, counters};
    const bool parallel = light->kind == SL_SOURCE_DIRECTIONAL;
    *cube = (sl_depth_cube){.size = size,
                            .eye = light->position,
                            .frame = sl_light_frame(light),
                            .tangent = tangent_of(light),
                            .rounding = 4e-7f * sl_scene_coordinate_near(scene, scene->central_min)};
    if (!dark && sl_is_finite(light->position))
        return parallel ? draw_parallel(&d, cube, error) : draw_cube(&d, cube, error);
    sl_count(counters, SL_COUNT_RASTER_PASSES_SKIPPED, parallel ? 1 : SL_LIGHT_SIDES);
    return allocate(cube, 0) ? SL_OK : sl_fail_memory(error, "a depth cube");
}

void sl_depth_cube_release(sl_depth_cube *cube) {
    sl_free(cube->depth);
    cube->depth = NULL;
}
