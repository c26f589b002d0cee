/* See raster_soup.h. Elementary functions are the library's own: the triangles are the same everywhere. */
#include "unit_test.h"
#include "raster_soup.h"

#include <stdlib.h>

#include "base/math.h"
#include "base/random.h"
#include "base/sanitized.h"
#include "raster_support.h"

const char *const soup_names[SOUP_KINDS] = {
    "big",           "medium, 64 px", "small, 8 px",    "below a pixel", "slivers",     "mesh, 5 px",
    "pixel centres", "1/512 ties",    "partly outside", "far outside",   "perspective", "near-clipped"};

/* A stream of numbers. */
typedef struct dice {
    uint64_t key, next;
} dice;

static float between(dice *d, float low, float high) {
    return low + (high - low) * sl_random_unit(d->key, d->next++);
}

/* Two numbers, or three. One after the other: compilers choose in which order a call's arguments are made. */
typedef struct pair {
    float x, y;
} pair;

static pair pair_between(dice *d, float low, float high) {
    float x = between(d, low, high), y = between(d, low, high);
    return (pair){x, y};
}

static sl_vec3 point_between(dice *d, sl_vec3 low, sl_vec3 high) {
    float x = between(d, low.x, high.x), y = between(d, low.y, high.y), z = between(d, low.z, high.z);
    return sl_v3(x, y, z);
}

static float log_2(float x) { return (float)(sl_log((double)x) / sl_log(2.0)); }

/* Every magnitude from small to large as likely. */
static float magnitude(dice *d, float small, float large) {
    return sl_exp2f(between(d, log_2(small), log_2(large)));
}

static float of_either_sign(dice *d, float small, float large) {
    float size = magnitude(d, small, large);
    return sl_random_bits(d->key, d->next++) & 1 ? -size : size;
}

static void set_vertex(soup *s, size_t v, float x, float y, float z) {
    s->position[0][v] = x;
    s->position[1][v] = y;
    s->position[2][v] = z;
}

/* From pixels (of the viewport, corner at 0) to clip space with w = 1. */
static float to_clip(float pixel, int size) { return (float)((double)pixel / (0.5 * (double)size) - 1.0); }

static void set_pixel(soup *s, size_t v, float px, float py, float z) {
    set_vertex(s, v, to_clip(px, s->view.width), to_clip(py, s->view.height), z);
}

/* ---- flat kinds: clip coordinates are the positions ------------------------------------------ */

/* One triangle with corners up to `size` pixels apart. */
static void small_triangle(soup *s, size_t t, dice *d, float size, const float z[3]) {
    float x = between(d, -0.5f * size, (float)s->view.width),
          y = between(d, -0.5f * size, (float)s->view.height);
    for (size_t k = 0; k < 3; k++) {
        pair by = pair_between(d, 0, size);
        set_pixel(s, 3 * t + k, x + by.x, y + by.y, z[k]);
    }
}

/* Corners on a grid of `steps` a pixel, moved by `offset` of a step. */
static void gridded_triangle(soup *s, size_t t, dice *d, float size, float steps, float offset,
                             const float z[3]) {
    float x = between(d, -0.5f * size, (float)s->view.width),
          y = between(d, -0.5f * size, (float)s->view.height);
    for (size_t k = 0; k < 3; k++) {
        float px = floorf((x + between(d, 0, size)) * steps), py = floorf((y + between(d, 0, size)) * steps);
        set_pixel(s, 3 * t + k, (px + offset) / steps, (py + offset) / steps, z[k]);
    }
}

static void sliver(soup *s, size_t t, dice *d, const float z[3]) {
    float w = (float)s->view.width, h = (float)s->view.height, x[2], y[2];
    float length = t % 2 ? 1.0f : 0.05f; /* across the whole screen, or a twentieth of it */
    x[0] = between(d, 0, w);
    y[0] = between(d, 0, h);
    x[1] = x[0] + (between(d, 0, w) - x[0]) * length;
    y[1] = y[0] + (between(d, 0, h) - y[0]) * length;
    float along = between(d, -0.2f, 1.2f), aside = t % 3 ? 0.3f : 0.02f;
    set_pixel(s, 3 * t, x[0], y[0], z[0]);
    set_pixel(s, 3 * t + 1, x[1], y[1], z[1]);
    pair by = pair_between(d, -aside, aside);
    set_pixel(s, 3 * t + 2, x[0] + along * (x[1] - x[0]) + by.x, y[0] + along * (y[1] - y[0]) + by.y, z[2]);
}

