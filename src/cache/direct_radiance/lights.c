#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/direct_radiance/lights.h"

#include <math.h>
#include <string.h>

/* ---- what a light gives ---- */

/* 1 inside the inner cone, 0 outside the outer one, smoothstep of the cosine between; a step where they are
 * equal. */
static float falloff(const sl_map_light *light, float cosine) {
    if (cosine >= light->cos_inner) return 1.0f;
    if (!(cosine > light->cos_outer)) return 0.0f;
    float x = (cosine - light->cos_outer) / (light->cos_inner - light->cos_outer);
    return x * x * (3.0f - 2.0f * x);
}

sl_rgb sl_map_light_intensity(const sl_map_light *light, sl_vec3 direction) {
    float cosine = sl_dot(light->direction, direction);
    switch (light->kind) {
    case SL_MAP_LIGHT_SPOT: return sl_rgb_scale(light->intensity, falloff(light, cosine));
    case SL_MAP_LIGHT_AREA:
        return sl_rgb_scale(light->intensity, cosine > 0.0f ? cosine : light->two_sided ? -cosine : 0.0f);
    default: return light->intensity;
    }
}

/* Flux over intensity. The smoothstep's mean over its range of cosines is 1/2. */
static double directions_of(const sl_map_light *light) {
    switch (light->kind) {
    case SL_MAP_LIGHT_POINT: return 4.0 * SL_PI;
    case SL_MAP_LIGHT_SPOT:
        return 2.0 * SL_PI * (1.0 - 0.5 * ((double)light->cos_inner + (double)light->cos_outer));
    case SL_MAP_LIGHT_AREA: return light->two_sided ? 2.0 * SL_PI : SL_PI;
    default: return 1.0;
    }
}

sl_rgb sl_map_light_flux(const sl_map_light *light) {
    return sl_rgb_scale(light->intensity, (float)directions_of(light));
}

/* ---- seeds: lights before any are merged ---- */

typedef struct {
    const sl_scene *scene;
    sl_map_lights *out;
    size_t groups, seeds, clusters; /* seeds: the scene's lights, then groups of emitters */
    uint32_t *group;                /* of each emitter */
    uint32_t *cluster;              /* of each seed */
    sl_light_seed *seed;
    sl_vec3d *centre, *normal;      /* of each seed: sums by flux, until they are divided */
    double *weight;                 /* of each cluster: fluxes added */
} finding;

enum { KIND_TWO_SIDED = SL_MAP_LIGHT_AREA + 1 };

static sl_map_light light_of(const sl_light *l) {
    static const sl_map_light_kind kinds[] = {[SL_LIGHT_POINT] = SL_MAP_LIGHT_POINT,
                                              [SL_LIGHT_SPOT] = SL_MAP_LIGHT_SPOT,
                                              [SL_LIGHT_DIRECTIONAL] = SL_MAP_LIGHT_DIRECTIONAL};
    sl_map_light light = {.kind = kinds[l->type],
                          .intensity = l->intensity,
                          .cos_inner = l->cos_inner,
                          .cos_outer = l->cos_outer};
    if (l->type != SL_LIGHT_DIRECTIONAL) light.position = l->position;
    if (l->type != SL_LIGHT_POINT) light.direction = l->direction;
    return light;
}

/* Emitters of different colours are weighed by their mean. */
static double power_of(const sl_emitter *e) {
    return (e->two_sided ? 2.0 : 1.0) * (double)sl_rgb_mean(e->radiance) * (double)e->area *
           (double)e->opaque;
}

/* Of what its mask leaves. */
static sl_vec3d middle_of_masked(const sl_scene *s, uint32_t triangle) {
    sl_vec3d sum = {0}, at;
    const int count = sl_scene_mask_points(s, triangle);
    int opaque = 0;
    for (int i = 0; i < count; i++) {
        if (!sl_map_light_mask_point(s, triangle, i, &at)) continue;
        sum = sl_addd(sum, at);
        opaque++;
    }
    return sl_scaled(sum, opaque > 0 ? 1.0 / opaque : 0.0);
}

