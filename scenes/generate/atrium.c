/* A palace courtyard, about 66,000 triangles: two storeys of arcades around a court of 24 x 11 metres that is
 * open to the sky, with galleries behind them, drapes, vases and a tiled floor; after the Sponza palace. */
#include "base/math.h"
#include "mesh.h"

enum { STONE, WALL, PLASTER, TILE, TILE_DARK, WOOD, RED, GREEN, BLUE, CLAY, ROOF, PLANT, LAMP, MATERIALS };

static const gen_material materials[MATERIALS] = {
    [STONE] = {"stone", "Kd 0.62 0.55 0.45\n"},
    [WALL] = {"wall", "Kd 0.6 0.48 0.36\n"},
    [PLASTER] = {"plaster", "Kd 0.7 0.66 0.58\n"},
    [TILE] = {"tile", "Kd 0.52 0.47 0.4\n"},
    [TILE_DARK] = {"tile_dark", "Kd 0.34 0.28 0.24\n"},
    [WOOD] = {"wood", "Kd 0.3 0.18 0.1\n"},
    [RED] = {"drape_red", "Kd 0.52 0.06 0.05\n"},
    [GREEN] = {"drape_green", "Kd 0.1 0.32 0.12\n"},
    [BLUE] = {"drape_blue", "Kd 0.08 0.16 0.42\n"},
    [CLAY] = {"clay", "Kd 0.5 0.26 0.14\n"},
    [ROOF] = {"roof_tiles", "Kd 0.52 0.22 0.12\n"},
    [PLANT] = {"plant", "Kd 0.12 0.3 0.08\n"},
    [LAMP] = {"lantern", "Kd 0 0 0\nKe 24 17 9\n"},
};

/* The court is |x| <= 12, |z| <= 5.5; the galleries reach 3.2 further. */
static const double half_x = 12.0, half_z = 5.5, gallery = 3.2, wall = 0.5;
static const double storey = 4.6, upper = 4.0; /* heights of the two storeys */

static void column(mesh *m, double shaft, double radius, int segments) {
    gen_box(m, gen_v3(-1.45 * radius, 0, -1.45 * radius), gen_v3(1.45 * radius, 0.14, 1.45 * radius));
    outline o = {.count = 0};
    gen_arc(&o, 1.15 * radius, 0.2, 0.25 * radius, 0.06, -90.0, 90.0, 3);
    gen_sharp(&o, 1.1 * radius, 0.26);
    gen_arc(&o, 1.05 * radius, 0.31, 0.12 * radius, 0.035, -80.0, 90.0, 3);
    gen_sharp(&o, radius, 0.345);
    gen_to(&o, radius, 0.4 * shaft);
    gen_sharp(&o, 0.85 * radius, shaft - 0.45);
    gen_arc(&o, 0.87 * radius, shaft - 0.42, 0.12 * radius, 0.03, -90.0, 90.0, 3);
    gen_sharp(&o, 0.85 * radius, shaft - 0.39);
    gen_arc(&o, 0.85 * radius, shaft - 0.12, 0.45 * radius, 0.26, -90.0, 0.0, 3);
    gen_to(&o, 1.3 * radius, shaft - 0.1);
    gen_lathe(m, o.p, o.count, segments);
    for (int i = 0; i < 8; i++) { /* leaves of the capital */
        frame before = gen_turn(m, 45.0 * i);
        double y = shaft - 0.4, r = 0.86 * radius;
        const v3 leaf[6] = {{r, y, 0.3 * radius},
                            {r, y, -0.3 * radius},
                            {r + 0.14 * radius, y + 0.17, 0.24 * radius},
                            {r + 0.14 * radius, y + 0.17, -0.24 * radius},
                            {r + 0.62 * radius, y + 0.26, 0.06 * radius},
                            {r + 0.62 * radius, y + 0.26, -0.06 * radius}};
        gen_grid(m, leaf, 2, 3, 0);
        m->frame = before;
    }
    gen_bevel_box(m, gen_v3(-1.5 * radius, shaft - 0.1, -1.5 * radius),
                  gen_v3(1.5 * radius, shaft, 1.5 * radius), 0.02);
}

