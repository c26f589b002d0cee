/* "Multi-mesh caching and hardware sampling for progressive and interactive rendering", in the order of the
 * paper:
 *
 *   image pass 1          identifiers and visible sizes
 *   image pass 2          materials: k_d and k_s
 *   multiple meshes       samples of vertices: equations (3), a light's irradiance, (4) and (6), direct
 *                         radiance, and (7), indirect irradiance
 *   progressive sampling  the roots' vertices; then the leaves that matter most, of three meshes, until no
 *                         eye can tell more; beside them the coarse mesh of all surfaces (coarse_rounds.c),
 *                         some vertices an update (method.c): when it is whole indirect light has a
 *                         mesh, too
 *   image pass 3          Gouraud: a picture of each mesh
 *   image pass 4          merge: L = k_d (U_dd + E_i / pi) + k_s U_ds + L_e, with the reflectances that
 *                         equations (4), (6) and (8) lack (merge.c) */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include "base/error.h"
#include "base/memory.h"

/* An update's vertices before refinement; light samples while things move. */
enum { FIRST_VERTICES = 1024, QUICK_SAMPLES = 8192, LEAF_VERTICES = 6 };

/* ---- image pass 1: identifiers and visible sizes; image pass 2: materials ---- */

sl_status sl_multi_mesh_draw_view(sl_multi_mesh_state *s, sl_error *error) {
    unsigned threads = s->settings.threads;
    sl_view view = sl_view_scene(s->scene, s->settings.width, s->settings.height);
    sl_target target = {s->settings.width, s->settings.height, s->id, NULL};
    sl_visible_pixels *before = s->visible; /* which the meshes still hold */
    s->visible = NULL;
    sl_multi_mesh_forget_materials(s);
    sl_status status = sl_raster_id(s->raster, &view, threads, &target, &s->counters, error);
    if (status == SL_OK)
        status = sl_visible_pixels_sort(s->primitives, s->raster, &view, s->id, threads, &s->visible,
                                        &s->counters, error);
    sl_announce_ids(&s->announcer, "identifiers, visible sizes", "image pass 1", s->settings.width,
                    s->settings.height, s->id);
    if (status == SL_OK) status = sl_multi_mesh_see_materials(s, &view, error);
    if (status == SL_OK) status = sl_multi_mesh_see(s, error);
    sl_visible_pixels_destroy(before);
    s->priorities_stale = false;
    s->highest = s->fraction = 0.0;
    s->seen_before = sl_multi_mesh_was_done(s);
    if (s->irradiance) sl_irradiance_meshes_spare(s->irradiance, s->seen_before);
    if (status == SL_OK) s->phase = SL_PHASE_FIRST;
    return status;
}

/* ---- multiple meshes: samples of vertices ---- */

sl_rgb sl_multi_mesh_direct(const sl_multi_mesh_state *s, sl_component part, const sl_sampled_lights *lights,
                            const float *share, const sl_mesh_point *point) {
    if (part == SL_DIRECT_DIFFUSE) return sl_direct_diffuse(lights, share); /* equation (4) */
    float exponent = sl_triangle_material(s->scene, point->face / 2)->exponent;
    /* equation (6) */
    return sl_direct_specular(lights, share, &point->lit, exponent, s->scene->camera.eye);
}

/* While things move: the closed form times the share that a few rays see. */
static sl_status sample_direct_quickly(sl_multi_mesh_state *s, size_t count, const sl_wanted_vertex *wanted,
                                       sl_error *error) {
    sl_displayed *part = s->part[SL_DIRECT_DIFFUSE];
    sl_root_place *places = sl_allocate(count, sizeof *places);
    sl_rgb *radiance = sl_allocate(count, sizeof *radiance);
    sl_status status = places && radiance ? SL_OK : sl_fail_memory(error, "samples");
    for (size_t i = 0; i < count && status == SL_OK; i++)
        places[i] = part->mesh->vertex[wanted[i].vertex].place;
    if (status == SL_OK)
        status = sl_coarse_light_take(&s->light, count, places, true, NULL, radiance, &s->counters, error);
    for (size_t i = 0; i < count && status == SL_OK; i++) {
        const bool valid = sl_rgb_is_finite(radiance[i]);
        sl_displayed_put(part, wanted[i].vertex, valid ? radiance[i] : sl_grey(0.0f), valid, &s->counters);
    }
    sl_free(radiance);
    sl_free(places);
    return status;
}

