/* The statue's surface by surface nets: a cell of the grid whose corners have different signs gets one
 * vertex, and each grid edge that changes sign gets the quadrilateral of the four cells around it. The grid
 * is walked layer by layer upwards, so that two layers are all that is kept; blocks of cells far from the
 * surface are passed over. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "statue.h"

enum { BLOCK = 8 };
static const v3 low = {-0.6, -0.02, -0.56};
static const v3 extent = {1.2, 2.1, 1.12};

typedef struct net {
    mesh *m;
    double cell;
    int nx, ny, nz;              /* cells */
    int bx, bz;                  /* blocks */
    double *block;               /* of the present slab: distance where far from the surface, 0 where near */
    double *value[2];            /* distances at the grid points of the lower and the upper layer */
    gen_corner *vertex[2];       /* vertices of the cells of the layer below and of the present one */
} net;

static v3 grid_point(const net *n, double i, double j, double k) {
    return gen_add(low, gen_scale(gen_v3(i, j, k), n->cell));
}

static void find_near_blocks(net *n, int slab) {
    double reach = 0.5 * BLOCK * n->cell * 1.7320508 * 1.6 + 0.01;
    for (int k = 0; k < n->bz; k++)
        for (int i = 0; i < n->bx; i++) {
            v3 centre = grid_point(n, (i + 0.5) * BLOCK, (slab + 0.5) * BLOCK, (k + 0.5) * BLOCK);
            double d = gen_statue_distance(centre);
            n->block[k * n->bx + i] = fabs(d) > reach ? d : 0.0;
        }
}

/* A grid point on a block's border takes the block below it; far blocks never touch the surface, so their
 * sign is enough. */
static void evaluate_layer(net *n, int j, double *value) {
    for (int k = 0; k <= n->nz; k++)
        for (int i = 0; i <= n->nx; i++) {
            int b = (k < n->nz ? k : n->nz - 1) / BLOCK * n->bx + (i < n->nx ? i : n->nx - 1) / BLOCK;
            double far = n->block[b];
            value[k * (n->nx + 1) + i] = far != 0.0 ? far : gen_statue_distance(grid_point(n, i, j, k));
        }
}

/* The gradient from four samples at the corners of a tetrahedron. */
static v3 gradient(v3 p, double step) {
    static const v3 corner[4] = {{1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}, {1, 1, 1}};
    v3 sum = {0, 0, 0};
    for (int i = 0; i < 4; i++)
        sum = gen_add(sum, gen_scale(corner[i], gen_statue_distance(gen_add(p, gen_scale(corner[i], step)))));
    return gen_scale(sum, 0.25 / step);
}

/* The mean of where the cell's edges cross the surface, then one Newton step towards it. */
static void place_vertex(net *n, int i, int j, int k, const double corner[8], gen_corner *vertex) {
    v3 sum = {0, 0, 0};
    int crossings = 0;
    for (int a = 0; a < 8; a++)
        for (int axis = 0; axis < 3; axis++) {
            int b = a | 1 << axis;
            if (b == a || (corner[a] < 0.0) == (corner[b] < 0.0)) continue;
            double t = corner[a] / (corner[a] - corner[b]);
            v3 p = gen_v3(a & 1, a >> 1 & 1, a >> 2 & 1);
            if (axis == 0) p.x = t;
            if (axis == 1) p.y = t;
            if (axis == 2) p.z = t;
            sum = gen_add(sum, p);
            crossings++;
        }
    sum = gen_scale(sum, 1.0 / crossings);
    v3 p = grid_point(n, i + sum.x, j + sum.y, k + sum.z), g = gradient(p, 0.4 * n->cell);
    double length_squared = gen_dot(g, g), limit = 0.4 * n->cell;
    if (length_squared > 0.05) {
        v3 step = gen_scale(g, -gen_statue_distance(p) / length_squared);
        double length = gen_length(step);
        p = gen_add(p, length > limit ? gen_scale(step, limit / length) : step);
    }
    vertex->position = gen_position(n->m, p);
    vertex->normal = gen_normal(n->m, g);
}

static void place_vertices(net *n, int j) {
    int row = n->nx + 1;
    for (int k = 0; k < n->nz; k++)
        for (int i = 0; i < n->nx; i++) {
            double corner[8];
            int inside = 0;
            for (int c = 0; c < 8; c++) {
                corner[c] = n->value[c >> 1 & 1][(k + (c >> 2)) * row + i + (c & 1)];
                inside += corner[c] < 0.0;
            }
            if (inside > 0 && inside < 8) place_vertex(n, i, j, k, corner, &n->vertex[1][k * n->nx + i]);
        }
}

static void quad(net *n, bool reverse, gen_corner a, gen_corner b, gen_corner c, gen_corner d) {
    gen_face(n->m, a, reverse ? c : b, reverse ? b : c);
    gen_face(n->m, a, reverse ? d : c, reverse ? c : d);
}

/* The edges that start in the lower layer: upwards, and, if there is a layer of cells below, along x and z.
 */
static void join_vertices(net *n, int j) {
    int row = n->nx + 1, nx = n->nx;
    const gen_corner *below = n->vertex[0], *here = n->vertex[1];
    for (int k = 1; k < n->nz; k++)
        for (int i = 1; i < n->nx; i++) {
            const double *lower = n->value[0] + k * row + i;
            bool in = lower[0] < 0.0;
            int c = k * nx + i; /* the cell above and beyond this grid point */
            if (in != (n->value[1][k * row + i] < 0.0)) quad(n, !in, here[c - 1], here[c], here[c - nx],
                                                             here[c - nx - 1]);
            if (j == 0) continue;
            if (in != (lower[1] < 0.0)) quad(n, !in, below[c - nx], here[c - nx], here[c], below[c]);
            if (in != (lower[row] < 0.0)) quad(n, !in, below[c - 1], below[c], here[c], here[c - 1]);
        }
}

static void swap_layers(net *n) {
    double *value = n->value[0];
    gen_corner *vertex = n->vertex[0];
    n->value[0] = n->value[1], n->value[1] = value;
    n->vertex[0] = n->vertex[1], n->vertex[1] = vertex;
}

void gen_statue(mesh *m, double cell) {
    net n = {.m = m, .cell = cell};
    n.bx = (int)ceil(extent.x / cell / BLOCK), n.bz = (int)ceil(extent.z / cell / BLOCK);
    n.nx = n.bx * BLOCK, n.nz = n.bz * BLOCK, n.ny = (int)ceil(extent.y / cell / BLOCK) * BLOCK;
    size_t points = (size_t)(n.nx + 1) * (size_t)(n.nz + 1);
    n.block = gen_allocate((size_t)n.bx * (size_t)n.bz * sizeof *n.block);
    for (int i = 0; i < 2; i++) {
        n.value[i] = gen_allocate(points * sizeof(double));
        n.vertex[i] = gen_allocate(points * sizeof(gen_corner));
        memset(n.vertex[i], 0, points * sizeof(gen_corner));
    }
    find_near_blocks(&n, 0);
    evaluate_layer(&n, 0, n.value[0]);
    for (int j = 0; j < n.ny; j++) {
        if (j > 0 && j % BLOCK == 0) {
            find_near_blocks(&n, j / BLOCK);
            /* its points lie on the border: blocks near on this side count too */
            evaluate_layer(&n, j, n.value[0]);
        }
        evaluate_layer(&n, j + 1, n.value[1]);
        place_vertices(&n, j);
        join_vertices(&n, j);
        swap_layers(&n);
    }
    for (int i = 0; i < 2; i++) {
        free(n.value[i]);
        free(n.vertex[i]);
    }
    free(n.block);
}
