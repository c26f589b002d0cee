#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/direct_radiance/map.h"
#include "trace/bsdf.h"
#include "trace/trace.h"

#include <string.h>

enum {
    PIXELS = 256, /* resolved together */
    VIEWS = 8     /* drawn together */
};

/* ---- one texel ---- */

/* Rounds a coordinate as an 8-bit colour holds it: scaled into the scene's box, in steps of 1/255 of its
 * extent. */
static float eight_bits(float value, float low, float high) {
    float extent = high - low;
    if (!(extent > 0.0f)) return low;
    float step = floorf((value - low) / extent * 255.0f + 0.5f);
    step = step > 0.0f ? step : 0.0f;
    return low + (step < 255.0f ? step : 255.0f) / 255.0f * extent;
}

static void put(float *const plane[3], size_t i, float x, float y, float z) {
    plane[0][i] = x, plane[1][i] = y, plane[2][i] = z;
}

static void write_position(const sl_map_drawing *d, size_t i, const sl_surface *s, float way) {
    const sl_scene *scene = d->scene;
    sl_radiance_map *map = d->map;
    sl_vec3 p = s->position;
    if (d->settings->eight_bit_positions) {
        p = sl_v3(eight_bits(p.x, scene->box_min.x, scene->box_max.x),
                  eight_bits(p.y, scene->box_min.y, scene->box_max.y),
                  eight_bits(p.z, scene->box_min.z, scene->box_max.z));
    }
    put(map->position, i, p.x, p.y, p.z);
    put(map->geometric, i, s->geometric_normal.x, s->geometric_normal.y, s->geometric_normal.z);
    map->path[i] = way;
}

/* Light at a texel: it arrives along `arrival` (unit, at y towards it) with irradiance `facing` on a plane
 * that faces it. */
typedef struct {
    sl_vec3 arrival;
    sl_rgb facing;
    float way;
} texel_light;

/* L_o = rho / pi E. Where numbers overflow (the light in the surface): nothing. */
static void write_color(const sl_map_drawing *d, size_t i, const sl_surface *s, const texel_light *light) {
    sl_rgb color = s->diffuse;
    if (d->map->lambertian) {
        float cosine = sl_dot(s->normal, light->arrival);
        float scale = (float)(1.0 / SL_PI) *
                      (cosine > 0.0f && sl_dot(s->geometric_normal, light->arrival) > 0.0f ? cosine : 0.0f);
        color = sl_rgb_scale(sl_rgb_mul(color, light->facing), scale);
        if (!sl_rgb_is_finite(color)) color = sl_grey(0.0f);
    }
    put(d->map->color, i, color.r, color.g, color.b);
}

static void write_texel(const sl_map_drawing *d, size_t i, const sl_surface *s, const texel_light *light) {
    write_position(d, i, s, light->way);
    write_color(d, i, s, light);
    if (d->map->normal[0]) put(d->map->normal, i, s->normal.x, s->normal.y, s->normal.z);
}

/* Returns the light that comes straight to y. */
static texel_light light_at(const sl_map_drawing *d, const sl_map_face *face, sl_vec3 y) {
    const sl_map_light *light = &d->map->lights->light[face->light];
    sl_vec3d way = sl_subd(sl_to_double(y), sl_to_double(face->eye));
    if (light->kind == SL_SOURCE_DIRECTIONAL) {
        return (texel_light){sl_neg(face->frame.z), light->intensity,
                             (float)sl_dotd(way, sl_to_double(face->frame.z))};
    }
    double squared = sl_dotd(way, way), length = sqrt(squared);
    if (!(squared > 0.0) || !isfinite(squared)) return (texel_light){face->frame.z, {0, 0, 0}, 0.0f};
    sl_vec3 direction = sl_to_float(sl_scaled(way, 1.0 / length));
    sl_rgb intensity = sl_map_light_intensity(light, direction);
    return (texel_light){sl_neg(direction), sl_rgb_scale(intensity, (float)(1.0 / squared)), (float)length};
}

/* ---- one face ---- */

typedef struct {
    const sl_map_drawing *drawing;
    uint64_t *shaded; /* by face */
} resolution;

