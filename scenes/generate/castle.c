/* A castle on a hill under a picture of the sky, about 58,000 triangles: curtain walls and round towers of
 * raised stones, a gatehouse with its arch and portcullis, a keep, houses and a well in the yard, woods and
 * hills around.
 *
 * The slates of the roofs are glossy (exponent 15); everything else is diffuse. The gate faces +z. */
#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "mesh.h"

enum { STONE, DRESSED, SLATE, GRASS, ROAD, WOOD, PLASTER, TILES, DARK, TRUNK, LEAVES, FIR, IRON, FLAG, WATER,
      MATERIALS };

static const gen_material materials[MATERIALS] = {
    [STONE] = {"stone", "Kd 0.5 0.45 0.37\n"},
    [DRESSED] = {"dressed_stone", "Kd 0.58 0.54 0.46\n"},
    [SLATE] = {"slate", "Kd 0.13 0.15 0.19\nKs 0.42 0.43 0.46\nNs 15\nillum 2\n"},
    [GRASS] = {"grass", "Kd 0.2 0.3 0.09\n"},
    [ROAD] = {"road", "Kd 0.44 0.37 0.28\n"},
    [WOOD] = {"wood", "Kd 0.28 0.18 0.1\n"},
    [PLASTER] = {"plaster", "Kd 0.7 0.64 0.52\n"},
    [TILES] = {"roof_tiles", "Kd 0.45 0.19 0.11\n"},
    [DARK] = {"dark", "Kd 0.03 0.03 0.03\n"},
    [TRUNK] = {"trunk", "Kd 0.22 0.15 0.1\n"},
    [LEAVES] = {"leaves", "Kd 0.16 0.28 0.06\n"},
    [FIR] = {"fir", "Kd 0.07 0.17 0.08\n"},
    [IRON] = {"iron", "Kd 0.12 0.12 0.13\n"},
    [FLAG] = {"flag", "Kd 0.6 0.08 0.06\n"},
    [WATER] = {"water", "Kd 0.08 0.16 0.2\n"},
};

static const double half_x = 18.0, half_z = 15.0, curtain = 7.0, thick = 1.6; /* the walls */

/* The hill: level at 0 where the castle stands, falling off outside, with higher hills far away and a road to
 * the gate. */
static double ground(double x, double z) {
    double r = sqrt(x * x + z * z);
    double slope = gen_smoothstep(26.0, 60.0, r), far = gen_smoothstep(60.0, 150.0, r);
    double rolling = gen_fractal(gen_v3(x * 0.035, 0.0, z * 0.035), 4, 601);
    double hills = 14.0 + 16.0 * gen_noise(gen_v3(x * 0.014, 0.0, z * 0.014), 611);
    return -9.0 * slope + 2.2 * slope * rolling + far * hills;
}

static v3 terrain_point(double u, double v, const void *unused) {
    (void)unused;
    double s = 2.0 * u - 1.0, t = 2.0 * v - 1.0; /* finer near the castle */
    double x = 170.0 * s * (0.3 + 0.7 * fabs(s)), z = -170.0 * t * (0.3 + 0.7 * fabs(t));
    return gen_v3(x, ground(x, z) - 0.02, z);
}

static v3 road_point(double u, double v, const void *unused) {
    (void)unused;
    double z = gen_mix(half_z - 4.0, 75.0, v),
           x = 7.0 * sl_sin((z - half_z) * 0.05) * gen_smoothstep(half_z, 45.0, z);
    x += (u - 0.5) * 3.6;
    return gen_v3(x, ground(x, z) + 0.1, z);
}

/* Courses of raised stones on a wall that faces +z; joints are staggered. */
static void ashlar(mesh *m, double x0, double x1, double y0, double y1, int courses, int stones) {
    double high = (y1 - y0) / courses, wide = (x1 - x0) / stones;
    for (int c = 0; c < courses; c++)
        for (int i = 0; i <= stones; i++) {
            double shift = c % 2 ? 0.5 : 0.0;
            double a = gen_clamp(x0 + (i - shift) * wide, x0, x1),
                   b = gen_clamp(x0 + (i + 1 - shift) * wide, x0, x1);
            double y = y0 + c * high;
            double up =
                0.03 + 0.05 * gen_random(621, (uint32_t)(c * 64 + i), (uint32_t)(stones * 16 + courses));
            if (b - a < 0.05) continue;
            gen_stone(m, gen_v3(a, y, 0), gen_v3(b, y, 0), gen_v3(b, y + high, 0), gen_v3(a, y + high, 0),
                      up);
        }
}

