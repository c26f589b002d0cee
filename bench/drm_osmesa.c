#include "drm_osmesa.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "osmesa.h"
#include "base/math.h"
#include "base/memory.h"
#include "common.h"
#include "drm_shaders.h"
#include "raster_osmesa.h"

enum { FACES = 6, PHOTONS_MAX = DRM_PEER_SAMPLES * DRM_PEER_SAMPLES, MAP_PLANES = 3 };

struct drm_peer {
    drm_peer_options options;
    sl_view camera, face[FACES];
    bool face_needed[FACES];
    float near, diagonal;
    osmesa_mesh mesh, screen;
    /* indices before the light's own triangles, which its map does not show */
    size_t unlit;
    osmesa_target shadow, map, picture, surfaces;
    unsigned depth, map_program, gbuffer, shade[DRM_SHADINGS][2]; /* forward, deferred */
    float *map_plane[MAP_PLANES], *result;
    int photons;
    float place[4 * PHOTONS_MAX], radiance[4 * PHOTONS_MAX], normal[4 * PHOTONS_MAX];
};

const char *drm_way_name(drm_way way) {
    static const char *const names[DRM_WAYS] = {"forward", "depth first", "deferred"};
    return names[way];
}

/* ---- geometry: a vertex for each material that meets there, those of the light last ---------- */

typedef struct builder {
    float *position, *normal, *colour;
    uint32_t *index, *copy; /* copy of a vertex that has a material; the next one follows it in `next` */
    uint32_t *next, *material;
    size_t vertices, indices;
} builder;

static void *allocated(size_t count, size_t size) {
    void *memory = calloc(count ? count : 1, size);
    if (!memory) bench_fail("OSMesa's peer", NULL);
    return memory;
}

static uint32_t vertex_of(builder *b, const sl_scene *s, uint32_t vertex, uint32_t material) {
    for (uint32_t v = b->copy[vertex]; v; v = b->next[v - 1]) {
        if (b->material[v - 1] == material) return v - 1;
    }
    uint32_t v = (uint32_t)b->vertices++;
    const sl_material *m = &s->materials[material];
    const sl_vec3 p = sl_scene_position(s, vertex), n = sl_scene_normal(s, vertex);
    bool shines = sl_material_is_emitter(m);
    sl_rgb c = shines ? m->emission : m->diffuse;
    memcpy(&b->position[3 * v], &p, sizeof p);
    memcpy(&b->normal[3 * v], &n, sizeof n);
    const float colour[4] = {c.r, c.g, c.b, shines ? 1.0f : 0.0f};
    memcpy(&b->colour[4 * v], colour, sizeof colour);
    b->material[v] = material;
    b->next[v] = b->copy[vertex];
    b->copy[vertex] = v + 1;
    return v;
}

static void add_triangles(builder *b, const sl_scene *s, bool lights) {
    for (size_t t = 0; t < s->triangle_count; t++) {
        uint32_t material = s->material_index[t];
        if (sl_material_is_emitter(&s->materials[material]) != lights) continue;
        for (int k = 0; k < 3; k++) b->index[b->indices++] = vertex_of(b, s, s->vertex[k][t], material);
    }
}

static void upload(drm_peer *peer, const sl_scene *s) {
    size_t most = 3 * s->triangle_count;
    builder b = {allocated(most, 3 * sizeof(float)),
                 allocated(most, 3 * sizeof(float)),
                 allocated(most, 4 * sizeof(float)),
                 allocated(most, sizeof *b.index),
                 allocated(s->vertex_count, sizeof *b.copy),
                 allocated(most, sizeof *b.next),
                 allocated(most, sizeof *b.material),
                 0,
                 0};
    add_triangles(&b, s, false);
    peer->unlit = b.indices;
    add_triangles(&b, s, true);
    const osmesa_stream streams[3] = {{b.position, b.vertices, 3, false},
                                      {b.normal, b.vertices, 3, false},
                                      {b.colour, b.vertices, 4, false}};
    peer->mesh = osmesa_mesh_create(3, streams, b.indices, b.index);
    peer->screen = osmesa_mesh_create(0, NULL, 3, NULL);
    free(b.position);
    free(b.normal);
    free(b.colour);
    free(b.index);
    free(b.copy);
    free(b.next);
    free(b.material);
}

