#include "app/numerics/cases.h"

#include <string.h>

/* ---- the room ---- */

/* Materials that every room has, by their numbers in the scene; emission leaves the front. */
enum { SL_ROOM_WHITE = 1, SL_ROOM_RED, SL_ROOM_GREEN, SL_ROOM_BOX, SL_ROOM_LAMP, SL_ROOM_MATERIALS };

enum { MOST = 8192 }; /* vertices, triangles */
static const double degree = 0.017453292519943295;

struct sl_room {
    float vertex[MOST][3];
    uint32_t corner[MOST][3], surface[MOST]; /* of triangles: vertices, and a material */
    uint32_t vertex_count, triangle_count;
    sl_material_data material[SL_ROOM_MATERIALS];
    double eye[3], target[3], fov_deg;
    int width, height;
};

/* ---- vertices and triangles ---- */

static uint32_t add_vertex(sl_room *r, double x, double y, double z) {
    const float vertex[3] = {(float)x, (float)y, (float)z};
    if (r->vertex_count == MOST) return 0;
    memcpy(r->vertex[r->vertex_count], vertex, sizeof vertex);
    return r->vertex_count++;
}

static void add_triangle(sl_room *r, uint32_t a, uint32_t b, uint32_t c, uint32_t material) {
    const uint32_t corner[3] = {a, b, c};
    if (r->triangle_count == MOST) return;
    memcpy(r->corner[r->triangle_count], corner, sizeof corner);
    r->surface[r->triangle_count++] = material;
}

static double share(int i, int count, double skew) {
    double even = (double)i / count;
    if (skew <= 0.0 || i == 0 || i == count) return even;
    double s = skew; /* the first part is `skew` wide, each next one as much wider as it takes */
    for (int k = 1; k < i; k++) s += (1.0 - skew) * k / (0.5 * count * (count - 1));
    return s < 1.0 ? s : even;
}

static const sl_room_cut plain_cut = {1, 1, 0.0};

/* Adds a quadrilateral, counter-clockwise from the front, cut in parts. */
static void add_quad(sl_room *r, const double corner[4][3], uint32_t material, const sl_room_cut *cut) {
    const uint32_t first = r->vertex_count, columns = (uint32_t)cut->columns + 1;
    for (int j = 0; j <= cut->rows; j++) {
        for (int i = 0; i <= cut->columns; i++) {
            double u = share(i, cut->columns, cut->skew), v = (double)j / cut->rows, p[3];
            for (int c = 0; c < 3; c++)
                p[c] = (1.0 - v) * ((1.0 - u) * corner[0][c] + u * corner[1][c]) +
                       v * ((1.0 - u) * corner[3][c] + u * corner[2][c]);
            add_vertex(r, p[0], p[1], p[2]);
        }
    }
    for (uint32_t j = 0; j < (uint32_t)cut->rows; j++) {
        for (uint32_t i = 0; i + 1 < columns; i++) {
            const uint32_t a = first + j * columns + i;
            add_triangle(r, a, a + 1, a + 1 + columns, material);
            add_triangle(r, a, a + 1 + columns, a + columns, material);
        }
    }
}

/* ---- the room ---- */

static void add_box(sl_room *r, const double low[3], const double high[3]) {
    /* bits: x, y, z */
    static const int side[6][4] = {{4, 5, 7, 6}, {1, 0, 2, 3}, {5, 1, 3, 7},
                                   {0, 4, 6, 2}, {6, 7, 3, 2}, {0, 1, 5, 4}};
    for (int s = 0; s < 6; s++) {
        double corner[4][3];
        for (int k = 0; k < 4; k++)
            for (int c = 0; c < 3; c++) corner[k][c] = side[s][k] >> c & 1 ? high[c] : low[c];
        add_quad(r, corner, SL_ROOM_BOX, &plain_cut);
    }
}

/* Makes a room of 4 x 3 x 5 with a box on its floor and a lamp of .8 x .8 under its ceiling, seen from its
 * open front. */
