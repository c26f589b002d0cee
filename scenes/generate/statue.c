/* A standing robed figure with a globe in the raised hand, made of blended ellipsoids and cones: each is a
 * signed distance, a smooth minimum joins them, and layered noise cuts the folds of the cloth and the hair.
 */
#include "statue.h"

#include <math.h>

static double ellipsoid(v3 p, v3 centre, v3 radii) {
    v3 q = gen_sub(p, centre);
    v3 once = gen_v3(q.x / radii.x, q.y / radii.y, q.z / radii.z);
    v3 twice = gen_v3(once.x / radii.x, once.y / radii.y, once.z / radii.z);
    double k0 = gen_length(once), k1 = gen_length(twice);
    return k1 > 0.0 ? k0 * (k0 - 1.0) / k1 : -gen_min(radii.x, gen_min(radii.y, radii.z));
}

/* A cone with round ends from a (radius ra) to b (radius rb). */
static double limb(v3 p, v3 a, v3 b, double ra, double rb) {
    v3 along = gen_sub(b, a), q = gen_sub(p, a);
    double t = gen_clamp(gen_dot(q, along) / gen_dot(along, along), 0.0, 1.0);
    return gen_length(gen_sub(q, gen_scale(along, t))) - gen_mix(ra, rb, t);
}

static double blend(double a, double b, double width) {
    double h = gen_max(width - fabs(a - b), 0.0) / width;
    return gen_min(a, b) - 0.25 * h * h * width;
}

static double head(v3 p) {
    double d = ellipsoid(p, gen_v3(0, 1.83, 0.03), gen_v3(0.083, 0.115, 0.098));
    d = blend(d, ellipsoid(p, gen_v3(0, 1.775, 0.06), gen_v3(0.055, 0.062, 0.06)), 0.05);           /* jaw */
    /* nose */
    d = blend(d, limb(p, gen_v3(0, 1.845, 0.115), gen_v3(0, 1.802, 0.142), 0.008, 0.015), 0.022);
    /* brow */
    d = blend(d, limb(p, gen_v3(-0.04, 1.857, 0.112), gen_v3(0.04, 1.857, 0.112), 0.009, 0.009), 0.02);
    /* lips */
    d = blend(d, limb(p, gen_v3(-0.02, 1.768, 0.115), gen_v3(0.02, 1.768, 0.115), 0.008, 0.008), 0.012);
    for (int side = -1; side <= 1; side += 2) { /* eyes sit in hollows */
        double hollow = ellipsoid(p, gen_v3(0.034 * side, 1.835, 0.124), gen_v3(0.02, 0.013, 0.014));
        d = -blend(-d, hollow, 0.015);
        d = blend(d, ellipsoid(p, gen_v3(0.034 * side, 1.835, 0.107), gen_v3(0.014, 0.011, 0.012)), 0.004);
    }
    double hair = ellipsoid(p, gen_v3(0, 1.865, -0.005), gen_v3(0.1, 0.105, 0.105));
    hair = blend(hair, limb(p, gen_v3(0, 1.85, -0.07), gen_v3(0, 1.6, -0.11), 0.075, 0.05), 0.06);
    hair += 0.012 * gen_fractal(gen_v3(p.x * 30.0, p.y * 9.0, p.z * 30.0), 2, 401);
    d = blend(d, gen_max(hair, p.z - 0.075), 0.012);
    return blend(d, limb(p, gen_v3(0, 1.73, 0.01), gen_v3(0, 1.58, -0.01), 0.052, 0.062), 0.05);
}

