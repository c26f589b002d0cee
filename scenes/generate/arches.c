/* Arches, walls with arched openings, groin vaults and their ribs.
 *
 * An arch of half width w is struck from two centres on the springing line, radius R = pointedness * 2 w: the
 * left half about (R - w, 0). Its natural height sqrt(R^2 - (R - w)^2) is scaled to the wanted rise. */
#include "mesh.h"

#include <math.h>
#include <stdlib.h>

#include "base/math.h"

double gen_arch_height(double s, double pointedness) {
    double r = 2.0 * pointedness, c = r - 1.0, x = fabs(s) + c;
    return sqrt(gen_max(r * r - x * x, 0.0) / (r * r - c * c));
}

int gen_arch_points(const arch *a, double widen, v2 *points) {
    double w = a->half_width + widen, rise = a->rise + widen;
    double r = 2.0 * a->pointedness * w, c = r - w, height = sqrt(r * r - c * c);
    double crown = SL_PI - sl_acos(c / r);
    int n = a->steps;
    for (int i = 0; i <= n; i++) {
        double angle = gen_mix(SL_PI, crown, (double)i / n);
        double x = i == n ? 0.0 : i == 0 ? -w : c + r * sl_cos(angle);
        double y = a->spring + (i == 0 ? 0.0 : rise * r * sl_sin(angle) / height);
        points[i] = (v2){x, y};
        points[2 * n - i] = (v2){-x, y};
    }
    return 2 * n + 1;
}

/* A rectangle that faces +z at z = depth, and its counterpart at -depth that faces -z. */
static void two_sided(mesh *m, v2 a, v2 b, v2 c, v2 d, double depth) {
    gen_quad(m, gen_v3(a.x, a.y, depth), gen_v3(b.x, b.y, depth), gen_v3(c.x, c.y, depth),
             gen_v3(d.x, d.y, depth));
    gen_quad(m, gen_v3(b.x, b.y, -depth), gen_v3(a.x, a.y, -depth), gen_v3(d.x, d.y, -depth),
             gen_v3(c.x, c.y, -depth));
}

static void rectangle(mesh *m, double x0, double y0, double x1, double y1, double depth) {
    two_sided(m, (v2){x0, y0}, (v2){x1, y0}, (v2){x1, y1}, (v2){x0, y1}, depth);
}

static void soffit(mesh *m, const v2 *curve, int count, double sill, double depth) {
    v3 *points = gen_allocate((size_t)(count + 2) * 2 * sizeof *points);
    int columns = count + 2;
    for (int i = 0; i < columns; i++) {
        v2 p = i == 0 ? (v2){curve[0].x, sill} : i > count ? (v2){curve[count - 1].x, sill} : curve[i - 1];
        points[i] = gen_v3(p.x, p.y, -depth);
        points[columns + i] = gen_v3(p.x, p.y, depth);
    }
    gen_grid(m, points, columns, 2, 0);
    free(points);
}

enum { ARCH_POINTS = 129 };

void gen_arch_wall(mesh *m, const arch *a, double x0, double x1, double sill, double top, double thickness) {
    v2 curve[ARCH_POINTS];
    int count = gen_arch_points(a, 0.0, curve);
    double w = a->half_width, depth = 0.5 * thickness;
    const double levels[4] = {0.0, sill, a->spring, top};
    for (int i = 0; i < 3; i++) { /* the piers; degenerate where there is none */
        rectangle(m, x0, levels[i], -w, levels[i + 1], depth);
        rectangle(m, w, levels[i], x1, levels[i + 1], depth);
    }
    for (int i = 0; i + 1 < count; i++)
        two_sided(m, curve[i], curve[i + 1], (v2){curve[i + 1].x, top}, (v2){curve[i].x, top}, depth);
    soffit(m, curve, count, sill, depth);
    if (sill > 0.0) {
        rectangle(m, -w, 0.0, w, sill, depth);
        gen_quad(m, gen_v3(-w, sill, depth), gen_v3(w, sill, depth), gen_v3(w, sill, -depth),
                 gen_v3(-w, sill, -depth));
    }
}

