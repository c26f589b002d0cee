/* A cavern, about 40,000 triangles: a winding tunnel that widens to a hall, with dripstone, boulders and a
 * pool. Everything is diffuse; two point lights and a spot light stand in it. Then the same with one point
 * light, the pool a mirror, and a mirror ball over it (after Fig. 9 of Frisvad et al. 2005).
 *
 * The rock is one closed surface around a curve: the radius comes from layered noise of the position itself,
 * so nothing repeats, and shrinks to nothing at both ends. */
#include <math.h>

#include "base/math.h"
#include "mesh.h"

enum { ROCK, DRIPSTONE, BOULDER, WATER, BALL, MATERIALS };

static const gen_material materials[MATERIALS] = {
    [ROCK] = {"rock", "Kd 0.46 0.38 0.3\n"},
    [DRIPSTONE] = {"dripstone", "Kd 0.66 0.58 0.46\n"},
    [BOULDER] = {"boulder", "Kd 0.4 0.35 0.31\n"},
    [WATER] = {"pool", "Kd 0.1 0.2 0.24\n"},
};

static const gen_material mirrors[MATERIALS] = {
    [ROCK] = {"rock", "Kd 0.46 0.38 0.3\n"},
    [DRIPSTONE] = {"dripstone", "Kd 0.66 0.58 0.46\n"},
    [BOULDER] = {"boulder", "Kd 0.4 0.35 0.31\n"},
    [WATER] = {"pool", "Kd 0 0 0\nKs 0.6 0.68 0.7\nillum 3\n"},
    [BALL] = {"ball", "Kd 0 0 0\nKs 0.9 0.9 0.9\nillum 3\n"},
};

static const double length = 42.0;

/* The tunnel's middle at t in [0,1]. */
static v3 middle(double t) {
    return gen_v3(3.2 * sl_sin(5.0 * t), 0.7 * sl_sin(3.0 * t + 0.5), -length * t);
}

static double radius(double t) {
    double closing = sqrt(gen_max(1.0 - (2.0 * t - 1.0) * (2.0 * t - 1.0), 0.0));
    double hall = gen_smoothstep(0.3, 0.5, t) * (1.0 - gen_smoothstep(0.55, 0.8, t));
    return (2.3 + 2.6 * hall) * gen_smoothstep(0.0, 0.45, closing);
}

static double floor_height(v3 p) {
    return middle(-p.z / length).y - 1.3 + 0.22 * gen_fractal(gen_scale(p, 0.7), 4, 91);
}

/* u goes round counter-clockwise seen from the entrance, v along. */
static v3 rock_point(double u, double v, const void *unused) {
    (void)unused;
    double angle = 2.0 * SL_PI * u, r = radius(v);
    v3 c = middle(v), round = gen_v3(sl_cos(angle), sl_sin(angle), 0.0);
    v3 at = gen_add(c, gen_scale(round, 2.0));
    double bulge = 0.28 * gen_fractal(gen_scale(at, 0.35), 2, 41);
    double rough = 0.09 * gen_fractal(gen_scale(at, 1.4), 4, 51);
    double ledge = 0.05 * gen_noise(gen_v3(at.x * 0.2, at.y * 2.2, at.z * 0.2), 61); /* layers of the rock */
    double squash = round.y > 0.0 ? 0.95 : 1.0;
    v3 p = gen_add(
        c, gen_scale(gen_v3(round.x * 1.15, round.y * squash, 0.0), r * (1.0 + bulge + rough + ledge)));
    double ground = floor_height(p), deep = ground - p.y;
    if (deep > -0.3) { /* the floor, blended in over a step of 0.3 */
        double t = gen_smoothstep(-0.3, 0.3, deep) * gen_smoothstep(0.0, 1.5, r);
        p.y = gen_mix(p.y, gen_max(ground, p.y), t);
    }
    return p;
}

/* A cone of dripstone from `root` along y (down where height < 0), with rings and a lean. */
typedef struct drip { v3 root; double height, width; uint32_t seed; } drip;

static v3 drip_point(double u, double v, const void *context) {
    const drip *d = context;
    double angle = 2.0 * SL_PI * u * (d->height > 0.0 ? 1.0 : -1.0), rest = 1.0 - v;
    double r = v >= 1.0
                   ? 0.0
                   : d->width * (0.12 + 0.5 * rest * rest + 0.4 * rest * rest * rest * rest * rest * rest);
    v3 p = gen_v3(r * sl_cos(angle), d->height * v, -r * sl_sin(angle));
    double rings = 1.0 + 0.16 * gen_noise(gen_v3(0, 9.0 * v, 3.0), d->seed) +
                   0.14 * gen_fractal(gen_scale(p, 5.0), 2, d->seed + 1);
    double lean = 0.12 * d->width * v * v;
    return gen_add(d->root, gen_v3(p.x * rings + lean, p.y, p.z * rings));
}