/* A row of bays along x from -half to half, facing +z at z = 0; columns carry it. */
static void arcade(mesh *m, double half, int bays, double floor, bool lower) {
    double bay = 2.0 * half / bays, radius = lower ? 0.3 : 0.2, top = lower ? storey : upper;
    double shaft = lower ? 2.6 : 2.1, open = 0.5 * bay - 0.75 * radius;
    arch a = {open, shaft, gen_min(open, top - shaft - 0.35), 0.5, lower ? 7 : 6};
    frame before = gen_move(m, 0, floor, 0);
    for (int i = 0; i < bays; i++) {
        frame row = gen_move(m, -half + (i + 0.5) * bay, 0, 0);
        gen_paint(m, lower ? "lower_arcade" : "upper_arcade", WALL);
        arch cut = a; /* nothing below the capitals: the wall begins at the springing */
        cut.spring = 0.0;
        frame springing = gen_move(m, 0, shaft, 0);
        gen_arch_wall(m, &cut, -0.5 * bay, 0.5 * bay, 0.0, top - shaft, wall);
        gen_quad(m, gen_v3(-0.5 * bay, 0, -0.5 * wall), gen_v3(-open, 0, -0.5 * wall),
                 gen_v3(-open, 0, 0.5 * wall), gen_v3(-0.5 * bay, 0, 0.5 * wall));
        gen_quad(m, gen_v3(open, 0, -0.5 * wall), gen_v3(0.5 * bay, 0, -0.5 * wall),
                 gen_v3(0.5 * bay, 0, 0.5 * wall), gen_v3(open, 0, 0.5 * wall));
        m->frame = springing;
        gen_paint(m, "archivolts", STONE);
        gen_arch_moulding(m, &a, 0.0, 0.5 * wall, 0.2, 0.06);
        if (!lower) { /* a balustrade between the columns */
            gen_bevel_box(m, gen_v3(-open, 0.85, -0.12), gen_v3(open, 0.97, 0.12), 0.02);
            outline o = {.count = 0};
            gen_sharp(&o, 0.05, 0.0);
            gen_to(&o, 0.035, 0.1);
            gen_arc(&o, 0.035, 0.3, 0.045, 0.2, -70.0, 70.0, 3);
            gen_to(&o, 0.03, 0.62);
            gen_to(&o, 0.055, 0.85);
            const int posts = 3;
            for (int p = 0; p < posts; p++) {
                frame rail = gen_move(m, -open + (p + 0.5) * 2.0 * open / posts, 0, 0);
                gen_lathe(m, o.p, o.count, 6);
                m->frame = rail;
            }
        }
        m->frame = row;
    }
    for (int i = 1; i < bays; i++) {
        frame row = gen_move(m, -half + i * bay, 0, 0);
        gen_paint(m, lower ? "lower_columns" : "upper_columns", STONE);
        column(m, shaft, radius, lower ? 12 : 9);
        m->frame = row;
    }
    gen_paint(m, "string_course", STONE);
    outline o = {.count = 0};
    gen_to(&o, 0.0, top - 0.2);
    gen_arc(&o, 0.0, top - 0.08, 0.14, 0.12, -90.0, 0.0, 4);
    gen_sharp(&o, 0.14, top);
    gen_to(&o, 0.0, top);
    const v3 path[2] = {{-half, 0, 0.5 * wall}, {half, 0, 0.5 * wall}};
    gen_sweep(m, path, 2, gen_v3(0, 1, 0), o.p, o.count, GEN_FLAT);
    m->frame = before;
}

/* The gallery behind a row of bays: back wall with doors, ceiling beams, ceiling, floor of the storey above.
 */
