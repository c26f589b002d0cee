/* Pass 2: a face's picture is the G-buffer that the rasterizer makes of it, in one pass with multiple render
 * targets; mirrors in it show what they light, as they show pixels what they reflect. */
#include "base/batch.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/direct_radiance/map.h"
#include "cache/reflect/reflect.h"

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

static void put(float *const plane[3], size_t i, sl_vec3 v) {
    plane[0][i] = v.x, plane[1][i] = v.y, plane[2][i] = v.z;
}

static void write_position(const sl_map_drawing *d, size_t i, sl_vec3 p) {
    const sl_scene *scene = d->scene;
    if (d->settings->eight_bit_positions)
        p = sl_v3(eight_bits(p.x, scene->box_min.x, scene->box_max.x),
                  eight_bits(p.y, scene->box_min.y, scene->box_max.y),
                  eight_bits(p.z, scene->box_min.z, scene->box_max.z));
    put(d->map->position, i, p);
}

/* Light at a texel: it arrives along `arrival` (unit, at y towards it) with irradiance `facing` on a plane
 * that faces it. */
typedef struct {
    sl_vec3 arrival;
    sl_rgb facing;
    float way;
} texel_light;

/* L_o = rho / pi E, or rho itself. Where numbers overflow (the light in the surface): nothing. */
static sl_rgb color_of(const sl_map_drawing *d, sl_rgb diffuse, sl_vec3 normal, sl_vec3 geometric,
                       const texel_light *light) {
    if (!d->map->lambertian) return diffuse;
    const float cosine = sl_dot(normal, light->arrival);
    const float scale = (float)(1.0 / SL_PI) *
                        (cosine > 0.0f && sl_dot(geometric, light->arrival) > 0.0f ? cosine : 0.0f);
    const sl_rgb color = sl_rgb_scale(sl_rgb_mul(diffuse, light->facing), scale);
    return sl_rgb_is_finite(color) ? color : sl_grey(0.0f);
}

static void write_texel(const sl_map_drawing *d, const sl_gbuffer *g, size_t pixel, size_t i,
                        const texel_light *light) {
    const sl_rgb diffuse = {g->diffuse_r[pixel], g->diffuse_g[pixel], g->diffuse_b[pixel]};
    const sl_vec3 normal = sl_gbuffer_normal(g, pixel),
                  geometric = sl_gbuffer_geometric(g, pixel);
    const sl_rgb color = color_of(d, diffuse, normal, geometric, light);
    write_position(d, i, sl_gbuffer_position(g, pixel));
    put(d->map->geometric, i, geometric);
    put(d->map->color, i, sl_v3(color.r, color.g, color.b));
    if (d->map->normal[0]) put(d->map->normal, i, normal);
    d->map->triangle[i] = g->id[pixel];
    d->map->path[i] = light->way;
}

/* ---- light that comes straight, and by way of mirrors ---- */

static const sl_map_light *light_of(const sl_map_drawing *d, const sl_map_face *face) {
    return &d->map->lights->light[face->light];
}

static texel_light light_at(const sl_map_drawing *d, const sl_map_face *face, sl_vec3 y) {
    const sl_map_light *light = light_of(d, face);
    sl_vec3d way = sl_subd(sl_to_double(y), sl_to_double(face->eye));
    if (light->source.kind == SL_SOURCE_DIRECTIONAL) {
        return (texel_light){sl_neg(face->frame.z), light->source.colour,
                             (float)sl_dotd(way, sl_to_double(face->frame.z))};
    }
    double squared = sl_dotd(way, way), length = sqrt(squared);
    if (!(squared > 0.0) || !isfinite(squared)) return (texel_light){face->frame.z, {0, 0, 0}, 0.0f};
    sl_vec3 direction = sl_to_float(sl_scaled(way, 1.0 / length));
    sl_rgb intensity = sl_map_light_intensity(light, direction);
    return (texel_light){sl_neg(direction), sl_rgb_scale(intensity, (float)(1.0 / squared)), (float)length};
}

/* Writes what mirror pixel k shows, lit as if from the light's mirror image: a planar mirror keeps solid
 * angles, and the whole way is b. */