static sl_status sample_direct(sl_multi_mesh_state *s, sl_component part, size_t count,
                               const sl_wanted_vertex *wanted, sl_error *error) {
    if (s->part[part]->put_as < s->part[part]->world) return sample_direct_quickly(s, count, wanted, error);
    size_t lights = s->now.lights->count;
    sl_face_point *points = sl_allocate(count, sizeof *points);
    float *share = sl_allocate(count * lights, sizeof *share);
    bool *valid = sl_allocate(count, sizeof *valid);
    sl_status status = points && share && valid ? SL_OK : sl_fail_memory(error, "samples");
    for (size_t i = 0; i < count && status == SL_OK; i++) {
        points[i] = (sl_face_point){s->part[part]->mesh->vertex[wanted[i].vertex].place,
                                    sl_multi_mesh_light_depth(s, wanted[i].wanted_depth)};
    }
    /* equation (3) */
    if (status == SL_OK)
        status = sl_irradiance_at(s->irradiance, count, points, share, valid, &s->counters, error);
    for (size_t i = 0; i < count && status == SL_OK; i++) {
        sl_mesh_point point = sl_mesh_point_of(s->part[part]->mesh, wanted[i].vertex);
        sl_rgb value = sl_multi_mesh_direct(s, part, s->now.lights, &share[i * lights], &point);
        sl_displayed_put(s->part[part], wanted[i].vertex, value, valid[i], &s->counters);
    }
    SL_FREE_ALL(valid, share, points);
    return status;
}

static sl_status sample_indirect(sl_multi_mesh_state *s, size_t count, const sl_wanted_vertex *wanted,
                                 sl_error *error) {
    sl_displayed *part = s->part[SL_INDIRECT];
    sl_mesh_point *points = sl_allocate(count, sizeof *points);
    sl_rgb *irradiance = sl_allocate(count, sizeof *irradiance);
    bool *valid = sl_allocate(count, sizeof *valid);
    sl_status status = points && irradiance && valid ? SL_OK : sl_fail_memory(error, "gathers");
    for (size_t i = 0; i < count && status == SL_OK; i++) {
        bool moved;
        points[i] = sl_mesh_point_of(part->mesh, wanted[i].vertex);
        valid[i] = !s->now.tracer || sl_leave_solid(part->mesh, s->now.tracer, NULL, wanted[i].vertex,
                                                &points[i].lit, &moved, &s->counters);
    }
    sl_gather_detail detail = part->put_as < part->world ? SL_GATHER_HALF : SL_GATHER_ALL;
    if (status == SL_OK) /* equation (7) */
        status = sl_multi_mesh_gather(s, &s->whole, detail, count, points, irradiance, error);
    for (size_t i = 0; i < count && status == SL_OK; i++)
        sl_displayed_put(part, wanted[i].vertex, irradiance[i], valid[i], &s->counters);
    SL_FREE_ALL(valid, irradiance, points);
    return status;
}

sl_status sl_multi_mesh_sample(sl_multi_mesh_state *s, sl_component part, size_t count,
                               const sl_wanted_vertex *wanted, sl_error *error) {
    if (count == 0) return SL_OK;
    return part == SL_INDIRECT ? sample_indirect(s, count, wanted, error)
                               : sample_direct(s, part, count, wanted, error);
}

/* ---- progressive sampling: the first picture, from the roots alone ---- */

/* Returns how many vertices an update takes at most: with many lights fewer while things move, so that what
 * it brings is soon seen. */
static size_t most_first_vertices(const sl_multi_mesh_state *s) {
    const size_t lights = s->now.lights ? s->now.lights->count : 0;
    const bool few = s->is_edited && lights * FIRST_VERTICES > QUICK_SAMPLES;
    return few ? QUICK_SAMPLES / lights + 1 : FIRST_VERTICES;
}

/* Some of the vertices that visible leaves lack; *none: there are no more. */
static sl_status fill_missing(sl_multi_mesh_state *s, sl_component part, bool *none, sl_error *error) {
    uint32_t vertex[FIRST_VERTICES];
    sl_wanted_vertex wanted[FIRST_VERTICES];
    const size_t most = most_first_vertices(s), count = sl_displayed_missing(s->part[part], vertex, most);
    *none = count < most;
    s->priorities_stale |= count > 0;
    for (size_t i = 0; i < count; i++) wanted[i] = (sl_wanted_vertex){vertex[i], 0};
    return sl_multi_mesh_sample(s, part, count, wanted, error);
}

sl_status sl_multi_mesh_first_vertices(sl_multi_mesh_state *s, sl_error *error) {
    bool all = true;
    for (int i = 0; i < SL_COMPONENTS; i++) {
        bool none = true;
        if (!sl_multi_mesh_takes_part(s, i)) continue;
        sl_status status = fill_missing(s, (sl_component)i, &none, error);
        if (status != SL_OK) return status;
        all = all && none;
    }
    if (!all) return SL_OK;
    /* in a view seen before they are as sl_displayed_see() has set them */
    for (int i = 0; i < SL_COMPONENTS; i++)
        if (sl_multi_mesh_takes_part(s, i) && s->priorities_stale) sl_displayed_prioritise(s->part[i]);
    sl_announce_pass(&s->announcer, "vertices of the roots", "progressive sampling");
    sl_multi_mesh_announce_priorities(s);
    s->phase = SL_PHASE_REFINE;
    return SL_OK;
}

/* ---- progressive sampling: the leaves that matter most, of all meshes ---- */

int sl_multi_mesh_most_urgent(const sl_multi_mesh_state *s) {
    int best = -1;
    float highest = 0.0f;
    for (int i = 0; i < SL_COMPONENTS; i++) {
        if (i == SL_INDIRECT && s->mixed) continue;
        float priority = sl_multi_mesh_takes_part(s, i) ? sl_displayed_priority(s->part[i]) : 0.0f;
        if (priority > highest) {
            highest = priority;
            best = i;
        }
    }
    return best;
}

