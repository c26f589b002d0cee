#include "app/numerics/cases.h"

#include <stdio.h>
#include <string.h>

static const sl_room_cut plain_cut = {1, 1, 0.0};
static const double nowhere[3] = {0.0, 0.0, 0.0};

static void begin(sl_room *r) { sl_room_begin(r, &plain_cut); }

/* ---- the same room elsewhere ---- */

static void scaled_down(sl_room *r) { begin(r), sl_room_move(r, 1e-4, nowhere, false); }
static void scaled_up(sl_room *r) { begin(r), sl_room_move(r, 1e4, nowhere, false); }
/* A room of 500 units, a million units away: a sixteenth of a unit is what a float tells apart there. */
static void far_away(sl_room *r) {
    begin(r), sl_room_move(r, 100.0, (const double[3]){1e6, 1e6, -1e6}, false);
}
static void mirrored(sl_room *r) { begin(r), sl_room_move(r, 1.0, nowhere, true); }

static void reordered(sl_room *r) {
    begin(r);
    for (size_t i = 0; i < r->triangle_count / 2; i++) {
        size_t other = r->triangle_count - 1 - i;
        char one[sizeof r->triangle[0]];
        memcpy(one, &r->triangle[i], sizeof one);
        memcpy(&r->triangle[i], &r->triangle[other], sizeof one);
        memcpy(&r->triangle[other], one, sizeof one);
    }
}

/* ---- other triangles for the same surfaces ---- */

static void finely_cut(sl_room *r) { sl_room_begin(r, &(sl_room_cut){24, 24, 0.0}); }
static void slivers(sl_room *r) { sl_room_begin(r, &(sl_room_cut){3, 1, 1e-6}); }

static void twice(sl_room *r) {
    begin(r);
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
    begin(r);
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
    begin(r);
    for (size_t i = 0; i < r->triangle_count; i++) {
        if (r->triangle[i].material == SL_ROOM_LAMP) continue;
        size_t b = r->triangle[i].corner[1];
        r->triangle[i].corner[1] = r->triangle[i].corner[2];
        r->triangle[i].corner[2] = b;
    }
}

/* Three faces on each edge of the box: fins that stand inside it, where nothing is seen of them. */
static void not_manifold(sl_room *r) {
    begin(r);
    size_t a = sl_room_vertex(r, -1.2, 0.0, -1.6), b = sl_room_vertex(r, -0.2, 1.3, -0.6),
           c = sl_room_vertex(r, -1.2, 1.3, -1.6), d = sl_room_vertex(r, -0.2, 0.0, -0.6);
    sl_room_triangle(r, a, d, b, SL_ROOM_BOX);
    sl_room_triangle(r, a, b, c, SL_ROOM_BOX);
}

/* ---- large and small at once ---- */

static void tiny_among_large(sl_room *r) {
    begin(r);
    for (int i = 0; i < 40; i++) {
        double x = 0.2 + 0.03 * i, s = 4e-6;
        size_t a = sl_room_vertex(r, x, 0.5, -1.0), b = sl_room_vertex(r, x + s, 0.5, -1.0),
               c = sl_room_vertex(r, x, 0.5 + s, -1.0);
        sl_room_triangle(r, a, b, c, SL_ROOM_RED);
    }
}

static void plain_below(sl_room *r, double half) {
    begin(r);
    const double far[4][3] = {{-half, -5, half}, {half, -5, half}, {half, -5, -half}, {-half, -5, -half}};
    sl_room_quad(r, far, SL_ROOM_WHITE, &plain_cut);
}
static void large_among_small(sl_room *r) { plain_below(r, 4e3); }
static void huge_among_small(sl_room *r) { plain_below(r, 4e6); }

/* Most of the vertices a million units away: no plain on which the room stands, but things of which it knows
 * nothing. */
static void far_planets(sl_room *r) {
    static const double place[3][3] = {{1e6, 2e5, 0}, {-3e5, 1e6, 1e5}, {1e5, 3e5, -1e6}};
    begin(r);
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
    begin(r);
    for (int i = 0; i < 200; i++) {
        double x = 0.8 + 5e-6 * (i % 20), y = 0.5 + 5e-6 * (i / 20), s = 4e-6;
        size_t a = sl_room_vertex(r, x, y, -1.0), b = sl_room_vertex(r, x + s, y, -1.0),
               c = sl_room_vertex(r, x, y + s, -1.0);
        sl_room_triangle(r, a, b, c, SL_ROOM_RED);
    }
}

/* ---- lights ---- */

