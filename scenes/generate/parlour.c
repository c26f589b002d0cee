/* A parlour in a house with thick walls, a neighbour and a lawn around it, and thin furniture: a folding
 * screen without thickness, a table of two centimetres, a lamp shade. Three scenes of the same mesh: lit
 * through the window by a portal, by sun and sky alone, and by one small bright bulb. Beside it polished
 * metal that stands alone on a floor. */
#include "mesh.h"

enum { PLASTER, FLOOR, WOOD, PAPER, LACQUER, STONE, LAWN, MATERIALS };

static const gen_material materials[MATERIALS] = {
    [PLASTER] = {"plaster", "Kd 0.75 0.73 0.68\n"},
    [FLOOR] = {"floor", "Kd 0.42 0.3 0.2\n"},
    [WOOD] = {"wood", "Kd 0.5 0.32 0.18\n"},
    [PAPER] = {"paper", "Kd 0.7 0.66 0.55\n"},
    [LACQUER] = {"lacquer", "Kd 0.25 0.08 0.06\nKs 0.4 0.4 0.4\nNs 60\n"},
    [STONE] = {"stone", "Kd 0.45 0.43 0.4\n"},
    [LAWN] = {"lawn", "Kd 0.15 0.3 0.1\n"},
};

static const v3 inner = {4.4, 2.6, 3.6};
static const double thick = 0.25, sill = 0.9, lintel = 2.1, jamb_low = 1.1, jamb_high = 2.5;

/* Six slabs; that at x = 4.4 has the window. */
static void house(mesh *m) {
    v3 low = gen_v3(-thick, -thick, -thick), high = gen_add(inner, gen_v3(thick, thick, thick));
    double x = inner.x;
    gen_paint(m, "floor", FLOOR);
    gen_box(m, low, gen_v3(high.x, 0, high.z));
    gen_paint(m, "ceiling", PLASTER);
    gen_box(m, gen_v3(low.x, inner.y, low.z), high);
    gen_paint(m, "walls", PLASTER);
    gen_box(m, gen_v3(low.x, 0, low.z), gen_v3(0, inner.y, high.z));
    gen_box(m, gen_v3(0, 0, low.z), gen_v3(x, inner.y, 0));
    gen_box(m, gen_v3(0, 0, inner.z), gen_v3(x, inner.y, high.z));
    gen_paint(m, "window_wall", PLASTER);
    gen_box(m, gen_v3(x, 0, low.z), gen_v3(high.x, sill, high.z));
    gen_box(m, gen_v3(x, lintel, low.z), gen_v3(high.x, inner.y, high.z));
    gen_box(m, gen_v3(x, sill, low.z), gen_v3(high.x, lintel, jamb_low));
    gen_box(m, gen_v3(x, sill, jamb_high), gen_v3(high.x, lintel, high.z));
    gen_paint(m, "window_bars", WOOD);
    gen_box(m, gen_v3(x + 0.08, sill, 1.78), gen_v3(x + 0.12, lintel, 1.82));
    gen_box(m, gen_v3(x + 0.08, 1.48, jamb_low), gen_v3(x + 0.12, 1.52, jamb_high));
}

static void outside(mesh *m) {
    gen_paint(m, "lawn", LAWN);
    gen_panel(m, gen_v3(-12, -0.3, 14), gen_v3(18, -0.3, 14), gen_v3(18, -0.3, -12), gen_v3(-12, -0.3, -12),
              6, 5);
    gen_paint(m, "neighbour", STONE);
    gen_box(m, gen_v3(10, -0.3, -4), gen_v3(14, 5, 3));
}

static void screen(mesh *m) {
    gen_paint(m, "screen", PAPER);
    for (int i = 0; i < 3; i++) {
        double x0 = 0.5 + 0.45 * i, z0 = i & 1 ? 1.35 : 1.1, z1 = i & 1 ? 1.1 : 1.35;
        gen_quad(m, gen_v3(x0, 0, z0), gen_v3(x0 + 0.45, 0, z1), gen_v3(x0 + 0.45, 1.7, z1),
                 gen_v3(x0, 1.7, z0));
    }
}

static void table(mesh *m, double x, double z, v3 half, double degrees, double leg) {
    frame before = gen_move(m, x, 0, z);
    gen_turn(m, degrees);
    gen_box(m, gen_v3(-half.x, half.y - 0.02, -half.z), gen_v3(half.x, half.y, half.z));
    for (int i = 0; i < 4; i++) {
        double lx = i & 1 ? half.x - leg : -half.x, lz = i & 2 ? half.z - leg : -half.z;
        gen_box(m, gen_v3(lx, 0, lz), gen_v3(lx + leg, half.y - 0.02, lz + leg));
    }
    m->frame = before;
}

