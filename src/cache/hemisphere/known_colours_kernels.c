#include "cache/hemisphere/known_colours.h"

/* A row is done in blocks: indices in lanes, then the numbers at those indices brought beside one another,
 * then arithmetic in lanes again. */
enum { BLOCK = 64 };

typedef struct block {
    _Alignas(64) float colour[SL_LATTICE_FLOATS][BLOCK], a[BLOCK], b[BLOCK];
    _Alignas(64) int32_t first[BLOCK], rows[BLOCK], at[BLOCK];
} block;

static inline void fetch(const float *restrict table, const int32_t *restrict index, int count,
                         float (*restrict out)[BLOCK]) {
    for (int k = 0; k < count; k++)
        for (int c = 0; c < SL_LATTICE_FLOATS; c++) out[c][k] = table[SL_LATTICE_FLOATS * index[k] + c];
}

/* ---- where on the lattice -------------------------------------------------------------------- */

/* Returns the side of a triangle that the eye is on; or the background. */
static inline int32_t face_of(const sl_colour_pixels *p, uint32_t id) {
    const sl_scene *s = p->scene;
    if (id >= s->triangle_count) return (int32_t)(2 * s->triangle_count);
    sl_vec3 to_eye = sl_sub(p->eye, sl_scene_position(s, s->vertex[0][id]));
    return (int32_t)(2 * id) + (sl_dot(to_eye, sl_scene_geometric_normal(s, id)) >= 0.0f ? 0 : 1);
}

/* Lattices of pixels: neighbours mostly show the same face. */
static inline void find_lattices(const sl_colour_pixels *p, block *b, int count, size_t first) {
    uint32_t before = SL_NO_INDEX;
    sl_face_lattice lattice = p->lattice.face[face_of(p, before)];
    for (int k = 0; k < count; k++) {
        uint32_t id = p->id[first + (size_t)k];
        if (id != before) lattice = p->lattice.face[face_of(p, id)];
        before = id;
        b->first[k] = lattice.first;
        b->rows[k] = lattice.rows;
    }
}

static inline void find_small_triangles(block *b, int count, const float *restrict w1,
                                        const float *restrict w2) {
#pragma omp simd
    for (int k = 0; k < count; k++)
        b->at[k] = b->first[k] + sl_lattice_locate(w1[k], w2[k], b->rows[k], &b->a[k], &b->b[k]);
}

/* ---- a row ----------------------------------------------------------------------------------- */

/* Colours between the corners; below the horizon black. */
static inline void write(const sl_colour_pixels *p, const block *b, int count, size_t first,
                         sl_vec3 origin, const float *restrict x) {
    const float *restrict weight = p->weight + first;
    float above[BLOCK], height = sl_dot(origin, p->horizon), slope = sl_dot(p->frame.x, p->horizon);
#pragma omp simd
    for (int k = 0; k < count; k++) above[k] = x[k] * slope + height > 0.0f ? 1.0f : 0.0f;
    for (int c = 0; c < 3; c++) {
        float *restrict radiance = p->radiance[c] + first, *restrict weighted = p->weighted[c] + first;
#pragma omp simd
        for (int k = 0; k < count; k++) {
            float value = b->colour[c][k] + b->a[k] * b->colour[c + 3][k] + b->b[k] * b->colour[c + 6][k];
            value = above[k] * (value > 0.0f ? value : 0.0f);
            radiance[k] = value;
            weighted[k] = value * weight[k];
        }
    }
}

void SL_KERNEL(sl_colour_pixels_shade)(const sl_colour_pixels *p) {
    block b;
    for (int row = 0; row < p->height; row++) {
        sl_vec3 origin = sl_mad(p->frame.z, p->y[row * p->width], p->frame.y);
        for (int at = 0; at < p->width; at += BLOCK) {
            int count = p->width - at < BLOCK ? p->width - at : BLOCK;
            size_t first = (size_t)row * (size_t)p->width + (size_t)at;
            find_lattices(p, &b, count, first);
            find_small_triangles(&b, count, p->w1 + first, p->w2 + first);
            fetch(p->lattice.colour, b.at, count, b.colour);
            write(p, &b, count, first, origin, p->x + at);
        }
    }
}
