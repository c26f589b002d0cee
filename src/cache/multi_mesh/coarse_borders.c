/* Where light is asked for on the coarse mesh. Inside a surface that is at its vertices. At a border (a
 * crease, a face's free edge) it is a little within: borders are where things meet, and corners of theirs are
 * darker than what lies between them, or stick in the next thing altogether. Gathers see areas, of which such
 * corners tell nothing: in the cathedral, with its 81,000 triangles and coarse ones of two metres, they made
 * a quarter of all light disappear. A vertex stands for what of its triangles is nearest to it, so light is
 * asked for half-way to their middle. */
#include "base/error.h"
#include "base/memory.h"
#include "cache/multi_mesh/coarse_tables.h"

/* Half-way from a corner, of weights 1, 0 and 0, to the middle, 1/3, 1/3 and 1/3. */
enum { STEPS = 6 };

/* Sites at which an edge ends that has a face on one side alone. */
static void mark_borders(const sl_topology *t, uint8_t *border) {
    for (size_t e = 0; e < t->edge_count; e++)
        if (t->edge_start[e + 1] - t->edge_start[e] == 1)
            border[t->edge_low[e]] = border[t->edge_high[e]] = 1;
}

static bool is_on_border(const sl_topology *t, const uint8_t *border, uint32_t face, const int weight[3]) {
    for (int k = 0; k < 3; k++) {
        if (weight[k] == SL_MESH_DYADIC) return border[t->site[k][face]];
        if (weight[k] != 0) continue;
        uint32_t e = t->edge[k][face];
        if (weight[(k + 1) % 3] != 0 && weight[(k + 2) % 3] != 0)
            return t->edge_start[e + 1] - t->edge_start[e] == 1;
    }
    return false;
}

/* Of lattices: weights of 0 grow by a sixth of a coarse triangle's, at the others' cost. */
static void move_into_lattice(int weight[3], int step) {
    int zeros = 0, sum = 0;
    for (int k = 0; k < 3; k++) zeros += weight[k] == 0;
    for (int k = 0; k < 3; k++) {
        if (weight[k] == 0) weight[k] = step;
        else weight[k] -= zeros * step / (3 - zeros);
        sum += weight[k];
    }
    for (int k = 0; k < 3; k++) /* halves of odd steps */
        if (weight[k] > step) {
            weight[k] += SL_MESH_DYADIC - sum;
            break;
        }
}

/* Of slices, across which the face is cut from its far corner: a sixth of the way from one long edge to the
 * other, and into the slice at either end. */
static void move_into_slice(int weight[3], int far, int step) {
    int a = (far + 1) % 3, b = (far + 2) % 3;
    if (weight[far] == SL_MESH_DYADIC) {
        move_into_lattice(weight, step);
        return;
    }
    int from = weight[a] == 0 ? b : a, to = from == a ? b : a, across = weight[from] / STEPS;
    weight[to] += across;
    weight[from] -= across;
    if (weight[far] != 0) return;
    weight[far] = step;
    weight[from] -= step;
}

static void move_vertex(const sl_coarse *c, const uint8_t *border, sl_coarse_vertex *v) {
    int weight[3] = {SL_MESH_DYADIC - v->p - v->q, v->p, v->q},
        step = SL_MESH_DYADIC / (STEPS * sl_coarse_rows(c, v->face));
    v->lit_p = v->p;
    v->lit_q = v->q;
    if (!is_on_border(c->topology, border, v->face, weight)) return;
    if (sl_coarse_is_sliced(c, v->face)) move_into_slice(weight, c->turn[v->face / 2], step);
    else move_into_lattice(weight, step);
    v->lit_p = (uint16_t)weight[1];
    v->lit_q = (uint16_t)weight[2];
}

sl_status sl_coarse_leave_borders(sl_coarse *c, sl_error *error) {
    uint8_t *border = sl_allocate(c->topology->site_count, sizeof *border);
    if (!border) return sl_fail_memory(error, "the coarse mesh");
    mark_borders(c->topology, border);
    for (size_t v = 0; v < c->vertex_count; v++) move_vertex(c, border, &c->vertex[v]);
    sl_free(border);
    return SL_OK;
}