static void light_text(sl_room *r, const char *text) {
    begin(r);
    snprintf(r->lights, sizeof r->lights, "%s", text);
}
static void light_on_the_floor(sl_room *r) {
    light_text(r, "{\"type\": \"point\", \"position\": [0.8, 0, 0], \"intensity\": 1}");
}
static void light_in_the_box(sl_room *r) {
    light_text(r, "{\"type\": \"point\", \"position\": [-0.7, 0.6, -1.1], \"intensity\": 1}");
}
static void light_behind_the_wall(sl_room *r) {
    light_text(r, "{\"type\": \"point\", \"position\": [0, 1, -2.51], \"intensity\": 1}");
}
static void lamp_in_the_floor(sl_room *r) {
    light_text(r, "{\"type\": \"quad\", \"corner\": [0.5, 0, 0], \"edge1\": [0, 0, 0.5], \"edge2\": [0.5, 0, "
                  "0], \"radiance\": 5}");
}
static void tiny_lamp(sl_room *r) {
    light_text(r, "{\"type\": \"quad\", \"corner\": [1, 2, 0], \"edge1\": [1e-5, 0, 0], \"edge2\": [0, 0, "
                  "1e-5], \"radiance\": 1e10}");
}
static void huge_lamp(sl_room *r) {
    light_text(r, "{\"type\": \"quad\", \"corner\": [-1e4, 2e4, -1e4], \"edge1\": [2e4, 0, 0], \"edge2\": "
                  "[0, 0, 2e4], \"radiance\": 0.3}");
}
static void a_thousand_lamps(sl_room *r) {
    begin(r);
    for (int i = 0; i < 1000; i++) {
        double x = -1.9 + 0.1 * (i % 38), z = -2.4 + 0.18 * (i / 38);
        const double lamp[4][3] = {
            {x, 2.98, z}, {x + 0.02, 2.98, z}, {x + 0.02, 2.98, z + 0.02}, {x, 2.98, z + 0.02}};
        sl_room_quad(r, lamp, SL_ROOM_LAMP, &plain_cut);
    }
}

static void emission(sl_room *r, double times) {
    begin(r);
    for (int c = 0; c < 3; c++) r->material[SL_ROOM_LAMP].emission[c] *= times;
}
static void faint(sl_room *r) { emission(r, 1e-20); }
static void blinding(sl_room *r) { emission(r, 1e20); }

/* ---- materials ---- */

static void reflectance(sl_room *r, double kd, double ks, double exponent) {
    begin(r);
    for (int m = SL_ROOM_WHITE; m < SL_ROOM_LAMP; m++) {
        for (int c = 0; c < 3; c++) r->material[m].diffuse[c] = kd;
        r->material[m].specular = ks;
        r->material[m].exponent = exponent;
    }
}
static void black(sl_room *r) { reflectance(r, 0.0, 0.0, 1.0); }
static void white(sl_room *r) { reflectance(r, 1.0, 0.0, 1.0); }
static void more_than_white(sl_room *r) { reflectance(r, 1.7, 0.5, 5.0); }
static void dull_gloss(sl_room *r) { reflectance(r, 0.3, 0.4, 1.0); }
static void sharp_gloss(sl_room *r) { reflectance(r, 0.3, 0.4, 1e5); }
static void mirrors(sl_room *r) {
    begin(r);
    r->material[SL_ROOM_BOX].mirror = r->material[SL_ROOM_GREEN].mirror = 1.0;
}

/* ---- the eye ---- */

static void look(sl_room *r, const double eye[3], const double target[3]) {
    begin(r);
    memcpy(r->eye, eye, sizeof r->eye);
    memcpy(r->target, target, sizeof r->target);
}
static void eye_in_the_wall(sl_room *r) {
    look(r, (const double[3]){0, 1, -2.5}, (const double[3]){0, 1, 2});
}
static void eye_in_a_corner(sl_room *r) {
    look(r, (const double[3]){-2, 0, -2.5}, (const double[3]){1, 1, 1});
}
static void eye_at_a_grain(sl_room *r) {
    grain(r);
    r->eye[0] = 0.80005, r->eye[1] = 0.50005, r->eye[2] = -0.995;
    memcpy(r->target, (const double[3]){0.80005, 0.50005, -1.0}, sizeof r->target);
}
static void nothing_to_see(sl_room *r) { look(r, (const double[3]){0, 1, 6}, (const double[3]){0, 1, 60}); }
static void far_view(sl_room *r) { look(r, (const double[3]){0, 1, 1e7}, (const double[3]){0, 1, 0}); }
static void telescope(sl_room *r) { begin(r), r->eye[2] = 1e4, r->fov_deg = 0.02; }

static void size(sl_room *r, int width, int height) { begin(r), r->width = width, r->height = height; }
static void one_pixel(sl_room *r) { size(r, 1, 1); }
static void one_row(sl_room *r) { size(r, 40, 1); }
static void one_column(sl_room *r) { size(r, 1, 40); }

