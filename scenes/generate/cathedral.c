/* A gothic church, about 80,000 triangles: a nave of six bays with a ribbed groin vault 17 metres high,
 * aisles, an apse with lancets, a rose window above it, and pews. The windows are its light: panels behind
 * the openings.
 *
 * x is across, the apse lies towards -z, the entrance is at z = 0. */
#include "base/math.h"
#include "mesh.h"

enum { STONE, VAULT, SHAFT, FLOOR_LIGHT, FLOOR_DARK, PEW, ALTAR, GOLD, CARPET, CLEAR, WARM, BLUE, MATERIALS };

static const gen_material materials[MATERIALS] = {
    [STONE] = {"stone", "Kd 0.6 0.55 0.47\n"},
    [VAULT] = {"vault", "Kd 0.68 0.64 0.57\n"},
    [SHAFT] = {"shaft", "Kd 0.5 0.46 0.4\n"},
    [FLOOR_LIGHT] = {"floor_light", "Kd 0.58 0.54 0.48\n"},
    [FLOOR_DARK] = {"floor_dark", "Kd 0.25 0.22 0.2\n"},
    [PEW] = {"pew", "Kd 0.32 0.18 0.09\n"},
    [ALTAR] = {"altar", "Kd 0.72 0.7 0.66\n"},
    [GOLD] = {"gold", "Kd 0.6 0.42 0.14\n"},
    [CARPET] = {"carpet", "Kd 0.45 0.06 0.06\n"},
    [CLEAR] = {"glass_clear", "Kd 0 0 0\nKe 9 9.5 10\n"},
    [WARM] = {"glass_warm", "Kd 0 0 0\nKe 13 8 3.5\n"},
    [BLUE] = {"glass_blue", "Kd 0 0 0\nKe 4 6.5 13\n"},
};

enum { BAYS = 6 };
static const double bay = 4.6, half_nave = 4.4, aisle = 3.8;  /* widths */
static const double pier_impost = 4.6, aisle_rise = 1.9, nave_impost = 11.6, nave_rise = 5.2, wall = 0.9;

/* A compound pier: a closed ring of eight shafts and the steps between them, drawn as one polar outline. */
static void pier(mesh *m, double height, double size) {
    enum { RING = 32, LEVELS = 8 };
    static const double level[LEVELS] = {0.0, 0.35, 0.45, 0.9, 0.93, 0.955, 0.97, 1.0};
    static const double swell[LEVELS] = {1.28, 1.28, 1.0, 1.0, 1.12, 1.0, 1.05, 1.3};
    v3 ring[RING * LEVELS];
    for (int l = 0; l < LEVELS; l++)
        for (int i = 0; i < RING; i++) {
            double angle = 2.0 * SL_PI * i / RING, part = 8.0 * i / RING;
            double off = part - (double)(int)part - 0.5; /* within one shaft, -1/2 .. 1/2 */
            double r = size * swell[l] * (0.78 + 0.34 * (1.0 - 4.0 * off * off));
            double y = l < 3 ? level[l] : height - (1.0 - level[l]) * 6.0;
            ring[l * RING + i] = gen_v3(r * sl_cos(angle), y, -r * sl_sin(angle));
        }
    gen_grid(m, ring, RING, LEVELS, GEN_WRAP_COLUMNS);
    gen_box(m, gen_v3(-1.3 * size, height, -1.3 * size), gen_v3(1.3 * size, height + 0.14, 1.3 * size));
}

/* A half-round shaft on the wall, from y0 to y1, with a small capital; the wall is at z = 0 facing +z. */
static void wall_shaft(mesh *m, double y0, double y1, double r) {
    outline o = {.count = 0};
    gen_to(&o, 0.0, y0);
    gen_to(&o, 1.6 * r, y0 + 0.25);
    gen_sharp(&o, r, y0 + 0.3);
    gen_sharp(&o, r, y1 - 0.5);
    gen_arc(&o, r, y1 - 0.46, 0.3 * r, 0.04, -90.0, 90.0, 2);
    gen_sharp(&o, r, y1 - 0.42);
    gen_to(&o, 1.15 * r, y1 - 0.2);
    gen_to(&o, 1.8 * r, y1 - 0.05);
    gen_sharp(&o, 1.8 * r, y1);
    gen_to(&o, 0.0, y1);
    gen_lathe(m, o.p, o.count, 8);
}