static void begin_room(sl_room *r, const sl_room_cut *cut) {
    /* floor */
    static const double walls[5][4][3] = {{{-2, 0, 2.5}, {2, 0, 2.5}, {2, 0, -2.5}, {-2, 0, -2.5}},
                                          /* ceiling */
                                          {{-2, 3, -2.5}, {2, 3, -2.5}, {2, 3, 2.5}, {-2, 3, 2.5}},
                                          /* back */
                                          {{-2, 0, -2.5}, {2, 0, -2.5}, {2, 3, -2.5}, {-2, 3, -2.5}},
                                          /* left */
                                          {{-2, 0, 2.5}, {-2, 0, -2.5}, {-2, 3, -2.5}, {-2, 3, 2.5}},
                                          /* right */
                                          {{2, 0, -2.5}, {2, 0, 2.5}, {2, 3, 2.5}, {2, 3, -2.5}}};
    static const uint32_t of_wall[5] = {SL_ROOM_WHITE, SL_ROOM_WHITE, SL_ROOM_WHITE, SL_ROOM_RED,
                                        SL_ROOM_GREEN};
    static const double lamp[4][3] = {
        {-0.4, 2.95, -0.6}, {0.4, 2.95, -0.6}, {0.4, 2.95, 0.2}, {-0.4, 2.95, 0.2}};
    *r = (sl_room){.eye = {0.1, 1.4, 6.0},
                   .target = {0.0, 1.3, -2.5},
                   .fov_deg = 42.0,
                   .width = 32,
                   .height = 24,
                   .material = {[SL_ROOM_WHITE] = {.diffuse = {0.7f, 0.7f, 0.7f}},
                                [SL_ROOM_RED] = {.diffuse = {0.6f, 0.1f, 0.1f}},
                                [SL_ROOM_GREEN] = {.diffuse = {0.1f, 0.5f, 0.1f}},
                                [SL_ROOM_BOX] = {.diffuse = {0.6f, 0.6f, 0.5f}},
                                [SL_ROOM_LAMP] = {.emission = {12, 11, 9}}}};
    for (int w = 0; w < 5; w++) add_quad(r, walls[w], of_wall[w], cut);
    add_quad(r, lamp, SL_ROOM_LAMP, &plain_cut);
    add_box(r, (const double[3]){-1.2, 0.0, -1.6}, (const double[3]){-0.2, 1.3, -0.6});
}

static void turn(sl_room *r, uint32_t triangle) {
    uint32_t *corner = r->corner[triangle], second = corner[1];
    corner[1] = corner[2];
    corner[2] = second;
}

static void move_point(double p[3], double scale, const double by[3], bool mirrored) {
    for (int c = 0; c < 3; c++) p[c] = p[c] * scale + by[c];
    if (mirrored) p[0] = -p[0];
}

/* Everything, the camera and its lamp too: times scale, then moved, then x turned into -x if mirrored. */
static void move_room(sl_room *r, double scale, const double by[3], bool mirrored) {
    for (uint32_t i = 0; i < r->vertex_count; i++) {
        double p[3];
        for (int c = 0; c < 3; c++) p[c] = (double)r->vertex[i][c];
        move_point(p, scale, by, mirrored);
        for (int c = 0; c < 3; c++) r->vertex[i][c] = (float)p[c];
    }
    move_point(r->eye, scale, by, mirrored);
    move_point(r->target, scale, by, mirrored);
    for (uint32_t i = 0; mirrored && i < r->triangle_count; i++) turn(r, i); /* fronts stay fronts */
}

/* ---- as a scene ---- */

static sl_status add_mesh(sl_scene_builder *b, const sl_room *r, sl_error *error) {
    uint32_t number = 0;
    sl_status status = SL_OK;
    for (int m = SL_ROOM_WHITE; m < SL_ROOM_MATERIALS && status == SL_OK; m++) {
        sl_material_data material = r->material[m];
        material.size = sizeof material;
        status = sl_scene_builder_material(b, &material, &number, error);
    }
    const sl_mesh_data mesh = {.size = sizeof mesh,
                               .vertex_count = r->vertex_count,
                               .positions = r->vertex[0],
                               .triangle_count = r->triangle_count,
                               .indices = r->corner[0],
                               .materials = r->surface};
    if (status == SL_OK) status = sl_scene_builder_mesh(b, &mesh, &number, error);
    const sl_instance_data instance = {.size = sizeof instance, .mesh = number};
    return status == SL_OK ? sl_scene_builder_instance(b, &instance, error) : status;
}