typedef struct refinement {
    sl_taken_leaf *leaf;
    size_t leaf_count;
    sl_wanted_vertex *wanted[SL_COMPONENTS];
    size_t wanted_count[SL_COMPONENTS];
} refinement;

static sl_status take_leaves(sl_multi_mesh_state *s, refinement *r, sl_error *error) {
    for (int k = 0; k < s->settings.multi_mesh.batch; k++) {
        int part = sl_multi_mesh_most_urgent(s);
        if (part < 0) break;
        sl_displayed *mesh = s->part[part];
        sl_patch_place place = sl_displayed_take(mesh);
        if (place.patch == SL_NO_INDEX) break;
        bool probed = sl_is_unprobed(mesh, &mesh->mesh->patch[place.patch]);
        r->leaf[r->leaf_count++] = (sl_taken_leaf){(sl_component)part, place, probed, false};
        if (probed) continue;
        uint32_t vertex[LEAF_VERTICES];
        size_t count = 0;
        sl_status status = sl_displayed_request(mesh, &place, vertex, &count, error);
        if (status != SL_OK) return status;
        int depth = sl_displayed_wanted_depth(mesh, &place);
        for (size_t i = 0; i < count; i++)
            r->wanted[part][r->wanted_count[part]++] = (sl_wanted_vertex){vertex[i], depth};
    }
    return SL_OK;
}

static sl_status serve_leaves(sl_multi_mesh_state *s, refinement *r, sl_error *error) {
    sl_status status = take_leaves(s, r, error);
    for (int i = 0; i < SL_COMPONENTS && status == SL_OK; i++)
        status = sl_multi_mesh_sample(s, (sl_component)i, r->wanted_count[i], r->wanted[i], error);
    if (status == SL_OK) sl_multi_mesh_probe(s, r->leaf_count, r->leaf);
    for (size_t i = 0; i < r->leaf_count && status == SL_OK; i++) {
        sl_taken_leaf *leaf = &r->leaf[i];
        if (!leaf->probed)
            status = sl_displayed_commit(s->part[leaf->part], &leaf->place, &s->counters, error);
    }
    for (size_t i = 0; i < r->leaf_count && status == SL_OK; i++) {
        sl_taken_leaf *leaf = &r->leaf[i];
        if (leaf->probed)
            sl_displayed_probed(s->part[leaf->part], &leaf->place, leaf->contradicted, &s->counters);
    }
    for (int i = 0; i < SL_COMPONENTS && status == SL_OK; i++)
        if (s->part[i]) sl_displayed_settle(s->part[i], &s->counters);
    return status;
}

sl_status sl_multi_mesh_refine(sl_multi_mesh_state *s, size_t *served, sl_error *error) {
    size_t batch = (size_t)s->settings.multi_mesh.batch;
    sl_wanted_vertex *wanted = sl_allocate(SL_COMPONENTS * batch * LEAF_VERTICES, sizeof *wanted);
    refinement r = {.leaf = sl_allocate(batch, sizeof *r.leaf)};
    for (size_t i = 0; wanted && i < SL_COMPONENTS; i++) r.wanted[i] = wanted + i * batch * LEAF_VERTICES;
    sl_status status = wanted && r.leaf ? serve_leaves(s, &r, error) : sl_fail_memory(error, "a batch");
    *served = r.leaf_count;
    sl_free(wanted);
    sl_free(r.leaf);
    return status;
}

/* ---- image pass 3: Gouraud; image pass 4: merge ---- */

static void draw_parts(sl_multi_mesh_state *s) {
    static const char *const names[SL_COMPONENTS] = {"direct diffuse radiance", "direct specular radiance",
                                                     "indirect irradiance"};
    for (int i = 0; i < SL_COMPONENTS; i++) {
        if (!sl_is_in_view(s->part[i])) continue;
        sl_rgb fallback = i == SL_INDIRECT ? s->ambient : sl_grey(0.0f);
        sl_displayed_draw(s->part[i], s->settings.threads, fallback, s->planes[i], &s->counters);
        sl_announce(&s->announcer, names[i], "image pass 3", s->settings.width, s->settings.height, 3,
                    s->planes[i][0], true);
        sl_multi_mesh_announce_edges(s, (sl_component)i);
    }
}

sl_status sl_multi_mesh_resolve(void *state, sl_image **image, sl_error *error) {
    sl_multi_mesh_state *s = state;
    /* nothing is seen yet */
    if (!s->materials.planes)
        return sl_image_create(s->settings.width, s->settings.height, 3, NULL, image, error);
    draw_parts(s);
    sl_status status = sl_multi_mesh_merge(s, image, error);
    sl_multi_mesh_announce_lights(s);
    const float *planes = status == SL_OK ? (*image)->planes : NULL;
    sl_announce(&s->announcer, "merge", "image pass 4", s->settings.width, s->settings.height, planes ? 3 : 0,
                planes, false);
    return status;
}
