/* A pool hall of about 10,000 triangles and quadrilaterals, eleven lamps without extent, and fifteen glossy
 * balls, two bicubic surfaces each. pool-walk.json: the eye walks round the table. */
#include <stdio.h>
#include <stdlib.h>

#include "mesh.h"

enum { WALL, PANEL, BOARDS, WOOD, BAIZE, LEATHER, GLASS_GREEN, GLASS_BROWN, BRASS, SHADE, MATERIALS };

static const gen_material materials[MATERIALS] = {
    [WALL] = {"wall", "Kd 0.62 0.52 0.4\n"},
    [PANEL] = {"panel", "Kd 0.34 0.2 0.11\n"},
    [BOARDS] = {"boards", "Kd 0.42 0.27 0.16\n"},
    [WOOD] = {"wood", "Kd 0.3 0.15 0.08\nKs 0.1 0.1 0.1\nNs 30\n"},
    [BAIZE] = {"baize", "Kd 0.08 0.36 0.16\n"},
    [LEATHER] = {"leather", "Kd 0.42 0.1 0.08\n"},
    [GLASS_GREEN] = {"bottle_green", "Kd 0.1 0.3 0.14\n"},
    [GLASS_BROWN] = {"bottle_brown", "Kd 0.36 0.2 0.07\n"},
    [BRASS] = {"brass", "Kd 0.45 0.34 0.14\n"},
    [SHADE] = {"shade", "Kd 0.55 0.6 0.5\n"},
};

static const double width = 9.0, height = 3.2, depth = 7.0;
enum { LAMPS = 11, BALLS = 15 };

/* Over the table, over the bar, on the walls: where the shade's top is. */
static const v3 lamp_at[LAMPS] = {{3.5, 1.95, 3.4}, {4.4, 1.95, 3.4}, {5.3, 1.95, 3.4}, {2.0, 2.2, 0.9},
                                  {3.6, 2.2, 0.9},  {5.2, 2.2, 0.9},  {6.8, 2.2, 0.9},  {0.35, 2.3, 2.4},
                                  {0.35, 2.3, 5.0}, {8.65, 2.3, 2.4}, {8.65, 2.3, 5.0}};

static void shell(mesh *m) {
    gen_paint(m, "floor", BOARDS);
    for (int k = 0; k < 10; k++)
        for (int i = 0; i < 24; i++) {
            double x = width * i / 24, z = depth * k / 10, dx = width / 24, dz = depth / 10;
            gen_stone(m, gen_v3(x, -0.003, z + dz), gen_v3(x + dx, -0.003, z + dz), gen_v3(x + dx, -0.003, z),
                      gen_v3(x, -0.003, z), 0.003);
        }
    gen_paint(m, "ceiling", WALL);
    gen_quad(m, gen_v3(0, height, 0), gen_v3(width, height, 0), gen_v3(width, height, depth),
             gen_v3(0, height, depth));
    gen_paint(m, "beams", PANEL);
    for (int i = 0; i < 7; i++)
        gen_box(m, gen_v3(0.6 + 1.25 * i, height - 0.2, 0), gen_v3(0.75 + 1.25 * i, height, depth));
    for (int side = 0; side < 4; side++) {
        double length = side % 2 ? depth : width;
        frame before = gen_move(m, side == 1 || side == 2 ? width : 0, 0, side >= 2 ? depth : 0);
        gen_turn(m, side == 0 ? 0.0 : side == 1 ? -90.0 : side == 2 ? 180.0 : 90.0);
        gen_paint(m, "walls", WALL);
        gen_quad(m, gen_v3(0, 1.1, 0), gen_v3(length, 1.1, 0), gen_v3(length, height, 0),
                 gen_v3(0, height, 0));
        gen_paint(m, "panels", PANEL);
        for (int i = 0; i < 14; i++) {
            double x0 = length * i / 14, x1 = length * (i + 1) / 14;
            gen_stone(m, gen_v3(x0, 0, 0), gen_v3(x1, 0, 0), gen_v3(x1, 1.1, 0), gen_v3(x0, 1.1, 0), 0.03);
        }
        m->frame = before;
    }
}

