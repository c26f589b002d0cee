#include "scene/bicubic.h"

#include <string.h>

#include "scene/derive.h"

/* ---- the surface ----------------------------------------------------------------------------- */

/* Bernstein polynomials of degree 3, their first and second derivatives. */
typedef struct basis {
    double value[4], first[4], second[4];
} basis;

static basis basis_at(double t) {
    double s = 1.0 - t;
    return (basis){{s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t},
                   {-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t},
                   {6.0 * s, 6.0 * (t - 2.0 * s), 6.0 * (s - 2.0 * t), 6.0 * t}};
}

static sl_vec3d combine(const sl_bicubic *b, const double along_u[4], const double along_v[4]) {
    sl_vec3d sum = {0, 0, 0};
    for (int j = 0; j < 4; j++) {
        for (int i = 0; i < 4; i++)
            sum = sl_addd(sum, sl_scaled(sl_to_double(b->point[j][i]), along_u[i] * along_v[j]));
    }
    return sum;
}

/* Returns how far apart control points are along an axis: what lengths are small against. */
static double size_of(const sl_bicubic *b) {
    double size = 0.0;
    for (int k = 1; k < 16; k++) {
        sl_vec3d d = sl_subd(sl_to_double(b->point[k / 4][k % 4]), sl_to_double(b->point[0][0]));
        size = fmax(size, fmax(fabs(d.x), fmax(fabs(d.y), fabs(d.z))));
    }
    return size;
}

static bool normalized(sl_vec3d a, double least, sl_vec3 *unit) {
    double length = sl_lengthd(a);
    if (!(length > least) || !isfinite(length)) return false;
    *unit = sl_to_float(sl_scaled(a, 1.0 / length));
    return true;
}

static double towards_the_middle(double t) { return t < 0.5 ? 1.0 : t > 0.5 ? -1.0 : 0.0; }

/* N = B_u x B_v, and its change N_u d_u + N_v d_v on the way (d_u, d_v) to the middle of the surface: what N
 * is in the limit where it is 0 itself. */
static bool normal_here(const sl_bicubic *b, double u, double v, double size, sl_vec3 *normal) {
    basis p = basis_at(u), q = basis_at(v);
    sl_vec3d bu = combine(b, p.first, q.value), bv = combine(b, p.value, q.first);
    double smallest = 1e-7 * size; /* of a derivative: control points are floats */
    bool singular = !(sl_lengthd(bu) > smallest && sl_lengthd(bv) > smallest);
    if (!singular && normalized(sl_crossd(bu, bv), 1e-6 * sl_lengthd(bu) * sl_lengthd(bv), normal))
        return true;
    sl_vec3d buu = combine(b, p.second, q.value), buv = combine(b, p.first, q.first),
             bvv = combine(b, p.value, q.second);
    sl_vec3d nu = sl_addd(sl_crossd(buu, bv), sl_crossd(bu, buv)),
             nv = sl_addd(sl_crossd(buv, bv), sl_crossd(bu, bvv));
    sl_vec3d change = sl_addd(sl_scaled(nu, towards_the_middle(u)), sl_scaled(nv, towards_the_middle(v)));
    return normalized(change, 1e-6 * size * size, normal);
}

static sl_vec3 normal_at(const sl_bicubic *b, double u, double v) {
    double size = size_of(b);
    sl_vec3 normal = sl_v3(0, 1, 0);
    /* Where the second order vanishes too, steps towards the middle decide. */
    for (double step = 0.0; step < 1.0; step = step == 0.0 ? 1.0 / 1024.0 : 4.0 * step) {
        double x = u + step * (0.5 - u), y = v + step * (0.5 - v);
        if (normal_here(b, x, y, size, &normal)) break;
    }
    return normal;
}

void sl_bicubic_at(const sl_bicubic *b, double u, double v, sl_vec3 *position, sl_vec3 *normal) {
    if (position) {
        basis p = basis_at(u), q = basis_at(v);
        *position = sl_to_float(combine(b, p.value, q.value));
    }
    if (normal) *normal = normal_at(b, u, v);
}