static sl_vec3d middle_of(const sl_scene *s, uint32_t triangle) {
    sl_vec3d sum = {0};
    if (sl_scene_has_alpha(s, triangle)) return middle_of_masked(s, triangle);
    for (int k = 0; k < 3; k++)
        sum = sl_addd(sum, sl_to_double(sl_scene_position(s, s->vertex[k][triangle])));
    return sl_scaled(sum, 1.0 / 3.0);
}

static void add_to_seed(finding *f, uint32_t emitter) {
    const sl_emitter *e = &f->scene->emitters[emitter];
    size_t i = f->scene->light_count + f->group[emitter];
    double power = power_of(e);
    f->seed[i].kind = e->two_sided ? KIND_TWO_SIDED : SL_MAP_LIGHT_AREA;
    f->seed[i].power += power;
    f->centre[i] = sl_addd(f->centre[i], sl_scaled(middle_of(f->scene, e->triangle), power));
    f->normal[i] = sl_addd(f->normal[i],
                           sl_scaled(sl_to_double(sl_scene_geometric_normal(f->scene, e->triangle)), power));
}

static void sow(finding *f) {
    const sl_scene *s = f->scene;
    for (size_t i = 0; i < s->light_count; i++) {
        sl_map_light light = light_of(&s->lights[i]);
        double power = (double)sl_rgb_mean(light.intensity) * directions_of(&light);
        f->seed[i] =
            (sl_light_seed){(int)light.kind, power > 0.0 ? power : 0.0, light.position, light.direction};
    }
    for (uint32_t e = 0; e < s->emitter_count; e++) {
        if (f->group[e] != SL_NO_INDEX) add_to_seed(f, e);
    }
    for (size_t i = s->light_count; i < f->seeds; i++) {
        f->seed[i].position = sl_to_float(sl_scaled(f->centre[i], 1.0 / f->seed[i].power));
        f->seed[i].normal =
            sl_normalize_or(sl_to_float(sl_scaled(f->normal[i], 1.0 / f->seed[i].power)), sl_v3(0, 0, 1));
    }
}

/* ---- lights without extent ---- */

/* The merged light stands in the middle by flux, shines as widely as its widest part, and has the flux of
 * both. */
static void merge_light(finding *f, size_t index) {
    const sl_light_seed *seed = &f->seed[index];
    sl_map_light part = light_of(&f->scene->lights[index]), *into = &f->out->light[f->cluster[index]];
    double *weight = &f->weight[f->cluster[index]], share;
    if (*weight < 0.0) {
        *into = part;
        *weight = seed->power;
        return;
    }
    share = *weight + seed->power > 0.0 ? seed->power / (*weight + seed->power) : 0.0;
    sl_rgb flux = sl_rgb_add(sl_map_light_flux(into), sl_map_light_flux(&part));
    into->position = sl_mad(into->position, (float)share, sl_sub(part.position, into->position));
    into->direction = sl_normalize_or(
        sl_mad(into->direction, (float)share, sl_sub(part.direction, into->direction)), into->direction);
    into->cos_inner = part.cos_inner < into->cos_inner ? part.cos_inner : into->cos_inner;
    into->cos_outer = part.cos_outer < into->cos_outer ? part.cos_outer : into->cos_outer;
    double directions = directions_of(into);
    into->intensity = sl_rgb_scale(flux, directions > 0.0 ? (float)(1.0 / directions) : 0.0f);
    *weight += seed->power;
}

/* ---- area lights ---- */

static uint32_t light_of_emitter(const finding *f, uint32_t emitter) {
    return f->group[emitter] == SL_NO_INDEX ? SL_NO_INDEX
                                            : f->cluster[f->scene->light_count + f->group[emitter]];
}