/* A pointed window in a wall that faces +z: the opening with mouldings, a mullion and tracery, and light
 * behind. */
static void lancet(mesh *m, const arch *a, double x0, double x1, double sill, double top, uint32_t glass) {
    gen_paint(m, "windows_wall", STONE);
    gen_arch_wall(m, a, x0, x1, sill, top, wall);
    double w = a->half_width, z = -0.3 * wall, crown = a->spring + a->rise;
    gen_paint(m, "glass", glass);
    gen_quad(m, gen_v3(-w - 0.02, sill - 0.02, z - 0.1), gen_v3(w + 0.02, sill - 0.02, z - 0.1),
             gen_v3(w + 0.02, crown + 0.02, z - 0.1), gen_v3(-w - 0.02, crown + 0.02, z - 0.1));
    gen_paint(m, "tracery", STONE);
    gen_arch_moulding(m, a, 0.0, 0.5 * wall, 0.16, 0.1);
    gen_box(m, gen_v3(-0.05, sill, z - 0.06), gen_v3(0.05, a->spring + 0.3 * a->rise, z + 0.06));
    arch light = {0.5 * w - 0.05, a->spring - 0.25 * a->rise, 0.62 * a->rise, a->pointedness, 4};
    for (int i = 0; i < 2; i++) {
        frame before = gen_move(m, (i ? 0.5 : -0.5) * w, 0, 0);
        gen_arch_moulding(m, &light, -0.06, z, 0.11, 0.07);
        m->frame = before;
    }
    double r = 0.3 * w; /* the oculus */
    v3 circle[12];
    for (int i = 0; i < 12; i++) {
        double angle = 2.0 * SL_PI * i / 12.0;
        circle[i] = gen_v3(r * sl_cos(angle), a->spring + 0.52 * a->rise + r * sl_sin(angle), z);
    }
    outline o = {.count = 0};
    gen_arc(&o, 0.0, 0.0, 0.05, 0.07, 0.0, 180.0, 3);
    gen_sweep(m, circle, 12, gen_v3(0, 0, 1), o.p, o.count, GEN_WRAP_COLUMNS);
    for (int i = 1; i < 3; i++) {
        double y = sill + i * (a->spring - sill) / 3.0;
        gen_box(m, gen_v3(-w, y, z - 0.02), gen_v3(w, y + 0.03, z + 0.02));
    }
}

/* One bay of the nave's side, seen from the nave, in the plane z = 0: arcade, triforium, clereexplanation. */
static void nave_side(mesh *m, int index) {
    const arch arcade = {0.5 * bay - 0.75, pier_impost, 1.6, 0.8, 8};
    const double triforium = 7.6, clereexplanation = 9.8, top = nave_impost + nave_rise + 0.4;
    gen_paint(m, "arcade", STONE);
    gen_arch_wall(m, &arcade, -0.5 * bay, 0.5 * bay, 0.0, triforium, wall);
    gen_arch_moulding(m, &arcade, 0.0, 0.5 * wall, 0.2, 0.12);
    gen_arch_moulding(m, &arcade, 0.3, 0.5 * wall, 0.16, 0.09);

    frame before = gen_move(m, 0, triforium, 0);
    const arch small = {0.5, 0.95, 0.7, 0.9, 4};
    for (int i = 0; i < 3; i++) {
        frame row = gen_move(m, (i - 1) * bay / 3.0, 0, 0);
        gen_paint(m, "triforium", STONE);
        gen_arch_wall(m, &small, -bay / 6.0, bay / 6.0, 0.25, clereexplanation - triforium, wall);
        gen_arch_moulding(m, &small, 0.0, 0.5 * wall, 0.1, 0.06);
        m->frame = row;
    }
    gen_paint(m, "triforium_back", SHAFT);
    gen_quad(m, gen_v3(-0.5 * bay, 0.2, -0.48), gen_v3(0.5 * bay, 0.2, -0.48), gen_v3(0.5 * bay, 2.1, -0.48),
             gen_v3(-0.5 * bay, 2.1, -0.48));
    m->frame = before;
    gen_paint(m, "string_courses", SHAFT);
    const double courses[2] = {triforium, clereexplanation};
    for (int i = 0; i < 2; i++) gen_bevel_box(m, gen_v3(-0.5 * bay, courses[i] - 0.1, 0.4 * wall),
                                              gen_v3(0.5 * bay, courses[i] + 0.06, 0.5 * wall + 0.13), 0.05);

    gen_move(m, 0, clereexplanation, 0);
    const arch window = {1.1, 3.0, 1.9, 0.95, 6};
    lancet(m, &window, -0.5 * bay, 0.5 * bay, 0.7, top - clereexplanation, index % 2 ? CLEAR : WARM);
    m->frame = before;
}