static void gallery_side(mesh *m, double half, int bays, double floor, double top) {
    frame before = gen_move(m, 0, floor, 0);
    double bay = 2.0 * half / bays, back = -gallery, reach = half + gallery;
    const arch door = {0.6, 2.0, 0.6, 0.5, 5};
    for (int i = 0; i < bays; i++) {
        frame row = gen_move(m, -half + (i + 0.5) * bay, 0, back);
        gen_paint(m, "gallery_walls", PLASTER);
        if (i % 2 == 0) {
            gen_arch_wall(m, &door, -0.5 * bay, 0.5 * bay, 0.0, top, 0.3);
            gen_paint(m, "doors", WOOD);
            gen_quad(m, gen_v3(-0.7, 0, -0.1), gen_v3(0.7, 0, -0.1), gen_v3(0.7, 2.7, -0.1),
                     gen_v3(-0.7, 2.7, -0.1));
            for (int p = 0; p < 4; p++) {
                double x = -0.55 + 0.6 * (p % 2), y = 0.2 + 1.1 * (p / 2);
                gen_stone(m, gen_v3(x, y, -0.1), gen_v3(x + 0.5, y, -0.1), gen_v3(x + 0.5, y + 0.9, -0.1),
                          gen_v3(x, y + 0.9, -0.1), 0.03);
            }
            gen_paint(m, "door_mouldings", STONE);
            gen_arch_moulding(m, &door, 0.0, 0.15, 0.12, 0.05);
        } else {
            gen_panel(m, gen_v3(-0.5 * bay, 0, 0.15), gen_v3(0.5 * bay, 0, 0.15),
                      gen_v3(0.5 * bay, top, 0.15), gen_v3(-0.5 * bay, top, 0.15), 2, 3);
        }
        m->frame = row;
        gen_paint(m, "beams", WOOD);
        double x = -half + i * bay;
        gen_box(m, gen_v3(x - 0.1, top - 0.35, back + 0.15), gen_v3(x + 0.1, top - 0.12, -0.5 * wall));
    }
    gen_paint(m, "gallery_walls", PLASTER);
    for (int end = 0; end < 2; end++) { /* the corners, beyond the bays */
        double x0 = end ? half : -reach, x1 = end ? reach : -half;
        gen_panel(m, gen_v3(x0, 0, back + 0.15), gen_v3(x1, 0, back + 0.15), gen_v3(x1, top, back + 0.15),
                  gen_v3(x0, top, back + 0.15), 2, 3);
    }
    gen_paint(m, "gallery_ceiling", PLASTER);
    double y = top - 0.12;
    gen_panel(m, gen_v3(-reach, y, back), gen_v3(reach, y, back), gen_v3(half, y, -0.5 * wall),
              gen_v3(-half, y, -0.5 * wall), 2 * bays, 3);
    gen_paint(m, "gallery_floor", TILE);
    gen_quad(m, gen_v3(-half, top, 0.5 * wall), gen_v3(half, top, 0.5 * wall), gen_v3(half, top, 0),
             gen_v3(-half, top, 0));
    gen_panel(m, gen_v3(-half, top, 0), gen_v3(half, top, 0), gen_v3(reach, top, back - 0.15),
              gen_v3(-reach, top, back - 0.15), 2 * bays, 3);
    m->frame = before;
}

static void roof(mesh *m, double half, int rows) {
    gen_paint(m, "roof", ROOF);
    const double y = storey + upper, low_z = 0.9, high_z = -gallery - 0.3, rise = 1.5;
    for (int i = 0; i < rows; i++) { /* a tile course: half-round tiles that lie side by side */
        double x0 = -half - low_z + (2.0 * (half + low_z)) * i / rows,
               x1 = -half - low_z + 2.0 * (half + low_z) * (i + 1) / rows;
        double spread = (half + gallery) / half;
        v3 grid[2 * 5];
        for (int c = 0; c < 5; c++) {
            double x = gen_mix(x0, x1, c / 4.0), bump = 0.07 * (c == 2 ? 1.0 : c == 1 || c == 3 ? 0.75 : 0.0);
            grid[c] = gen_v3(x * (half - low_z) / (half + low_z), y + 0.05 + bump, low_z);
            grid[5 + c] = gen_v3(x * spread, y + rise + bump, high_z);
        }
        gen_grid(m, grid, 5, 2, 0);
    }
    gen_paint(m, "eaves", WOOD);
    double inner = half - low_z, outer = half;
    gen_quad(m, gen_v3(-outer, y, 0.25), gen_v3(outer, y, 0.25), gen_v3(inner, y + 0.04, low_z),
             gen_v3(-inner, y + 0.04, low_z));
}

