/* A furnished living room, about 7,000 triangles: 5 x 2.7 x 6 metres, lit by a panel in the ceiling. */
#include "mesh.h"

enum {
    WALL,
    CEILING,
    BOARDS,
    WOOD,
    DARK_WOOD,
    WHITE,
    SOFA,
    CUSHION,
    RUG,
    CERAMIC,
    LEAF,
    FRUIT,
    METAL,
    SHADE,
    NIGHT,
    BOOK_RED,
    BOOK_BLUE,
    BOOK_GREEN,
    BOOK_OCHRE,
    CURTAIN,
    LAMP,
    MATERIALS
};

static const gen_material materials[MATERIALS] = {
    [WALL] = {"wall", "Kd 0.74 0.7 0.62\n"},
    [CEILING] = {"ceiling", "Kd 0.82 0.82 0.8\n"},
    [BOARDS] = {"boards", "Kd 0.48 0.31 0.18\n"},
    [WOOD] = {"wood", "Kd 0.55 0.36 0.2\n"},
    [DARK_WOOD] = {"dark_wood", "Kd 0.26 0.15 0.09\n"},
    [WHITE] = {"white", "Kd 0.8 0.8 0.78\n"},
    [SOFA] = {"sofa", "Kd 0.2 0.32 0.38\n"},
    [CUSHION] = {"cushion", "Kd 0.72 0.42 0.16\n"},
    [RUG] = {"rug", "Kd 0.5 0.14 0.12\n"},
    [CERAMIC] = {"ceramic", "Kd 0.62 0.7 0.74\n"},
    [LEAF] = {"leaf", "Kd 0.13 0.32 0.1\n"},
    [FRUIT] = {"fruit", "Kd 0.62 0.14 0.07\n"},
    [METAL] = {"metal", "Kd 0.32 0.3 0.27\n"},
    [SHADE] = {"shade", "Kd 0.75 0.68 0.52\n"},
    [NIGHT] = {"night", "Kd 0.03 0.05 0.12\n"},
    [BOOK_RED] = {"book_red", "Kd 0.46 0.11 0.1\n"},
    [BOOK_BLUE] = {"book_blue", "Kd 0.12 0.2 0.42\n"},
    [BOOK_GREEN] = {"book_green", "Kd 0.15 0.34 0.2\n"},
    [BOOK_OCHRE] = {"book_ochre", "Kd 0.6 0.46 0.2\n"},
    [CURTAIN] = {"curtain", "Kd 0.68 0.6 0.48\n"},
    [LAMP] = {"lamp", "Kd 0 0 0\nKe 16 14.5 12\n"},
};

static const double width = 5.0, height = 2.7, depth = 6.0;

/* A wall in the plane z = 0 facing +z, with a rectangular opening whose reveals go back to z = -deep. */
static void wall_with_opening(mesh *m, double length, v2 low, v2 high, double deep) {
    const double x[4] = {0.0, low.x, high.x, length}, y[4] = {0.0, low.y, high.y, height};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (i != 1 || j != 1)
                gen_quad(m, gen_v3(x[i], y[j], 0), gen_v3(x[i + 1], y[j], 0), gen_v3(x[i + 1], y[j + 1], 0),
                         gen_v3(x[i], y[j + 1], 0));
    const v3 front[4] = {{low.x, low.y, 0}, {high.x, low.y, 0}, {high.x, high.y, 0}, {low.x, high.y, 0}};
    for (int i = 0; i < 4; i++) {
        v3 a = front[i], b = front[(i + 1) % 4], back = {0, 0, -deep};
        gen_quad(m, a, b, gen_add(b, back), gen_add(a, back));
    }
}