static void nave(mesh *m) {
    for (int b = 0; b < BAYS; b++) {
        double z = -(b + 0.5) * bay;
        frame before = gen_move(m, 0, 0, z);
        gen_paint(m, "nave_vault", VAULT);
        gen_vault(m, half_nave, 0.5 * bay, nave_impost, nave_rise, 0.85, 8);
        gen_paint(m, "nave_ribs", SHAFT);
        gen_vault_ribs(m, half_nave, 0.5 * bay, nave_impost, nave_rise, 0.85, 0.2, 8);
        gen_paint(m, "bosses", GOLD);
        gen_ball(m, gen_v3(0, nave_impost + nave_rise - 0.18, 0), gen_v3(0.35, 0.2, 0.35), 14, 7, 0.12, 71);
        for (int side = 0; side < 2; side++) {
            frame here = m->frame;
            gen_turn(m, side ? 90.0 : -90.0);
            gen_move(m, 0, 0, -half_nave - 0.5 * wall);
            nave_side(m, b);
            m->frame = here;
        }
        m->frame = before;
    }
    for (int p = 0; p <= BAYS; p++)
        for (int side = -1; side <= 1; side += 2) {
            frame before = gen_move(m, side * (half_nave + 0.5 * wall), 0, -p * bay);
            gen_paint(m, "piers", STONE);
            pier(m, pier_impost - 0.14, 0.66);
            m->frame = before;
            gen_paint(m, "vaulting_shafts", SHAFT);
            for (int i = -1; i <= 1; i++) {
                gen_move(m, side * half_nave, 0, -p * bay + 0.24 * i);
                wall_shaft(m, 5.2, nave_impost, i ? 0.1 : 0.15);
                m->frame = before;
            }
        }
}

static void aisles(mesh *m) {
    const arch window = {0.95, 3.9, 1.5, 0.95, 5};
    for (int side = 0; side < 2; side++)
        for (int b = 0; b < BAYS; b++) {
            double s = side ? 1.0 : -1.0, middle = half_nave + wall + 0.5 * aisle;
            frame before = gen_move(m, s * middle, 0, -(b + 0.5) * bay);
            gen_paint(m, "aisle_vault", VAULT);
            gen_vault(m, 0.5 * aisle, 0.5 * bay, pier_impost, aisle_rise, 0.8, 5);
            gen_paint(m, "aisle_ribs", SHAFT);
            gen_vault_ribs(m, 0.5 * aisle, 0.5 * bay, pier_impost, aisle_rise, 0.8, 0.13, 5);
            m->frame = before;
            gen_turn(m, side ? -90.0 : 90.0);
            frame turned = m->frame;
            m->frame.origin = gen_v3(s * (half_nave + wall + aisle + 0.5 * wall), 0, -(b + 0.5) * bay);
            lancet(m, &window, -0.5 * bay, 0.5 * bay, 1.6, pier_impost + aisle_rise + 0.3,
                   b % 2 ? BLUE : CLEAR);
            gen_paint(m, "aisle_shafts", SHAFT);
            gen_move(m, -0.5 * bay, 0, 0.5 * wall);
            wall_shaft(m, 0.0, pier_impost, 0.16);
            m->frame = turned;
            m->frame = before;
        }
}

/* The ends of the aisles, and the entrance wall with its portal. */
static void ends(mesh *m) {
    const double outer = half_nave + wall + aisle, top = nave_impost + nave_rise + 0.4,
                 low = pier_impost + aisle_rise + 0.3;
    gen_paint(m, "end_walls", STONE);
    for (int side = 0; side < 2; side++) {
        double x0 = side ? half_nave : -outer, x1 = side ? outer : -half_nave, z = -BAYS * bay;
        gen_quad(m, gen_v3(x0, 0, z), gen_v3(x1, 0, z), gen_v3(x1, low, z), gen_v3(x0, low, z));
        gen_quad(m, gen_v3(x1, 0, 0), gen_v3(x0, 0, 0), gen_v3(x0, low, 0), gen_v3(x1, low, 0));
    }
    frame before = gen_turn(m, 180.0);
    const arch portal = {1.6, 2.6, 2.0, 0.8, 8};
    gen_move(m, 0, 0, -0.5 * wall);
    gen_arch_wall(m, &portal, -half_nave, half_nave, 0.0, top, wall);
    gen_arch_moulding(m, &portal, 0.0, 0.5 * wall, 0.25, 0.12);
    gen_arch_moulding(m, &portal, 0.35, 0.5 * wall, 0.2, 0.1);
    gen_paint(m, "portal", PEW);
    for (int i = 0; i < 16; i++) {
        double x = -1.6 + 0.2 * i;
        gen_bevel_box(m, gen_v3(x, 0, -0.3), gen_v3(x + 0.2, 4.7, -0.22), 0.015);
    }
    m->frame = before;
}

