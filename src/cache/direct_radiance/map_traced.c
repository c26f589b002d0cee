/* A texel's light leaves as a narrow pyramid. Its middle ray gives the end point y, its four corner rays what becomes of its cross-section:
 * a convex mirror spreads it, a concave one draws it together. Where all five end by way of mirrors, the corner rays' last legs are cut with
 * y's tangent plane; the quad's area, seen along the middle ray, is the spread that takes the place of b^2 dOmega. */
#include "cache/direct_radiance/map_traced.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "trace/trace.h"

enum { RAYS = 5, LEGS_MAX = 9 };

/* The last leg of a way over mirrors. */
typedef struct {
    sl_vec3 origin, direction; /* unit */
    sl_rgb carried;            /* reflectances, multiplied */
    double way;                /* of the legs so far */
    uint32_t from;             /* the mirror that the leg leaves */
    int mirrors;
    bool going, arrived;
    uint32_t triangle;         /* where it ends */
    float w1, w2;
} leg;

/* ---- following rays ---- */

static void aim(const sl_map_face *f, int column, int row, leg way[RAYS]) {
    static const double place[RAYS][2] = {{0.5, 0.5}, {0, 0}, {1, 0}, {1, 1}, {0, 1}};
    double wide = (f->right - f->left) / (double)f->width, high = (f->top - f->bottom) / (double)f->height;
    for (int k = 0; k < RAYS; k++) {
        float x = (float)(f->left + wide * ((double)column + place[k][0])), y = (float)(f->bottom + high * ((double)row + place[k][1]));
        sl_vec3 direction = sl_normalize_or(sl_frame_to_world(&f->frame, sl_v3(x, y, 1.0f)), f->frame.z);
        way[k] = (leg){.origin = f->eye, .direction = direction, .carried = {1, 1, 1}, .from = SL_NO_INDEX, .going = true};
    }
}

/* Reflected about the shading normal; about the geometric one where that would lead into the mirror. */
static sl_vec3 reflect(sl_vec3 d, const sl_surface *s) {
    sl_vec3 r = sl_mad(d, -2.0f * sl_dot(d, s->normal), s->normal);
    if (!(sl_dot(r, s->geometric_normal) > 0.0f)) r = sl_mad(d, -2.0f * sl_dot(d, s->geometric_normal), s->geometric_normal);
    return sl_normalize_or(r, s->geometric_normal);
}

static void arrive(const sl_scene *scene, uint32_t triangle, float t, float w1, float w2, leg *way) {
    sl_surface s;
    way->going = false;
    if (triangle == SL_NO_INDEX) return;
    sl_scene_surface(scene, triangle, w1, w2, sl_neg(way->direction), &s);
    way->way += (double)t;
    if (!sl_material_is_mirror(s.material)) {
        way->arrived = way->mirrors > 0;
        way->triangle = triangle;
        way->w1 = w1;
        way->w2 = w2;
        return;
    }
    way->going = ++way->mirrors < LEGS_MAX;
    way->carried = sl_rgb_mul(way->carried, s.material->mirror);
    way->direction = reflect(way->direction, &s);
    way->origin = s.position;
    way->from = triangle;
}

static void follow(const sl_map_drawing *d, leg way[RAYS], sl_counters *counters) {
    for (int leg_number = 0; leg_number < LEGS_MAX; leg_number++) {
        sl_ray16 rays = {0};
        sl_hit16 hits;
        int which[RAYS];
        unsigned count = 0;
        for (int k = 0; k < RAYS; k++) {
            if (!way[k].going) continue;
            sl_ray16_set(&rays, count, way[k].origin, way[k].direction,
                         (leg_number ? 1e-6f : 1e-5f) * d->scene->scale, INFINITY, way[k].from);
            which[count++] = k;
        }
        if (!count) return;
        sl_trace(d->options->tracer, &rays, count, false, &hits, counters);
        for (unsigned i = 0; i < count; i++) arrive(d->scene, hits.triangle[i], hits.t[i], hits.w1[i], hits.w2[i], &way[which[i]]);
    }
}

/* ---- the area at their end ---- */

/* Where a leg meets the plane through y; false if it does not, in front of it. */
static bool meet(const leg *way, sl_vec3d y, sl_vec3d n, sl_vec3d *p) {
    sl_vec3d o = sl_to_double(way->origin), d = sl_to_double(way->direction);
    double slope = sl_dotd(d, n), t = sl_dotd(sl_subd(y, o), n) / (slope < 0.0 ? slope : -1.0);
    *p = sl_addd(o, sl_scaled(d, t));
    return way->arrived && slope < -1e-4 && t > 0.0 && isfinite(t);
}