static void shell(mesh *m) {
    gen_paint(m, "ceiling", CEILING);
    gen_quad(m, gen_v3(0, height, 0), gen_v3(width, height, 0), gen_v3(width, height, depth),
             gen_v3(0, height, depth));
    gen_paint(m, "walls", WALL);
    gen_quad(m, gen_v3(0, 0, 0), gen_v3(width, 0, 0), gen_v3(width, height, 0), gen_v3(0, height, 0));
    gen_quad(m, gen_v3(width, 0, depth), gen_v3(0, 0, depth), gen_v3(0, height, depth),
             gen_v3(width, height, depth));
    frame before = gen_move(m, 0, 0, depth); /* the left wall with the window */
    gen_turn(m, 90.0);
    wall_with_opening(m, depth, (v2){2.2, 0.85}, (v2){4.0, 2.25}, 0.35);
    m->frame = before;
    gen_move(m, width, 0, 0); /* the right wall with the door */
    gen_turn(m, -90.0);
    wall_with_opening(m, depth, (v2){1.0, 0.0}, (v2){1.95, 2.1}, 0.12);
    m->frame = before;

    gen_paint(m, "cornice", CEILING);
    const v3 corners[4] = {{0, height, 0}, {width, height, 0}, {width, height, depth}, {0, height, depth}};
    /* seen by one who walks round clockwise with the head up: the room is on the right */
    outline cornice = {.count = 0};
    gen_to(&cornice, 0.0, -0.12);
    gen_sharp(&cornice, 0.02, -0.12);
    gen_arc(&cornice, 0.10, -0.10, 0.08, 0.08, 180.0, 90.0, 5);
    gen_sharp(&cornice, 0.12, -0.02);
    gen_to(&cornice, 0.12, 0.0);
    v3 clockwise[4];
    for (int i = 0; i < 4; i++) clockwise[i] = corners[i];
    gen_sweep(m, clockwise, 4, gen_v3(0, 1, 0), cornice.p, cornice.count, GEN_WRAP_COLUMNS | GEN_FLAT);

    gen_paint(m, "skirting", WHITE);
    v3 low[4] = {{width, 0, 1.95}, {width, 0, depth}, {0, 0, depth}, {0, 0, 0}};
    v2 board[4] = {{0.018, 0.0}, {0.018, 0.09}, {0.01, 0.1}, {0.0, 0.1}};
    gen_sweep(m, low, 4, gen_v3(0, 1, 0), board, 4, GEN_FLAT);
    v3 rest[3] = {{0, 0, 0}, {width, 0, 0}, {width, 0, 1.0}};
    gen_sweep(m, rest, 3, gen_v3(0, 1, 0), board, 4, GEN_FLAT);
}

static void floor_boards(mesh *m) {
    gen_paint(m, "floor", DARK_WOOD); /* what is seen in the joints */
    gen_quad(m, gen_v3(0, -0.004, depth), gen_v3(width, -0.004, depth), gen_v3(width, -0.004, 0),
             gen_v3(0, -0.004, 0));
    gen_quad(m, gen_v3(width, -0.004, 1.95), gen_v3(width + 0.12, -0.004, 1.95),
             gen_v3(width + 0.12, -0.004, 1.0), gen_v3(width, -0.004, 1.0)); /* the threshold */
    gen_paint(m, "floor", BOARDS);
    const int rows = 20;
    for (int row = 0; row < rows; row++) {
        double x0 = width * row / rows, x1 = width * (row + 1) / rows;
        double joint = 1.6 + 2.8 * gen_random(11, (uint32_t)row, 0);
        const double z[3] = {0.0, joint, depth};
        for (int i = 0; i < 2; i++)
            gen_stone(m, gen_v3(x0, -0.004, z[i + 1]), gen_v3(x1, -0.004, z[i + 1]), gen_v3(x1, -0.004, z[i]),
                      gen_v3(x0, -0.004, z[i]), 0.004);
    }
}

static void window(mesh *m) {
    frame before = gen_move(m, 0, 0, depth);
    gen_turn(m, 90.0);
    gen_paint(m, "window", NIGHT);
    gen_quad(m, gen_v3(2.2, 0.85, -0.33), gen_v3(4.0, 0.85, -0.33), gen_v3(4.0, 2.25, -0.33),
             gen_v3(2.2, 2.25, -0.33));
    gen_paint(m, "window", WHITE);
    const double bars[4] = {2.2, 2.76, 3.38, 3.94};
    for (int i = 0; i < 4; i++) gen_box(m, gen_v3(bars[i], 0.85, -0.33), gen_v3(bars[i] + 0.06, 2.25, -0.28));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double y = 0.85 + 0.67 * j;
            gen_box(m, gen_v3(bars[i] + 0.06, y, -0.325), gen_v3(bars[i + 1], y + 0.06, -0.285));
        }
    gen_bevel_box(m, gen_v3(2.1, 0.80, -0.33), gen_v3(4.1, 0.845, 0.12), 0.01);
    gen_paint(m, "curtain_rail", METAL);
    gen_rod(m, gen_v3(1.7, 2.42, 0.1), gen_v3(4.5, 2.42, 0.1), 0.015, 0.015, 8);
    gen_ball(m, gen_v3(1.69, 2.42, 0.1), gen_v3(0.03, 0.03, 0.03), 8, 5, 0, 0);
    gen_ball(m, gen_v3(4.51, 2.42, 0.1), gen_v3(0.03, 0.03, 0.03), 8, 5, 0, 0);
    m->frame = before;
}