static void add_emitter(finding *f, uint32_t emitter, uint32_t light) {
    const sl_emitter *e = &f->scene->emitters[emitter];
    sl_map_light *l = &f->out->light[light];
    l->kind = SL_MAP_LIGHT_AREA;
    l->two_sided = e->two_sided;
    l->count++;
    f->out->light_of_triangle[e->triangle] = light;
}

/* Sums over the emitters in double; the strongest one's normal where normals cancel. */
static void place_area_light(const finding *f, sl_map_light *l) {
    sl_vec3d centre = {0}, normal = {0}, intensity = {0};
    double sum = 0.0, most = -1.0, area = 0.0;
    sl_vec3 strongest = {0};
    for (size_t i = 0; i < l->count; i++) {
        const sl_emitter *e = &f->scene->emitters[f->out->emitter[l->first + i]];
        sl_vec3 n = sl_scene_geometric_normal(f->scene, e->triangle);
        double power = power_of(e);
        sum += power;
        area += (double)e->area;
        intensity = sl_addd(intensity, sl_scaled(sl_v3d(e->radiance.r, e->radiance.g, e->radiance.b),
                                                 (double)e->area * (double)e->opaque));
        centre = sl_addd(centre, sl_scaled(middle_of(f->scene, e->triangle), power));
        normal = sl_addd(normal, sl_scaled(sl_to_double(n), power));
        if (power > most) strongest = n;
        most = power > most ? power : most;
    }
    l->area = (float)area;
    l->intensity = (sl_rgb){(float)intensity.x, (float)intensity.y, (float)intensity.z};
    l->position = sl_to_float(sl_scaled(centre, 1.0 / sum));
    normal = sl_scaled(normal, 1.0 / sum);
    l->direction = sl_lengthd(normal) > 1e-3 ? sl_normalize_or(sl_to_float(normal), strongest) : strongest;
}

float sl_map_light_clearance(const sl_scene *scene, const sl_map_lights *lights, size_t light, sl_vec3 eye,
                             bool back) {
    const sl_map_light *l = &lights->light[light];
    sl_vec3d n = sl_scaled(sl_to_double(l->direction), back ? -1.0 : 1.0), o = sl_to_double(eye);
    double most = 0.0;
    for (size_t i = 0; i < l->count; i++) {
        uint32_t triangle = scene->emitters[lights->emitter[l->first + i]].triangle;
        for (int k = 0; k < 3; k++) {
            double height =
                sl_dotd(n, sl_subd(sl_to_double(sl_scene_position(scene, scene->vertex[k][triangle])), o));
            most = height > most ? height : most;
        }
    }
    return (float)most;
}

/* A bulging light hides what lies before it from its own middle. */
static void bring_forward(const finding *f, size_t light) {
    sl_map_light *l = &f->out->light[light];
    float height = l->two_sided ? 0.0f : sl_map_light_clearance(f->scene, f->out, light, l->position, false);
    if (height > 1e-5f * f->scene->scale) l->position = sl_mad(l->position, height, l->direction);
}

static void gather_emitters(finding *f) {
    sl_map_lights *out = f->out;
    size_t count = 0;
    for (uint32_t e = 0; e < f->scene->emitter_count; e++) {
        uint32_t light = light_of_emitter(f, e);
        if (light != SL_NO_INDEX) add_emitter(f, e, light);
    }
    for (size_t i = 0; i < out->count; i++) {
        out->light[i].first = count;
        count += out->light[i].count;
        out->light[i].count = 0;
    }
    out->emitter_count = count;
    for (uint32_t e = 0; e < f->scene->emitter_count; e++) {
        uint32_t light = light_of_emitter(f, e);
        if (light != SL_NO_INDEX) out->emitter[out->light[light].first + out->light[light].count++] = e;
    }
    for (size_t i = 0; i < out->count; i++) {
        if (out->light[i].kind != SL_MAP_LIGHT_AREA) continue;
        place_area_light(f, &out->light[i]);
        bring_forward(f, i);
    }
}

/* ---- all ---- */

