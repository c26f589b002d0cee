/* A statue of about 860,000 small triangles on a pedestal in a hall of ten thousand, with a lamp: 870,000 in
 * all. */
#include "mesh.h"
#include "statue.h"

enum { MARBLE, STONE, WALL, DARK_TILE, LIGHT_TILE, BRONZE, LAMP, MATERIALS };

static const gen_material materials[MATERIALS] = {
    [MARBLE] = {"marble", "Kd 0.76 0.73 0.68\n"},
    [STONE] = {"stone", "Kd 0.6 0.56 0.5\n"},
    [WALL] = {"wall", "Kd 0.62 0.46 0.36\n"},
    [DARK_TILE] = {"dark_tile", "Kd 0.22 0.2 0.2\n"},
    [LIGHT_TILE] = {"light_tile", "Kd 0.66 0.63 0.58\n"},
    [BRONZE] = {"bronze", "Kd 0.3 0.21 0.11\n"},
    [LAMP] = {"lamp", "Kd 0 0 0\nKe 30 26 20\n"},
};

static const double half = 4.0, tall = 5.4; /* the hall: 8 x 5.4 x 8 */

static void tiles(mesh *m) {
    const int n = 16;
    for (int k = 0; k < n; k++)
        for (int i = 0; i < n; i++) {
            double s = 2.0 * half / n, x = -half + s * i, z = -half + s * k;
            gen_paint(m, "floor", (i + k) % 2 ? DARK_TILE : LIGHT_TILE);
            gen_stone(m, gen_v3(x, -0.003, z + s), gen_v3(x + s, -0.003, z + s), gen_v3(x + s, -0.003, z),
                      gen_v3(x, -0.003, z), 0.003);
        }
}

static void column(mesh *m, double x, double z) {
    frame before = gen_move(m, x, 0, z);
    gen_box(m, gen_v3(-0.32, 0, -0.32), gen_v3(0.32, 0.12, 0.32));
    outline o = {.count = 0};
    gen_arc(&o, 0.25, 0.17, 0.06, 0.05, -90.0, 90.0, 6);
    gen_sharp(&o, 0.24, 0.22);
    gen_arc(&o, 0.21, 0.3, 0.03, 0.03, -60.0, 90.0, 4);
    gen_sharp(&o, 0.2, 0.34);
    gen_to(&o, 0.2, 1.8);
    gen_sharp(&o, 0.165, 4.0);
    gen_arc(&o, 0.165, 4.03, 0.03, 0.03, -90.0, 90.0, 4);
    gen_sharp(&o, 0.17, 4.06);
    gen_arc(&o, 0.17, 4.24, 0.12, 0.14, -90.0, 0.0, 5);
    gen_sharp(&o, 0.29, 4.26);
    gen_lathe(m, o.p, o.count, 28);
    gen_box(m, gen_v3(-0.3, 4.26, -0.3), gen_v3(0.3, 4.38, 0.3));
    m->frame = before;
}

/* One side of the hall, seen towards -z: three bays with arched niches between the columns, and a cornice
 * above. */
static void side(mesh *m) {
    const arch niche = {0.75, 2.3, 0.75, 0.5, 12};
    for (int bay = -1; bay <= 1; bay++) {
        frame before = gen_move(m, bay * half * 2.0 / 3.0, 0, -half);
        gen_paint(m, "walls", WALL);
        gen_arch_wall(m, &niche, -half / 3.0, half / 3.0, 0.7, tall, 0.5);
        gen_quad(m, gen_v3(-1.0, 0.6, -0.2), gen_v3(1.0, 0.6, -0.2), gen_v3(1.0, 3.2, -0.2),
                 gen_v3(-1.0, 3.2, -0.2));
        gen_paint(m, "mouldings", STONE);
        gen_arch_moulding(m, &niche, 0.0, 0.25, 0.14, 0.06);
        m->frame = before;
    }
    gen_paint(m, "columns", STONE);
    for (int i = 0; i < 2; i++) column(m, (i ? 1.0 : -1.0) * half / 3.0, -half + 0.6);
    gen_paint(m, "cornice", STONE);
    outline o = {.count = 0};
    gen_to(&o, 0.0, 4.38);
    gen_sharp(&o, 0.65, 4.38);
    gen_sharp(&o, 0.65, 4.6);
    gen_arc(&o, 0.65, 4.72, 0.1, 0.1, -90.0, 0.0, 5);
    gen_sharp(&o, 0.75, 4.8);
    gen_to(&o, 0.25, 4.8);
    const v3 path[2] = {{-half + 0.25, 0, -half + 0.25}, {half - 0.25, 0, -half + 0.25}};
    gen_sweep(m, path, 2, gen_v3(0, 1, 0), o.p, o.count, GEN_FLAT);
}