/* ---- programs -------------------------------------------------------------------------------- */

static unsigned scene_or_screen_program(bool screen, const char *fragment) {
    return screen ? osmesa_program(screen_vertex, fragment) : peer_scene_program(surface_vertex, fragment);
}

static unsigned shade_program(const drm_peer *peer, drm_shading shading, bool deferred) {
    static const int weights[DRM_SHADINGS] = {[DRM_EVEN] = 11, [DRM_BOX] = 15, [DRM_DISC] = 14};
    char text[8192];
    snprintf(text, sizeof text,
             "#define SHADOWS %d\n#define WEIGHT %d\n#define PHOTONS %d\n#define AREA %d\n#define DEFERRED "
             "%d\n%s%s%s%s",
             shading != DRM_LOCAL, weights[shading], peer->options.samples * peer->options.samples,
             peer->options.area, deferred, slope_function, light_functions, shade_functions, shade_fragment);
    return scene_or_screen_program(deferred, text);
}

static unsigned map_program(const drm_peer *peer) {
    char text[4096];
    snprintf(text, sizeof text, "#define AREA %d\n%s%s%s", peer->options.area, slope_function,
             light_functions, map_fragment);
    return scene_or_screen_program(false, text);
}

static unsigned gbuffer_program(void) {
    char text[2048];
    snprintf(text, sizeof text, "%s%s", slope_function, gbuffer_fragment);
    return scene_or_screen_program(false, text);
}

static void set_light(const drm_peer *peer, unsigned program) {
    const drm_peer_options *o = &peer->options;
    osmesa_uniform(program, "light", 3, &o->position.x);
    osmesa_uniform(program, "intensity", 3, &o->intensity.r);
    if (o->area) osmesa_uniform(program, "axis", 3, &o->direction.x);
}

/* ---- passes 1 to 3 --------------------------------------------------------------------------- */

/* Faces +x -x +y -y +z -z, coordinates in cyclic order, as shade_functions look them up. */
static void place_faces(drm_peer *peer) {
    static const sl_vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const drm_peer_options *o = &peer->options;
    for (int k = 0; k < FACES; k++) {
        sl_vec3 x = axes[(k / 2 + 1) % 3], y = axes[(k / 2 + 2) % 3],
                z = sl_scale(axes[k / 2], k % 2 ? -1.0f : 1.0f);
        const sl_frame frame = {x, y, z};
        float most =
            sl_dot(o->direction, z) + fabsf(sl_dot(o->direction, x)) + fabsf(sl_dot(o->direction, y));
        peer->face_needed[k] = !o->area || most > 0.0f; /* some of what it sees lies before the light */
        peer->face[k] = sl_view_pyramid(&frame, o->position, -1.0f, 1.0f, -1.0f, 1.0f, o->shadow_size,
                                        o->shadow_size, peer->near);
    }
}

static void draw_depth_cube(drm_peer *peer) {
    int size = peer->options.shadow_size;
    osmesa_state(true, false);
    osmesa_clear(&peer->shadow);
    for (int k = 0; k < FACES; k++) {
        if (!peer->face_needed[k]) continue;
        osmesa_viewport(k * size, 0, size, size);
        peer_set_view(peer->depth, &peer->face[k]);
        osmesa_draw(peer->depth, &peer->mesh, 0, peer->unlit, 0);
    }
}

static void draw_map(drm_peer *peer) {
    osmesa_state(true, false);
    osmesa_clear(&peer->map);
    peer_set_view(peer->map_program, &peer->options.map_view);
    set_light(peer, peer->map_program);
    osmesa_draw(peer->map_program, &peer->mesh, 0, peer->unlit, 0);
    for (int k = 0; k < MAP_PLANES; k++) osmesa_read(&peer->map, k, peer->map_plane[k]);
}