static void resolve_texel(const sl_map_drawing *d, const sl_map_face *face, size_t i, float w1, float w2) {
    uint32_t triangle = d->map->triangle[i];
    sl_surface surface;
    /* Every point of the triangle is seen from the same side. */
    sl_vec3 to_light = sl_sub(face->eye, sl_scene_position(d->scene, d->scene->vertex[0][triangle]));
    if (d->map->lights->light[face->light].kind == SL_SOURCE_DIRECTIONAL) to_light = sl_neg(face->frame.z);
    sl_scene_surface(d->scene, triangle, w1, w2, to_light, &surface);
    texel_light light = light_at(d, face, surface.position);
    write_texel(d, i, &surface, &light);
}

static void resolve_face(void *context, size_t index, unsigned worker) {
    (void)worker;
    const resolution *r = context;
    const sl_map_drawing *d = r->drawing;
    const sl_map_face *face = &d->map->face[index];
    size_t texels = (size_t)face->width * (size_t)face->height;
    uint32_t pixel[PIXELS];
    float w1[PIXELS], w2[PIXELS];
    for (size_t first = 0; first < texels; first += PIXELS) {
        size_t count = texels - first < PIXELS ? texels - first : PIXELS;
        for (size_t i = 0; i < count; i++) pixel[i] = (uint32_t)(first + i);
        sl_raster_barycentrics(d->raster, &face->view, count, pixel, d->map->triangle + face->first + first,
                               w1, w2);
        for (size_t i = 0; i < count; i++) {
            size_t texel = face->first + first + i;
            if (d->map->triangle[texel] == SL_NO_INDEX) continue;
            resolve_texel(d, face, texel, w1[i], w2[i]);
            r->shaded[index]++;
        }
    }
}

/* ---- all ---- */

/* Draws the faces' triangles, some at a time: each view of a call takes a tile's memory. */
static sl_status draw_triangles(const sl_map_drawing *d, sl_error *error) {
    sl_radiance_map *map = d->map;
    sl_status status = SL_OK;
    for (size_t first = 0; first < map->face_count && status == SL_OK; first += VIEWS) {
        sl_view views[VIEWS];
        sl_target targets[VIEWS];
        size_t count = 0;
        for (; count < VIEWS && first + count < map->face_count; count++) {
            const sl_map_face *face = &map->face[first + count];
            views[count] = face->view;
            targets[count] = (sl_target){face->width, face->height, map->triangle + face->first, NULL};
        }
        status =
            sl_raster_ids(d->raster, count, views, d->options->threads, targets, d->counters, error);
    }
    return status;
}

sl_status sl_map_pictures_draw(const sl_map_drawing *d, sl_error *error) {
    size_t faces = d->map->face_count;
    if (!faces) return SL_OK;
    resolution r = {d, sl_allocate(faces, sizeof *r.shaded)};
    if (!r.shaded) return sl_fail_memory(error, "a radiance map's faces");
    sl_status status = draw_triangles(d, error);
    if (status == SL_OK) {
        sl_parallel_for(sl_thread_count(d->options->threads), faces, resolve_face, &r);
        for (size_t f = 0; f < faces; f++) sl_count(d->counters, SL_COUNT_FRAGMENTS_SHADED, r.shaded[f]);
        /* Four floats a texel; 8-bit positions have four bytes. */
        size_t bytes = (d->settings->eight_bit_positions ? 4u : 16u) + (d->map->normal[0] ? 32u : 16u);
        sl_count(d->counters, SL_COUNT_BYTES_READ_BACK, bytes * d->map->texels);
    }
    sl_free(r.shaded);
    return status;
}

/* A texel's light leaves as a narrow pyramid. Its middle ray gives the end point y, its four corner rays what
 * becomes of its cross-section: a convex mirror spreads it, a concave one draws it together. The area between
 * their ends, seen along the middle ray, takes the place of b^2 dOmega. */

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

static void aim(const sl_map_face *f, bool directional, int column, int row, leg way[RAYS]) {
    static const double place[RAYS][2] = {{0.5, 0.5}, {0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int k = 0; k < RAYS; k++) {
        sl_vec3d origin, direction;
        sl_map_face_ray(f, directional, (double)column + place[k][0], (double)row + place[k][1], &origin,
                        &direction);
        way[k] = (leg){.origin = sl_to_float(origin),
                       .direction = sl_normalize_or(sl_to_float(direction), f->frame.z),
                       .carried = {1, 1, 1},
                       .from = SL_NO_INDEX,
                       .going = true};
    }
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
    way->direction = sl_normalize_or(sl_reflect_off(way->direction, s.normal, s.geometric_normal),
                                     s.geometric_normal);
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
        for (unsigned i = 0; i < count; i++)
            arrive(d->scene, hits.triangle[i], hits.t[i], hits.w1[i], hits.w2[i], &way[which[i]]);
    }
}

