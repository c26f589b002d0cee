/* Vertices without light of their own: inside other geometry, where a table leg stands on the floor, or where
 * no number came. What they show is extrapolated from the corners of the leaves around them that have light,
 * the nearer the more (1/d^2, Shepard 1968; a corner of two leaves counts twice), or, where none of these has
 * any, from those of their parents, and so on upwards. So a leaf that is half under the leg shows on its
 * other half what is beside it, and where the leg begins is for splits to find: what such a leaf shows may be
 * wrong by all of it (sl_patch_error()), down to the size at which nothing is split any more. */
#include "cache/patches/patches.h"

void sl_patches_set_extrapolated(sl_patches *p, uint32_t vertex) {
    p->vertex[vertex].extrapolated = 1;
    p->extrapolates = true;
}

typedef struct estimate {
    uint32_t vertex;
    int above;                 /* it comes from patches so many levels above the leaves around it */
    sl_vec3 position;
    double weight, value[6];
} estimate;

static void add_vertex(const sl_patches *p, estimate *to, uint32_t other_vertex) {
    const sl_patch_vertex *v = &p->vertex[other_vertex];
    if (v->evaluated == SL_VERTEX_NEVER || v->extrapolated || other_vertex == to->vertex) return;
    sl_vec3d apart = sl_subd(sl_to_double(sl_vertex_position(p, other_vertex)), sl_to_double(to->position));
    double weight = 1.0 / fmax(sl_dotd(apart, apart), 1e-30);
    to->weight += weight;
    for (int c = 0; c < p->settings.channels; c++)
        to->value[c] += weight * (double)sl_vertex_value(p, other_vertex)[c];
}

static void add_patch(sl_patches *p, const sl_patch_place *leaf, void *context) {
    estimate *to = context;
    uint32_t patch = leaf->patch;
    for (int i = 0; i < to->above && patch != SL_NO_INDEX; i++) patch = sl_patch_parent(p, patch);
    for (int c = 0; patch != SL_NO_INDEX && c < sl_patch_corners(p, patch); c++)
        add_vertex(p, to, sl_patch_corner(p, patch, c));
}

/* Where nobody has anything what is there stays. */
static void extrapolate(sl_patches *p, uint32_t vertex) {
    const sl_root_place at = p->vertex[vertex].place;
    estimate l = {.vertex = vertex, .position = sl_vertex_position(p, vertex)};
    for (; !(l.weight > 0.0) && l.above <= SL_PATCH_DEPTH_MAX; l.above++)
        sl_patches_visit_around(p, at, add_patch, &l);
    for (int c = 0; c < p->settings.channels && l.weight > 0.0; c++)
        sl_vertex_value(p, vertex)[c] = (float)(l.value[c] / l.weight);
}

/* Values come from vertices with light of their own, so the order does not matter. */
void sl_patches_extrapolate(sl_patches *p) {
    for (uint32_t i = 0; p->extrapolates && i < p->vertex_count; i++)
        if (p->vertex[i].references && p->vertex[i].extrapolated) extrapolate(p, i);
}