static void merlons(mesh *m, double x0, double x1, double y, double z, int count) {
    double step = (x1 - x0) / count;
    gen_box(m, gen_v3(x0, y, z - 0.5), gen_v3(x1, y + 0.8, z));
    for (int i = 0; i < count; i++) {
        double x = x0 + (i + 0.25) * step;
        gen_bevel_box(m, gen_v3(x, y + 0.8, z - 0.5), gen_v3(x + 0.55 * step, y + 1.7, z), 0.05);
    }
}

static void round_courses(mesh *m, double radius, double y0, double y1, int courses, int stones) {
    for (int c = 0; c < courses; c++)
        for (int i = 0; i < stones; i++) {
            double from = 2.0 * SL_PI * (i + (c % 2 ? 0.5 : 0.0)) / stones, to = from + 2.0 * SL_PI / stones;
            double low = gen_mix(y0, y1, (double)c / courses), high = gen_mix(y0, y1, (c + 1.0) / courses);
            double foot = 1.0 + 0.12 * (1.0 - gen_smoothstep(0.0, 0.35, (double)c / courses));
            double above = 1.0 + 0.12 * (1.0 - gen_smoothstep(0.0, 0.35, (c + 1.0) / courses));
            v3 a = gen_v3(sl_cos(from), 0, -sl_sin(from)), b = gen_v3(sl_cos(to), 0, -sl_sin(to));
            v3 up = {0, low, 0}, top = {0, high, 0};
            double raised = 0.03 + 0.05 * gen_random(631, (uint32_t)(c * 64 + i), (uint32_t)(radius * 100.0));
            gen_stone(m, gen_add(gen_scale(a, radius * foot), up), gen_add(gen_scale(b, radius * foot), up),
                      gen_add(gen_scale(b, radius * above), top), gen_add(gen_scale(a, radius * above), top),
                      raised);
        }
}

/* A round tower with corbels, merlons and, where roof > 0, a slated cone with a flag. */
static void tower(mesh *m, double x, double z, double radius, double height, double roof, int courses,
                  int stones) {
    frame before = gen_move(m, x, 0, z);
    gen_paint(m, "towers", STONE);
    round_courses(m, radius, -2.0, height, courses, stones);
    double core = 0.96 * radius; /* behind the stones, so that no light comes through the staggered joints */
    const v2 body[] = {{core, -2.0}, {core, height}};
    gen_lathe(m, body, 2, 24);
    gen_paint(m, "tower_tops", DRESSED);
    outline o = {.count = 0};
    gen_to(&o, 0.98 * radius, height - 0.1);
    gen_arc(&o, radius, height + 0.3, 0.45, 0.4, -90.0, 0.0, 4);
    gen_sharp(&o, radius + 0.45, height + 1.1);
    gen_sharp(&o, radius - 0.05, height + 1.1);
    gen_sharp(&o, radius - 0.05, height + 0.5);
    gen_to(&o, 0.0, height + 0.5);
    gen_lathe(m, o.p, o.count, 24);
    int count = radius > 3.0 ? 12 : 8;
    for (int i = 0; i < count; i++) {
        frame here = gen_turn(m, 360.0 * (i + 0.5) / count);
        double half = 0.27 * 2.0 * SL_PI * radius / count;
        gen_bevel_box(m, gen_v3(-half, height + 1.1, radius - 0.05),
                      gen_v3(half, height + 2.0, radius + 0.42), 0.05);
        m->frame = here;
    }
    gen_paint(m, "arrow_slits", DARK);
    for (int i = 0; i < 6; i++) {
        frame here = gen_turn(m, 60.0 * i + 15.0);
        double y = height * (0.45 + 0.25 * (i % 2));
        gen_box(m, gen_v3(-0.09, y, 0.9 * radius), gen_v3(0.09, y + 1.3, radius + 0.1));
        m->frame = here;
    }
    if (roof > 0.0) {
        gen_paint(m, "tower_roofs", SLATE);
        const double y = height + 1.9, r = radius + 0.75;
        outline cone = {.count = 0};
        gen_to(&cone, 0.0, y);
        gen_sharp(&cone, r, y);
        for (int i = 1; i <= 6; i++) gen_to(&cone, r * (1.0 - i / 6.0) * (0.9 + 0.1 * (1.0 - i / 6.0)),
                                            y + roof * i / 6.0);
        gen_lathe(m, cone.p, cone.count, 24);
        gen_paint(m, "roof_posts", WOOD);
        gen_rod(m, gen_v3(0, height + 0.5, 0), gen_v3(0, y + roof + 2.0, 0), 0.09, 0.05, 6);
        gen_paint(m, "flags", FLAG);
        v3 cloth[18];
        for (int c = 0; c < 9; c++)
            for (int row = 0; row < 2; row++)
                cloth[row * 9 + c] =
                    gen_v3(0.05 + 0.22 * c, y + roof + 0.9 + row * (1.0 - 0.06 * c) - 0.03 * c,
                           0.16 * sl_sin(0.9 * c) * c / 8.0);
        gen_grid(m, cloth, 9, 2, 0);
    }
    m->frame = before;
}