/* Perpendicular to the middle ray. Of four corners or three; without as many (the texel lies across the mirror's rim), as if the mirrors
 * were flat. Never so small that radiance would grow without bound where light is focused. */
static float spread_of(const leg way[RAYS], const sl_surface *end, double angle) {
    sl_vec3d y = sl_to_double(end->position), n = sl_to_double(end->geometric_normal), corner[4];
    double flat = way[0].way * way[0].way * angle, cosine = fabs(sl_dotd(n, sl_to_double(way[0].direction))), area;
    bool met[4];
    int count = 0;
    for (int k = 0; k < 4; k++) count += met[k] = meet(&way[k + 1], y, n, &corner[k]) && way[k + 1].mirrors == way[0].mirrors;
    if (count == 4) {
        area = 0.5 * sl_lengthd(sl_crossd(sl_subd(corner[2], corner[0]), sl_subd(corner[3], corner[1])));
    } else if (count == 3) {
        int missing = 0;
        while (met[missing]) missing++;
        sl_vec3d a = corner[(missing + 2) % 4];
        area = sl_lengthd(sl_crossd(sl_subd(corner[(missing + 1) % 4], a), sl_subd(corner[(missing + 3) % 4], a)));
    } else {
        return (float)flat;
    }
    double spread = area * cosine, least = 1e-4 * flat;
    return (float)(spread > least ? spread : least);
}

/* ---- texels ---- */

static bool shows_curved_mirror(const sl_map_drawing *d, size_t i) {
    uint32_t t = d->map->triangle[i];
    if (t == SL_NO_INDEX || !sl_material_is_mirror(&d->scene->materials[d->scene->material_index[t]])) return false;
    return !d->options->mirrors || d->options->mirrors->of_triangle[t] == SL_NO_INDEX;
}

static void write_end(const sl_map_drawing *d, const sl_map_face *f, size_t i, sl_vec3 departure, const leg way[RAYS]) {
    sl_radiance_map *map = d->map;
    const sl_map_light *light = &map->lights->light[f->light];
    sl_surface end;
    sl_scene_surface(d->scene, way[0].triangle, way[0].w1, way[0].w2, sl_neg(way[0].direction), &end);
    float spread = spread_of(way, &end, (double)map->block_angle[i]);
    if (!(spread > 0.0f) || !isfinite(spread)) return;
    sl_rgb carried = sl_rgb_mul(sl_map_light_intensity(light, departure), way[0].carried);
    sl_texel_light arriving = {sl_neg(way[0].direction), sl_rgb_scale(carried, map->block_angle[i] / spread), (float)way[0].way};
    map->triangle[i] = way[0].triangle;
    map->spread[i] = spread;
    map->arrival[0][i] = arriving.arrival.x;
    map->arrival[1][i] = arriving.arrival.y;
    map->arrival[2][i] = arriving.arrival.z;
    map->carried[0][i] = way[0].carried.r;
    map->carried[1][i] = way[0].carried.g;
    map->carried[2][i] = way[0].carried.b;
    sl_map_texel_write(d, i, &end, &arriving);
}

typedef struct {
    const sl_map_drawing *drawing;
    sl_counters *counters; /* by face */
} tracing;

/* Faces of planar mirrors show what light meets after that one; curved mirrors in them are not followed, nor those of parallel light. */
static void trace_face(void *context, size_t index, unsigned worker) {
    (void)worker;
    const tracing *t = context;
    const sl_map_drawing *d = t->drawing;
    const sl_map_face *f = &d->map->face[index];
    if (f->mirror != SL_NO_INDEX || d->map->lights->light[f->light].kind == SL_MAP_LIGHT_DIRECTIONAL) return;
    for (int row = 0; row < f->height; row++) {
        for (int column = 0; column < f->width; column++) {
            size_t i = f->first + (size_t)row * (size_t)f->width + (size_t)column;
            leg way[RAYS];
            if (!shows_curved_mirror(d, i)) continue;
            aim(f, column, row, way);
            sl_vec3 departure = way[0].direction;
            follow(d, way, &t->counters[index]);
            if (way[0].arrived) write_end(d, f, i, departure, way);
        }
    }
}

sl_status sl_map_trace_mirrors(const sl_map_drawing *drawing, sl_error *error) {
    size_t faces = drawing->map->face_count;
    tracing t = {drawing, sl_allocate(faces, sizeof *t.counters)};
    if (!t.counters) return sl_fail_memory(error, "traced mirrors");
    sl_parallel_for(sl_thread_count(drawing->options->threads), faces, trace_face, &t);
    for (size_t f = 0; f < faces; f++) sl_counters_add(drawing->counters, &t.counters[f]);
    sl_free(t.counters);
    return SL_OK;
}
