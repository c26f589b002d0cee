#include "cache/light/light_kernels.h"

#include <float.h>

#include "base/error.h"
#include "base/memory.h"

size_t sl_emitter_sides(const sl_scene *scene) {
    size_t sides = 0;
    for (size_t i = 0; i < scene->emitter_count; i++) sides += scene->emitters[i].two_sided ? 2 : 1;
    return sides;
}

sl_light_source sl_light_source_of(const sl_light *light) {
    return (sl_light_source){.kind = (sl_source_kind)light->type,
                             .position = light->position,
                             .direction = light->direction,
                             .cos_inner = light->cos_inner,
                             .cos_outer = light->cos_outer,
                             .colour = light->intensity};
}

void sl_polygon_light_bound(sl_polygon_light *p) {
    const sl_vec3 centre = sl_scale(sl_add(sl_add(p->corner[0], p->corner[1]), p->corner[2]), 1.0f / 3.0f);
    p->bounds = sl_box_empty();
    p->extent_squared = 0.0f;
    for (int c = 0; c < 3; c++) {
        const sl_vec3 d = sl_sub(p->corner[c], centre);
        sl_box_add(&p->bounds, p->corner[c]);
        p->extent_squared = fmaxf(p->extent_squared, sl_dot(d, d));
    }
}

sl_polygon_light sl_polygon_light_of(const sl_scene *scene, const sl_emitter *e, bool back) {
    sl_polygon_light p = {.normal = sl_scene_geometric_normal(scene, e->triangle), .area = e->area};
    for (int c = 0; c < 3; c++) p.corner[c] = sl_scene_position(scene, scene->vertex[c][e->triangle]);
    if (back) {
        sl_vec3 first = p.corner[1];
        p.corner[1] = p.corner[2];
        p.corner[2] = first;
        p.normal = sl_neg(p.normal);
    }
    sl_polygon_light_bound(&p);
    return p;
}

/* ---- all sides ---- */

static bool any_masked(const sl_scene *scene) {
    for (size_t i = 0; i < scene->emitter_count; i++) {
        if (sl_scene_has_alpha(scene, scene->emitters[i].triangle)) return true;
    }
    return false;
}

static void add_side(const sl_scene *scene, const sl_emitter *e, bool back, sl_light_sides *s) {
    size_t k = s->count++;
    sl_polygon_light *p = &s->polygon[k];
    *p = sl_polygon_light_of(scene, e, back);
    s->emitter[k] = (uint32_t)(e - scene->emitters);
    float luminance = sl_luminance(e->radiance), *v = s->values + k * SL_SIDE_VALUES;
    sl_vec3 parts[4] = {p->corner[0], sl_sub(p->corner[1], p->corner[0]), sl_sub(p->corner[2], p->corner[0]),
                        p->normal};
    for (int i = 0; i < 4; i++) {
        v[3 * i] = parts[i].x;
        v[3 * i + 1] = parts[i].y;
        v[3 * i + 2] = parts[i].z;
    }
    v[12] = p->area;
    v[13] = luminance > 0.0f ? e->radiance.r / luminance : 0.0f; /* 1 / luminance may be infinite */
    v[14] = luminance > 0.0f ? e->radiance.g / luminance : 0.0f;
    v[15] = luminance > 0.0f ? e->radiance.b / luminance : 0.0f;
    s->luminance[k] = luminance;
}

/* Powers of two change no bit of a share. */
static void choose_unit(sl_light_sides *s) {
    float strongest = 0.0f;
    int exponent = 0;
    for (size_t k = 0; k < s->count; k++) strongest = fmaxf(strongest, s->luminance[k]);
    if (strongest > 0.0f && isfinite(strongest)) (void)frexpf(strongest, &exponent);
    exponent = exponent > FLT_MAX_EXP - 1 ? FLT_MAX_EXP - 1 : exponent;
    s->unit = ldexpf(1.0f, exponent);
    for (size_t k = 0; k < s->count; k++) s->luminance[k] = ldexpf(s->luminance[k], -exponent);
}

sl_status sl_light_sides_make(const sl_scene *scene, size_t most, sl_light_sides *s, sl_error *error) {
    size_t sides = sl_emitter_sides(scene);
    *s = (sl_light_sides){.unit = 1.0f};
    if (sides == 0 || sides > most || any_masked(scene)) return SL_OK;
    s->polygon = sl_allocate(sides, sizeof *s->polygon);
    s->values = sl_allocate(sides * SL_SIDE_VALUES, sizeof *s->values);
    s->luminance = sl_allocate(sides, sizeof *s->luminance);
    s->emitter = sl_allocate(sides, sizeof *s->emitter);
    if (!s->polygon || !s->values || !s->luminance || !s->emitter)
        return sl_fail_memory(error, "direct light");
    for (size_t i = 0; i < scene->emitter_count; i++) {
        add_side(scene, &scene->emitters[i], false, s);
        if (scene->emitters[i].two_sided) add_side(scene, &scene->emitters[i], true, s);
    }
    choose_unit(s);
    return SL_OK;
}

void sl_light_sides_release(sl_light_sides *s) {
    sl_free(s->polygon);
    sl_free(s->values);
    sl_free(s->luminance);
    sl_free(s->emitter);
    *s = (sl_light_sides){.count = 0};
}