/* ---- the area at their end ---- */

static sl_vec3d end_of(const sl_map_drawing *d, const leg *way) {
    sl_surface s;
    sl_scene_surface(d->scene, way->triangle, way->w1, way->w2, sl_neg(way->direction), &s);
    return sl_to_double(s.position);
}

/* Returns the area between the corner rays' ends, perpendicular to the middle ray; `flat`, as if the mirrors
 * were, where not all corners go the middle's way (the texel lies across the mirror's rim). Never so small
 * that radiance would grow without bound where light is focused. */
static float spread_of(const sl_map_drawing *d, const leg way[RAYS], double flat) {
    sl_vec3d corner[4];
    for (int k = 0; k < 4; k++) {
        if (!way[k + 1].arrived || way[k + 1].mirrors != way[0].mirrors) return (float)flat;
        corner[k] = end_of(d, &way[k + 1]);
    }
    const sl_vec3d twice = sl_crossd(sl_subd(corner[2], corner[0]), sl_subd(corner[3], corner[1]));
    return (float)fmax(0.5 * fabs(sl_dotd(twice, sl_to_double(way[0].direction))), 1e-4 * flat);
}

/* ---- texels ---- */

static bool shows_mirror(const sl_map_drawing *d, size_t i) {
    const uint32_t t = d->map->triangle[i];
    return t != SL_NO_INDEX && sl_material_is_mirror(&d->scene->materials[d->scene->material_index[t]]);
}

static void write_end(const sl_map_drawing *d, const sl_map_face *f, size_t i, sl_vec3 departure,
                      const leg way[RAYS]) {
    sl_radiance_map *map = d->map;
    const sl_map_light *light = &map->lights->light[f->light];
    const double size = (double)map->block_angle[i]; /* of directional light: an area already */
    const double flat = light->kind == SL_SOURCE_DIRECTIONAL ? size : way[0].way * way[0].way * size;
    sl_surface end;
    sl_scene_surface(d->scene, way[0].triangle, way[0].w1, way[0].w2, sl_neg(way[0].direction), &end);
    float spread = spread_of(d, way, flat);
    if (!(spread > 0.0f) || !isfinite(spread)) return;
    sl_rgb carried = sl_rgb_mul(sl_map_light_intensity(light, departure), way[0].carried);
    texel_light arriving = {sl_neg(way[0].direction), sl_rgb_scale(carried, map->block_angle[i] / spread),
                            (float)way[0].way};
    map->triangle[i] = way[0].triangle;
    map->spread[i] = spread;
    put(map->arrival, i, arriving.arrival.x, arriving.arrival.y, arriving.arrival.z);
    put(map->carried, i, way[0].carried.r, way[0].carried.g, way[0].carried.b);
    write_texel(d, i, &end, &arriving);
}

typedef struct {
    const sl_map_drawing *drawing;
    sl_counters *counters; /* by face */
} tracing;

static void trace_face(void *context, size_t index, unsigned worker) {
    (void)worker;
    const tracing *t = context;
    const sl_map_drawing *d = t->drawing;
    const sl_map_face *f = &d->map->face[index];
    const bool directional = d->map->lights->light[f->light].kind == SL_SOURCE_DIRECTIONAL;
    for (int row = 0; row < f->height; row++) {
        for (int column = 0; column < f->width; column++) {
            const size_t i = sl_map_texel_index(f, column, row);
            leg way[RAYS];
            if (!shows_mirror(d, i)) continue;
            aim(f, directional, column, row, way);
            sl_vec3 departure = way[0].direction;
            follow(d, way, &t->counters[index]);
            if (way[0].arrived) write_end(d, f, i, departure, way);
        }
    }
}

sl_status sl_map_trace_mirrors(const sl_map_drawing *drawing, sl_error *error) {
    size_t faces = drawing->map->face_count;
    tracing t = {drawing, sl_allocate(faces, sizeof *t.counters)};
    if (!t.counters) return sl_fail_memory(error, "mirrors in a light's view");
    sl_parallel_for(sl_thread_count(drawing->options->threads), faces, trace_face, &t);
    for (size_t f = 0; f < faces; f++) sl_counters_add(drawing->counters, &t.counters[f]);
    sl_free(t.counters);
    return SL_OK;
}