/* The wall above the apse's arch with the rose window: rings and twelve spokes with little arches, light
 * behind. */
static void rose(mesh *m, double y, double radius) {
    gen_paint(m, "rose_glass", BLUE);
    frame before = gen_move(m, 0, y, -0.2);
    v3 rim[48];
    for (int i = 0; i < 48; i++) {
        double angle = 2.0 * SL_PI * i / 48.0;
        rim[i] = gen_v3(radius * sl_cos(angle), radius * sl_sin(angle), 0.0);
    }
    for (int i = 0; i < 12; i++) {
        gen_paint(m, "rose_glass", i % 2 ? BLUE : WARM);
        for (int k = 0; k < 2; k++) {
            v3 a = gen_scale(rim[4 * i + 2 * k], 0.98), b = gen_scale(rim[(4 * i + 2 * k + 2) % 48], 0.98);
            gen_triangle(m, gen_v3(0, 0, 0), a, b);
        }
    }
    gen_paint(m, "rose_tracery", STONE);
    outline o = {.count = 0};
    gen_arc(&o, 0.0, 0.0, 0.09, 0.16, 0.0, 180.0, 4);
    const double rings[3] = {0.26, 0.64, 0.99};
    for (int r = 0; r < 3; r++) {
        v3 ring[48];
        for (int i = 0; i < 48; i++) ring[i] = gen_scale(rim[i], rings[r]);
        gen_sweep(m, ring, 48, gen_v3(0, 0, 1), o.p, o.count, GEN_WRAP_COLUMNS);
    }
    for (int i = 0; i < 12; i++) {
        v3 from = gen_scale(rim[4 * i], 0.28), to = gen_scale(rim[4 * i], 0.98);
        gen_rod(m, from, to, 0.07, 0.07, 8);
        v3 centre = gen_scale(rim[4 * i + 2], 0.8), small[12];
        for (int k = 0; k < 12; k++) {
            double angle = 2.0 * SL_PI * k / 12.0;
            small[k] = gen_add(centre, gen_scale(gen_v3(sl_cos(angle), sl_sin(angle), 0.0), 0.15 * radius));
        }
        outline thin = {.count = 0};
        gen_arc(&thin, 0.0, 0.0, 0.05, 0.1, 0.0, 180.0, 3);
        gen_sweep(m, small, 12, gen_v3(0, 0, 1), thin.p, thin.count, GEN_WRAP_COLUMNS);
    }
    gen_ball(m, gen_v3(0, 0, 0), gen_v3(0.26 * radius, 0.26 * radius, 0.12), 20, 8, 0, 0);
    m->frame = before;
}

/* A wall facing +z from floor to top whose opening is a circle about (0, y). */
static void round_opening(mesh *m, double x, double low, double top, double y, double r) {
    v3 inner[33], outer[33];
    for (int i = 0; i <= 32; i++) {
        double angle = 2.0 * SL_PI * i / 32.0, c = sl_cos(angle), s = sl_sin(angle);
        double reach = 1e9; /* along the ray to the rectangle */
        if (c > 1e-9) reach = gen_min(reach, x / c);
        if (c < -1e-9) reach = gen_min(reach, -x / c);
        if (s > 1e-9) reach = gen_min(reach, (top - y) / s);
        if (s < -1e-9) reach = gen_min(reach, (low - y) / s);
        inner[i] = gen_v3(r * c, y + r * s, 0.0);
        outer[i] = gen_v3(reach * c, y + reach * s, 0.0);
    }
    for (int i = 0; i < 32; i++) {
        v3 deep = {0, 0, -0.5};
        gen_quad(m, inner[i], outer[i], outer[i + 1], inner[i + 1]);
        gen_quad(m, inner[i], inner[i + 1], gen_add(inner[i + 1], deep), gen_add(inner[i], deep));
    }
    double corner[2] = {-x, x};
    for (int i = 0; i < 2; i++) { /* what the fan leaves out in the corners */
        for (int k = 0; k < 2; k++) {
            v3 c = gen_v3(corner[i], k ? top : low, 0.0);
            for (int j = 0; j < 32; j++) {
                v3 a = outer[j], b = outer[j + 1];
                bool a_side = a.x * corner[i] > 0.0 && (a.y > y) == (k == 1),
                     b_side = b.x * corner[i] > 0.0 && (b.y > y) == (k == 1);
                bool turns = (gen_max(a.x * a.x, b.x * b.x) >= x * x - 1e-9) &&
                             (gen_min(a.x * a.x, b.x * b.x) < x * x - 1e-9);
                if (a_side && b_side && turns) gen_triangle(m, a, c, b);
            }
        }
    }
}