/* One photon by (12) with m for w, and (13). What depends on the weight alone goes into its radiance: E = sum
 * of radiance cos theta (...). */
static void take_photon(drm_peer *peer, int j, size_t texel, drm_shading shading) {
    const drm_peer_options *o = &peer->options;
    const float *y = &peer->map_plane[0][4 * texel], *l = &peer->map_plane[1][4 * texel],
                *n = &peer->map_plane[2][4 * texel];
    const sl_vec3 to_light = sl_sub(o->position, sl_v3(y[0], y[1], y[2]));
    double b = sqrt((double)sl_dot(to_light, to_light)),
           side = 2.0 * b * sl_tan(o->map_fov / (2.0 * o->samples));
    double footprint = side * side,
           cosine = b > 0.0 ? (double)sl_dot(sl_v3(n[0], n[1], n[2]), to_light) / b : 0.0, weight = 1.0;
    if (shading == DRM_EVEN) weight = 2.0 * SL_PI / peer->photons;
    if (shading == DRM_BOX) weight = footprint / ((double)peer->diagonal * (double)peer->diagonal);
    if (!(y[3] > 0.5f)) weight = 0.0; /* nothing there */
    float *place = &peer->place[4 * j], *radiance = &peer->radiance[4 * j];
    memcpy(place, y, 3 * sizeof *place);
    memcpy(&peer->normal[4 * j], n, 4 * sizeof *n);
    place[3] = cosine > 0.0 ? (float)(footprint / cosine) : 0.0f;
    for (int c = 0; c < 3; c++) radiance[c] = weight > 0.0 ? (float)(weight * (double)l[c]) : 0.0f;
}

static void take_photons(drm_peer *peer, drm_shading shading) {
    int m = peer->options.samples, width = peer->map.width, block = width / m;
    peer->photons = m * m;
    for (int j = 0; j < m * m; j++) { /* the middle texel of each block; the first of two that are as near */
        int x = j % m * block + (block - 1) / 2, y = j / m * block + (block - 1) / 2;
        take_photon(peer, j, (size_t)y * (size_t)width + (size_t)x, shading);
    }
}

/* ---- passes 6 to 8 --------------------------------------------------------------------------- */

static void set_shading(drm_peer *peer, unsigned program, drm_shading shading) {
    set_light(peer, program);
    if (shading != DRM_LOCAL) {
        /* The depth plane's last bit, in units of 1/w. */
        const float size[3] = {(float)peer->options.shadow_size, peer->near, 1.2e-7f / peer->near};
        osmesa_uniform(program, "shadow_size", 3, size);
        osmesa_input(program, "shadow", 3, peer->shadow.depth);
    }
    if (shading <= DRM_DIRECT) return;
    osmesa_uniform_array(program, "place_of", peer->photons, peer->place);
    osmesa_uniform_array(program, "radiance_of", peer->photons, peer->radiance);
    if (shading == DRM_DISC) osmesa_uniform_array(program, "normal_of", peer->photons, peer->normal);
}

static void draw_scene(drm_peer *peer, unsigned program, osmesa_order order) {
    osmesa_draw_order(order);
    peer_set_view(program, &peer->camera);
    osmesa_draw_all(program, &peer->mesh);
    osmesa_draw_order(ORDER_USUAL);
}

static void draw_forward(drm_peer *peer, drm_shading shading, bool depth_first) {
    unsigned program = peer->shade[shading][0];
    osmesa_state(true, false);
    osmesa_clear(&peer->picture);
    if (depth_first) draw_scene(peer, peer->depth, ORDER_DEPTH_ALONE);
    set_shading(peer, program, shading);
    draw_scene(peer, program, depth_first ? ORDER_VISIBLE_ALONE : ORDER_USUAL);
}