/* A drape hangs from a rod in front of the upper gallery: pleats that die out towards the rod. */
static v3 drape_point(double u, double v, const void *context) {
    const double *d = context; /* width, drop */
    double wave = sl_sin(2.0 * SL_PI * 4.0 * u + 1.3 * sl_sin(5.0 * v)), loose = 0.03 + 0.12 * (1.0 - v);
    double sway = 0.08 * (1.0 - v) * (1.0 - v);
    return gen_v3(d[0] * (u - 0.5) * (0.92 + 0.08 * v), -d[1] * (1.0 - v), loose * wave + sway);
}

static void drape(mesh *m, double x, double y, double width, double drop, uint32_t colour) {
    frame before = gen_move(m, x, y, 0.5 * wall + 0.28);
    const double size[2] = {width, drop};
    gen_paint(m, "drapes", colour);
    gen_surface(m, 32, 8, 0, drape_point, size);
    gen_paint(m, "drape_rods", WOOD);
    gen_rod(m, gen_v3(-0.55 * width, 0.02, 0), gen_v3(0.55 * width, 0.02, 0), 0.03, 0.03, 8);
    m->frame = before;
}

static void vase(mesh *m, double x, double z, uint32_t seed) {
    frame before = gen_move(m, x, 0, z);
    gen_paint(m, "vases", CLAY);
    outline o = {.count = 0};
    gen_sharp(&o, 0.25, 0.0);
    gen_sharp(&o, 0.25, 0.08);
    gen_to(&o, 0.14, 0.16);
    gen_arc(&o, 0.16, 0.55, 0.26, 0.36, -75.0, 60.0, 8);
    gen_to(&o, 0.26, 0.95);
    gen_sharp(&o, 0.36, 1.04);
    gen_to(&o, 0.3, 1.02);
    gen_to(&o, 0.22, 0.92);
    gen_to(&o, 0.0, 0.9);
    gen_lathe(m, o.p, o.count, 16);
    gen_paint(m, "plants", PLANT);
    for (uint32_t i = 0; i < 16; i++) {
        frame pot = gen_move(m, 0, 0.9, 0);
        gen_turn(m, 22.5 * i + 20.0 * gen_random(seed, i, 0));
        double l = 0.6 + 0.4 * gen_random(seed, i, 1), lift = 0.5 + 0.6 * gen_random(seed, i, 2);
        v3 leaf[15];
        for (int r = 0; r < 5; r++) {
            double t = r / 4.0, w = 0.32 * l * t * (1.0 - t) + (r == 0 ? 0.01 : 0.0);
            v3 stem = gen_v3(0.0, l * lift * (1.6 * t - 0.9 * t * t), l * t);
            for (int c = 0; c < 3; c++)
                leaf[3 * r + c] = gen_add(stem, gen_v3(-w * (c - 1), c == 1 ? 0.0 : 0.15 * w, 0.0));
        }
        gen_grid(m, leaf, 3, 5, GEN_FLIP);
        m->frame = pot;
    }
    m->frame = before;
}

static void court_floor(mesh *m) {
    const int nx = 24, nz = 11;
    for (int k = 0; k < nz; k++)
        for (int i = 0; i < nx; i++) {
            double sx = 2.0 * half_x / nx, sz = 2.0 * half_z / nz, x = -half_x + sx * i, z = -half_z + sz * k;
            bool border = i < 2 || i >= nx - 2 || k < 2 || k >= nz - 2;
            gen_paint(m, "court_floor", border != ((i + k) % 2 == 0 && !border) ? TILE_DARK : TILE);
            gen_stone(m, gen_v3(x, -0.006, z + sz), gen_v3(x + sx, -0.006, z + sz), gen_v3(x + sx, -0.006, z),
                      gen_v3(x, -0.006, z), 0.006);
        }
    gen_paint(m, "gallery_floor", TILE);
    double rx = half_x + gallery + 0.15, rz = half_z + gallery + 0.15;
    const double x[4] = {-rx, -half_x, half_x, rx}, z[4] = {-rz, -half_z, half_z, rz};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            if (i != 1 || k != 1)
                gen_panel(m, gen_v3(x[i], 0, z[k + 1]), gen_v3(x[i + 1], 0, z[k + 1]),
                          gen_v3(x[i + 1], 0, z[k]), gen_v3(x[i], 0, z[k]), i == 1 ? 16 : 4, k == 1 ? 8 : 4);
}