static void table(mesh *m) {
    frame before = gen_move(m, 4.4, 0, 3.4);
    gen_paint(m, "pool_table", WOOD);
    gen_box(m, gen_v3(-1.35, 0.62, -0.75), gen_v3(1.35, 0.8, 0.75));
    for (int i = 0; i < 4; i++) {
        double x = i & 1 ? 1.05 : -1.25, z = i & 2 ? 0.45 : -0.65;
        gen_bevel_box(m, gen_v3(x, 0, z), gen_v3(x + 0.2, 0.62, z + 0.2), 0.02);
    }
    gen_bevel_box(m, gen_v3(-1.4, 0.78, -0.8), gen_v3(1.4, 0.86, -0.66), 0.015);
    gen_bevel_box(m, gen_v3(-1.4, 0.78, 0.66), gen_v3(1.4, 0.86, 0.8), 0.015);
    gen_bevel_box(m, gen_v3(-1.4, 0.78, -0.66), gen_v3(-1.26, 0.86, 0.66), 0.015);
    gen_bevel_box(m, gen_v3(1.26, 0.78, -0.66), gen_v3(1.4, 0.86, 0.66), 0.015);
    gen_paint(m, "baize", BAIZE);
    gen_panel(m, gen_v3(-1.26, 0.81, 0.66), gen_v3(1.26, 0.81, 0.66), gen_v3(1.26, 0.81, -0.66),
              gen_v3(-1.26, 0.81, -0.66), 8, 4);
    m->frame = before;
}

static void bottle(mesh *m, double x, double y, double z, uint32_t number) {
    frame before = gen_move(m, x, y, z);
    double tall = 0.26 + 0.06 * gen_random(5, number, 0), wide = 0.032 + 0.01 * gen_random(5, number, 1);
    outline o = {.count = 0};
    gen_sharp(&o, wide, 0.0);
    gen_to(&o, wide, 0.6 * tall);
    gen_arc(&o, wide - 0.02, 0.6 * tall, 0.02, 0.04, 0.0, 70.0, 3);
    gen_to(&o, 0.012, 0.8 * tall);
    gen_sharp(&o, 0.012, tall);
    gen_to(&o, 0.0, tall);
    gen_paint(m, "bottles", gen_random(5, number, 2) < 0.5 ? GLASS_GREEN : GLASS_BROWN);
    gen_lathe(m, o.p, o.count, 10);
    m->frame = before;
}

static void bar(mesh *m) {
    gen_paint(m, "bar", WOOD);
    gen_box(m, gen_v3(1.2, 0, 1.05), gen_v3(7.6, 1.05, 1.2));
    gen_bevel_box(m, gen_v3(1.1, 1.05, 0.85), gen_v3(7.7, 1.1, 1.4), 0.01);
    for (int i = 0; i < 3; i++)
        gen_box(m, gen_v3(1.8, 1.2 + 0.42 * i, 0.03), gen_v3(7.0, 1.23 + 0.42 * i, 0.25));
    for (uint32_t i = 0; i < 33; i++) bottle(m, 2.0 + 0.46 * (i % 11), 1.23 + 0.42 * (i / 11), 0.14, i);
    for (int i = 0; i < 5; i++) {
        frame before = gen_move(m, 2.0 + 1.2 * i, 0, 1.75);
        gen_paint(m, "stools", LEATHER);
        const v2 seat[5] = {{0.17, 0.7}, {0.19, 0.73}, {0.18, 0.77}, {0.18, 0.77}, {0.0, 0.78}};
        gen_lathe(m, seat, 5, 14);
        gen_paint(m, "stool_legs", BRASS);
        for (int leg = 0; leg < 4; leg++) {
            double s = leg & 1 ? 1.0 : -1.0, t = leg & 2 ? 1.0 : -1.0;
            gen_rod(m, gen_v3(0.18 * s, 0, 0.18 * t), gen_v3(0.1 * s, 0.7, 0.1 * t), 0.014, 0.014, 6);
        }
        m->frame = before;
    }
}

static void lamp(mesh *m, v3 at) {
    frame before = gen_move(m, at.x, at.y, at.z);
    gen_paint(m, "shades", SHADE);
    const v2 outside[3] = {{0.2, -0.16}, {0.13, -0.02}, {0.03, 0.0}},
             inside[4] = {{0.025, -0.01}, {0.12, -0.03}, {0.19, -0.16}, {0.2, -0.16}};
    gen_lathe(m, outside, 3, 16);
    gen_lathe(m, inside, 4, 16);
    gen_paint(m, "rods", BRASS);
    gen_rod(m, gen_v3(0, 0, 0), gen_v3(0, height - at.y, 0), 0.01, 0.01, 6);
    m->frame = before;
}

static void cues(mesh *m) {
    gen_paint(m, "cue_rack", PANEL);
    gen_box(m, gen_v3(2.5, 1.5, depth - 0.08), gen_v3(4.1, 1.56, depth));
    gen_box(m, gen_v3(2.5, 0.3, depth - 0.08), gen_v3(4.1, 0.36, depth));
    gen_paint(m, "cues", WOOD);
    for (int i = 0; i < 8; i++)
        gen_rod(m, gen_v3(2.6 + 0.2 * i, 0.36, depth - 0.06), gen_v3(2.6 + 0.2 * i, 1.8, depth - 0.06), 0.015,
                0.007, 8);
}