/* A curtain hangs in pleats that a parabola-shaped wave makes; it is gathered towards the top. */
static v3 curtain_point(double u, double v, const void *context) {
    const double *x = context;
    double phase = u * 7.0, wave = phase - (double)(int)phase;
    double pleat = 4.0 * wave * (1.0 - wave) * ((int)phase % 2 ? 1.0 : -1.0);
    double flare = 0.035 + 0.03 * (1.0 - v);
    return gen_v3(gen_mix(x[0], x[1], u) + 0.02 * pleat * (1.0 - v), gen_mix(0.06, 2.41, v),
                  0.1 + flare * pleat);
}

static void curtains(mesh *m) {
    frame before = gen_move(m, 0, 0, depth);
    gen_turn(m, 90.0);
    gen_paint(m, "curtains", CURTAIN);
    gen_surface(m, 28, 3, 0, curtain_point, (const double[2]){1.75, 2.3});
    gen_surface(m, 28, 3, 0, curtain_point, (const double[2]){3.9, 4.45});
    m->frame = before;
}

static void door(mesh *m) {
    frame before = gen_move(m, width, 0, 0);
    gen_turn(m, -90.0);
    gen_paint(m, "door", WHITE);
    gen_quad(m, gen_v3(1.0, 0, -0.1), gen_v3(1.95, 0, -0.1), gen_v3(1.95, 2.1, -0.1), gen_v3(1.0, 2.1, -0.1));
    for (int i = 0; i < 2; i++) {
        double x = 1.1 + 0.4 * i;
        gen_stone(m, gen_v3(x, 0.2, -0.1), gen_v3(x + 0.34, 0.2, -0.1), gen_v3(x + 0.34, 0.9, -0.1),
                  gen_v3(x, 0.9, -0.1), 0.02);
        gen_stone(m, gen_v3(x, 1.1, -0.1), gen_v3(x + 0.34, 1.1, -0.1), gen_v3(x + 0.34, 1.95, -0.1),
                  gen_v3(x, 1.95, -0.1), 0.02);
    }
    gen_box(m, gen_v3(0.9, 0, 0), gen_v3(1.0, 2.2, 0.025));
    gen_box(m, gen_v3(1.95, 0, 0), gen_v3(2.05, 2.2, 0.025));
    gen_box(m, gen_v3(1.0, 2.1, 0), gen_v3(1.95, 2.2, 0.025));
    gen_paint(m, "door_knob", METAL);
    gen_rod(m, gen_v3(1.06, 1.02, -0.1), gen_v3(1.06, 1.02, -0.06), 0.012, 0.012, 8);
    gen_ball(m, gen_v3(1.06, 1.02, -0.045), gen_v3(0.03, 0.03, 0.025), 10, 6, 0, 0);
    m->frame = before;
}

static void turned_leg(mesh *m, double x, double z, double top) {
    frame before = gen_move(m, x, 0, z);
    outline o = {.count = 0};
    gen_to(&o, 0.0, 0.0);
    gen_sharp(&o, 0.018, 0.0);
    gen_to(&o, 0.024, 0.25 * top);
    gen_to(&o, 0.036, 0.55 * top);
    gen_sharp(&o, 0.026, 0.68 * top);
    gen_arc(&o, 0.026, 0.71 * top, 0.014, 0.02, -90.0, 90.0, 3);
    gen_sharp(&o, 0.026, 0.75 * top);
    gen_to(&o, 0.036, top);
    gen_lathe(m, o.p, o.count, 8);
    m->frame = before;
}

static void table(mesh *m) {
    frame before = gen_move(m, 3.1, 0, 2.3);
    gen_paint(m, "table", WOOD);
    gen_bevel_box(m, gen_v3(-0.8, 0.72, -0.45), gen_v3(0.8, 0.755, 0.45), 0.008);
    gen_box(m, gen_v3(-0.7, 0.62, -0.37), gen_v3(0.7, 0.72, -0.345));
    gen_box(m, gen_v3(-0.7, 0.62, 0.345), gen_v3(0.7, 0.72, 0.37));
    gen_box(m, gen_v3(-0.72, 0.62, -0.345), gen_v3(-0.695, 0.72, 0.345));
    gen_box(m, gen_v3(0.695, 0.62, -0.345), gen_v3(0.72, 0.72, 0.345));
    for (int i = 0; i < 4; i++) turned_leg(m, i & 1 ? 0.7 : -0.7, i & 2 ? 0.355 : -0.355, 0.72);
    m->frame = before;
}