static void pedestal(mesh *m) {
    gen_paint(m, "pedestal", STONE);
    gen_bevel_box(m, gen_v3(-0.75, 0, -0.75), gen_v3(0.75, 0.16, 0.75), 0.02);
    gen_bevel_box(m, gen_v3(-0.62, 0.16, -0.62), gen_v3(0.62, 0.3, 0.62), 0.03);
    gen_bevel_box(m, gen_v3(-0.5, 0.3, -0.5), gen_v3(0.5, 0.82, 0.5), 0.01);
    gen_bevel_box(m, gen_v3(-0.6, 0.82, -0.6), gen_v3(0.6, 0.92, 0.6), 0.03);
    gen_paint(m, "plaque", BRONZE);
    gen_stone(m, gen_v3(-0.3, 0.42, 0.5), gen_v3(0.3, 0.42, 0.5), gen_v3(0.3, 0.7, 0.5),
              gen_v3(-0.3, 0.7, 0.5), 0.015);
    gen_paint(m, "plinth", STONE);
    outline o = {.count = 0};
    gen_to(&o, 0.47, 0.92);
    gen_arc(&o, 0.47, 0.96, 0.03, 0.04, -90.0, 90.0, 6);
    gen_sharp(&o, 0.45, 1.0);
    gen_to(&o, 0.0, 1.0);
    gen_lathe(m, o.p, o.count, 48);
}

static void lamp(mesh *m) {
    gen_paint(m, "lamp", LAMP);
    gen_quad(m, gen_v3(-0.6, 5.0, 0.6), gen_v3(0.6, 5.0, 0.6), gen_v3(0.6, 5.0, 1.8), gen_v3(-0.6, 5.0, 1.8));
    gen_paint(m, "lamp_frame", BRONZE);
    gen_box(m, gen_v3(-0.65, 5.02, 0.55), gen_v3(0.65, 5.07, 1.85));
    for (int i = 0; i < 4; i++) {
        double x = i & 1 ? 0.6 : -0.6, z = i & 2 ? 1.8 : 0.6;
        gen_rod(m, gen_v3(x, 5.07, z), gen_v3(x, tall, z), 0.012, 0.012, 8);
    }
}

void gen_figure(const char *folder) {
    mesh m;
    gen_mesh_init(&m, materials, MATERIALS);
    tiles(&m);
    gen_paint(&m, "ceiling", WALL);
    gen_quad(&m, gen_v3(-half, tall, -half), gen_v3(half, tall, -half), gen_v3(half, tall, half),
             gen_v3(-half, tall, half));
    for (int i = 0; i < 4; i++) {
        frame before = gen_turn(&m, 90.0 * i);
        side(&m);
        m.frame = before;
    }
    pedestal(&m);
    lamp(&m);
    gen_paint(&m, "statue", MARBLE);
    frame before = gen_move(&m, 0, 1.0, 0);
    gen_turn(&m, 14.0);
    gen_statue(&m, 0.00372);
    m.frame = before;
    gen_write_scene(folder, "figure", &m,
                    "  \"camera\": {\"eye\": [1.55, 1.75, 3.1], \"target\": [0.0, 1.75, 0.0], \"up\": [0, 1, "
                    "0], \"fov_deg\": 52}");
    gen_mesh_free(&m);
}
