#include "app/numerics/cases.h"

#include <stdio.h>
#include <string.h>

static const sl_room_cut plain_cut = {1, 1, 0.0};

static void reordered(sl_room *r) {
    for (size_t i = 0; i < r->triangle_count / 2; i++) {
        size_t other = r->triangle_count - 1 - i;
        char one[sizeof r->triangle[0]];
        memcpy(one, &r->triangle[i], sizeof one);
        memcpy(&r->triangle[i], &r->triangle[other], sizeof one);
        memcpy(&r->triangle[other], one, sizeof one);
    }
}

static void twice(sl_room *r) {
    for (size_t i = 0, count = r->triangle_count; i < count; i++) {
        /* a lamp twice is twice as bright to some, and hidden to others */
        if (r->triangle[i].material == SL_ROOM_LAMP) continue;
        const size_t *c = r->triangle[i].corner;
        sl_room_triangle(r, c[0], c[1], c[2], r->triangle[i].material);
    }
}

/* The back wall's lower half is cut in three, the upper one in two: corners of one lie on edges of the other.
 */
static void t_junctions(sl_room *r) {
    for (size_t i = 0; i < r->triangle_count; i++) { /* takes the back wall out */
        bool back = true;
        for (int k = 0; k < 3; k++) back &= r->vertex[r->triangle[i].corner[k]][2] == -2.5;
        if (!back) continue;
        for (size_t k = i + 1; k < r->triangle_count; k++) r->triangle[k - 1] = r->triangle[k];
        r->triangle_count--, i--;
    }
    const double low[4][3] = {{-2, 0, -2.5}, {2, 0, -2.5}, {2, 1.5, -2.5}, {-2, 1.5, -2.5}},
                 high[4][3] = {{-2, 1.5, -2.5}, {2, 1.5, -2.5}, {2, 3, -2.5}, {-2, 3, -2.5}};
    sl_room_quad(r, low, SL_ROOM_WHITE, &(sl_room_cut){3, 1, 0.0});
    sl_room_quad(r, high, SL_ROOM_WHITE, &(sl_room_cut){2, 1, 0.0});
}

/* Surfaces reflect on both sides; the lamp stays as it is. */
static void inverted(sl_room *r) {
    for (size_t i = 0; i < r->triangle_count; i++) {
        if (r->triangle[i].material == SL_ROOM_LAMP) continue;
        size_t b = r->triangle[i].corner[1];
        r->triangle[i].corner[1] = r->triangle[i].corner[2];
        r->triangle[i].corner[2] = b;
    }
}

/* Three faces on each edge of the box: fins that stand inside it, where nothing is seen of them. */
static void not_manifold(sl_room *r) {
    size_t a = sl_room_vertex(r, -1.2, 0.0, -1.6), b = sl_room_vertex(r, -0.2, 1.3, -0.6),
           c = sl_room_vertex(r, -1.2, 1.3, -1.6), d = sl_room_vertex(r, -0.2, 0.0, -0.6);
    sl_room_triangle(r, a, d, b, SL_ROOM_BOX);
    sl_room_triangle(r, a, b, c, SL_ROOM_BOX);
}

/* ---- large and small at once ---- */

static void tiny_among_large(sl_room *r) {
    for (int i = 0; i < 40; i++) {
        double x = 0.2 + 0.03 * i, s = 4e-6;
        size_t a = sl_room_vertex(r, x, 0.5, -1.0), b = sl_room_vertex(r, x + s, 0.5, -1.0),
               c = sl_room_vertex(r, x, 0.5 + s, -1.0);
        sl_room_triangle(r, a, b, c, SL_ROOM_RED);
    }
}

static void plain_below(sl_room *r, double half) {
    const double far[4][3] = {{-half, -5, half}, {half, -5, half}, {half, -5, -half}, {-half, -5, -half}};
    sl_room_quad(r, far, SL_ROOM_WHITE, &plain_cut);
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
        sl_room_quad(r, side, SL_ROOM_WHITE, &(sl_room_cut){16, 16, 0.0});
    }
}

/* Most of the vertices in a ten-thousandth of the room: it must not be mistaken for the scene. */
static void grain(sl_room *r) {
    for (int i = 0; i < 200; i++) {
        double x = 0.8 + 5e-6 * (i % 20), y = 0.5 + 5e-6 * (i / 20), s = 4e-6;
        size_t a = sl_room_vertex(r, x, y, -1.0), b = sl_room_vertex(r, x + s, y, -1.0),
               c = sl_room_vertex(r, x, y + s, -1.0);
        sl_room_triangle(r, a, b, c, SL_ROOM_RED);
    }
}