static void ware(mesh *m) {
    frame before = gen_move(m, 3.1, 0, 2.3);
    gen_paint(m, "bowl", CERAMIC);
    gen_move(m, 0.2, 0.755, 0.02);
    outline bowl = {.count = 0};
    gen_sharp(&bowl, 0.06, 0.0);
    gen_arc(&bowl, 0.05, 0.1, 0.11, 0.09, -60.0, 0.0, 4);
    gen_arc(&bowl, 0.05, 0.1, 0.098, 0.082, 0.0, -90.0, 4);
    gen_to(&bowl, 0.0, 0.018);
    gen_lathe(m, bowl.p, bowl.count, 14);
    gen_paint(m, "fruit", FRUIT);
    for (uint32_t i = 0; i < 4; i++) {
        double x = i == 3 ? 0.0 : i == 0 ? 0.055 : -0.03, z = i == 1 ? 0.05 : i == 2 ? -0.05 : 0.0;
        gen_ball(m, gen_v3(x, i == 3 ? 0.12 : 0.07, z), gen_v3(0.042, 0.038, 0.042), 8, 5, 0.05, i);
    }
    m->frame = before;
    gen_move(m, 2.75, 0.755, 2.15);
    gen_paint(m, "vase", CERAMIC);
    outline vase = {.count = 0};
    gen_sharp(&vase, 0.05, 0.0);
    gen_arc(&vase, 0.045, 0.1, 0.045, 0.1, -70.0, 60.0, 6);
    gen_to(&vase, 0.03, 0.22);
    gen_sharp(&vase, 0.045, 0.27);
    gen_to(&vase, 0.035, 0.265);
    gen_to(&vase, 0.02, 0.2);
    gen_to(&vase, 0.0, 0.19);
    gen_lathe(m, vase.p, vase.count, 14);
    m->frame = before;
}

/* The seat's front is towards +z. */
static void chair(mesh *m, double x, double z, double degrees) {
    frame before = gen_move(m, x, 0, z);
    gen_turn(m, degrees);
    gen_bevel_box(m, gen_v3(-0.22, 0.43, -0.21), gen_v3(0.22, 0.465, 0.22), 0.012);
    for (int i = 0; i < 2; i++) {
        double s = i ? 1.0 : -1.0;
        gen_rod(m, gen_v3(0.20 * s, 0, 0.2), gen_v3(0.18 * s, 0.43, 0.18), 0.014, 0.02, 5);
        gen_rod(m, gen_v3(0.20 * s, 0, -0.22), gen_v3(0.18 * s, 0.43, -0.18), 0.014, 0.02, 5);
        gen_rod(m, gen_v3(0.18 * s, 0.46, -0.18), gen_v3(0.2 * s, 0.95, -0.27), 0.018, 0.014, 5);
    }
    gen_bevel_box(m, gen_v3(-0.23, 0.86, -0.275), gen_v3(0.23, 0.96, -0.25), 0.008);
    for (int i = 0; i < 4; i++) {
        double at = -0.12 + 0.08 * i;
        gen_rod(m, gen_v3(at, 0.46, -0.185), gen_v3(at, 0.88, -0.262), 0.009, 0.009, 4);
    }
    m->frame = before;
}

static void sofa(mesh *m) {
    frame before = gen_move(m, 0.75, 0, 2.9); /* along the left wall, facing +x */
    gen_turn(m, 90.0);
    gen_paint(m, "sofa", SOFA);
    gen_bevel_box(m, gen_v3(-1.05, 0.1, -0.42), gen_v3(1.05, 0.3, 0.42), 0.03);
    gen_bevel_box(m, gen_v3(-1.05, 0.3, -0.42), gen_v3(1.05, 0.8, -0.22), 0.06);
    gen_bevel_box(m, gen_v3(-1.2, 0.1, -0.42), gen_v3(-1.0, 0.6, 0.43), 0.06);
    gen_bevel_box(m, gen_v3(1.0, 0.1, -0.42), gen_v3(1.2, 0.6, 0.43), 0.06);
    for (int i = 0; i < 3; i++) {
        double x = -1.0 + 2.0 * i / 3.0;
        gen_bevel_box(m, gen_v3(x + 0.005, 0.3, -0.22), gen_v3(x + 0.66, 0.46, 0.44), 0.045);
        gen_bevel_box(m, gen_v3(x + 0.01, 0.46, -0.24), gen_v3(x + 0.655, 0.86, -0.06), 0.06);
    }
    gen_paint(m, "sofa_feet", DARK_WOOD);
    for (int i = 0; i < 4; i++) {
        double x = i & 1 ? 1.05 : -1.1, z = i & 2 ? 0.32 : -0.38;
        gen_box(m, gen_v3(x, 0, z), gen_v3(x + 0.05, 0.1, z + 0.05));
    }
    gen_paint(m, "pillows", CUSHION);
    for (int i = 0; i < 2; i++) {
        frame seat = gen_move(m, i ? 0.78 : -0.75, 0.64, 0.02);
        gen_tilt(m, -20.0);
        gen_ball(m, gen_v3(0, 0, 0), gen_v3(0.22, 0.2, 0.08), 12, 6, 0.04, (uint32_t)(7 + i));
        m->frame = seat;
    }
    m->frame = before;
}