/* A length of curtain wall from x0 to x1 whose outer face is at z = 0, looking to +z. */
static void curtain_wall(mesh *m, double x0, double x1, int stones) {
    gen_paint(m, "curtain_walls", STONE);
    ashlar(m, x0, x1, -1.5, curtain, 9, stones);
    gen_panel(m, gen_v3(x1, -0.1, -thick), gen_v3(x0, -0.1, -thick), gen_v3(x0, curtain, -thick),
              gen_v3(x1, curtain, -thick), 6, 3);
    gen_paint(m, "wall_walks", DRESSED);
    gen_panel(m, gen_v3(x0, curtain, 0), gen_v3(x1, curtain, 0), gen_v3(x1, curtain, -thick),
              gen_v3(x0, curtain, -thick), 6, 1);
    merlons(m, x0, x1, curtain, 0.0, (int)((x1 - x0) / 2.0 + 0.5));
}

static void gatehouse(mesh *m) {
    frame before = gen_move(m, 0, 0, half_z - 2.0);
    const arch gate = {1.7, 2.6, 1.9, 0.75, 10};
    gen_paint(m, "gatehouse", DRESSED);
    gen_arch_wall(m, &gate, -3.4, 3.4, 0.0, 9.0, 5.0);
    gen_arch_moulding(m, &gate, 0.0, 2.5, 0.45, 0.15);
    gen_quad(m, gen_v3(3.4, 0, 2.5), gen_v3(3.4, 0, -2.5), gen_v3(3.4, 9, -2.5), gen_v3(3.4, 9, 2.5));
    gen_quad(m, gen_v3(-3.4, 0, -2.5), gen_v3(-3.4, 0, 2.5), gen_v3(-3.4, 9, 2.5), gen_v3(-3.4, 9, -2.5));
    gen_quad(m, gen_v3(-3.4, 9, 2.5), gen_v3(3.4, 9, 2.5), gen_v3(3.4, 9, -2.5), gen_v3(-3.4, 9, -2.5));
    merlons(m, -3.4, 3.4, 9.0, 2.5, 4);
    gen_paint(m, "coat_of_arms", FLAG);
    gen_stone(m, gen_v3(-0.6, 5.6, 2.5), gen_v3(0.6, 5.6, 2.5), gen_v3(0.6, 7.2, 2.5), gen_v3(-0.6, 7.2, 2.5),
              0.12);
    gen_paint(m, "portcullis", IRON); /* half drawn up */
    for (int i = 0; i < 9; i++) {
        double x = -1.6 + 0.4 * i;
        gen_box(m, gen_v3(x - 0.05, 2.3, 1.0), gen_v3(x + 0.05, 4.6, 1.1));
        v3 tip = gen_v3(x, 2.05, 1.05);
        gen_triangle(m, tip, gen_v3(x + 0.05, 2.3, 1.1), gen_v3(x - 0.05, 2.3, 1.1));
        gen_triangle(m, tip, gen_v3(x - 0.05, 2.3, 1.0), gen_v3(x + 0.05, 2.3, 1.0));
        gen_triangle(m, tip, gen_v3(x - 0.05, 2.3, 1.1), gen_v3(x - 0.05, 2.3, 1.0));
        gen_triangle(m, tip, gen_v3(x + 0.05, 2.3, 1.0), gen_v3(x + 0.05, 2.3, 1.1));
    }
    for (int i = 0; i < 4; i++)
        gen_box(m, gen_v3(-1.68, 2.5 + 0.5 * i, 0.98), gen_v3(1.68, 2.58 + 0.5 * i, 1.12));
    m->frame = before;
    for (int side = -1; side <= 1; side += 2) tower(m, side * 4.8, half_z - 0.4, 2.3, 10.0, 5.0, 12, 16);
}