static void flat_triangle(soup *s, soup_kind kind, size_t t, dice *d) {
    float z[3], level = floorf(between(d, -4, 4)) * 0.2f;
    for (int k = 0; k < 3; k++) z[k] = t % 3 == 0 ? level : between(d, -0.95f, 0.95f);
    if (kind == SOUP_MEDIUM) small_triangle(s, t, d, 64, z);
    else if (kind == SOUP_SMALL) small_triangle(s, t, d, 8, z);
    else if (kind == SOUP_SUBPIXEL) small_triangle(s, t, d, 1, z);
    else if (kind == SOUP_SLIVER) sliver(s, t, d, z);
    else if (kind == SOUP_PIXEL_CENTRES) gridded_triangle(s, t, d, t % 2 ? 64 : 6, 1, 0.5f, z);
    else if (kind == SOUP_TIES) gridded_triangle(s, t, d, t % 2 ? 32 : 4, 256, 0.5f, z);
    else {
        for (size_t k = 0; k < 3; k++) {
            float reach = kind == SOUP_BIG ? 1 : 3;
            float x = kind == SOUP_FAR_OFF ? of_either_sign(d, 0.1f, 5000) : between(d, -reach, reach);
            float y = kind == SOUP_FAR_OFF ? of_either_sign(d, 0.1f, 5000) : between(d, -reach, reach);
            set_vertex(s, 3 * t + k, x, y, kind == SOUP_BIG ? z[k] : 1.6f * z[k]);
        }
    }
}

/* ---- a mesh ---------------------------------------------------------------------------------- */

/* Corner (i, j) of the grid; the outer ones stay outside the screen, the inner ones move by less than half a
 * cell. */
static void mesh_corner(soup *s, size_t v, uint64_t key, int i, int j, int nx, int ny) {
    uint64_t at = (uint64_t)(j * (nx + 1) + i) * 3;
    float jitter_x = 0.45f * (2 * sl_random_unit(key, at) - 1),
          jitter_y = 0.45f * (2 * sl_random_unit(key, at + 1) - 1);
    float px = ((float)i + jitter_x) / (float)nx, py = ((float)j + jitter_y) / (float)ny;
    px = px * (float)(s->view.width + 10) - 5;
    py = py * (float)(s->view.height + 10) - 5;
    set_pixel(s, v, px, py, 1.8f * sl_random_unit(key, at + 2) - 0.9f);
}

static void make_mesh(soup *s, uint64_t key, int nx, int ny) {
    size_t v = 0;
    for (int j = 0; j < ny; j++) {
        for (int i = 0; i < nx; i++) {
            bool other = sl_random_bits(key + 2, (uint64_t)(j * nx + i)) & 1; /* which diagonal */
            const int corner[2][6][2] = {{{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}},
                                         {{0, 0}, {1, 0}, {0, 1}, {1, 0}, {1, 1}, {0, 1}}};
            for (int c = 0; c < 6; c++)
                mesh_corner(s, v++, key, i + corner[other][c][0], j + corner[other][c][1], nx, ny);
        }
    }
}

/* Cells of about 5 pixels, unless that is more than asked for. */
static size_t mesh_size(size_t triangles, int width, int height, int *nx, int *ny) {
    *nx = width / 5 + 1;
    *ny = height / 5 + 1;
    while ((size_t)*nx * (size_t)*ny * 2 > triangles && *nx * *ny > 1) {
        if (*nx > 1) *nx -= (*nx + 9) / 10;
        if (*ny > 1) *ny -= (*ny + 9) / 10;
    }
    return (size_t)*nx * (size_t)*ny * 2;
}

/* ---- perspective ----------------------------------------------------------------------------- */

/* A corner at distance `w` before (or behind) the camera, within a little more than what it sees. */
static void perspective_vertex(soup *s, size_t v, const sl_camera *camera, float sx, float sy, float w) {
    float tangent = (float)sl_tan(0.5 * (double)camera->vertical_fov),
          aspect = (float)s->view.width / (float)s->view.height, reach = fabsf(w);
    sl_vec3 p = sl_mad(camera->eye, -w, camera->back);
    p = sl_mad(p, sx * reach * tangent * aspect, camera->right);
    p = sl_mad(p, sy * reach * tangent, camera->up);
    set_vertex(s, v, p.x, p.y, p.z);
}