static void shelves(mesh *m) {
    frame before = gen_move(m, 1.9, 0, 0.02); /* on the back wall */
    gen_paint(m, "shelves", DARK_WOOD);
    const double w = 1.8, tall = 2.1, deep = 0.3, board = 0.025;
    gen_box(m, gen_v3(-w / 2 - board, 0, 0), gen_v3(-w / 2, tall, deep));
    gen_box(m, gen_v3(w / 2, 0, 0), gen_v3(w / 2 + board, tall, deep));
    for (int level = 0; level < 6; level++) {
        double y = 0.06 + level * (tall - 0.06 - board) / 5.0;
        gen_box(m, gen_v3(-w / 2, y, 0), gen_v3(w / 2, y + board, deep));
    }
    for (int level = 0; level < 5; level++) {
        double y = 0.06 + board + level * (tall - 0.06 - board) / 5.0, x = -w / 2 + 0.02,
               stop = w / 2 - 0.2 * (1 + level % 3);
        for (uint32_t book = 0; x < stop; book++) {
            uint32_t row = (uint32_t)level;
            double thick = 0.03 + 0.04 * gen_random(21, row, book),
                   high = 0.22 + 0.11 * gen_random(22, row, book);
            double back = 0.03 + 0.06 * gen_random(23, row, book);
            gen_paint(m, "books", BOOK_RED + (uint32_t)(4.0 * gen_random(24, row, book)));
            gen_box(m, gen_v3(x, y, 0.02), gen_v3(x + thick - 0.002, y + high, deep - back));
            x += thick + (gen_random(25, row, book) > 0.93 ? 0.12 : 0.0);
        }
    }
    m->frame = before;
}

static void picture(mesh *m, double x, double y, double w, double h, uint32_t canvas) {
    frame before = gen_move(m, x, y, 0);
    const v3 corners[4] = {{-w / 2, -h / 2, 0}, {-w / 2, h / 2, 0}, {w / 2, h / 2, 0}, {w / 2, -h / 2, 0}};
    outline o = {.count = 0}; /* walked clockwise, head towards the room: right is inwards */
    gen_sharp(&o, 0.0, 0.012);
    gen_sharp(&o, 0.0, 0.022);
    gen_to(&o, -0.03, 0.035);
    gen_sharp(&o, -0.05, 0.025);
    gen_to(&o, -0.05, 0.0);
    gen_paint(m, "picture_frames", DARK_WOOD);
    gen_sweep(m, corners, 4, gen_v3(0, 0, 1), o.p, o.count, GEN_WRAP_COLUMNS | GEN_FLAT);
    gen_paint(m, "pictures", canvas);
    gen_quad(m, gen_v3(-w / 2, -h / 2, 0.012), gen_v3(w / 2, -h / 2, 0.012), gen_v3(w / 2, h / 2, 0.012),
             gen_v3(-w / 2, h / 2, 0.012));
    m->frame = before;
}

static void floor_lamp(mesh *m) {
    frame before = gen_move(m, 0.5, 0, 0.95);
    gen_paint(m, "floor_lamp", METAL);
    outline o = {.count = 0};
    gen_to(&o, 0.0, 0.0);
    gen_sharp(&o, 0.15, 0.0);
    gen_sharp(&o, 0.15, 0.02);
    gen_to(&o, 0.03, 0.04);
    gen_to(&o, 0.012, 0.08);
    gen_to(&o, 0.012, 1.5);
    gen_to(&o, 0.0, 1.5);
    gen_lathe(m, o.p, o.count, 14);
    gen_paint(m, "lamp_shade", SHADE);
    v2 shade[] = {{0.24, 1.38},  {0.14, 1.72},  {0.14, 1.72},  {0.135, 1.72},
                  {0.135, 1.72}, {0.235, 1.38}, {0.235, 1.38}, {0.24, 1.38}};
    gen_lathe(m, shade, 8, 18);
    m->frame = before;
}