static double arms(v3 p) {
    const v3 right[3] = {{-0.19, 1.5, -0.01}, {-0.3, 1.2, 0.02}, {-0.1, 1.17, 0.24}};
    const v3 left[3] = {{0.19, 1.5, -0.01}, {0.36, 1.33, 0.06}, {0.36, 1.64, 0.2}};
    double d =
        blend(limb(p, right[0], right[1], 0.068, 0.055), limb(p, right[1], right[2], 0.055, 0.034), 0.03);
    d = gen_min(
        d, blend(limb(p, left[0], left[1], 0.068, 0.053), limb(p, left[1], left[2], 0.052, 0.032), 0.03));
    /* the left hand's fingers hold the globe, the right's a book */
    for (int finger = 0; finger < 4; finger++) {
        double f = finger - 1.5;
        d = blend(
            d,
            limb(p, gen_v3(0.36 + 0.018 * f, 1.66, 0.21), gen_v3(0.36 + 0.03 * f, 1.715, 0.262), 0.012, 0.01),
            0.02);
        d = blend(
            d,
            limb(p, gen_v3(-0.1, 1.17 + 0.014 * f, 0.25), gen_v3(-0.03, 1.17 + 0.02 * f, 0.285), 0.011, 0.01),
            0.02);
    }
    d = blend(d, limb(p, gen_v3(-0.28, 1.22, 0.04), gen_v3(-0.3, 0.95, 0.09), 0.075, 0.04),
              0.06);     /* sleeves hang */
    d = blend(d, limb(p, gen_v3(0.34, 1.34, 0.05), gen_v3(0.36, 1.06, 0.03), 0.07, 0.04), 0.06);
    return d;
}

/* Folds run downwards: noise of the direction from the axis, stretched along y, and stronger towards the hem.
 */
static double folds(v3 p, double depth) {
    double r = sqrt(p.x * p.x + p.z * p.z) + 1e-9;
    v3 q = gen_v3(4.2 * p.x / r, 0.9 * p.y, 4.2 * p.z / r);
    return depth * (gen_noise(q, 411) + 0.5 * gen_noise(gen_scale(q, 2.1), 412));
}

static double robe(v3 p) {
    double chest = ellipsoid(p, gen_v3(0, 1.4, 0), gen_v3(0.185, 0.21, 0.125));
    chest = blend(chest, limb(p, gen_v3(-0.15, 1.52, -0.01), gen_v3(0.15, 1.52, -0.01), 0.07, 0.07), 0.08);
    double hips = ellipsoid(p, gen_v3(0, 1.02, 0), gen_v3(0.19, 0.2, 0.15));
    double skirt = limb(p, gen_v3(0, 0.95, 0), gen_v3(0, 0.0, 0.02), 0.18, 0.3);
    skirt = blend(skirt, limb(p, gen_v3(0.09, 0.9, 0.04), gen_v3(0.12, 0.5, 0.19), 0.1, 0.075),
                  0.12); /* the bent knee */
    double cape = limb(p, gen_v3(0, 1.45, -0.1), gen_v3(0, 0.05, -0.24), 0.14, 0.24);
    double d = blend(blend(chest, hips, 0.12), blend(skirt, cape, 0.06), 0.1);
    double belt = fabs(p.y - 1.19 - 0.1 * p.x) - 0.02;
    d -= 0.012 * (1.0 - gen_smoothstep(0.0, 0.012,
                                       belt)); /* a belt stands out, the cloth is gathered above and below */
    return d + folds(p, 0.012 + 0.026 * gen_smoothstep(1.3, 0.2, p.y));
}

double gen_statue_distance(v3 p) {
    double globe = gen_length(gen_sub(p, gen_v3(0.36, 1.79, 0.235))) - 0.082;
    globe = gen_min(globe, limb(p, gen_v3(0.36, 1.87, 0.235), gen_v3(0.36, 1.94, 0.235), 0.013, 0.008));
    v3 page = gen_sub(p, gen_v3(-0.035, 1.19, 0.24));
    double book =
        gen_max(fabs(page.x + 0.25 * page.y) - 0.085, gen_max(fabs(page.y) - 0.115, fabs(page.z) - 0.022));
    double d = robe(p); /* the other parts where they can matter */
    if (p.y > 0.8) d = blend(d, arms(p), 0.05);
    if (p.y > 1.42) d = blend(d, head(p), 0.03);
    d = blend(d, globe, 0.008);
    d = blend(d, book, 0.008);
    d += 0.0012 * gen_noise(gen_scale(p, 55.0), 421);   /* marks of the chisel */
    return gen_max(d, -p.y - 0.001);                   /* the feet are cut level */
}