/* ---- its tessellation ------------------------------------------------------------------------ */

void sl_bicubic_tessellate(const sl_bicubic *b, float *positions, float *normals, float *texture_coordinates,
                           uint32_t *triangles) {
    uint32_t n = (uint32_t)b->steps, side = n + 1;
    for (uint32_t k = 0; k < side * side; k++) {
        double u = (double)(k % side) / (double)n, v = (double)(k / side) / (double)n;
        sl_vec3 p, normal;
        sl_bicubic_at(b, u, v, &p, &normal);
        memcpy(positions + 3 * (size_t)k, (float[3]){p.x, p.y, p.z}, 3 * sizeof(float));
        memcpy(normals + 3 * (size_t)k, (float[3]){normal.x, normal.y, normal.z}, 3 * sizeof(float));
        memcpy(texture_coordinates + 2 * (size_t)k, (float[2]){(float)u, (float)v}, 2 * sizeof(float));
    }
    for (uint32_t k = 0; k < n * n; k++) {
        uint32_t at = b->first_vertex + k / n * side + k % n;
        memcpy(triangles + 6 * (size_t)k,
               (uint32_t[6]){at, at + 1, at + side + 1, at, at + side + 1, at + side}, 6 * sizeof(uint32_t));
    }
}

/* As much as one of its triangles that the scene would keep. */
bool sl_bicubic_has_area(const sl_bicubic *b) {
    double n = (double)b->steps;
    for (int k = 0; k < b->steps * b->steps; k++) {
        double u = (double)(k % b->steps), v = (double)(k / b->steps);
        sl_vec3 p[4];
        for (int c = 0; c < 4; c++)
            sl_bicubic_at(b, (u + (c == 1 || c == 2)) / n, (v + (c >= 2)) / n, &p[c], NULL);
        sl_vec3d cross;
        if (sl_triangle_cross(p[0], p[1], p[2], &cross) || sl_triangle_cross(p[0], p[2], p[3], &cross))
            return true;
    }
    return false;
}

/* ---- its triangles --------------------------------------------------------------------------- */

static uint32_t number_in_grid(const sl_bicubic *b, uint32_t column, uint32_t row, uint32_t half) {
    return 2 * (row * (uint32_t)b->steps + column) + half;
}

/* Returns where in the whole grid a triangle of the scene stands. */
static uint32_t number_of(const sl_scene *scene, const sl_bicubic *b, uint32_t triangle) {
    uint32_t side = (uint32_t)b->steps + 1;
    uint32_t at[3], column = side, row = side, half = 1;
    for (int c = 0; c < 3; c++) {
        at[c] = scene->vertex[c][triangle] - b->first_vertex;
        column = at[c] % side < column ? at[c] % side : column;
        row = at[c] / side < row ? at[c] / side : row;
    }
    for (int c = 0; c < 3; c++) {
        if (at[c] == row * side + column + 1) half = 0;
    }
    return number_in_grid(b, column, row, half);
}

/* They stand in order, so the one of a cell is at most as many places early as triangles are missing. */
uint32_t sl_bicubic_triangle(const sl_scene *scene, const sl_bicubic *b, int column, int row, int half) {
    uint32_t wanted = number_in_grid(b, (uint32_t)column, (uint32_t)row, (uint32_t)half);
    if (b->triangle_count == 2u * (uint32_t)b->steps * (uint32_t)b->steps) return b->first_triangle + wanted;
    uint32_t low = 0, high = b->triangle_count < wanted + 1 ? b->triangle_count : wanted + 1;
    while (low < high) { /* the first whose number is not below the wanted one */
        uint32_t middle = low + (high - low) / 2;
        if (number_of(scene, b, b->first_triangle + middle) < wanted) low = middle + 1;
        else high = middle;
    }
    if (low >= b->triangle_count) return SL_NO_INDEX;
    uint32_t found = b->first_triangle + low;
    return number_of(scene, b, found) == wanted ? found : SL_NO_INDEX;
}
