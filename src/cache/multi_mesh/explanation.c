/* The explanation of a pixel: image passes 3 and 4 told backwards. In each mesh the pixel lies in a leaf; the
 * leaf's corners and what lies on its edges add weight times value times what the surface reflects. */
#include "cache/multi_mesh/explanation.h"

#include "base/math.h"
#include "base/memory.h"
#include "cache/multi_mesh/displayed_internal.h"
#include "cache/patches/fan.h"

/* ---- a pixel's vertices ---- */

typedef struct weighted_vertex {
    uint32_t vertex;
    double weight;
} weighted_vertex;
enum { VERTICES = 5 /* three corners, two vertices of an edge */, STEPS = SL_FAN_EDGE - 1 };

/* Where a pixel's face was sorted: its entry and the pixel's place in the view's arrays. False: the mesh does
 * not show there. */
static bool find_pixel(const sl_displayed *d, const uint32_t *id, uint32_t pixel, uint32_t *face,
                       size_t *at) {
    const sl_visible_pixels *p = d->pixels;
    for (uint32_t side = 0; side < 2 && id[pixel] != SL_NO_INDEX; side++) {
        uint32_t entry = p->entry_of_face[2 * id[pixel] + side];
        if (entry == SL_NO_INDEX || !sl_displayed_wants(d, entry)) continue;
        const sl_visible_face *f = &p->face[entry];
        for (*at = f->first; *at < (size_t)f->first + f->count; ++*at) {
            *face = f->face;
            if (p->pixel[*at] == pixel) return true;
        }
    }
    return false;
}

/* Tells whether a leaf's corners are sampled, and how many of them are of use. */
static bool has_values(const sl_displayed *d, uint32_t node, int *known) {
    *known = 0;
    for (int c = 0; c < 3; c++) {
        uint32_t vertex = d->mesh->node[node].vertex[c];
        if (!sl_displayed_is_settled(d, vertex)) return false;
        *known += d->mesh->state[vertex] == SL_VERTEX_KNOWN;
    }
    return *known > 0;
}

/* The leaf, or the nearest node above it that has values, as it is drawn. */
static bool find_shown(const sl_displayed *d, sl_mesh_place *place, int *known) {
    while (!has_values(d, place->node, known)) {
        uint32_t parent = sl_mesh_parent(d->mesh, place->node);
        if (parent == SL_NO_INDEX) return false;
        *place = sl_mesh_place_of(d->mesh, parent);
    }
    return true;
}

/* Between the two vertices of edge e around a point, in steps of 1/2^SL_FAN_LEVELS: shares of the edge's
 * ends (by corner), the rest is others'. */
static size_t weigh_edge(const sl_displayed *d, const sl_mesh_place *place, int e, double steps, double share,
                         double corner[3], weighted_vertex *out) {
    sl_edge_vertices list = {.count = 0};
    int ends[2] = {(e + 1) % 3, (e + 2) % 3}, low = -1, made = 0;
    if (d->settings.hanging) sl_mesh_edge_vertices(d->mesh, place, e, &list);
    while (low + 1 < list.count && (double)list.at[low + 1] <= steps) low++;
    int high = low + 1;
    double from = low < 0 ? 0.0 : list.at[low], to = high < list.count ? list.at[high] : STEPS;
    double rest = (steps - from) / (to - from);
    if (low < 0) corner[ends[0]] += share * (1.0 - rest);
    else out[made++] = (weighted_vertex){list.vertex[low], share * (1.0 - rest)};
    if (high == list.count) corner[ends[1]] += share * rest;
    else out[made++] = (weighted_vertex){list.vertex[high], share * rest};
    return (size_t)made;
}

/* The fan of mesh_interpolate.c. */
static size_t weigh_vertices(const sl_displayed *d, const sl_mesh_place *place, int known, float w1, float w2,
                             weighted_vertex out[VERTICES]) {
    float own_w1, own_w2;
    sl_mesh_weights_within(place, w1, w2, &own_w1, &own_w2);
    sl_fan_place fan = sl_fan_place_of(true, own_w1, own_w2);
    double s = (double)fan.out, centre = (1.0 - s) / 3.0, corner[3] = {centre, centre, centre}, lost = 0.0;
    size_t count = weigh_edge(d, place, (fan.edge + 2) % 3, STEPS * (double)fan.along, s, corner, out);
    const uint32_t *vertex = d->mesh->node[place->node].vertex;
    for (int c = 0; c < 3; c++) lost += d->mesh->state[vertex[c]] == SL_VERTEX_KNOWN ? 0.0 : corner[c];
    for (int c = 0; c < 3; c++) /* the mean of the others stands in for a corner that is of no use */
        if (d->mesh->state[vertex[c]] == SL_VERTEX_KNOWN)
            out[count++] = (weighted_vertex){vertex[c], corner[c] + lost / (double)known};
    return count;
}