/* A house of 2 w by 2 d with a gabled roof along x. */
static void house(mesh *m, double x, double z, double degrees, double w, double d, double eaves,
                  uint32_t roof) {
    frame before = gen_move(m, x, 0, z);
    gen_turn(m, degrees);
    double ridge = eaves + 0.9 * d;
    gen_paint(m, "houses", PLASTER);
    gen_box(m, gen_v3(-w, 0, -d), gen_v3(w, eaves, d));
    gen_triangle(m, gen_v3(w, eaves, d), gen_v3(w, eaves, -d), gen_v3(w, ridge, 0));
    gen_triangle(m, gen_v3(-w, eaves, -d), gen_v3(-w, eaves, d), gen_v3(-w, ridge, 0));
    gen_paint(m, "house_roofs", roof);
    double drop = 0.3, out = 0.35;
    for (int side = 0; side < 2; side++) { /* courses of slates, each a little proud of the one above */
        frame here = gen_turn(m, 180.0 * side);
        for (int c = 0; c < 8; c++) {
            double t0 = c / 8.0, t1 = (c + 1.0) / 8.0;
            double y0 = gen_mix(eaves - drop, ridge, t0), y1 = gen_mix(eaves - drop, ridge, t1);
            double z0 = gen_mix(d * (1.0 + drop / (ridge - eaves)), 0.0,
                                t0), z1 = gen_mix(d * (1.0 + drop / (ridge - eaves)), 0.0, t1);
            v3 a = gen_v3(-w - out, y0 + 0.12, z0), b = gen_v3(w + out, y0 + 0.12, z0);
            gen_panel(m, a, b, gen_v3(w + out, y1 + 0.06, z1), gen_v3(-w - out, y1 + 0.06, z1), 6, 1);
            gen_quad(m, gen_v3(-w - out, y0 + 0.0, z0), gen_v3(w + out, y0 + 0.0, z0), b, a);
        }
        m->frame = here;
    }
    gen_paint(m, "timber", WOOD);
    for (int i = 0; i <= 4; i++) {
        double at = -w + 0.5 * w * i;
        gen_box(m, gen_v3(at - 0.08, 0, d), gen_v3(at + 0.08, eaves, d + 0.06));
        gen_box(m, gen_v3(at - 0.08, 0, -d - 0.06), gen_v3(at + 0.08, eaves, -d));
    }
    gen_box(m, gen_v3(-w, eaves - 0.2, d), gen_v3(w, eaves, d + 0.07));
    gen_paint(m, "doors_and_windows", DARK);
    gen_box(m, gen_v3(-0.25 * w - 0.4, 0, d - 0.1), gen_v3(-0.25 * w + 0.4, 1.9, d + 0.03));
    for (int i = 0; i < 2; i++) gen_box(m, gen_v3(w * (i ? 0.6 : 0.1), 1.0, d - 0.1),
                                        gen_v3(w * (i ? 0.6 : 0.1) + 0.6, 1.8, d + 0.03));
    m->frame = before;
}

static void keep(mesh *m) {
    frame before = gen_move(m, -4.0, 0, -7.0);
    const double half = 4.6, height = 17.0;
    for (int s = 0; s < 4; s++) {
        frame here = gen_turn(m, 90.0 * s);
        gen_move(m, 0, 0, half);
        gen_paint(m, "keep", STONE);
        ashlar(m, -half, half, -0.5, height, 16, 6);
        gen_paint(m, "keep_quoins", DRESSED);
        gen_bevel_box(m, gen_v3(-half - 0.25, -0.5, -0.35), gen_v3(-half + 0.35, height + 0.1, 0.25), 0.08);
        merlons(m, -half, half, height, 0.15, 5);
        gen_paint(m, "keep_windows", DARK);
        for (int i = 0; i < 4; i++) {
            double x = i % 2 ? 1.8 : -2.3, y = 6.0 + 5.0 * (i / 2);
            gen_box(m, gen_v3(x, y, -0.3), gen_v3(x + 0.55, y + 1.5, 0.13));
        }
        m->frame = here;
    }
    gen_paint(m, "keep_roof", SLATE);
    const v3 apex = {0, height + 5.2, 0};
    for (int s = 0; s < 4; s++) {
        frame here = gen_turn(m, 90.0 * s);
        double e = half - 0.6;
        gen_panel(m, gen_v3(-e, height + 0.5, e), gen_v3(e, height + 0.5, e), apex, apex, 6, 6);
        m->frame = here;
    }
    gen_paint(m, "keep_deck", DRESSED);
    gen_quad(m, gen_v3(-half, height, half), gen_v3(half, height, half), gen_v3(half, height, -half),
             gen_v3(-half, height, -half));
    m->frame = before;
}