static v3 conch_point(double u, double v, const void *context) {
    const double *c = context; /* radius, springing, rise */
    double angle = SL_PI * (u + 1.0), s = 1.0 - (1.0 - v) * (1.0 - v);
    return gen_v3(c[0] * s * sl_cos(angle), c[1] + c[2] * gen_arch_height(s, 0.8), c[0] * s * sl_sin(angle));
}

static void apse(mesh *m) {
    const double r = 3.6, spring = 6.2, rise = 3.0, top = nave_impost + nave_rise + 0.4;
    frame before = gen_move(m, 0, 0, -BAYS * bay);
    const arch opening = {r, spring, rise, 0.8, 16};
    gen_paint(m, "chancel_arch", STONE);
    frame arch_plane = gen_move(m, 0, 0, -0.5 * wall);
    gen_arch_wall(m, &opening, -half_nave, half_nave, 0.0, 10.2, wall);
    gen_arch_moulding(m, &opening, 0.0, 0.5 * wall, 0.25, 0.14);
    gen_arch_moulding(m, &opening, 0.35, 0.5 * wall, 0.2, 0.1);
    m->frame = arch_plane;
    gen_paint(m, "rose_wall", STONE);
    round_opening(m, half_nave, 10.2, top, 13.4, 2.5);
    rose(m, 13.4, 2.5);
    gen_move(m, 0, 0, -wall);
    gen_paint(m, "conch", VAULT);
    /* wider than the opening: nothing shows between */
    const double conch[3] = {r + 0.05, spring, rise + 0.05};
    gen_surface(m, 30, 10, GEN_FLIP, conch_point, conch);
    const arch window = {0.6, 4.4, 1.1, 0.95, 6};
    for (int i = 0; i < 5; i++) { /* five flat sides of a half decagon */
        frame side = gen_turn(m, 72.0 - 36.0 * i);
        double apothem = r * sl_cos(SL_PI / 10.0), reach = r * sl_sin(SL_PI / 10.0);
        gen_move(m, 0, 0, -apothem - 0.5 * wall);
        lancet(m, &window, -reach, reach, 1.5, spring + 0.25, i % 2 ? BLUE : WARM);
        m->frame = side;
        gen_paint(m, "apse_shafts", SHAFT);
        gen_turn(m, 90.0 - 36.0 * i);
        gen_move(m, 0, 0, -r + 0.02);
        wall_shaft(m, 0.0, spring, 0.14);
        m->frame = side;
        gen_paint(m, "apse_ribs", SHAFT);
        v3 path[13];
        double angle = (90.0 - 36.0 * i - 18.0) * SL_PI / 180.0;
        for (int k = 0; k <= 12; k++) {
            double s = 1.0 - (k / 12.0) * (k / 12.0);
            path[12 - k] = gen_v3(-r * s * sl_sin(angle), spring + rise * gen_arch_height(s, 0.8) - 0.02,
                                  -r * s * sl_cos(angle));
        }
        for (int k = 1; k <= 12; k++) gen_rod(m, path[k - 1], path[k], 0.1, 0.1, 6);
    }
    m->frame = before;
}