static sl_status build_room(const sl_room *r, const sl_light_data *light, sl_scene **scene, sl_error *error) {
    const float eye[3] = {(float)r->eye[0], (float)r->eye[1], (float)r->eye[2]}, up[3] = {0.0f, 1.0f, 0.0f},
                target[3] = {(float)r->target[0], (float)r->target[1], (float)r->target[2]};
    sl_scene_builder *b = NULL;
    sl_status status = sl_scene_builder_create(&b, error);
    if (status == SL_OK) status = add_mesh(b, r, error);
    if (status == SL_OK && light->size) status = sl_scene_builder_light(b, light, error);
    if (status == SL_OK)
        status = sl_scene_builder_camera(b, eye, target, up, (float)(r->fov_deg * degree), error);
    if (status == SL_OK) status = sl_scene_builder_film(b, r->width, r->height, error);
    if (status == SL_OK) status = sl_scene_builder_build(b, scene, error);
    sl_scene_builder_destroy(b);
    return status;
}

/* ---- what is done to it ---- */

static void exchange(uint32_t *a, uint32_t *b) {
    const uint32_t kept = *a;
    *a = *b;
    *b = kept;
}

static void reordered(sl_room *r) {
    for (uint32_t i = 0; i < r->triangle_count / 2; i++) {
        const uint32_t other = r->triangle_count - 1 - i;
        for (int k = 0; k < 3; k++) exchange(&r->corner[i][k], &r->corner[other][k]);
        exchange(&r->surface[i], &r->surface[other]);
    }
}

static void twice(sl_room *r) {
    for (uint32_t i = 0, count = r->triangle_count; i < count; i++) {
        /* a lamp twice is twice as bright to some, and hidden to others */
        if (r->surface[i] == SL_ROOM_LAMP) continue;
        const uint32_t *c = r->corner[i];
        add_triangle(r, c[0], c[1], c[2], r->surface[i]);
    }
}

/* The back wall's lower half is cut in three, the upper one in two: corners of one lie on edges of the other.
 */
static void t_junctions(sl_room *r) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < r->triangle_count; i++) { /* takes the back wall out */
        bool back = true;
        for (int k = 0; k < 3; k++) back &= r->vertex[r->corner[i][k]][2] == -2.5f;
        if (back) continue;
        memcpy(r->corner[kept], r->corner[i], sizeof r->corner[i]);
        r->surface[kept++] = r->surface[i];
    }
    r->triangle_count = kept;
    const double low[4][3] = {{-2, 0, -2.5}, {2, 0, -2.5}, {2, 1.5, -2.5}, {-2, 1.5, -2.5}},
                 high[4][3] = {{-2, 1.5, -2.5}, {2, 1.5, -2.5}, {2, 3, -2.5}, {-2, 3, -2.5}};
    add_quad(r, low, SL_ROOM_WHITE, &(sl_room_cut){3, 1, 0.0});
    add_quad(r, high, SL_ROOM_WHITE, &(sl_room_cut){2, 1, 0.0});
}

/* Surfaces reflect on both sides; the lamp stays as it is. */
static void inverted(sl_room *r) {
    for (uint32_t i = 0; i < r->triangle_count; i++) {
        if (r->surface[i] != SL_ROOM_LAMP) turn(r, i);
    }
}

/* Three faces on each edge of the box: fins that stand inside it, where nothing is seen of them. */
static void not_manifold(sl_room *r) {
    uint32_t a = add_vertex(r, -1.2, 0.0, -1.6), b = add_vertex(r, -0.2, 1.3, -0.6),
           c = add_vertex(r, -1.2, 1.3, -1.6), d = add_vertex(r, -0.2, 0.0, -0.6);
    add_triangle(r, a, d, b, SL_ROOM_BOX);
    add_triangle(r, a, b, c, SL_ROOM_BOX);
}

/* ---- large and small at once ---- */

