/* A bare loft of about 300 quadrilaterals, 6 x 3 x 5 metres. Its one lamp lies in a trough below the ceiling
 * and shines at that alone: nearly all that one sees is lit indirectly. */
#include "mesh.h"

enum { WALL, RED, FLOOR, WOOD, TROUGH, LAMP, MATERIALS };

static const gen_material materials[MATERIALS] = {
    [WALL] = {"wall", "Kd 0.78 0.76 0.7\n"},      [RED] = {"red", "Kd 0.6 0.16 0.1\n"},
    [FLOOR] = {"floor", "Kd 0.5 0.42 0.34\n"},    [WOOD] = {"wood", "Kd 0.55 0.36 0.2\n"},
    [TROUGH] = {"trough", "Kd 0.7 0.7 0.7\n"},    [LAMP] = {"lamp", "Kd 0 0 0\nKe 60 55 46\n"},
};

static void shell(mesh *m) {
    const double w = 6.0, h = 3.0, d = 5.0;
    gen_paint(m, "floor", FLOOR);
    gen_panel(m, gen_v3(0, 0, d), gen_v3(w, 0, d), gen_v3(w, 0, 0), gen_v3(0, 0, 0), 8, 6);
    gen_paint(m, "ceiling", WALL);
    gen_panel(m, gen_v3(0, h, 0), gen_v3(w, h, 0), gen_v3(w, h, d), gen_v3(0, h, d), 4, 3);
    gen_paint(m, "walls", WALL);
    gen_panel(m, gen_v3(0, 0, 0), gen_v3(w, 0, 0), gen_v3(w, h, 0), gen_v3(0, h, 0), 3, 2);
    gen_panel(m, gen_v3(w, 0, d), gen_v3(0, 0, d), gen_v3(0, h, d), gen_v3(w, h, d), 3, 2);
    gen_panel(m, gen_v3(w, 0, 0), gen_v3(w, 0, d), gen_v3(w, h, d), gen_v3(w, h, 0), 3, 2);
    gen_paint(m, "red_wall", RED);
    gen_panel(m, gen_v3(0, 0, d), gen_v3(0, 0, 0), gen_v3(0, h, 0), gen_v3(0, h, d), 3, 2);
}

static void lamp(mesh *m) {
    gen_paint(m, "trough", TROUGH);
    gen_box(m, gen_v3(1.5, 2.35, 0.6), gen_v3(4.5, 2.38, 1.2));
    gen_box(m, gen_v3(1.5, 2.38, 0.6), gen_v3(4.5, 2.6, 0.63));
    gen_box(m, gen_v3(1.5, 2.38, 1.17), gen_v3(4.5, 2.6, 1.2));
    gen_box(m, gen_v3(1.5, 2.38, 0.63), gen_v3(1.53, 2.6, 1.17));
    gen_box(m, gen_v3(4.47, 2.38, 0.63), gen_v3(4.5, 2.6, 1.17));
    gen_paint(m, "lamp", LAMP);
    gen_quad(m, gen_v3(1.6, 2.4, 1.1), gen_v3(4.4, 2.4, 1.1), gen_v3(4.4, 2.4, 0.7), gen_v3(1.6, 2.4, 0.7));
}

/* A top on four legs. */
static void table(mesh *m, double x, double z, v3 half, double degrees) {
    frame before = gen_move(m, x, 0, z);
    gen_turn(m, degrees);
    gen_box(m, gen_v3(-half.x, half.y - 0.05, -half.z), gen_v3(half.x, half.y, half.z));
    for (int i = 0; i < 4; i++) {
        double lx = i & 1 ? half.x - 0.06 : -half.x, lz = i & 2 ? half.z - 0.06 : -half.z;
        gen_box(m, gen_v3(lx, 0, lz), gen_v3(lx + 0.06, half.y - 0.05, lz + 0.06));
    }
    m->frame = before;
}

static void shelf(mesh *m) {
    for (int i = 0; i < 2; i++) gen_box(m, gen_v3(4.0 + 1.4 * i, 0, 0.0), gen_v3(4.05 + 1.4 * i, 1.8, 0.35));
    for (int i = 0; i < 4; i++)
        gen_box(m, gen_v3(4.05, 0.1 + 0.5 * i, 0.0), gen_v3(5.4, 0.13 + 0.5 * i, 0.33));
}

void gen_loft(const char *folder) {
    mesh m;
    gen_mesh_init(&m, materials, MATERIALS);
    shell(&m);
    lamp(&m);
    gen_paint(&m, "table", WOOD);
    table(&m, 2.6, 2.2, gen_v3(0.9, 0.75, 0.5), 12.0);
    gen_paint(&m, "stools", RED);
    table(&m, 1.9, 3.1, gen_v3(0.2, 0.45, 0.2), 30.0);
    table(&m, 3.3, 3.0, gen_v3(0.2, 0.45, 0.2), -20.0);
    gen_paint(&m, "stools", WOOD);
    table(&m, 2.0, 1.35, gen_v3(0.2, 0.45, 0.2), 5.0);
    table(&m, 4.6, 2.4, gen_v3(0.25, 0.4, 0.25), 40.0);
    shelf(&m);
    gen_paint(&m, "boxes", TROUGH);
    gen_box(&m, gen_v3(2.3, 0.75, 2.0), gen_v3(2.6, 0.95, 2.2));
    gen_write_scene(folder, "loft", &m,
                    "  \"camera\": {\"eye\": [5.3, 1.6, 4.8], \"target\": [2.4, 0.9, 1.4], \"fov_deg\": 60}");
    gen_mesh_free(&m);
}
