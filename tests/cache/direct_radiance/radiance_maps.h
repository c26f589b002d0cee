/* Shared by the tests of sample photons: scenes with one light, and the pictures taken from it. */
#pragma once

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "cache/direct_radiance/map.h"
#include "trace_scenes.h"

/* A map made by hand: a point light, faces added one by one, texels filled by the rasterizer or by the test.
 */
typedef struct hand_map {
    sl_map_lights lights;
    sl_map_light light;
    sl_radiance_map map;
    sl_map_face face[6];
} hand_map;

static inline sl_map_light hand_light(sl_vec3 position) {
    return (sl_map_light){
        .source = {.kind = SL_SOURCE_POINT, .position = position, .colour = {2.0f, 3.0f, 5.0f}}};
}

static inline float *hand_plane(size_t texels) {
    float *plane = calloc(texels + 1, sizeof *plane);
    assert_non_null(plane);
    return plane;
}

/* `faces` faces of w x w texels, m x m blocks, 90 degrees each; the first six are a cube's.
 * Nothing is in them. */
static inline hand_map *hand_map_begin(sl_map_light light, int faces, int w, int m) {
    hand_map *h = calloc(1, sizeof *h);
    assert_non_null(h);
    static const sl_vec3 axis[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    size_t each = (size_t)w * (size_t)w, texels = each * (size_t)faces;
    h->light = light;
    h->lights = (sl_map_lights){.count = 1, .light = &h->light};
    h->map = (sl_radiance_map){.lights = &h->lights,
                               .face_count = (size_t)faces,
                               .face = h->face,
                               .texels = texels,
                               .lambertian = true};
    h->map.triangle = calloc(texels, sizeof *h->map.triangle);
    h->map.path = hand_plane(texels);
    for (int c = 0; c < 3; c++) {
        h->map.position[c] = hand_plane(texels);
        h->map.color[c] = hand_plane(texels);
        h->map.geometric[c] = hand_plane(texels);
    }
    memset(h->map.triangle, 0xff, texels * sizeof *h->map.triangle);
    for (int f = 0; f < faces; f++) {
        h->face[f] = (sl_map_face){.eye = light.source.position,
                                   .frame = sl_frame_from_normal(axis[f]),
                                   .left = -1,
                                   .right = 1,
                                   .bottom = -1,
                                   .top = 1,
                                   .width = w,
                                   .height = w,
                                   .columns = m,
                                   .rows = m,
                                   .first = (size_t)f * each};
        h->face[f].view =
            sl_view_pyramid(&h->face[f].frame, light.source.position, -1, 1, -1, 1, w, w, 1e-4f);
    }
    return h;
}

static inline double texel_size(const sl_radiance_map *map, size_t i) {
    const sl_map_face *f = map->face;
    while (i >= f->first + (size_t)f->width * (size_t)f->height) f++;
    const size_t width = (size_t)f->width, texel = i - f->first;
    return sl_map_part(map, f, (int)(texel % width), (int)(texel / width), 1);
}

/* Texel i shows triangle's surface at p, which reflects as much as a white Lambertian surface of that
 * reflectance. */
static inline void hand_texel(hand_map *h, size_t i, uint32_t triangle, sl_vec3 p, sl_vec3 normal,
                              sl_rgb reflectance) {
    sl_vec3 d = sl_sub(h->light.source.position, p);
    double b2 = sl_dotd(sl_to_double(d), sl_to_double(d)),
           cosine = sl_dotd(sl_to_double(normal), sl_to_double(d)) / sqrt(b2);
    h->map.triangle[i] = triangle;
    const float position[3] = {p.x, p.y, p.z}, n[3] = {normal.x, normal.y, normal.z};
    const float rho[3] = {reflectance.r, reflectance.g, reflectance.b};
    sl_rgb intensity = sl_map_light_intensity(&h->light, sl_normalize_or(sl_neg(d), sl_v3(0, 0, 1)));
    const float power[3] = {intensity.r, intensity.g, intensity.b};
    for (int c = 0; c < 3; c++) {
        h->map.position[c][i] = position[c];
        h->map.geometric[c][i] = n[c];
        h->map.color[c][i] = h->map.lambertian
                                 ? (float)((double)rho[c] * (double)power[c] * fmax(cosine, 0) / (SL_PI * b2))
                                 : rho[c];
    }
    h->map.path[i] = (float)sqrt(b2);
}

/* The pictures of a scene. */
static inline void hand_map_render(hand_map *h, const sl_raster *raster) {
    for (size_t f = 0; f < h->map.face_count; f++) {
        sl_gbuffer *g;
        sl_counters counters = {{0}};
        assert_int_equal(sl_gbuffer_create(h->face[f].width, h->face[f].height, &g, NULL), SL_OK);
        assert_int_equal(sl_raster_gbuffer(raster, &h->face[f].view, 1, g, &counters, NULL), SL_OK);
        for (int i = 0; i < g->width * g->height; i++) {
            if (g->id[i] == SL_NO_INDEX) continue;
            hand_texel(h, h->face[f].first + (size_t)i, g->id[i],
                       sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]),
                       sl_v3(g->geometric_x[i], g->geometric_y[i], g->geometric_z[i]),
                       (sl_rgb){g->diffuse_r[i], g->diffuse_g[i], g->diffuse_b[i]});
        }
        sl_gbuffer_destroy(g);
    }
}