/* ---- files ---- */

#define BALL_RADIUS 0.045 /* larger than life, so that each is some pixels wide */

static char *append(char *to, const char *format, double a, double b, double c, int number) {
    return to + sprintf(to, format, number, a, b, c);
}

/* Balls as racked, some of them astray. */
static char *put_balls(char *to) {
    int number = 0;
    for (int row = 0; row < 5; row++)
        for (int i = 0; i <= row; i++, number++) {
            double stray = number % 4 == 3 ? 0.35 : 0.0, x = 4.9 + 0.087 * row - 2.2 * stray,
                   z = 3.4 + 0.1 * (i - 0.5 * row) + stray * (number % 8 == 3 ? 1.0 : -1.0);
            to = append(to,
                        ",\n    {\"file\": \"pool-ball.bpt\", \"material\": \"ball%d\", \"transform\": "
                        "{\"translate\": [%.4f, %.4f, %.4f]}}",
                        x, 0.81 + BALL_RADIUS, z, number);
        }
    return to;
}

static char *put_materials(char *to) {
    static const v3 colors[5] = {
        {0.7, 0.55, 0.06}, {0.08, 0.14, 0.5}, {0.6, 0.07, 0.05}, {0.3, 0.1, 0.36}, {0.65, 0.6, 0.5}};
    for (int i = 0; i < BALLS; i++) {
        const v3 *c = &colors[i % 5];
        to = append(to,
                    i ? ",\n    \"ball%d\": {\"diffuse\": [%.2f, %.2f, %.2f]"
                      : "    \"ball%d\": {\"diffuse\": [%.2f, %.2f, %.2f]",
                    c->x, c->y, c->z, i);
        to += sprintf(to, ", \"specular\": 0.15, \"exponent\": 60}");
    }
    return to;
}

static char *put_lamps(char *to) {
    for (int i = 0; i < LAMPS; i++) {
        const v3 *p = &lamp_at[i];
        double watts = i < 3 ? 26.0 : i < 7 ? 14.0 : 10.0;
        to += sprintf(
            to,
            "%s    {\"type\": \"point\", \"position\": [%.2f, %.2f, %.2f], \"power\": [%.1f, %.1f, %.1f]}",
            i ? ",\n" : "", p->x, p->y - 0.17, p->z, 3.0 * watts, 2.5 * watts, 1.8 * watts);
    }
    return to;
}

static void write_scene(const char *folder, const char *name, const char *keyframes) {
    enum { ROOM = 8192 };
    char *balls = gen_allocate(3 * ROOM), *looks = balls + ROOM, *lamps = looks + ROOM;
    put_balls(balls);
    put_materials(looks);
    put_lamps(lamps);
    gen_write_text(folder, name, ".json",
                   "{\n  \"softlux\": 1,\n  \"meshes\": [\n    {\"file\": \"pool.obj\"}%s\n  ],\n  "
                   "\"materials\": {\n%s\n  },\n  \"lights\": [\n%s\n  ],\n"
                   "  \"camera\": {\"eye\": [6.9, 1.65, 5.6], \"target\": [4.1, 0.85, 2.6], \"fov_deg\": "
                   "58%s},\n  \"film\": {\"width\": 512, \"height\": 512}\n}\n",
                   balls, looks, lamps, keyframes);
    free(balls);
}

void gen_pool(const char *folder) {
    static const v2 half_circle[4] = {{0, -BALL_RADIUS},
                                      {4.0 / 3.0 * BALL_RADIUS, -BALL_RADIUS},
                                      {4.0 / 3.0 * BALL_RADIUS, BALL_RADIUS},
                                      {0, BALL_RADIUS}};
    gen_bicubic ball[2];
    mesh m;
    gen_mesh_init(&m, materials, MATERIALS);
    shell(&m);
    table(&m);
    bar(&m);
    cues(&m);
    for (int i = 0; i < LAMPS; i++) lamp(&m, lamp_at[i]);
    gen_write_mesh(folder, "pool", &m);
    gen_write_bicubic(folder, "pool-ball", ball, gen_revolve(half_circle, 2, ball));
    write_scene(folder, "pool", "");
    write_scene(
        folder, "pool-walk",
        ", \"keyframes\": [\n    {\"time\": 0, \"eye\": [6.9, 1.65, 5.6], \"target\": [4.1, 0.85, 2.6]},\n"
        "    {\"time\": 1, \"eye\": [6.0, 1.55, 5.5], \"target\": [4.2, 0.85, 2.9]},\n    {\"time\": 2, "
        "\"eye\": [4.8, 1.5, 5.2], \"target\": [4.6, 0.85, 3.0]}]");
    gen_mesh_free(&m);
}