/* ---- lights and materials ---- */

static void a_thousand_lamps(sl_room *r) {
    for (int i = 0; i < 1000; i++) {
        double x = -1.9 + 0.1 * (i % 38), z = -2.4 + 0.18 * (i / 38);
        const double lamp[4][3] = {
            {x, 2.98, z}, {x + 0.02, 2.98, z}, {x + 0.02, 2.98, z + 0.02}, {x, 2.98, z + 0.02}};
        sl_room_quad(r, lamp, SL_ROOM_LAMP, &plain_cut);
    }
}

static void mirrors(sl_room *r) {
    r->material[SL_ROOM_BOX].mirror = r->material[SL_ROOM_GREEN].mirror = 1.0;
}

#define LAMP(corner, edge1, edge2, radiance) \
    "{\"type\": \"quad\", \"corner\": " corner ", \"edge1\": " edge1 ", \"edge2\": " edge2 \
    ", \"radiance\": " radiance "}"
#define POINT(position) "{\"type\": \"point\", \"position\": " position ", \"intensity\": 1}"

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
    {"light on the floor", SL_EXPECT_TRUE, 0.05, 0, 2, .lights = POINT("[0.8, 0, 0]")},
    /* A light that nobody sees takes its share of light samples all the same, and of the light that exposures
       are reckoned by. */
    {"light inside the box", SL_EXPECT_RESAMPLED, 0.02, 4, 4, .lights = POINT("[-0.7, 0.6, -1.1]")},
    {"light behind the wall", SL_EXPECT_RESAMPLED, 0.02, 4, 4, .lights = POINT("[0, 1, -2.51]")},
    /* Two surfaces in one place: which of them is seen, rounding decides. */
    {"lamp in the floor", SL_EXPECT_SOUND, 0, 0, 0,
     .lights = LAMP("[0.5, 0, 0]", "[0, 0, 0.5]", "[0.5, 0, 0]", "5")},
    {"tiny lamp", SL_EXPECT_TRUE, 0.05, 0, 2,
     .lights = LAMP("[1, 2, 0]", "[1e-5, 0, 0]", "[0, 0, 1e-5]", "1e10")},
    /* Its light reaches a strip of the floor alone, an edge of light a pixel or two wide. */
    {"huge lamp", SL_EXPECT_TRUE, 0.12, 0, 12,
     .lights = LAMP("[-1e4, 2e4, -1e4]", "[2e4, 0, 0]", "[0, 0, 2e4]", "0.3")},
    {"a thousand lamps", SL_EXPECT_TRUE, 0.06, 0, 3, .make = a_thousand_lamps},
    {"radiance times 1e-20", SL_EXPECT_SCALED, 0.0001, 0, 0, .emission = 1e-20},
    {"radiance times 1e20", SL_EXPECT_SCALED, 0.0001, 0, 0, .emission = 1e20},
    {"reflectance 0", SL_EXPECT_TRUE, 0.01, 0, 0, .reflects = {0.0, 0.0, 1.0}},
    {"reflectance 1", SL_EXPECT_TRUE, 0.06, 0, 4, .reflects = {1.0, 0.0, 1.0}},
    {"reflectance above 1", SL_EXPECT_TRUE, 0.06, 0, 4, .reflects = {1.7, 0.5, 5.0}},
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

void sl_hard_case_make(const sl_hard_case *c, sl_room *r) {
    sl_room_begin(r, c->cut.columns ? &c->cut : &plain_cut);
    if (c->make) c->make(r);
    if (c->lights) snprintf(r->lights, sizeof r->lights, "%s", c->lights);
    for (int i = 0; c->emission > 0.0 && i < 3; i++) r->material[SL_ROOM_LAMP].emission[i] *= c->emission;
    for (int m = SL_ROOM_WHITE; c->reflects[2] > 0.0 && m < SL_ROOM_LAMP; m++) {
        for (int i = 0; i < 3; i++) r->material[m].diffuse[i] = c->reflects[0];
        r->material[m].specular = c->reflects[1];
        r->material[m].exponent = c->reflects[2];
    }
    if (c->eye[1] != 0.0 || c->eye[0] != 0.0) {
        memcpy(r->eye, c->eye, sizeof r->eye);
        memcpy(r->target, c->target, sizeof r->target);
    }
    if (c->fov_deg > 0.0) r->fov_deg = c->fov_deg;
    if (c->size[0]) r->width = c->size[0], r->height = c->size[1];
    if (c->scale > 0.0) sl_room_move(r, c->scale, c->by, c->expectation == SL_EXPECT_MIRRORED);
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