static void tiny_among_large(sl_room *r) {
    for (int i = 0; i < 40; i++) {
        double x = 0.2 + 0.03 * i, s = 4e-6;
        uint32_t a = add_vertex(r, x, 0.5, -1.0), b = add_vertex(r, x + s, 0.5, -1.0),
               c = add_vertex(r, x, 0.5 + s, -1.0);
        add_triangle(r, a, b, c, SL_ROOM_RED);
    }
}

static void plain_below(sl_room *r, double half) {
    const double far[4][3] = {{-half, -5, half}, {half, -5, half}, {half, -5, -half}, {-half, -5, -half}};
    add_quad(r, far, SL_ROOM_WHITE, &plain_cut);
}
static void large_among_small(sl_room *r) { plain_below(r, 4e3); }
static void huge_among_small(sl_room *r) { plain_below(r, 4e6); }

/* Most of the vertices a million units away: no plain on which the room stands, but things of which it knows
 * nothing. */
static void far_planets(sl_room *r) {
    static const double place[3][3] = {{1e6, 2e5, 0}, {-3e5, 1e6, 1e5}, {1e5, 3e5, -1e6}};
    for (int i = 0; i < 3; i++) {
        const double *p = place[i], s = 1e4;
        const double side[4][3] = {{p[0] - s, p[1] - s, p[2]},
                                   {p[0] + s, p[1] - s, p[2] + s},
                                   {p[0] + s, p[1] + s, p[2]},
                                   {p[0] - s, p[1] + s, p[2] - s}};
        add_quad(r, side, SL_ROOM_WHITE, &(sl_room_cut){16, 16, 0.0});
    }
}

/* Most of the vertices in a ten-thousandth of the room: it must not be mistaken for the scene. */
static void grain(sl_room *r) {
    for (int i = 0; i < 200; i++) {
        double x = 0.8 + 5e-6 * (i % 20), y = 0.5 + 5e-6 * (i / 20), s = 4e-6;
        uint32_t a = add_vertex(r, x, y, -1.0), b = add_vertex(r, x + s, y, -1.0),
               c = add_vertex(r, x, y + s, -1.0);
        add_triangle(r, a, b, c, SL_ROOM_RED);
    }
}

/* ---- lights and materials ---- */

static void a_thousand_lamps(sl_room *r) {
    for (int i = 0; i < 1000; i++) {
        double x = -1.9 + 0.1 * (i % 38), z = -2.4 + 0.18 * (i / 38);
        const double lamp[4][3] = {
            {x, 2.98, z}, {x + 0.02, 2.98, z}, {x + 0.02, 2.98, z + 0.02}, {x, 2.98, z + 0.02}};
        add_quad(r, lamp, SL_ROOM_LAMP, &plain_cut);
    }
}

static void mirrors(sl_room *r) {
    static const sl_material_data mirror = {.mirror = {1.0f, 1.0f, 1.0f}};
    r->material[SL_ROOM_BOX] = r->material[SL_ROOM_GREEN] = mirror;
}

#define LIGHT(...) {.size = sizeof(sl_light_data), __VA_ARGS__}
#define POINT(x, y, z) \
    LIGHT(.type = SL_LIGHT_POINT, .position = {x, y, z}, .strength = {1.0f, 1.0f, 1.0f})