/* A leaf bends over: u along it, v across. */
static v3 leaf_point(double u, double v, const void *context) {
    const double *length = context;
    double across = (v - 0.5) * 0.16 * u * (1.0 - u) * 4.0 * *length;
    double fold = 0.3 * (v - 0.5) * (v - 0.5);
    return gen_v3(across, *length * (0.95 * u - 0.45 * u * u) + fold, *length * (0.25 * u + 0.55 * u * u));
}

static void plant(mesh *m) {
    frame before = gen_move(m, 0.45, 0, 0.45);
    gen_move(m, 0, 0, 4.9);
    gen_paint(m, "pot", CERAMIC);
    outline o = {.count = 0};
    gen_sharp(&o, 0.12, 0.0);
    gen_sharp(&o, 0.17, 0.3);
    gen_sharp(&o, 0.15, 0.3);
    gen_to(&o, 0.14, 0.27);
    gen_to(&o, 0.0, 0.27);
    gen_lathe(m, o.p, o.count, 14);
    gen_paint(m, "leaves", LEAF);
    gen_move(m, 0, 0.27, 0);
    for (uint32_t i = 0; i < 12; i++) {
        frame pot = m->frame;
        double length = 0.6 + 0.45 * gen_random(31, i, 0);
        gen_turn(m, 360.0 * (i + 0.7 * gen_random(32, i, 0)) / 12.0);
        gen_surface(m, 6, 2, 0, leaf_point, &length);
        m->frame = pot;
    }
    m->frame = before;
}

void gen_room_walls(mesh *m) {
    gen_mesh_init(m, materials, MATERIALS);
    shell(m);
    floor_boards(m);
    window(m);
    curtains(m);
    door(m);
}

void gen_room_table(mesh *m) {
    gen_paint(m, "rug", RUG);
    gen_bevel_box(m, gen_v3(1.35, 0, 1.5), gen_v3(4.4, 0.012, 3.9), 0.006);
    table(m);
}

void gen_room_chair(mesh *m, double x, double z, double degrees) {
    gen_paint(m, "chairs", WOOD);
    chair(m, x, z, degrees);
}

void gen_room_sides(mesh *m) {
    sofa(m);
    shelves(m);
    picture(m, 3.45, 1.55, 0.5, 0.65, BOOK_OCHRE);
    picture(m, 4.2, 1.5, 0.45, 0.45, BOOK_BLUE);
    picture(m, 4.2, 2.05, 0.45, 0.3, RUG);
}

void gen_room(const char *folder) {
    mesh m;
    gen_room_walls(&m);
    gen_paint(&m, "ceiling_light", LAMP);
    gen_quad(&m, gen_v3(2.0, 2.66, 2.3), gen_v3(3.0, 2.66, 2.3), gen_v3(3.0, 2.66, 3.3),
             gen_v3(2.0, 2.66, 3.3));
    gen_paint(&m, "ceiling_light_frame", WHITE);
    const v3 ring[4] = {{2.0, 2.66, 2.3}, {3.0, 2.66, 2.3}, {3.0, 2.66, 3.3}, {2.0, 2.66, 3.3}};
    const v2 rim[4] = {{-0.03, 0.04}, {-0.03, -0.01}, {0, -0.01}, {0, 0}};
    gen_sweep(&m, ring, 4, gen_v3(0, 1, 0), rim, 4, GEN_WRAP_COLUMNS | GEN_FLAT);
    gen_room_table(&m);
    ware(&m);
    gen_paint(&m, "chairs", WOOD);
    chair(&m, 2.75, 3.05, 176.0);
    chair(&m, 3.5, 3.1, -168.0);
    chair(&m, 2.7, 1.6, 4.0);
    chair(&m, 3.55, 1.55, -7.0);
    gen_room_sides(&m);
    floor_lamp(&m);
    plant(&m);
    gen_write_scene(folder, "room", &m,
                    "  \"camera\": {\"eye\": [4.55, 1.65, 5.7], \"target\": [2.0, 0.95, 1.6], \"up\": [0, 1, "
                    "0], \"fov_deg\": 58}");
    gen_mesh_free(&m);
}