/* A cube's faces of w x w texels and m x m blocks with the pictures of a scene. */
static inline hand_map *hand_map_of(const sl_scene *scene, sl_map_light light, int w, int m,
                                    bool lambertian) {
    sl_raster *raster;
    assert_int_equal(sl_raster_create(scene, 1, &raster, NULL), SL_OK);
    hand_map *h = hand_map_begin(light, 6, w, m);
    h->map.lambertian = lambertian;
    hand_map_render(h, raster);
    sl_raster_destroy(raster);
    return h;
}

static inline void hand_map_end(hand_map *h) {
    free(h->map.triangle);
    free(h->map.path);
    for (int c = 0; c < 3; c++) {
        free(h->map.position[c]);
        free(h->map.color[c]);
        free(h->map.geometric[c]);
        free(h->map.normal[c]);
        free(h->map.arrival[c]);
        free(h->map.carried[c]);
    }
    free(h);
}

static inline void destroy_photons(sl_map_photons *photons, hand_map *h) { /* and their map */
    sl_map_photons_destroy(photons);
    hand_map_end(h);
}

static inline sl_map_photons *take_photons(const sl_scene *scene, const sl_radiance_map *map,
                                           const sl_radiance_map_settings *settings) {
    sl_map_photons *photons = NULL;
    sl_counters counters = {{0}};
    sl_error error;
    if (sl_map_photons_take(scene, map, settings, &photons, &counters, &error) != SL_OK)
        fail_msg("%s", error.message);
    assert_int_equal(counters.value[SL_COUNT_MAP_PHOTONS], photons->count);
    assert_int_equal(counters.value[SL_COUNT_MAP_PHOTONS_DROPPED], photons->dropped);
    return photons;
}

/* The flux weight (cache/direct_radiance/weights.h) of grey light, once more in double. */
static inline double flux_irradiance(const sl_map_photons *photons, sl_vec3d x, sl_vec3d n) {
    double sum = 0.0;
    for (size_t j = 0; j < photons->count; j++) {
        const sl_map_photon *p = &photons->photon[j];
        sl_vec3d d = sl_subd(sl_to_double(p->position), x);
        double r2 = sl_dotd(d, d), c = sl_dotd(n, d), s = -sl_dotd(sl_to_double(p->normal), d);
        if (!(c > 0) || !(s > 0) || !(r2 > (double)photons->nearest * (double)photons->nearest)) continue;
        sum += (double)p->flux.g * c * s / r2 * (double)p->cos_alpha /
               (r2 * (double)p->cos_alpha + (double)p->footprint / SL_PI);
    }
    return sum;
}