static void well(mesh *m) {
    frame before = gen_move(m, 6.0, 0, 4.5);
    gen_paint(m, "well", DRESSED);
    outline o = {.count = 0};
    gen_sharp(&o, 1.0, 0.0);
    gen_sharp(&o, 0.95, 0.75);
    gen_arc(&o, 0.85, 0.8, 0.17, 0.08, -40.0, 220.0, 6);
    gen_sharp(&o, 0.74, 0.75);
    gen_to(&o, 0.74, -0.5);
    gen_lathe(m, o.p, o.count, 20);
    gen_paint(m, "well_water", WATER);
    const v2 disc[] = {{0.74, -0.4}, {0.0, -0.4}};
    gen_lathe(m, disc, 2, 20);
    gen_paint(m, "well_frame", WOOD);
    for (int i = -1; i <= 1; i += 2) gen_box(m, gen_v3(0.85 * i - 0.07, 0.8, -0.07),
                                             gen_v3(0.85 * i + 0.07, 2.2, 0.07));
    gen_rod(m, gen_v3(-0.95, 1.6, 0), gen_v3(0.95, 1.6, 0), 0.07, 0.07, 8);
    gen_rod(m, gen_v3(0, 0.9, 0), gen_v3(0, 1.6, 0), 0.012, 0.012, 5);
    gen_paint(m, "well_roof", TILES);
    for (int side = 0; side < 2; side++) {
        frame here = gen_turn(m, 180.0 * side);
        gen_panel(m, gen_v3(-1.2, 2.0, 0.9), gen_v3(1.2, 2.0, 0.9), gen_v3(1.2, 2.8, 0), gen_v3(-1.2, 2.8, 0),
                  4, 4);
        m->frame = here;
    }
    m->frame = before;
}

static void trees(mesh *m) {
    for (uint32_t i = 0, planted = 0; i < 400 && planted < 42; i++) {
        double angle = 2.0 * SL_PI * gen_random(641, i, 0), r = 30.0 + 60.0 * gen_random(642, i, 0);
        double x = r * sl_cos(angle), z = r * sl_sin(angle), size = 0.8 + 0.7 * gen_random(643, i, 0);
        /* the road and the view */
        if ((fabs(x) < 15.0 && z > 0.0) || (z > 38.0 && x > 0.0 && x < 50.0)) continue;
        frame before = gen_move(m, x, ground(x, z) - 0.2, z);
        gen_paint(m, "trees", TRUNK);
        gen_rod(m, gen_v3(0, 0, 0), gen_v3(0, 2.4 * size, 0), 0.28 * size, 0.2 * size, 6);
        if (planted % 2) {
            gen_paint(m, "trees", FIR);
            for (int k = 0; k < 4; k++) {
                double y = (1.3 + 1.35 * k) * size, w = (2.1 - 0.45 * k) * size;
                const v2 skirt[] = {
                    {0.2, y + 0.25}, {w, y}, {w, y}, {0.5 * w, y + 1.0 * size}, {0.03, y + 2.3 * size}};
                gen_lathe(m, skirt, 5, 10);
            }
        } else {
            gen_paint(m, "trees", LEAVES);
            gen_ball(m, gen_v3(0, 4.2 * size, 0), gen_v3(2.3 * size, 2.4 * size, 2.3 * size), 12, 8, 0.22,
                     700 + i);
        }
        m->frame = before;
        planted++;
    }
}

/* ---- the sky --------------------------------------------------------------------------------- */

/* A clear sky from zenith to horizon, clouds drawn on a plane overhead, and a sun of three degrees' radius.
 */