const sl_hard_case sl_hard_cases[] = {
    {"scaled by 1e-4", SL_EXPECT_SAME, 0.01, 0, 0, .scale = 1e-4},
    {"scaled by 1e4", SL_EXPECT_SAME, 0.01, 0, 0, .scale = 1e4},
    /* A room of 500 units, a million units away: a sixteenth of a unit is what a float tells apart there. */
    {"a million units away", SL_EXPECT_SAME, 0.03, 0, 1.5, .scale = 100.0, .by = {1e6, 1e6, -1e6}},
    {"mirrored", SL_EXPECT_MIRRORED, 0.02, 2, 0, .scale = 1.0},
    {"triangles reordered", SL_EXPECT_RESAMPLED, 0.02, 2, 0, .make = reordered},
    /* Meshes have these triangles for roots. */
    {"finely cut", SL_EXPECT_SAME, 0.02, 0, 1.5, .cut = {24, 24, 0.0}},
    {"slivers of aspect 1e6", SL_EXPECT_SAME, 0.02, 0, 1.5, .cut = {3, 1, 1e-6}},
    {"everything twice", SL_EXPECT_SAME, 0.02, 0, 1.5, .make = twice},
    {"T-junctions", SL_EXPECT_SAME, 0.02, 0, 1.5, .make = t_junctions},
    {"turned inside out", SL_EXPECT_RESAMPLED, 0.02, 2, 0, .make = inverted},
    {"not manifold", SL_EXPECT_SAME, 0.02, 0, 1.5, .make = not_manifold},
    {"triangles of 1e-6", SL_EXPECT_SAME, 0.005, 0, 0, .make = tiny_among_large},
    {"a grain of detail", SL_EXPECT_SAME, 0.005, 0, 0, .make = grain},
    {"triangles of 1e3", SL_EXPECT_SAME, 0.03, 0, 0, .make = large_among_small},
    {"triangles of 1e6", SL_EXPECT_SAME, 0.03, 0, 0, .make = huge_among_small},
    {"far planets", SL_EXPECT_SAME, 0.03, 0, 0, .make = far_planets},
    {"light on the floor", SL_EXPECT_TRUE, 0.05, 0, 2, .light = POINT(0.8, 0, 0)},
    /* A light that nobody sees takes its share of light samples all the same, and of the light that exposures
       are reckoned by. */
    {"light inside the box", SL_EXPECT_RESAMPLED, 0.02, 4, 4, .light = POINT(-0.7, 0.6, -1.1)},
    {"light behind the wall", SL_EXPECT_RESAMPLED, 0.02, 4, 4, .light = POINT(0, 1, -2.51)},
    /* Two surfaces in one place: which of them is seen, rounding decides. */
    {"lamp in the floor", SL_EXPECT_SOUND, 0, 0, 0,
     .light = LIGHT(.type = SL_LIGHT_QUAD, .position = {0.5, 0, 0}, .edge1 = {0, 0, 0.5},
                    .edge2 = {0.5, 0, 0}, .strength = {5, 5, 5})},
    {"tiny lamp", SL_EXPECT_TRUE, 0.05, 0, 2,
     .light = LIGHT(.type = SL_LIGHT_QUAD, .position = {1, 2, 0}, .edge1 = {1e-5, 0, 0},
                    .edge2 = {0, 0, 1e-5}, .strength = {1e10f, 1e10f, 1e10f})},
    /* Its light reaches a strip of the floor alone, an edge of light a pixel or two wide. */
    {"huge lamp", SL_EXPECT_TRUE, 0.12, 0, 12,
     .light = LIGHT(.type = SL_LIGHT_QUAD, .position = {-1e4, 2e4, -1e4}, .edge1 = {2e4, 0, 0},
                    .edge2 = {0, 0, 2e4}, .strength = {0.3f, 0.3f, 0.3f})},
    {"a thousand lamps", SL_EXPECT_TRUE, 0.06, 0, 3, .make = a_thousand_lamps},
    {"radiance times 1e-20", SL_EXPECT_SCALED, 0.0001, 0, 0, .emission = 1e-20},
    {"radiance times 1e20", SL_EXPECT_SCALED, 0.0001, 0, 0, .emission = 1e20},
    {"reflectance 0", SL_EXPECT_TRUE, 0.01, 0, 0, .reflects = {0.0, 0.0, 1.0}},
    {"reflectance 1", SL_EXPECT_TRUE, 0.06, 0, 4, .reflects = {1.0, 0.0, 1.0}},
    {"exponent 1", SL_EXPECT_TRUE, 0.05, 0, 2, .reflects = {0.3, 0.4, 1.0}},
    {"exponent 1e5", SL_EXPECT_TRUE, 0.05, 0, 5, .reflects = {0.3, 0.4, 1e5}},
    {"mirrors", SL_EXPECT_TRUE, 0.05, 0, 2, .make = mirrors},
    {"eye in the wall", SL_EXPECT_TRUE, 0.05, 0, 5, .eye = {0, 1, -2.5}, .target = {0, 1, 2}},
    {"eye in a corner", SL_EXPECT_TRUE, 0.08, 0, 12, .eye = {-2, 0, -2.5}, .target = {1, 1, 1}},
    {"eye at a grain", SL_EXPECT_TRUE, 0.05, 0, 5, .make = grain,
     .eye = {0.80005, 0.50005, -0.995}, .target = {0.80005, 0.50005, -1.0}},
    {"nothing to see", SL_EXPECT_TRUE, 0.01, 0, 0, .eye = {0, 1, 6}, .target = {0, 1, 60}},
    {"seen from 1e7", SL_EXPECT_TRUE, 0.01, 0, 0, .eye = {0, 1, 1e7}, .target = {0, 1, 0}},
    {"a telescope", SL_EXPECT_TRUE, 0.05, 0, 4,
     .eye = {0.1, 1.4, 1e4}, .target = {0.0, 1.3, -2.5}, .fov_deg = 0.02},
    {"one pixel", SL_EXPECT_TRUE, 0.05, 0, 2, .size = {1, 1}},
    {"one row", SL_EXPECT_TRUE, 0.05, 0, 4, .size = {40, 1}},
    {"one column", SL_EXPECT_TRUE, 0.05, 0, 2, .size = {1, 40}},
};
const size_t sl_hard_case_count = sizeof sl_hard_cases / sizeof sl_hard_cases[0];