static sl_status divide(finding *f, int n, sl_error *error) {
    sl_map_lights *out = f->out;
    size_t most = 0;
    for (size_t i = 0; i < out->count; i++)
        most += out->light[i].kind == SL_MAP_LIGHT_AREA ? (size_t)n * (size_t)n : 1;
    out->point = sl_allocate(most, sizeof *out->point);
    if (!out->point) return sl_fail_memory(error, "the lights' points");
    for (size_t i = 0; i < out->count; i++) {
        const sl_map_light *l = &out->light[i];
        sl_map_light_point *point = out->point + out->point_count;
        size_t count = 1;
        if (l->kind == SL_MAP_LIGHT_AREA)
            count = sl_map_light_divide(f->scene, l, out->emitter + l->first, n, point);
        else *point = (sl_map_light_point){.position = l->position, .intensity = l->intensity};
        for (size_t k = 0; k < count; k++) point[k].light = (uint32_t)i;
        out->point_count += count;
        if (l->kind != SL_MAP_LIGHT_DIRECTIONAL) out->flux = sl_rgb_add(out->flux, sl_map_light_flux(l));
    }
    return SL_OK;
}

static sl_status merge(finding *f, sl_error *error) {
    f->seeds = f->scene->light_count + f->groups;
    f->seed = sl_allocate(f->seeds, sizeof *f->seed);
    f->cluster = sl_allocate(f->seeds, sizeof *f->cluster);
    f->centre = sl_allocate(f->seeds, sizeof *f->centre);
    f->normal = sl_allocate(f->seeds, sizeof *f->normal);
    if (!f->seed || !f->cluster || !f->centre || !f->normal) return sl_fail_memory(error, "the lights");
    sow(f);
    return sl_light_seeds_merge(f->seed, f->seeds, SL_MAP_LIGHTS_MAX, sl_scene_central_diagonal(f->scene),
                                f->cluster, &f->clusters, error);
}

static sl_status make(finding *f, int subdivision, sl_error *error) {
    const sl_scene *s = f->scene;
    sl_map_lights *out = f->out;
    out->count = f->clusters;
    out->light = sl_allocate(out->count, sizeof *out->light);
    out->emitter = sl_allocate(s->emitter_count, sizeof *out->emitter);
    f->weight = sl_allocate(out->count, sizeof *f->weight);
    if (s->emitter_count)
        out->light_of_triangle = sl_allocate(s->triangle_count, sizeof *out->light_of_triangle);
    if (!out->light || !out->emitter || !f->weight || (s->emitter_count && !out->light_of_triangle))
        return sl_fail_memory(error, "the lights");
    for (size_t i = 0; i < out->count; i++) f->weight[i] = -1.0;
    for (size_t t = 0; out->light_of_triangle && t < s->triangle_count; t++)
        out->light_of_triangle[t] = SL_NO_INDEX;
    for (size_t i = 0; i < s->light_count; i++) merge_light(f, i);
    gather_emitters(f);
    return divide(f, subdivision, error);
}

sl_status sl_map_lights_find(const sl_scene *scene, int subdivision, sl_map_lights **lights,
                             sl_error *error) {
    *lights = NULL;
    if (subdivision < 1 || subdivision > 64)
        return sl_fail(error, SL_ERROR_USAGE,
                       "area lights are divided into 1 x 1 to 64 x 64 points, not %d x %d", subdivision,
                       subdivision);
    finding f = {.scene = scene,
                 .out = sl_allocate(1, sizeof *f.out),
                 .group = sl_allocate(scene->emitter_count, sizeof *f.group)};
    sl_status status = f.out && f.group ? sl_emitters_group(scene, f.group, &f.groups, error)
                                        : sl_fail_memory(error, "the lights");
    if (status == SL_OK) status = merge(&f, error);
    if (status == SL_OK) status = make(&f, subdivision, error);
    sl_free(f.group);
    sl_free(f.seed);
    sl_free(f.cluster);
    sl_free(f.centre);
    sl_free(f.normal);
    sl_free(f.weight);
    if (status != SL_OK) sl_map_lights_destroy(f.out);
    else *lights = f.out;
    return status;
}