static void furniture(mesh *m) {
    static const v2 shade[] = {{0.2, 0.0}, {0.11, 0.24}};
    screen(m);
    gen_paint(m, "table", WOOD);
    table(m, 2.5, 1.9, gen_v3(0.7, 0.72, 0.4), 8.0, 0.03);
    table(m, 1.5, 2.4, gen_v3(0.2, 0.45, 0.2), 25.0, 0.02);
    gen_paint(m, "shelf", WOOD);
    for (int i = 0; i < 3; i++)
        gen_box(m, gen_v3(2.6, 1.0 + 0.4 * i, 0.0), gen_v3(3.9, 1.015 + 0.4 * i, 0.22));
    gen_paint(m, "boxes", LACQUER);
    gen_box(m, gen_v3(2.2, 0.72, 1.75), gen_v3(2.5, 0.9, 1.95));
    gen_box(m, gen_v3(3.2, 1.015, 0.03), gen_v3(3.5, 1.3, 0.19));
    gen_box(m, gen_v3(0.5, 0.0, 2.6), gen_v3(1.1, 0.5, 3.2));
    gen_paint(m, "shade", PAPER);
    frame before = gen_move(m, 2.9, 1.15, 1.9);
    gen_lathe(m, shade, 2, 24);
    m->frame = before;
    gen_paint(m, "stand", WOOD);
    gen_rod(m, gen_v3(2.9, 0.72, 1.9), gen_v3(2.9, 1.2, 1.9), 0.012, 0.012, 8);
}

static const char *const camera =
    "  \"camera\": {\"eye\": [0.35, 1.55, 3.3], \"target\": [2.9, 0.95, 1.2], \"fov_deg\": 62}";

static void write_parlour(const char *folder, const char *name, const char *light) {
    gen_write_text(folder, name, ".json",
                   "{\n  \"softlux\": 1,\n  \"meshes\": [{\"file\": \"parlour.obj\"}],\n%s,\n%s,\n"
                   "  \"film\": {\"width\": 512, \"height\": 512}\n}\n", light, camera);
}

void gen_parlour(const char *folder) {
    mesh m;
    gen_mesh_init(&m, materials, MATERIALS);
    house(&m);
    outside(&m);
    furniture(&m);
    gen_write_mesh(folder, "parlour", &m);
    write_parlour(folder, "parlour",
                  "  \"lights\": [{\"type\": \"quad\", \"corner\": [4.6, 0.95, 1.15], \"edge1\": [0, 0, 1.3],"
                  " \"edge2\": [0, 1.1, 0], \"radiance\": [9, 9.5, 11]}]");
    write_parlour(folder, "parlour-day",
                  "  \"lights\": [{\"type\": \"directional\", \"direction\": [-0.75, -0.55, -0.2],"
                  " \"irradiance\": [30, 27, 22]}],\n  \"environment\": {\"radiance\": [2.2, 2.8, 4]}");
    write_parlour(
        folder, "parlour-bulb",
        "  \"lights\": [{\"type\": \"quad\", \"corner\": [2.88, 1.3, 1.88], \"edge1\": [0.04, 0, 0],"
        " \"edge2\": [0, 0, 0.04], \"radiance\": [3000, 2700, 2100], \"two_sided\": true}]");
    gen_mesh_free(&m);
}

/* ---- metal ---- */

enum { PLINTH, COPPER, STEEL, METALS };

/* Roughness .25 of glTF's scale is an exponent of 510, roughness .4 one of 76. */
static const gen_material metals[METALS] = {
    [PLINTH] = {"plinth", "Kd 0.5 0.5 0.5\n"},
    [COPPER] = {"copper", "Kd 0 0 0\nKs 0.95 0.64 0.54\nNs 510\n"},
    [STEEL] = {"steel", "Kd 0 0 0\nKs 0.56 0.57 0.58\nNs 76\n"},
};

void gen_metals(const char *folder) {
    mesh m;
    gen_mesh_init(&m, metals, METALS);
    gen_paint(&m, "ground", PLINTH);
    gen_panel(&m, gen_v3(-3, 0, 3), gen_v3(3, 0, 3), gen_v3(3, 0, -3), gen_v3(-3, 0, -3), 3, 3);
    gen_paint(&m, "ball", COPPER);
    gen_ball(&m, gen_v3(-0.6, 0.55, 0), gen_v3(0.5, 0.5, 0.5), 48, 24, 0.0, 1);
    gen_paint(&m, "block", STEEL);
    gen_bevel_box(&m, gen_v3(0.35, 0.0, -0.4), gen_v3(1.05, 0.9, 0.4), 0.04);
    gen_write_scene(folder, "metals", &m,
                    "  \"lights\": [{\"type\": \"quad\", \"corner\": [-0.5, 3, 0.5], \"edge1\": [1, 0, 0],"
                    " \"edge2\": [0, 0, 1], \"radiance\": [20, 19, 17]}],\n"
                    "  \"camera\": {\"eye\": [0.4, 1.5, 4], \"target\": [0.1, 0.4, 0], \"fov_deg\": 40}");
    gen_mesh_free(&m);
}