static void perspective_triangle(soup *s, soup_kind kind, size_t t, dice *d, const sl_camera *camera) {
    bool clipped = kind == SOUP_NEAR_CLIPPED;
    float x = between(d, -0.95f, 0.95f), y = between(d, -0.95f, 0.95f),
          size = clipped ? 1.0f
                 : t % 2 ? 0.2f
                         : 0.02f;
    float w = magnitude(d, 0.2f, 20.0f);
    for (size_t k = 0; k < 3; k++) {
        float corner_w = w * between(d, 0.7f, 1.4f);
        if (clipped) corner_w = between(d, -1.5f, 2.5f);
        else if (t % 16 == 1) corner_w = magnitude(d, 0.2f, 20.0f); /* steep ones */
        pair by = pair_between(d, -size, size);
        perspective_vertex(s, 3 * t + k, camera, x + by.x, y + by.y, fminf(corner_w, 20.0f));
    }
}

static sl_camera random_camera(dice *d) {
    sl_camera camera;
    sl_vec3 eye = point_between(d, sl_v3(-3, -3, -3), sl_v3(3, 3, 3));
    sl_vec3 towards = point_between(d, sl_v3(-1, -0.9f, 0.2f), sl_v3(1, 0.9f, 1));
    if (!sl_camera_look_at(&camera, eye, sl_add(eye, towards), sl_v3(0, 1, 0), between(d, 0.5f, 1.8f)))
        fail_msg("no camera");
    return camera;
}

/* ---- all ------------------------------------------------------------------------------------- */

soup soup_make(soup_kind kind, uint64_t seed, size_t triangles, int width, int height) {
    soup s = {.triangles = triangles};
    dice d = {sl_random_key(1000 + (uint64_t)kind, seed), 0};
    int nx = 0, ny = 0;
    if (kind == SOUP_MESH) s.triangles = mesh_size(triangles, width, height, &nx, &ny);
    for (int k = 0; k < 3; k++) {
        s.position[k] = malloc(3 * s.triangles * sizeof *s.position[k]);
        s.vertex[k] = malloc(s.triangles * sizeof *s.vertex[k]);
        assert_non_null(s.position[k]);
        assert_non_null(s.vertex[k]);
        for (size_t t = 0; t < s.triangles; t++) s.vertex[k][t] = (uint32_t)(3 * t) + (uint32_t)k;
    }
    s.view =
        (sl_view){.width = width, .height = height, .depth = SL_DEPTH_WINDOW, .skip_triangle = SL_NO_INDEX};
    for (int k = 0; k < 4; k++) s.view.clip[k][k] = 1.0f;
    if (kind == SOUP_MESH) make_mesh(&s, d.key, nx, ny);
    else if (kind == SOUP_PERSPECTIVE || kind == SOUP_NEAR_CLIPPED) {
        sl_camera camera = random_camera(&d);
        s.view = camera_view(&camera, width, height, 0.1f, 25.0f);
        for (size_t t = 0; t < s.triangles; t++) perspective_triangle(&s, kind, t, &d, &camera);
    } else {
        for (size_t t = 0; t < s.triangles; t++) flat_triangle(&s, kind, t, &d);
    }
    return s;
}

void soup_free(soup *s) {
    for (int k = 0; k < 3; k++) {
        free(s->position[k]);
        free(s->vertex[k]);
    }
    *s = (soup){0};
}

sl_raster_mesh soup_mesh(const soup *s) {
    return (sl_raster_mesh){.vertex_count = 3 * s->triangles,
                            .triangle_count = s->triangles,
                            .x = s->position[0],
                            .y = s->position[1],
                            .z = s->position[2],
                            .vertex = {s->vertex[0], s->vertex[1], s->vertex[2]}};
}

sl_raster *soup_raster(const soup *s) {
    sl_raster_mesh mesh = soup_mesh(s);
    sl_raster *raster = NULL;
    sl_error error;
    if (sl_raster_create_mesh(&mesh, 1, &raster, &error) != SL_OK) fail_msg("%s", error.message);
    return raster;
}

size_t soup_share(size_t count) { return SL_SANITIZED ? count / 20 + 1 : count; }