static void write_mirrored(const sl_map_drawing *d, const sl_map_face *face, const sl_gbuffer *g,
                           const sl_reflections *r, size_t k) {
    sl_radiance_map *map = d->map;
    const size_t pixel = r->pixel[k], i = face->first + pixel;
    const bool parallel = light_of(d, face)->source.kind == SL_SOURCE_DIRECTIONAL;
    const sl_vec3 y = sl_gbuffer_position(g, pixel);
    const sl_vec3 arrival = sl_normalize_or(sl_sub(g->seen_from[pixel], y), sl_v3(0, 0, 0));
    const sl_vec3 left = sl_map_face_departure(face, pixel);
    sl_rgb carried = sl_rgb_mul(sl_map_light_intensity(light_of(d, face), left), r->throughput[k]);
    if (!parallel) carried = sl_rgb_scale(carried, 1.0f / (r->way[k] * r->way[k]));
    map->triangle[i] = SL_NO_INDEX;
    if (g->id[pixel] == SL_NO_INDEX || !(r->way[k] > 0.0f)) return;
    write_texel(d, g, pixel, i, &(texel_light){arrival, carried, r->way[k]});
    put(map->arrival, i, arrival);
    put(map->carried, i, sl_v3(r->throughput[k].r, r->throughput[k].g, r->throughput[k].b));
}

/* ---- one face ---- */

/* A G-buffer's normals are turned to the origin of its view; parallel light comes from everywhere. */
static void turn_to_light(const sl_map_face *face, sl_gbuffer *g) {
    float *const plane[] = {g->normal_x,    g->normal_y,    g->normal_z,
                            g->geometric_x, g->geometric_y, g->geometric_z};
    for (size_t i = 0; i < (size_t)face->width * (size_t)face->height; i++) {
        if (!(sl_dot(sl_gbuffer_geometric(g, i), face->frame.z) > 0.0f)) continue;
        for (int k = 0; k < 6; k++) plane[k][i] = -plane[k][i];
    }
}

static sl_status draw(const sl_map_drawing *d, const sl_map_face *face, sl_gbuffer *g,
                      sl_reflections **reflections, sl_counters *counters) {
    const bool parallel = light_of(d, face)->source.kind == SL_SOURCE_DIRECTIONAL;
    const sl_viewer viewer = {.eye = face->eye, .along = parallel ? face->frame.z : sl_v3(0, 0, 0)};
    const sl_status status = sl_raster_gbuffer(d->raster, &face->view, 1, g, counters, NULL);
    if (status == SL_OK && parallel) turn_to_light(face, g);
    if (status != SL_OK || !d->options->tracer) return status;
    return sl_reflect_seen(d->scene, d->options->tracer, 1, &viewer, g, reflections, counters, NULL);
}

static void write_face(const sl_map_drawing *d, const sl_map_face *face, const sl_gbuffer *g,
                       const sl_reflections *r) {
    const size_t texels = (size_t)face->width * (size_t)face->height;
    for (size_t p = 0; p < texels; p++) {
        d->map->triangle[face->first + p] = SL_NO_INDEX;
        if (g->id[p] == SL_NO_INDEX) continue;
        const texel_light light = light_at(d, face, sl_gbuffer_position(g, p));
        write_texel(d, g, p, face->first + p, &light);
    }
    for (size_t k = 0; r && k < r->count; k++) write_mirrored(d, face, g, r, k);
}

static void draw_face(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    (void)worker;
    const sl_map_drawing *d = context;
    const sl_map_face *face = &d->map->face[index];
    sl_gbuffer *g = NULL;
    sl_reflections *reflections = NULL;
    sl_status *status = result;
    *status = sl_gbuffer_create(face->width, face->height, &g, NULL);
    if (*status == SL_OK) *status = draw(d, face, g, &reflections, counters);
    if (*status == SL_OK) write_face(d, face, g, reflections);
    sl_reflections_destroy(reflections);
    sl_gbuffer_destroy(g);
}

/* ---- all ---- */

sl_status sl_map_pictures_draw(const sl_map_drawing *d, sl_error *error) {
    const size_t faces = d->map->face_count;
    sl_status *status = sl_allocate(faces, sizeof *status);
    bool failed = !status;
    if (status) {
        const sl_batch batch = {.count = faces, .work = draw_face, .context = (void *)(uintptr_t)d,
                                .results = status, .result_bytes = sizeof *status};
        sl_batch_run(&batch, sl_thread_count(d->options->threads), d->counters);
    }
    for (size_t f = 0; f < faces && !failed; f++) failed = status[f] != SL_OK;
    sl_free(status);
    if (failed) return sl_fail_memory(error, "a radiance map's pictures");
    /* Four floats a texel; 8-bit positions have four bytes. */
    const size_t bytes = (d->settings->eight_bit_positions ? 4u : 16u) + (d->map->normal[0] ? 32u : 16u);
    sl_count(d->counters, SL_COUNT_BYTES_READ_BACK, bytes * d->map->texels);
    return SL_OK;
}