static void dripstones(mesh *m) {
    for (uint32_t i = 0; i < 40; i++) {
        double v = 0.16 + 0.70 * (i + gen_random(71, i, 0)) / 40.0,
               u = 0.25 + 0.17 * (2.0 * gen_random(72, i, 0) - 1.0);
        v3 roof = rock_point(u, v, NULL), ground = gen_v3(roof.x, 0, roof.z);
        ground.y = floor_height(ground);
        double space = roof.y - ground.y, tall = space * (0.2 + 0.35 * gen_random(73, i, 0));
        if (space < 1.5) continue;
        bool column = i % 9 == 4;
        if (column) tall = 0.56 * space;
        double width = 0.16 + 0.14 * tall * (0.5 + gen_random(74, i, 0));
        roof.y += 0.4;
        drip hanging = {roof, -tall - 0.4, width, 100 + i};
        gen_paint(m, "stalactites", DRIPSTONE);
        gen_surface(m, 12, 10, GEN_WRAP_COLUMNS, drip_point, &hanging);
        if (i % 2 && !column) continue;
        double up = column ? 0.56 * space : 0.45 * tall;
        ground.y -= 0.2;
        drip standing = {ground, up + 0.2, 1.5 * width, 200 + i};
        gen_paint(m, "stalagmites", DRIPSTONE);
        gen_surface(m, 12, 10, GEN_WRAP_COLUMNS, drip_point, &standing);
    }
}

static void boulders(mesh *m) {
    gen_paint(m, "boulders", BOULDER);
    for (uint32_t i = 0; i < 18; i++) {
        double v = 0.15 + 0.7 * gen_random(81, i, 0), side = gen_random(82, i, 0) < 0.5 ? -1.0 : 1.0;
        v3 c = middle(v);
        c.x += side * radius(v) * (0.45 + 0.4 * gen_random(83, i, 0));
        double size = 0.18 + 0.4 * gen_random(84, i, 0);
        c.y = floor_height(c) + 0.25 * size;
        gen_ball(m, c, gen_v3(size, 0.75 * size, size * (0.8 + 0.4 * gen_random(85, i, 0))), 14, 8, 0.25,
                 300 + i);
    }
}

static void cavern(mesh *m) {
    gen_paint(m, "rock", ROCK);
    gen_surface(m, 104, 110, GEN_WRAP_COLUMNS, rock_point, NULL);
    dripstones(m);
    boulders(m);
    gen_paint(m, "pool", WATER);
    v3 p = middle(0.52);
    double level = p.y - 1.27;
    gen_panel(m, gen_v3(p.x - 5, level, p.z + 4), gen_v3(p.x + 5, level, p.z + 4),
              gen_v3(p.x + 5, level, p.z - 4), gen_v3(p.x - 5, level, p.z - 4), 8, 8);
}

void gen_cave(const char *folder) {
    mesh m;
    gen_mesh_init(&m, materials, BALL);
    cavern(&m);
    gen_write_scene(
        folder, "cave", &m,
        "  \"lights\": [\n"
        "    {\"type\": \"point\", \"position\": [2.2, 1.7, -15.5], \"intensity\": [60, 48, 32]},\n"
        "    {\"type\": \"point\", \"position\": [0.5, 1.2, -25.5], \"intensity\": [30, 38, 55]},\n"
        "    {\"type\": \"spot\", \"position\": [2.0, 0.9, -5.0], \"direction\": [0.12, -0.12, -1],"
        " \"intensity\": [90, 85, 75], \"inner_deg\": 14, \"outer_deg\": 30}\n  ],\n"
        "  \"camera\": {\"eye\": [2.3, 0.5, -8.5], \"target\": [1.6, 0.4, -20], \"up\": [0, 1, 0], "
        "\"fov_deg\": 62}");
    gen_mesh_free(&m);
}

void gen_mirror_cave(const char *folder) {
    mesh m;
    gen_mesh_init(&m, mirrors, MATERIALS);
    cavern(&m);
    gen_paint(&m, "ball", BALL);
    gen_ball(&m, gen_v3(1.0, 0.9, -20.6), gen_v3(0.9, 0.9, 0.9), 32, 16, 0.0, 0);
    gen_write_scene(
        folder, "mirror-cave", &m,
        "  \"lights\": [\n"
        "    {\"type\": \"point\", \"position\": [3.2, 2.4, -18.5], \"intensity\": [130, 105, 72]}\n  ],\n"
        "  \"camera\": {\"eye\": [2.3, 1.5, -14.6], \"target\": [1.2, -0.3, -22], \"up\": [0, 1, 0], "
        "\"fov_deg\": 62}");
    gen_mesh_free(&m);
}