static v3 sky(v3 d) {
    const v3 sun = {-0.82, 0.44, 0.37};
    double up = gen_max(d.y, 0.0), towards_sun = gen_dot(d, gen_unit(sun));
    v3 horizon = {0.92, 0.95, 1.0}, zenith = {0.2, 0.38, 0.82};
    v3 c = gen_lerp(horizon, zenith, 1.0 - (1.0 - up) * (1.0 - up) * (1.0 - up));
    if (d.y > 0.02) {
        v3 plane = gen_scale(gen_v3(d.x, 0.0, d.z), 1.1 / (d.y + 0.12));
        double cover =
            gen_smoothstep(0.05, 0.75, gen_fractal(plane, 5, 651)) * gen_smoothstep(0.02, 0.2, d.y);
        c = gen_lerp(c, gen_v3(1.35, 1.32, 1.28), 0.85 * cover);
    }
    if (d.y < 0.0) c = gen_lerp(horizon, gen_v3(0.16, 0.15, 0.11), gen_smoothstep(0.0, 0.12, -d.y));
    double glow = gen_smoothstep(0.8, 1.0, towards_sun);
    c = gen_add(c, gen_scale(gen_v3(1.0, 0.85, 0.6), 0.8 * glow * glow));
    if (towards_sun > 0.99863) c = gen_v3(1020, 920, 760);
    return c;
}

static void write_sky(const char *folder) {
    enum { WIDTH = 512, HEIGHT = 256 };
    float *rgb = gen_allocate(sizeof(float) * WIDTH * HEIGHT * 3);
    for (int row = 0; row < HEIGHT; row++)
        for (int column = 0; column < WIDTH; column++) {
            double theta = SL_PI * (row + 0.5) / HEIGHT, phi = 2.0 * SL_PI * ((column + 0.5) / WIDTH - 0.5);
            v3 c = sky(gen_v3(sl_sin(theta) * sl_sin(phi), sl_cos(theta), -sl_sin(theta) * sl_cos(phi)));
            float *to = rgb + 3 * (row * WIDTH + column);
            to[0] = (float)c.x, to[1] = (float)c.y, to[2] = (float)c.z;
        }
    gen_write_pfm(folder, "castle-sky", rgb, WIDTH, HEIGHT);
    free(rgb);
}

void gen_castle(const char *folder) {
    mesh m;
    gen_mesh_init(&m, materials, MATERIALS);
    gen_paint(&m, "hills", GRASS);
    gen_surface(&m, 76, 76, 0, terrain_point, NULL);
    gen_paint(&m, "road", ROAD);
    gen_surface(&m, 4, 60, GEN_FLIP, road_point, NULL);
    gen_paint(&m, "yard", ROAD);
    gen_panel(&m, gen_v3(-half_x, 0.05, half_z), gen_v3(half_x, 0.05, half_z), gen_v3(half_x, 0.05, -half_z),
              gen_v3(-half_x, 0.05, -half_z), 12, 10);
    for (int s = 0; s < 4; s++) {
        frame before = gen_turn(&m, 90.0 * s);
        double out = s % 2 ? half_x : half_z, along = s % 2 ? half_z : half_x;
        gen_move(&m, 0, 0, out);
        if (s == 0) {
            curtain_wall(&m, -along, -3.4, 8);
            curtain_wall(&m, 3.4, along, 8);
        } else {
            curtain_wall(&m, -along, along, s % 2 ? 15 : 18);
        }
        m.frame = before;
    }
    for (int i = 0; i < 4; i++)
        tower(&m, i & 1 ? half_x : -half_x, i & 2 ? half_z : -half_z, 3.6, i == 0 ? 15.0 : 12.0,
              i == 1 ? 0.0 : 7.0, 12, 18);
    gatehouse(&m);
    keep(&m);
    house(&m, 11.5, -8.5, 0.0, 4.0, 2.6, 3.4, TILES);
    house(&m, -13.0, 4.0, 90.0, 4.5, 2.4, 3.0, SLATE);
    house(&m, 13.2, 2.5, -90.0, 3.4, 2.2, 2.8, TILES);
    well(&m);
    trees(&m);
    write_sky(folder);
    gen_write_scene(folder, "castle", &m,
                    "  \"environment\": {\"file\": \"castle-sky.pfm\"},\n"
                    "  \"camera\": {\"eye\": [14, 15, 60], \"target\": [0.5, 5.5, -2], \"up\": [0, 1, 0], "
                    "\"fov_deg\": 46}");
    gen_mesh_free(&m);
}