static void draw_deferred(drm_peer *peer, drm_shading shading) {
    static const char *const samplers[3] = {"places", "normals", "colours"};
    unsigned program = peer->shade[shading][1];
    osmesa_state(true, false);
    osmesa_clear(&peer->surfaces);
    osmesa_uniform(peer->gbuffer, "light", 3, &peer->options.position.x);
    draw_scene(peer, peer->gbuffer, ORDER_USUAL);
    osmesa_draw_to(&peer->picture);
    osmesa_state(false, false);
    for (int k = 0; k < 3; k++) osmesa_input(program, samplers[k], k, peer->surfaces.plane[k]);
    set_shading(peer, program, shading);
    osmesa_draw_all(program, &peer->screen);
}

const float *drm_peer_frame(drm_peer *peer, drm_shading shading, drm_way way, bool camera_only) {
    if (!camera_only && shading != DRM_LOCAL) draw_depth_cube(peer);
    if (!camera_only && shading > DRM_DIRECT) {
        draw_map(peer);
        take_photons(peer, shading);
    }
    if (way == DRM_DEFERRED) draw_deferred(peer, shading);
    else draw_forward(peer, shading, way == DRM_DEPTH_FIRST);
    osmesa_read(&peer->picture, 0, peer->result);
    return peer->result;
}

/* ---- life ------------------------------------------------------------------------------------ */

static osmesa_target planes_target(int width, int height, int planes) {
    return osmesa_target_create(width, height, planes,
                                (osmesa_format[]){PLANE_RGBA32F, PLANE_RGBA32F, PLANE_RGBA32F}, true);
}

drm_peer *drm_peer_create(const sl_scene *scene, const drm_peer_options *o) {
    drm_peer *peer = allocated(1, sizeof *peer);
    peer->options = *o;
    peer->diagonal = scene->diagonal;
    peer->near = 1e-3f * scene->diagonal;
    peer->camera = sl_view_camera(&scene->camera, o->size, o->size, peer->near, 2.0f * scene->diagonal);
    upload(peer, scene);
    place_faces(peer);
    peer->shadow = osmesa_target_create(FACES * o->shadow_size, o->shadow_size, 0, NULL, true);
    peer->map = planes_target(o->map_view.width, o->map_view.height, MAP_PLANES);
    peer->picture = planes_target(o->size, o->size, 1);
    peer->surfaces = planes_target(o->size, o->size, 3);
    peer->depth = peer_scene_program(depth_vertex, depth_fragment);
    peer->map_program = map_program(peer);
    peer->gbuffer = gbuffer_program();
    for (int s = 0; s < DRM_SHADINGS; s++) {
        for (int deferred = 0; deferred < 2; deferred++)
            peer->shade[s][deferred] = shade_program(peer, (drm_shading)s, deferred);
    }
    size_t texels = (size_t)o->map_view.width * (size_t)o->map_view.height;
    for (int k = 0; k < MAP_PLANES; k++) peer->map_plane[k] = allocated(texels, 4 * sizeof(float));
    peer->result = allocated((size_t)o->size * (size_t)o->size, 4 * sizeof(float));
    return peer;
}

void drm_peer_destroy(drm_peer *peer) {
    if (!peer) return;
    osmesa_target_destroy(&peer->shadow);
    osmesa_target_destroy(&peer->map);
    osmesa_target_destroy(&peer->picture);
    osmesa_target_destroy(&peer->surfaces);
    osmesa_mesh_destroy(&peer->mesh);
    osmesa_mesh_destroy(&peer->screen);
    osmesa_program_destroy(peer->depth);
    osmesa_program_destroy(peer->map_program);
    osmesa_program_destroy(peer->gbuffer);
    for (int s = 0; s < DRM_SHADINGS; s++) {
        for (int deferred = 0; deferred < 2; deferred++) osmesa_program_destroy(peer->shade[s][deferred]);
    }
    for (int k = 0; k < MAP_PLANES; k++) free(peer->map_plane[k]);
    free(peer->result);
    free(peer);
}