const sl_hard_case sl_hard_cases[] = {
    {"scaled by 1e-4", scaled_down, SL_EXPECT_SAME, 0.01, 0, 0, 1},
    {"scaled by 1e4", scaled_up, SL_EXPECT_SAME, 0.01, 0, 0, 1},
    {"a million units away", far_away, SL_EXPECT_SAME, 0.03, 0, 1.5, 1},
    {"mirrored", mirrored, SL_EXPECT_MIRRORED, 0.02, 2, 0, 1},
    {"triangles reordered", reordered, SL_EXPECT_RESAMPLED, 0.02, 2, 0, 1},
    /* Meshes have these triangles for roots. */
    {"finely cut", finely_cut, SL_EXPECT_SAME, 0.02, 0, 1.5, 1},
    {"slivers of aspect 1e6", slivers, SL_EXPECT_SAME, 0.02, 0, 1.5, 1},
    {"everything twice", twice, SL_EXPECT_SAME, 0.02, 0, 1.5, 1},
    {"T-junctions", t_junctions, SL_EXPECT_SAME, 0.02, 0, 1.5, 1},
    {"turned inside out", inverted, SL_EXPECT_RESAMPLED, 0.02, 2, 0, 1},
    {"not manifold", not_manifold, SL_EXPECT_SAME, 0.02, 0, 1.5, 1},
    {"triangles of 1e-6", tiny_among_large, SL_EXPECT_SAME, 0.005, 0, 0, 1},
    {"a grain of detail", grain, SL_EXPECT_SAME, 0.005, 0, 0, 1},
    {"triangles of 1e3", large_among_small, SL_EXPECT_SAME, 0.03, 0, 0, 1},
    {"triangles of 1e6", huge_among_small, SL_EXPECT_SAME, 0.03, 0, 0, 1},
    {"far planets", far_planets, SL_EXPECT_SAME, 0.03, 0, 0, 1},
    {"light on the floor", light_on_the_floor, SL_EXPECT_TRUE, 0.05, 0, 2, 1},
    /* A light that nobody sees takes its share of light samples all the same, and of the light that exposures
       are reckoned by. */
    {"light inside the box", light_in_the_box, SL_EXPECT_RESAMPLED, 0.02, 4, 4, 1},
    {"light behind the wall", light_behind_the_wall, SL_EXPECT_RESAMPLED, 0.02, 4, 4, 1},
    /* Two surfaces in one place: which of them is seen, rounding decides. */
    {"lamp in the floor", lamp_in_the_floor, SL_EXPECT_SOUND, 0, 0, 0, 1},
    {"tiny lamp", tiny_lamp, SL_EXPECT_TRUE, 0.05, 0, 2, 1},
    /* Its light reaches a strip of the floor alone, an edge of light a pixel or two wide. */
    {"huge lamp", huge_lamp, SL_EXPECT_TRUE, 0.12, 0, 12, 1},
    {"a thousand lamps", a_thousand_lamps, SL_EXPECT_TRUE, 0.06, 0, 3, 1},
    {"radiance times 1e-20", faint, SL_EXPECT_SCALED, 0.0001, 0, 0, 1e-20},
    {"radiance times 1e20", blinding, SL_EXPECT_SCALED, 0.0001, 0, 0, 1e20},
    {"reflectance 0", black, SL_EXPECT_TRUE, 0.01, 0, 0, 1},
    {"reflectance 1", white, SL_EXPECT_TRUE, 0.06, 0, 4, 1},
    {"reflectance above 1", more_than_white, SL_EXPECT_TRUE, 0.06, 0, 4, 1},
    {"exponent 1", dull_gloss, SL_EXPECT_TRUE, 0.05, 0, 2, 1},
    {"exponent 1e5", sharp_gloss, SL_EXPECT_TRUE, 0.05, 0, 5, 1},
    {"mirrors", mirrors, SL_EXPECT_TRUE, 0.05, 0, 2, 1},
    {"eye in the wall", eye_in_the_wall, SL_EXPECT_TRUE, 0.05, 0, 5, 1},
    {"eye in a corner", eye_in_a_corner, SL_EXPECT_TRUE, 0.08, 0, 12, 1},
    {"eye at a grain", eye_at_a_grain, SL_EXPECT_TRUE, 0.05, 0, 5, 1},
    {"nothing to see", nothing_to_see, SL_EXPECT_TRUE, 0.01, 0, 0, 1},
    {"seen from 1e7", far_view, SL_EXPECT_TRUE, 0.01, 0, 0, 1},
    {"a telescope", telescope, SL_EXPECT_TRUE, 0.05, 0, 4, 1},
    {"one pixel", one_pixel, SL_EXPECT_TRUE, 0.05, 0, 2, 1},
    {"one row", one_row, SL_EXPECT_TRUE, 0.05, 0, 4, 1},
    {"one column", one_column, SL_EXPECT_TRUE, 0.05, 0, 2, 1},
};
const size_t sl_hard_case_count = sizeof sl_hard_cases / sizeof sl_hard_cases[0];

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
