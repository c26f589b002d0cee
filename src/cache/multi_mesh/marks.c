/* What can be seen of the meshes while they are made: their edges as marks, and pictures that samples are
 * made from. Nothing of it without an observer, and with one nothing that the method does is any different.
 */
#include "base/memory.h"
#include "cache/multi_mesh/displayed_internal.h"
#include "cache/multi_mesh/explanation.h"

#include <stdlib.h>

/* ---- edges ---- */

typedef struct edges {
    uint64_t *pair;         /* two vertices, the lower one in the upper half */
    size_t count, room;
} edges;

static void put_edge(edges *e, uint32_t a, uint32_t b) {
    if (e->count < e->room) e->pair[e->count++] = a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

/* The middle one of four children has no edges of its own. */
static void put_edges_below(const sl_mesh *mesh, edges *e, uint32_t node) {
    const sl_mesh_node *n = &mesh->node[node];
    if (n->child == SL_NO_INDEX) {
        for (int c = 0; c < 3; c++) put_edge(e, n->vertex[(c + 1) % 3], n->vertex[(c + 2) % 3]);
        return;
    }
    for (int c = 0; c < 4; c++)
        if (c < 3 || !sl_mesh_is_leaf(mesh, n->child + 3)) put_edges_below(mesh, e, n->child + (uint32_t)c);
}

static int by_vertices(const void *a, const void *b) {
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

/* Each edge once, though two leaves have it. */
static void sort_edges(edges *e) {
    size_t kept = 0;
    qsort(e->pair, e->count, sizeof *e->pair, by_vertices);
    for (size_t i = 0; i < e->count; i++)
        if (i == 0 || e->pair[i] != e->pair[i - 1]) e->pair[kept++] = e->pair[i];
    e->count = kept;
}

/* colour: of a mesh of one channel, its light's. */
static sl_rgb value_at(const sl_mesh *mesh, sl_rgb colour, uint32_t vertex) {
    const float *v = &mesh->value[(size_t)vertex * (size_t)mesh->channels];
    return mesh->channels == 3 ? (sl_rgb){v[0], v[1], v[2]} : sl_rgb_scale(colour, v[0]);
}

static sl_mark mark_of(const sl_mesh *mesh, sl_rgb light, uint64_t pair) {
    uint32_t a = (uint32_t)(pair >> 32), b = (uint32_t)pair;
    sl_mesh_point from, to;
    sl_mesh_point_of(mesh, a, &from);
    sl_mesh_point_of(mesh, b, &to);
    sl_rgb colour = sl_rgb_scale(sl_rgb_add(value_at(mesh, light, a), value_at(mesh, light, b)), 0.5f);
    return (sl_mark){.kind = SL_MARK_SEGMENT,
                     .at = {from.position.x, from.position.y, from.position.z},
                     .to = {to.position.x, to.position.y, to.position.z},
                     .colour = {colour.r, colour.g, colour.b}};
}

static void announce_mesh(sl_multi_mesh_state *s, const sl_mesh *mesh, sl_rgb light, const char *name) {
    const sl_visible_pixels *pixels = s->visible;
    edges e = {.room = 3 * mesh->leaf_count};
    sl_mark *mark = pixels && e.room ? sl_allocate(e.room, sizeof *mark) : NULL;
    e.pair = mark ? sl_allocate(e.room, sizeof *e.pair) : NULL;
    for (size_t f = 0; e.pair && f < pixels->face_count; f++) {
        uint32_t root = sl_mesh_root_of(mesh, pixels->face[f].face);
        if (root != SL_NO_INDEX) put_edges_below(mesh, &e, root);
    }
    if (e.count) sort_edges(&e);
    for (size_t i = 0; i < e.count; i++) mark[i] = mark_of(mesh, light, e.pair[i]);
    if (e.count) sl_announce_marks(&s->announcer, name, "multiple meshes", mark, e.count);
    sl_free(e.pair);
    sl_free(mark);
}

void sl_multi_mesh_announce_edges(sl_multi_mesh_state *s, sl_component part) {
    static const char *const names[SL_COMPONENTS] = {"edges of the direct diffuse mesh",
                                                     "edges of the direct specular mesh",
                                                     "edges of the indirect mesh"};
    if (sl_announcing(&s->announcer) && s->part[part])
        announce_mesh(s, s->part[part]->mesh, sl_grey(1.0f), names[part]);
}

void sl_multi_mesh_announce_lights(sl_multi_mesh_state *s) {
    static const char *const names[] = {"edges of the first light's irradiance mesh",
                                        "edges of the second light's irradiance mesh"};
    if (!sl_announcing(&s->announcer) || !s->irradiance) return;
    for (size_t l = 0; l < s->lights->count && l < sizeof names / sizeof names[0]; l++)
        announce_mesh(s, sl_irradiance_mesh(s->irradiance, l), s->lights->light[l].colour, names[l]);
}

/* ---- pictures ---- */

static float *plane_for_observer(const sl_multi_mesh_state *s) {
    return sl_announcing(&s->announcer) ? sl_allocate(sl_multi_mesh_pixels(s), sizeof(float)) : NULL;
}

static void announce_plane(sl_multi_mesh_state *s, const char *name, const char *source, float *plane) {
    sl_announce(&s->announcer, name, source, s->settings.width, s->settings.height, 1, plane, true);
    sl_free(plane);
}

void sl_multi_mesh_announce_ids(sl_multi_mesh_state *s) {
    float *plane = plane_for_observer(s);
    if (!plane) {
        sl_announce_pass(&s->announcer, "identifiers, visible sizes", "image pass 1");
        return;
    }
    for (size_t i = 0; i < sl_multi_mesh_pixels(s); i++)
        plane[i] = s->id[i] == SL_NO_INDEX ? -1.0f : (float)s->id[i];
    announce_plane(s, "identifiers, visible sizes", "image pass 1", plane);
}

void sl_multi_mesh_announce_priorities(sl_multi_mesh_state *s) {
    int part = 0;
    while (part < SL_COMPONENTS && !s->part[part]) part++;
    float *plane = part < SL_COMPONENTS ? plane_for_observer(s) : NULL;
    if (!plane) return;
    const sl_displayed *d = s->part[part];
    const sl_visible_pixels *pixels = s->visible;
    for (size_t e = 0; e < pixels->face_count; e++) {
        float priority = sl_displayed_wants(d, e) ? d->mesh->node[sl_displayed_root(d, e)].priority : 0.0f;
        for (uint32_t i = 0; i < pixels->face[e].count; i++)
            plane[pixels->pixel[pixels->face[e].first + i]] = priority;
    }
    announce_plane(s, "priorities of the roots", "progressive sampling", plane);
}

void sl_multi_mesh_announce_gather(sl_multi_mesh_state *s) {
    const sl_visible_pixels *pixels = s->visible;
    if (!sl_announcing(&s->announcer) || !s->gatherer || !pixels || !pixels->face_count) return;
    size_t widest = 0;
    for (size_t f = 1; f < pixels->face_count; f++)
        widest = pixels->face[f].count > pixels->face[widest].count ? f : widest;
    sl_face_point middle = {
        .face = pixels->face[widest].face, .p = SL_MESH_DYADIC / 3, .q = SL_MESH_DYADIC / 3};
    sl_mesh_point point = sl_face_point_in_world(s->primitives, &middle);
    sl_counters nobodys = {{0}}; /* no sample of the picture's */
    sl_mesh_gather_take(s->gather, &point, s->gatherer[0].scratch, &nobodys);
    const float *planes[3];
    int size;
    sl_mesh_gather_picture(s->gatherer[0].scratch, &size, planes);
    sl_announce_planes(&s->announcer, "one gather", "equation (7)", size, size, planes);
}

/* Returns how near a vertex of a light's mesh is to seeing just half of the light: at most 1/2. */
static double half_seen(const sl_multi_mesh_state *s, size_t light, uint32_t vertex, sl_lit_point *point) {
    const sl_mesh *mesh = sl_irradiance_mesh(s->irradiance, light);
    sl_mesh_point at;
    if (mesh->state[vertex] != SL_VERTEX_KNOWN) return 0.0;
    sl_mesh_point_of(mesh, vertex, &at);
    *point = (sl_lit_point){at.position, at.normal, at.geometric_normal, at.triangle};
    double all = sl_light_unoccluded(&s->lights->light[light], point),
           share = all > 0.0 ? (double)mesh->value[vertex] / all : 0.0;
    return share < 0.5 ? share : 1.0 - share;
}

static void announce_sample(sl_multi_mesh_state *s, size_t light, const sl_lit_point *point,
                            sl_light_sample_scratch *scratch) {
    enum { REDUCED = 16 };
    sl_counters nobodys = {{0}};
    sl_light_sample_take(s->sampling, light, point, scratch, &nobodys);
    sl_light_picture picture = sl_light_last_picture(scratch);
    if (!picture.weight) return;
    sl_announce(&s->announcer, "one light sample", "equation (3)", picture.size, picture.size, 1,
                picture.weight, true);
    float *halves = sl_allocate((size_t)picture.size * (size_t)picture.size, sizeof *halves),
          sums[REDUCED * REDUCED];
    if (!halves || picture.size < REDUCED) {
        sl_free(halves);
        return;
    }
    sl_raster_reduce(picture.weight, picture.size, 1, REDUCED, halves, sums, &nobodys);
    sl_announce(&s->announcer, "... reduced to 16 x 16", "equation (3)", REDUCED, REDUCED, 1, sums, true);
    sl_free(halves);
}

void sl_multi_mesh_announce_light_sample(sl_multi_mesh_state *s) {
    if (!sl_announcing(&s->announcer) || !s->irradiance || !s->lights->count) return;
    sl_light_sample_scratch *scratch;
    sl_lit_point point, chosen = {.triangle = SL_NO_INDEX};
    double most = 0.0;
    const sl_mesh *mesh = sl_irradiance_mesh(s->irradiance, 0);
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
        double near = half_seen(s, 0, v, &point);
        if (!(near > most)) continue;
        most = near;
        chosen = point;
    }
    if (!(most > 0.0) || sl_light_sample_scratch_create(s->sampling, &scratch, NULL) != SL_OK) return;
    announce_sample(s, 0, &chosen, scratch);
    sl_light_sample_scratch_destroy(scratch);
}