static void pews(mesh *m) {
    gen_paint(m, "pews", PEW);
    for (int row = 0; row < 13; row++)
        for (int side = 0; side < 2; side++) {
            frame before = gen_move(m, side ? 2.55 : -2.55, 0.02, -3.2 - 1.25 * row);
            gen_bevel_box(m, gen_v3(-1.45, 0.42, -0.2), gen_v3(1.45, 0.47, 0.22), 0.015);
            gen_bevel_box(m, gen_v3(-1.45, 0.42, 0.2), gen_v3(1.45, 0.95, 0.25), 0.015);
            for (int e = 0; e < 2; e++) {
                double x = e ? 1.4 : -1.48;
                gen_bevel_box(m, gen_v3(x, 0, -0.25), gen_v3(x + 0.08, 0.62, 0.3), 0.02);
                gen_box(m, gen_v3(x, 0.62, 0.12), gen_v3(x + 0.08, 1.02, 0.3));
            }
            gen_box(m, gen_v3(-1.4, 0.12, -0.5), gen_v3(1.4, 0.17, -0.38));
            m->frame = before;
        }
}

static void floors(mesh *m) {
    const double outer = half_nave + wall + aisle, size = 1.2;
    for (int k = 0; k * size < BAYS * bay - 1e-6; k++)
        for (int i = -8; i < 8; i++) {
            double x0 = gen_max(i * size, -outer), x1 = gen_min((i + 1) * size,
                                                                outer), z0 = -k * size, z1 = -(k + 1) * size;
            gen_paint(m, "floor", (i + k) & 1 ? FLOOR_DARK : FLOOR_LIGHT);
            gen_stone(m, gen_v3(x0, -0.004, z0), gen_v3(x1, -0.004, z0), gen_v3(x1, -0.004, z1),
                      gen_v3(x0, -0.004, z1), 0.004);
        }
    double end = -BAYS * bay, edge = outer + 0.5;
    gen_paint(m, "floor", FLOOR_DARK); /* seen in the joints */
    gen_quad(m, gen_v3(-edge, -0.004, 0.5), gen_v3(edge, -0.004, 0.5), gen_v3(edge, -0.004, end),
             gen_v3(-edge, -0.004, end));
    gen_paint(m, "chancel_steps", FLOOR_LIGHT);
    for (int i = 0; i < 3; i++) gen_bevel_box(m, gen_v3(-half_nave, -0.1, end - 5.2),
                                              gen_v3(half_nave, 0.16 * (i + 1), end + 1.6 - 0.4 * i), 0.02);
    gen_paint(m, "carpet", CARPET);
    gen_box(m, gen_v3(-0.75, 0, end + 1.6), gen_v3(0.75, 0.012, -1.0));
    gen_paint(m, "altar", ALTAR);
    frame before = gen_move(m, 0, 0.48, end - 1.2);
    gen_bevel_box(m, gen_v3(-1.1, 0, -0.4), gen_v3(1.1, 0.92, 0.4), 0.02);
    gen_bevel_box(m, gen_v3(-1.25, 0.92, -0.5), gen_v3(1.25, 1.04, 0.5), 0.03);
    gen_paint(m, "candlesticks", GOLD);
    outline o = {.count = 0};
    gen_sharp(&o, 0.1, 0.0);
    gen_to(&o, 0.03, 0.06);
    gen_arc(&o, 0.02, 0.2, 0.03, 0.04, -90.0, 90.0, 4);
    gen_to(&o, 0.02, 0.4);
    gen_sharp(&o, 0.06, 0.45);
    gen_sharp(&o, 0.02, 0.46);
    gen_sharp(&o, 0.02, 0.75);
    gen_to(&o, 0.0, 0.76);
    for (int i = -2; i <= 2; i++) {
        if (i == 0) continue;
        frame top = gen_move(m, 0.45 * i, 1.04, -0.2);
        gen_lathe(m, o.p, o.count, 10);
        m->frame = top;
    }
    gen_box(m, gen_v3(-0.04, 1.04, -0.24), gen_v3(0.04, 2.2, -0.16));
    gen_box(m, gen_v3(-0.32, 1.75, -0.24), gen_v3(0.32, 1.83, -0.16));
    m->frame = before;
}

void gen_cathedral(const char *folder) {
    mesh m;
    gen_mesh_init(&m, materials, MATERIALS);
    floors(&m);
    nave(&m);
    aisles(&m);
    ends(&m);
    apse(&m);
    pews(&m);
    gen_write_scene(folder, "cathedral", &m,
                    "  \"camera\": {\"eye\": [0.9, 2.3, -1.2], \"target\": [-0.3, 6.2, -20], \"up\": [0, 1, "
                    "0], \"fov_deg\": 66}");
    gen_mesh_free(&m);
}