static void copy_points(const sl_map_lights *lights, sl_map_lights *out) {
    out->count = out->point_count = lights->point_count;
    out->emitter_count = lights->emitter_count;
    out->flux = lights->flux;
    if (out->emitter_count) memcpy(out->emitter, lights->emitter, out->emitter_count * sizeof *out->emitter);
    for (size_t i = 0; i < out->count; i++) {
        const sl_map_light_point *point = &lights->point[i];
        out->light[i] = lights->light[point->light];
        out->light[i].position = point->position;
        out->light[i].intensity = point->intensity;
        out->point[i] = (sl_map_light_point){(uint32_t)i, point->position, point->intensity};
    }
}

sl_status sl_map_lights_by_point(const sl_map_lights *lights, sl_map_lights **by_point, sl_error *error) {
    *by_point = NULL;
    if (lights->point_count == lights->count || lights->point_count > SL_MAP_POINTS_MAX) return SL_OK;
    sl_map_lights *out = sl_allocate(1, sizeof *out);
    if (!out) return sl_fail_memory(error, "the lights' points");
    out->light = sl_allocate(lights->point_count, sizeof *out->light);
    out->point = sl_allocate(lights->point_count, sizeof *out->point);
    out->emitter = sl_allocate(lights->emitter_count + 1, sizeof *out->emitter);
    if (!out->light || !out->point || !out->emitter) {
        sl_map_lights_destroy(out);
        return sl_fail_memory(error, "the lights' points");
    }
    copy_points(lights, out);
    *by_point = out;
    return SL_OK;
}

void sl_map_lights_destroy(sl_map_lights *lights) {
    if (!lights) return;
    sl_free(lights->light);
    sl_free(lights->emitter);
    sl_free(lights->light_of_triangle);
    sl_free(lights->point);
    sl_free(lights);
}

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

/* Of a spot: nearest to its axis are the middles of the sides' upper edges, at 45 degrees, and the back's
 * corners, at acos(-1/sqrt 3); a little more, for rounding. */
bool sl_light_shines_on(const sl_map_light *light, int side) {
    static const float nearest[3] = {2.0f, 0.7071070f, -0.5773500f};
    if (light->kind == SL_MAP_LIGHT_AREA) return side != SL_LIGHT_BACK || light->two_sided;
    if (light->kind != SL_MAP_LIGHT_SPOT) return true;
    return light->cos_outer < nearest[side == SL_LIGHT_AHEAD ? 0 : side == SL_LIGHT_BACK ? 2 : 1];
}

sl_view sl_light_picture_view(const sl_scene *scene, const sl_map_light *light, const sl_light_picture *p) {
    sl_view view = sl_view_pyramid(&p->frame, p->eye, (float)p->left, (float)p->right, (float)p->bottom,
                                   (float)p->top, p->width, p->height, 1e-5f * scene->scale);
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

static float reach_along(sl_vec3 axis, sl_vec3 half) {
    return fabsf(axis.x * half.x) + fabsf(axis.y * half.y) + fabsf(axis.z * half.z);
}

sl_parallel_picture sl_parallel_picture_of(const sl_scene *scene, const sl_map_light *light) {
    sl_vec3 half = sl_scale(sl_sub(scene->box_max, scene->box_min), 0.5f);
    float margin = 1e-3f * scene->diagonal;
    sl_parallel_picture p = {.centre = sl_add(scene->box_min, half),
                             .frame = sl_frame_from_normal(light->direction)};
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
    sl_view view = {.origin = p->centre,
                    .width = width,
                    .height = height,
                    .depth = SL_DEPTH_WINDOW,
                    .skip_triangle = SL_NO_INDEX};
    set_row(view.clip[0], p->frame.x, p->reach_x);
    set_row(view.clip[1], p->frame.y, p->reach_y);
    set_row(view.clip[2], p->frame.z, p->reach_z);
    view.clip[3][3] = 1.0f;
    return view;
}