static void fountain(mesh *m) {
    gen_paint(m, "fountain", STONE);
    outline o = {.count = 0};
    gen_sharp(&o, 1.5, 0.0);
    gen_sharp(&o, 1.5, 0.15);
    gen_sharp(&o, 1.25, 0.15);
    gen_to(&o, 1.2, 0.3);
    gen_arc(&o, 1.22, 0.5, 0.1, 0.1, -60.0, 180.0, 8);
    gen_sharp(&o, 1.1, 0.25);
    gen_sharp(&o, 0.3, 0.25);
    gen_arc(&o, 0.15, 0.6, 0.1, 0.3, -70.0, 70.0, 6);
    gen_to(&o, 0.14, 1.1);
    gen_to(&o, 0.3, 1.25);
    gen_to(&o, 0.62, 1.36);
    gen_sharp(&o, 0.66, 1.42);
    gen_to(&o, 0.58, 1.38);
    gen_to(&o, 0.1, 1.28);
    gen_sharp(&o, 0.08, 1.5);
    gen_arc(&o, 0.0, 1.6, 0.1, 0.12, -50.0, 90.0, 6);
    gen_lathe(m, o.p, o.count, 28);
}

static void lanterns(mesh *m, double half, int bays) {
    for (int i = 1; i < bays; i += 2) {
        frame before = gen_move(m, -half + (i + 0.5) * 2.0 * half / bays, 3.1, -0.5 * gallery);
        gen_paint(m, "lantern_frames", WOOD);
        gen_rod(m, gen_v3(0, 0.3, 0), gen_v3(0, storey - 3.22, 0), 0.012, 0.012, 6);
        gen_box(m, gen_v3(-0.16, 0.26, -0.16), gen_v3(0.16, 0.3, 0.16));
        gen_paint(m, "lanterns", LAMP);
        gen_box(m, gen_v3(-0.12, 0, -0.12), gen_v3(0.12, 0.26, 0.12));
        m->frame = before;
    }
}

void gen_atrium(const char *folder) {
    mesh m;
    gen_mesh_init(&m, materials, MATERIALS);
    court_floor(&m);
    fountain(&m);
    for (int s = 0; s < 4; s++) {
        double half = s % 2 ? half_z : half_x;
        int bays = s % 2 ? 4 : 9;
        frame before = gen_turn(&m, 90.0 * s);
        gen_move(&m, 0, 0, s % 2 ? -half_x : -half_z);
        arcade(&m, half, bays, 0.0, true);
        arcade(&m, half, bays, storey, false);
        gallery_side(&m, half, bays, 0.0, storey);
        gallery_side(&m, half, bays, storey, upper);
        roof(&m, half, s % 2 ? 26 : 58);
        lanterns(&m, half, bays);
        double bay = 2.0 * half / bays;
        for (int i = 1; i < bays; i += s % 2 ? 2 : 3) /* from the upper balustrades into the court */
            drape(&m, -half + (i + 0.5) * bay, storey + 0.9, 1.7, 2.4,
                  RED + (uint32_t)((i / (s % 2 ? 2 : 3) + s) % 3));
        for (int c = 0; c < 2; c++) { /* corner piers */
            double x = c ? half : -half;
            gen_paint(&m, "corner_piers", STONE);
            if (c)
                gen_bevel_box(&m, gen_v3(x - 0.35, 0, -0.35), gen_v3(x + 0.35, storey + upper, 0.35), 0.04);
        }
        m.frame = before;
    }
    for (uint32_t i = 0; i < 6; i++) vase(&m, (i % 3 - 1.0) * 8.0, i < 3 ? -4.4 : 4.4, 500 + i);
    gen_write_scene(folder, "atrium", &m,
                    "  \"lights\": [{\"type\": \"directional\", \"direction\": [-0.42, -1, -0.36], "
                    "\"irradiance\": [14, 12.8, 10.6]}],\n"
                    "  \"environment\": {\"radiance\": [0.55, 0.75, 1.1]},\n"
                    "  \"camera\": {\"eye\": [10.4, 1.9, 1.6], \"target\": [-4, 3.1, -0.6], \"up\": [0, 1, "
                    "0], \"fov_deg\": 68}");
    gen_mesh_free(&m);
}