/* ---- telling ---- */

typedef struct telling {
    sl_multi_mesh_state *s;
    sl_explanation_writer *writer;
    uint32_t pixel;
} telling;

static const char *const layers[SL_COMPONENTS] = {"direct", "specular", "indirect"};
static const char *const kinds[SL_COMPONENTS] = {
    "vertex of the direct diffuse mesh: radiance of white",
    "vertex of the direct specular mesh: radiance of a mirror-like white",
    "vertex of the indirect mesh: irradiance"};

/* Gives the factor by which the merge multiplies a mesh's value. */
static void reflectance_of(const telling *t, sl_component part, float reflectance[3]) {
    const sl_materials_seen *m = t->s->materials;
    float scale = part == SL_INDIRECT ? (float)(1.0 / SL_PI) : 1.0f;
    for (int k = 0; k < 3; k++) {
        const float *plane = part == SL_DIRECT_SPECULAR ? m->specular[k] : m->diffuse[k];
        reflectance[k] = plane ? plane[t->pixel] * scale : 0.0f;
    }
}

static void tell_vertex(const telling *t, sl_component part, const weighted_vertex *v,
                        const float reflectance[3]) {
    const sl_mesh *mesh = t->s->part[part]->mesh;
    sl_explanation_term term = {
        .layer = layers[part], .kind = kinds[part], .index = v->vertex, .placed = true, .weight = v->weight};
    sl_mesh_point point;
    sl_mesh_point_of(mesh, v->vertex, &point);
    term.position[0] = point.position.x;
    term.position[1] = point.position.y;
    term.position[2] = point.position.z;
    for (int k = 0; k < 3; k++) {
        term.value[k] = mesh->value[3 * (size_t)v->vertex + (size_t)k];
        term.contribution[k] = v->weight * (double)term.value[k] * (double)reflectance[k];
    }
    sl_explanation_add(t->writer, &term);
}

/* Light that is assumed until there is a mesh of it. */
static void tell_ambient(const telling *t, const float reflectance[3]) {
    const float value[3] = {t->s->ambient.r, t->s->ambient.g, t->s->ambient.b};
    sl_explanation_term term = {
        .layer = "indirect", .kind = "constant, before the coarse mesh is whole: irradiance", .weight = 1.0};
    for (int k = 0; k < 3; k++) {
        term.value[k] = value[k];
        term.contribution[k] = (double)value[k] * (double)reflectance[k];
    }
    sl_explanation_add(t->writer, &term);
}

static void tell_part(const telling *t, sl_component part) {
    const sl_displayed *d = t->s->part[part];
    uint32_t face;
    size_t at;
    float reflectance[3], leaf_w1, leaf_w2;
    if (!d || !d->pixels || !find_pixel(d, t->s->id, t->pixel, &face, &at)) return;
    reflectance_of(t, part, reflectance);
    float w1 = d->pixels->w1[at], w2 = d->pixels->w2[at];
    sl_mesh_place place = sl_mesh_locate(d->mesh, face, w1, w2, &leaf_w1, &leaf_w2);
    int known;
    if (!find_shown(d, &place, &known)) {
        if (part == SL_INDIRECT) tell_ambient(t, reflectance);
        return;
    }
    weighted_vertex vertex[VERTICES];
    size_t count = weigh_vertices(d, &place, known, w1, w2, vertex);
    for (size_t i = 0; i < count; i++)
        if (vertex[i].weight != 0.0) tell_vertex(t, part, &vertex[i], reflectance);
}

sl_status sl_multi_mesh_explanation(void *state, int x, int y, sl_explanation_writer *writer,
                                    sl_error *error) {
    (void)error;
    telling t = {state, writer,
                 (uint32_t)y * (uint32_t)((sl_multi_mesh_state *)state)->settings.width + (uint32_t)x};
    if (!t.s->materials) return SL_OK; /* nothing is seen yet */
    for (int part = 0; part < SL_COMPONENTS; part++) tell_part(&t, (sl_component)part);
    sl_explanation_add_layer(writer, "emission", "emitted light");
    return SL_OK;
}
