/* The explanation of a pixel: image passes 3 and 4 told backwards. In each mesh the pixel lies in a leaf; the
 * leaf's corners and what lies on its edges add weight times value times what the surface reflects. */
#include "base/math.h"
#include "base/memory.h"
#include "cache/multi_mesh/multi_mesh_internal.h"

/* ---- a pixel's vertices ---- */

/* Finds where a pixel was sorted: its face, and its place in the view's arrays. False: the mesh does not show
 * there. */
static bool find_pixel(const sl_displayed *d, const uint32_t *id, uint32_t pixel, uint32_t *face,
                       size_t *at) {
    const sl_visible_pixels *p = d->pixels;
    if (id[pixel] == SL_NO_INDEX) return false;
    *face = sl_root_seen(d->mesh->primitives, d->mesh->primitives->scene, id[pixel], p->view.origin);
    uint32_t entry = p->entry_of_face[*face];
    if (!sl_displayed_wants(d, entry)) return false;
    for (*at = p->face[entry].first; p->pixel[*at] != pixel;) ++*at;
    return true;
}

/* The mean of the known corners stands in for one that is of no use. */
static sl_vertex_shares known_shares(const sl_patches *mesh, const sl_mesh_fan *fan, double a, double b) {
    static const uint32_t corner[3] = {0, 1, 2};
    sl_vertex_shares all = sl_leaf_shares(3, corner, fan->count, fan->spoke, a, b), shares = {.count = 0};
    bool known[3];
    for (int c = 0; c < 3; c++) known[c] = sl_mesh_state(mesh, fan->vertex[c]) == SL_VERTEX_KNOWN;
    for (size_t i = 0; i < all.count; i++) {
        uint32_t from = all.vertex[i];
        bool itself = from > 2 || known[from];
        if (itself) sl_share_add(&shares, fan->vertex[from], all.weight[i]);
        for (int c = 0; c < 3 && !itself; c++)
            if (known[c])
                sl_share_add(&shares, fan->vertex[c], all.weight[i] / (known[0] + known[1] + known[2]));
    }
    return shares;
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
static void reflectance_of(const telling *t, sl_component part, double reflectance[3]) {
    const sl_materials_seen *m = &t->s->materials;
    float scale = part == SL_INDIRECT ? (float)(1.0 / SL_PI) : 1.0f;
    for (int k = 0; k < 3; k++) {
        const float *plane = part == SL_DIRECT_SPECULAR ? m->specular[k] : m->diffuse[k];
        reflectance[k] = plane ? (double)(plane[t->pixel] * scale) : 0.0;
    }
}

static void tell_part(const telling *t, sl_component part) {
    const sl_displayed *d = t->s->part[part];
    uint32_t face;
    size_t at;
    double reflectance[3];
    if (!d || !d->pixels || !find_pixel(d, t->s->id, t->pixel, &face, &at)) return;
    reflectance_of(t, part, reflectance);
    float w1 = d->pixels->w1[at], w2 = d->pixels->w2[at];
    sl_patch_place place = sl_mesh_locate(d->mesh, face, w1, w2);
    sl_mesh_fan fan;
    if (!sl_mesh_fan_shown(d->mesh, &place, d->settings.hanging, &fan)) {
        const float value[3] = {t->s->ambient.r, t->s->ambient.g, t->s->ambient.b};
        if (part == SL_INDIRECT)
            sl_explanation_add_light(t->writer, layers[part],
                                     "constant, before the coarse mesh is whole: irradiance", 0, NULL, 1.0,
                                     value, reflectance);
        return;
    }
    sl_mesh_weights_within(&place, w1, w2, &w1, &w2);
    sl_vertex_shares all = known_shares(d->mesh, &fan, (double)w1, (double)w2);
    for (size_t i = 0; i < all.count; i++) {
        sl_vec3 position = sl_vertex_position(d->mesh, all.vertex[i]);
        sl_explanation_add_light(t->writer, layers[part], kinds[part], all.vertex[i], &position,
                                 all.weight[i], sl_vertex_value(d->mesh, all.vertex[i]), reflectance);
    }
}

sl_status sl_multi_mesh_explanation(void *state, int x, int y, sl_explanation_writer *writer,
                                    sl_error *error) {
    (void)error;
    telling t = {state, writer,
                 (uint32_t)y * (uint32_t)((sl_multi_mesh_state *)state)->settings.width + (uint32_t)x};
    if (!t.s->materials.planes) return SL_OK; /* nothing is seen yet */
    for (int part = 0; part < SL_COMPONENTS; part++) tell_part(&t, (sl_component)part);
    sl_explanation_add_layer(writer, "emission", "emitted light");
    return SL_OK;
}

/* The meshes while they are made, for those who look on: their edges as marks, and pictures that samples are
 * made from. Nothing of it without an observer, and with one nothing that the method does is any different.
 */

/* ---- edges ---- */

typedef struct marking {
    const sl_multi_mesh_state *s;
    const sl_patches *mesh;
    sl_rgb light;           /* of a mesh of one channel, its light's colour */
} marking;

static bool is_in_view(const void *context, uint32_t leaf) {
    const marking *m = context;
    return m->s->visible->entry_of_face[sl_patch_root(m->mesh, leaf)] != SL_NO_INDEX;
}

static sl_rgb value_at(const void *context, uint32_t vertex) {
    const marking *m = context;
    const float *v = sl_vertex_value(m->mesh, vertex);
    return m->mesh->settings.channels == 3 ? (sl_rgb){v[0], v[1], v[2]} : sl_rgb_scale(m->light, v[0]);
}

static void announce_mesh(sl_multi_mesh_state *s, const sl_patches *mesh, sl_rgb light, const char *name) {
    const marking m = {s, mesh, light};
    size_t count;
    if (!s->visible) return;
    sl_mark *marks = sl_patches_edge_marks(mesh, &(sl_edge_marking){is_in_view, value_at, &m}, &count);
    if (count) sl_announce_marks(&s->announcer, name, "multiple meshes", marks, count);
    sl_free(marks);
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
    for (size_t l = 0; l < s->now.lights->count && l < sizeof names / sizeof names[0]; l++)
        announce_mesh(s, sl_irradiance_mesh(s->irradiance, l), s->now.lights->light[l].colour, names[l]);
}

/* ---- pictures ---- */

void sl_multi_mesh_announce_priorities(sl_multi_mesh_state *s) {
    int part = 0;
    while (part < SL_COMPONENTS && !s->part[part]) part++;
    const bool announced = part < SL_COMPONENTS && sl_announcing(&s->announcer);
    float *plane = announced ? sl_allocate(sl_settings_pixels(&s->settings), sizeof *plane) : NULL;
    if (!plane) return;
    const sl_displayed *d = s->part[part];
    const sl_visible_pixels *pixels = s->visible;
    for (size_t e = 0; e < pixels->face_count; e++) {
        float priority = sl_displayed_wants(d, e) ? d->mesh->patch[d->root[e]].priority : 0.0f;
        for (uint32_t i = 0; i < pixels->face[e].count; i++)
            plane[pixels->pixel[pixels->face[e].first + i]] = priority;
    }
    sl_announce(&s->announcer, "priorities of the roots", "progressive sampling", s->settings.width,
                s->settings.height, 1, plane, true);
    sl_free(plane);
}

void sl_multi_mesh_announce_gather(sl_multi_mesh_state *s) {
    const sl_visible_pixels *pixels = s->visible;
    if (!sl_announcing(&s->announcer) || !pixels || !pixels->face_count) return;
    if (sl_multi_mesh_ready_eye(s, &s->whole, SL_GATHER_ALL, NULL) != SL_OK) return;
    const sl_gathers *eye = &s->whole.eye[SL_GATHER_ALL];
    size_t widest = 0;
    for (size_t f = 1; f < pixels->face_count; f++)
        widest = pixels->face[f].count > pixels->face[widest].count ? f : widest;
    const uint16_t third = SL_PATCH_DYADIC / 3;
    sl_mesh_point point =
        sl_mesh_point_at(s->primitives, (sl_root_place){pixels->face[widest].face, third, third});
    sl_counters nobodys = {{0}}; /* no sample of the picture's */
    sl_coarse_gather(s->scene, eye->gather, &point, eye->scratch[0], &nobodys);
    sl_gather_picture picture = sl_gather_last_picture(eye->scratch[0]);
    const float *planes[3] = {picture.r, picture.g, picture.b};
    sl_announce_planes(&s->announcer, "one gather", "equation (7)", picture.width, picture.height, planes);
}

/* Returns how near a vertex of a light's mesh is to seeing just half of the light: at most 1/2. */
static double half_seen(const sl_multi_mesh_state *s, size_t light, uint32_t vertex, sl_lit_point *point) {
    const sl_patches *mesh = sl_irradiance_mesh(s->irradiance, light);
    if (sl_mesh_state(mesh, vertex) != SL_VERTEX_KNOWN) return 0.0;
    *point = sl_mesh_point_of(mesh, vertex).lit;
    double all = sl_light_unoccluded(&s->now.lights->light[light], point),
           share = all > 0.0 ? (double)*sl_vertex_value(mesh, vertex) / all : 0.0;
    return share < 0.5 ? share : 1.0 - share;
}

static void announce_sample(sl_multi_mesh_state *s, size_t light, const sl_lit_point *point,
                            sl_light_sample_scratch *scratch) {
    sl_counters nobodys = {{0}};
    sl_light_sample_take(s->now.sampling, light, point, scratch, &nobodys);
    sl_light_picture picture = sl_light_last_picture(scratch);
    if (!picture.weight) return;
    sl_announce(&s->announcer, "one light sample", "equation (3)", picture.size, picture.size, 1,
                picture.weight, true);
    float *halves = sl_allocate((size_t)picture.size * (size_t)picture.size, sizeof *halves),
          sums[SL_REDUCED * SL_REDUCED];
    if (!halves || picture.size < SL_REDUCED) {
        sl_free(halves);
        return;
    }
    sl_raster_reduce(picture.weight, picture.size, 1, SL_REDUCED, halves, sums, &nobodys);
    sl_announce(&s->announcer, "... reduced to 16 x 16", "equation (3)", SL_REDUCED, SL_REDUCED, 1, sums,
                true);
    sl_free(halves);
}

void sl_multi_mesh_announce_light_sample(sl_multi_mesh_state *s) {
    if (!sl_announcing(&s->announcer) || !s->irradiance || !s->now.lights->count) return;
    sl_light_sample_scratch *scratch;
    sl_lit_point point, chosen = {.triangle = SL_NO_INDEX};
    double most = 0.0;
    const sl_patches *mesh = sl_irradiance_mesh(s->irradiance, 0);
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
        double near = half_seen(s, 0, v, &point);
        if (!(near > most)) continue;
        most = near;
        chosen = point;
    }
    if (!(most > 0.0) || sl_light_sample_scratch_create(s->now.sampling, &scratch, NULL) != SL_OK) return;
    announce_sample(s, 0, &chosen, scratch);
    sl_light_sample_scratch_destroy(scratch);
}
