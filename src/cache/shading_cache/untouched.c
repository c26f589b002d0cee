/* What outlives an edit: where objects have moved and nothing else has changed, direct light is as it was
 * at a vertex from which no light is seen through a place where something was, or is now. */
#include <math.h>

#include "base/math.h"
#include "cache/shading_cache/state.h"

/* Tells whether a segment from a point to somewhere in a box may meet another box: whether at some share t of
 * the way p + t (light - p) and the box overlap along each axis. */
static bool may_cross(sl_vec3 point, const sl_box *light, const sl_box *box) {
    const float p[3] = {point.x, point.y, point.z},
                low[3] = {light->low.x, light->low.y, light->low.z},
                high[3] = {light->high.x, light->high.y, light->high.z},
                from[3] = {box->low.x, box->low.y, box->low.z},
                to[3] = {box->high.x, box->high.y, box->high.z};
    float t[2] = {0.0f, 1.0f};
    for (int a = 0; a < 3; a++) {
        /* p + t (low - p) <= to, and p + t (high - p) >= from: d t <= room */
        const float d[2] = {low[a] - p[a], p[a] - high[a]}, room[2] = {to[a] - p[a], p[a] - from[a]};
        for (int k = 0; k < 2; k++) {
            if (d[k] > 0.0f) t[1] = fminf(t[1], room[k] / d[k]);
            else if (d[k] < 0.0f) t[0] = fmaxf(t[0], room[k] / d[k]);
            else if (room[k] < 0.0f) return false;
        }
    }
    return t[0] <= t[1];
}

static void hold(sl_box *box, sl_vec3 p) {
    box->low = sl_v3(fminf(box->low.x, p.x), fminf(box->low.y, p.y), fminf(box->low.z, p.z));
    box->high = sl_v3(fmaxf(box->high.x, p.x), fmaxf(box->high.y, p.y), fmaxf(box->high.z, p.z));
}

static const sl_box nowhere = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

/* Lights, a box each; all emissive triangles in one. More than there is room for, or light from infinity:
 * none. */
enum { BOXES = 32 };
static size_t find_lights(const sl_scene *scene, sl_box box[BOXES]) {
    size_t count = 0;
    if (scene->light_count >= BOXES) return 0;
    for (size_t l = 0; l < scene->light_count; l++) {
        if (scene->lights[l].type == SL_LIGHT_DIRECTIONAL) return 0;
        box[count++] = (sl_box){scene->lights[l].position, scene->lights[l].position};
    }
    if (scene->emitter_count == 0) return count;
    box[count] = nowhere;
    for (size_t e = 0; e < scene->emitter_count; e++) {
        for (int c = 0; c < 3; c++)
            hold(&box[count], sl_scene_position(scene, scene->vertex[c][scene->emitters[e].triangle]));
    }
    return count + 1;
}

/* Where things were and are that have moved, a little larger as places are rounded; returns how many. */
static size_t find_moved(const sl_object_places *before, const sl_object_places *after, const bool *moved,
                         float slack, sl_box box[BOXES]) {
    size_t count = 0;
    for (size_t i = 0; i < after->count; i++) {
        if (!moved[i]) continue;
        if (count + 2 > BOXES) return 0;
        box[count++] = before->box[i];
        box[count++] = after->box[i];
    }
    for (size_t i = 0; i < count; i++) {
        box[i].low = sl_sub(box[i].low, sl_v3(slack, slack, slack));
        box[i].high = sl_add(box[i].high, sl_v3(slack, slack, slack));
    }
    return count;
}

/* Only light that comes straight from lamps tells by its way whether something came between. */
static bool is_told_by_lamps(const sl_shading_state *s) {
    bool sky = s->scene->environment.present && s->settings.shading_cache.indirect == SL_INDIRECT_NONE;
    return s->plan.direct && !s->plan.caustics && !sky && (s->layers.kept || !s->plan.indirect);
}

void sl_shading_keep_untouched(sl_shading_state *s, unsigned what, const sl_object_places *after,
                               const bool *moved) {
    sl_box light[BOXES], box[BOXES];
    if (what != SL_CHANGED_OBJECTS || !is_told_by_lamps(s)) return;
    size_t lights = find_lights(s->scene, light),
           boxes = find_moved(s->places, after, moved, 1e-4f * sl_scene_central_diagonal(s->scene), box);
    if (lights == 0 || boxes == 0) return;
    for (uint32_t v = 0; v < s->patches->vertex_count; v++) {
        sl_patch_vertex *vertex = &s->patches->vertex[v];
        if (!vertex->references || vertex->evaluated == SL_VERTEX_NEVER || vertex->extrapolated ||
            moved[sl_root_object(s->primitives, vertex->root)] || sl_vertex_is_stale(s->patches, &s->work, v))
            continue;
        sl_lit_point at;
        sl_vertex_sample_point(s->patches, v, &at);
        bool touched = false;
        for (size_t k = 0; k < lights * boxes && !touched; k++)
            touched = may_cross(at.position, &light[k / boxes], &box[k % boxes]);
        if (!touched) sl_vertex_mark(vertex, s->now + 1);
    }
}