static void make_case(const sl_hard_case *c, sl_room *r) {
    begin_room(r, c->cut.columns ? &c->cut : &plain_cut);
    if (c->make) c->make(r);
    for (int i = 0; c->emission > 0.0 && i < 3; i++)
        r->material[SL_ROOM_LAMP].emission[i] *= (float)c->emission;
    for (int m = SL_ROOM_WHITE; c->reflects[2] > 0.0 && m < SL_ROOM_LAMP; m++) {
        for (int i = 0; i < 3; i++) r->material[m].diffuse[i] = (float)c->reflects[0];
        for (int i = 0; i < 3; i++) r->material[m].specular[i] = (float)c->reflects[1];
        r->material[m].exponent = (float)c->reflects[2];
    }
    if (c->eye[1] != 0.0 || c->eye[0] != 0.0) {
        memcpy(r->eye, c->eye, sizeof r->eye);
        memcpy(r->target, c->target, sizeof r->target);
    }
    if (c->fov_deg > 0.0) r->fov_deg = c->fov_deg;
    if (c->size[0]) r->width = c->size[0], r->height = c->size[1];
    if (c->scale > 0.0) move_room(r, c->scale, c->by, c->expectation == SL_EXPECT_MIRRORED);
}

sl_status sl_hard_case_load(const sl_hard_case *hard, sl_scene **scene, sl_error *error) {
    static const sl_hard_case plain = {0};
    static sl_room room; /* large */
    const sl_hard_case *c = hard ? hard : &plain;
    make_case(c, &room);
    return build_room(&room, &c->light, scene, error);
}

const sl_known_limit sl_known_limits[] = {
    {"multi-mesh", "one row", 0.5, "all of the room is in two pixels, and each of them is of one leaf"},
    {"light-octree", "huge lamp", 0.35, "voxels blur the strip of light"},
    {"shading-cache", "huge lamp", 0.25, "an edge of light between vertices"},
    {"bidirectional", "one row", 0.9, "noise of the two pixels in which all of the room is"},
    {"path", "one row", 0.9, "noise of the two pixels in which all of the room is"},
    {"path", "reflectance 0", 0.5, "noise of the lamp's outline alone"},
    {"bidirectional", "reflectance 0", 0.5, "noise of the lamp's outline alone"},
    {"light-octree", "one row", 0.5, "voxels blur the two pixels in which all of the room is"},
    {"multi-mesh", "turned inside out", 0.05, "bodies wound inside out are not known for solids"},
    {"shading-cache", "exponent 1e5", 0.25, "what sharp lobes show is cached at vertices"},
    {"shading-cache", "mirrors", 0.2, "what mirrors show is cached at vertices"},
    {NULL, NULL, 0, NULL}};