void gen_arch_moulding(mesh *m, const arch *a, double widen, double z, double width, double depth) {
    v2 curve[ARCH_POINTS];
    v3 path[ARCH_POINTS];
    int count = gen_arch_points(a, widen, curve);
    for (int i = 0; i < count; i++) path[i] = gen_v3(curve[i].x, curve[i].y, z);
    outline o = {.count = 0};
    gen_arc(&o, -0.5 * width, 0.0, 0.5 * width, depth, 0.0, 180.0, 4);
    gen_sweep(m, path, count, gen_v3(0, 0, 1), o.p, o.count, 0);
    v3 right = gen_unit(gen_cross(gen_sub(path[1], path[0]), gen_v3(0, 0, 1)));
    for (int i = 1; i + 1 < o.count; i++) { /* its ends look down at the imposts; the arch is symmetric */
        v3 left_end[3], right_end[3];
        for (int k = 0; k < 3; k++) {
            v2 p = o.p[k == 0 ? 0 : i + k - 1];
            left_end[k] = gen_add(path[0], gen_v3(right.x * p.x, right.y * p.x, p.y));
            right_end[k] = gen_v3(-left_end[k].x, left_end[k].y, left_end[k].z);
        }
        gen_triangle(m, left_end[0], left_end[1], left_end[2]);
        gen_triangle(m, right_end[0], right_end[2], right_end[1]);
    }
}

/* ---- vaults ---------------------------------------------------------------------------------- */

/* The height of a groin vault is the larger of two barrels' heights, so that each of its four webs bends one
 * way only. Points lie closer towards the imposts, where the arch is steep. */
static double towards_imposts(double u) {
    double rest = 1.0 - fabs(u);
    return copysign(1.0 - rest * rest, u);
}

typedef struct web {
    double a, b, spring, rise, pointedness;
    bool along_z; /* the web beside x = +-a; otherwise beside z = +-b */
    double side;
} web;

static v3 web_point(double u, double v, const void *context) {
    const web *w = context;
    double s = towards_imposts(v), t = s * towards_imposts(2.0 * u - 1.0);
    double y = w->spring + w->rise * gen_arch_height(t, w->pointedness);
    return w->along_z ? gen_v3(w->side * w->a * s, y, w->b * t) : gen_v3(w->a * t, y, w->side * w->b * s);
}

void gen_vault(mesh *m, double a, double b, double spring, double rise, double pointedness, int steps) {
    for (int i = 0; i < 4; i++) {
        web w = {a, b, spring, rise, pointedness, i < 2, i % 2 ? -1.0 : 1.0};
        gen_surface(m, 2 * steps, steps, (i == 0 || i == 3) ? GEN_FLIP : 0, web_point, &w);
    }
}

/* A rib over the ground line from (x0,z0) to (x1,z1), hanging `rib` below the webs. */
static void vault_rib(mesh *m, v2 from, v2 to, double spring, double rise, double pointedness, double rib,
                      int steps) {
    v3 path[ARCH_POINTS];
    int count = 2 * steps + 1;
    for (int i = 0; i < count; i++) {
        double s = towards_imposts((double)i / steps - 1.0), t = 0.5 * (s + 1.0);
        path[i] = gen_v3(gen_mix(from.x, to.x, t), spring + rise * gen_arch_height(s, pointedness),
                         gen_mix(from.y, to.y, t));
    }
    outline o = {.count = 0};
    gen_to(&o, -0.3 * rib, -0.7 * rib);
    gen_sharp(&o, 0.3 * rib, -0.7 * rib);
    gen_arc(&o, 0.4 * rib, 0.0, 0.6 * rib, 0.45 * rib, -90.0, 90.0, 3);
    gen_sharp(&o, 0.3 * rib, 0.7 * rib);
    gen_to(&o, -0.3 * rib, 0.7 * rib);
    gen_sweep(m, path, count, gen_v3(from.y - to.y, 0.0, to.x - from.x), o.p, o.count, 0);
}

void gen_vault_ribs(mesh *m, double a, double b, double spring, double rise, double pointedness, double rib,
                    int steps) {
    vault_rib(m, (v2){-a, -b}, (v2){a, b}, spring, rise, pointedness, rib, steps);
    vault_rib(m, (v2){-a, b}, (v2){a, -b}, spring, rise, pointedness, rib, steps);
    vault_rib(m, (v2){-a, -b}, (v2){a, -b}, spring, rise, pointedness, 1.3 * rib, steps);
    vault_rib(m, (v2){-a, -b}, (v2){-a, b}, spring, rise, pointedness, 0.7 * rib, steps);
    vault_rib(m, (v2){a, b}, (v2){a, -b}, spring, rise, pointedness, 0.7 * rib, steps);
}
