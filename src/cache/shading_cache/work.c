/* From chosen pixels to work. A patch whose corners are not all there gets them; any other one that is
 * larger than a pixel is cut in four, and its places go to the children. Where many places lie in one
 * patch that is done again at once: several levels in one update. */
#include "cache/shading_cache/work.h"

#include <math.h>

#include "base/code_sort.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/shading_cache/renderers.h"

/* Places in a child that make it be processed, too; splits one in another in one update. */
enum { CROWD = 4, LEVELS = 3 };

typedef struct worker {
    sl_patches *patches;
    const sl_work_settings *settings;
    const sl_chosen_place *places;
    uint32_t *handed;          /* indices of places, while they are handed on to children */
    uint32_t *vertex;
    size_t count;
    sl_counters *counters;
    sl_error *error;
} worker;

/* ---- vertices asked for ---- */

/* Returns the update before which what was evaluated is not as the scene is now. */
static uint32_t stale_before(const sl_patches *p, const sl_work_settings *settings, uint32_t root) {
    uint32_t edited = settings->changes->object[sl_root_object(p->primitives, root)].stale_before,
             moved = settings->changes->eye_moved;
    if (settings->changes->no_ageing) return 0;
    return moved > edited && sl_material_has_lobe(sl_root_material(p->primitives, root)) ? moved : edited;
}

bool sl_vertex_is_stale(const sl_patches *p, const sl_work_settings *settings, uint32_t vertex) {
    const sl_patch_vertex *v = &p->vertex[vertex];
    if (v->evaluated == SL_VERTEX_NEVER) return false;
    return v->evaluated < stale_before(p, settings, v->root) || (v->is_quick && !settings->moves);
}

/* Leaves that will not be split any more: bands of light would show in them. */
static bool is_full_size(const worker *w, float area) {
    return w->settings->dense && area > 0.0f && area <= w->settings->split_above;
}

static bool place_is_full_size(const worker *w, const sl_patch_place *place) {
    return is_full_size(w, sl_patch_projected(w->patches, place, w->settings->view).area);
}

static void ask_for(worker *w, uint32_t vertex) {
    if (!w->patches->vertex[vertex].asked) w->vertex[w->count++] = vertex;
    w->patches->vertex[vertex].asked = 1;
}

/* Those corners that were never evaluated; true: there were some. */
static bool ask_for_missing(worker *w, const sl_patch_place *place) {
    bool any = false, full = false;
    for (int c = 0; c < place->corners; c++) {
        uint32_t vertex = sl_patch_corner(w->patches, place->patch, c);
        sl_patch_vertex *v = &w->patches->vertex[vertex];
        if (v->evaluated != SL_VERTEX_NEVER) continue;
        if (!any) full = place_is_full_size(w, place);
        if (full) v->dense = 1;
        ask_for(w, vertex);
        any = true;
    }
    return any;
}

/* Corners that were shaded with few points on lights; true: there were some. */
static bool ask_for_dense(worker *w, const sl_patch_place *place) {
    bool any = false;
    for (int c = 0; c < place->corners; c++) {
        uint32_t vertex = sl_patch_corner(w->patches, place->patch, c);
        sl_patch_vertex *v = &w->patches->vertex[vertex];
        if (v->evaluated == SL_VERTEX_NEVER || v->extrapolated || v->dense) continue;
        v->dense = 1;
        ask_for(w, vertex);
        any = true;
    }
    return any;
}

static void ask_for_all(worker *w, uint32_t patch) {
    for (int c = 0; c < sl_patch_corners(w->patches, patch); c++)
        ask_for(w, sl_patch_corner(w->patches, patch, c));
}

/* ---- is it noise? ---- */

/* Returns how far a level is off where the irradiance is off by its standard error: |D'| sigma, as a central
 * difference, since D' has no bound at black. */
static double level_noise(const worker *w, uint32_t root, uint32_t vertex) {
    const sl_patches *p = w->patches;
    float luminance = sl_vertex_luminance(p, vertex),
          kd = sl_curve_luminance(sl_root_mean_diffuse(p->primitives, root));
    float off = sqrtf(fmaxf(p->sets[vertex].variance, 0.0f)) * kd * (float)(1.0 / SL_PI);
    return 0.5 * ((double)sl_curve_level_of(w->settings->curve, luminance + off) -
                  (double)sl_curve_level_of(w->settings->curve, luminance - off));
}

/* p_err < 2 s, s of the darkest and of the brightest corner: more samples instead of a split. */
static bool is_noise(const worker *w, uint32_t patch) {
    uint32_t root = sl_patch_root(w->patches, patch), low = 0, high = 0;
    float least = HUGE_VALF, most = -1.0f;
    for (int c = 0; c < sl_patch_corners(w->patches, patch); c++) {
        uint32_t vertex = sl_patch_corner(w->patches, patch, c);
        if (w->patches->sets[vertex].count == UINT32_MAX || w->patches->vertex[vertex].extrapolated)
            return false;
        float level = sl_vertex_level(w->patches, w->settings->curve, vertex);
        if (level < least) least = level, low = vertex;
        if (level > most) most = level, high = vertex;
    }
    double a = level_noise(w, root, low), b = level_noise(w, root, high);
    return (double)sl_patch_error(w->patches, w->settings->curve, patch) < 2.0 * sqrt(a * a + b * b);
}

/* ---- splits ---- */

static bool is_sharp(const sl_patches *p, const sl_work_settings *s, const sl_patch_place *place) {
    const sl_material *material = sl_root_material(p->primitives, place->root);
    bool polished = sl_material_is_mirror(material) ||
                    (sl_material_has_lobe(material) && material->exponent >= SL_POLISHED);
    return s->sharp && polished && sl_patch_error(p, s->curve, place->patch) >= (float)SL_SHARP_LEVELS;
}

static bool is_large(const sl_patches *p, const sl_work_settings *s, const sl_patch_place *place,
                     sl_screen_size size) {
    float area = s->split_above;
    if (s->coarsest > 0.0f && s->changes->object[sl_root_object(p->primitives, place->root)].changing)
        area = fmaxf(area, 4.0f * (place->corners == 3 ? 0.5f * s->coarsest : s->coarsest));
    if (area == s->split_above && is_sharp(p, s, place)) area /= (float)SL_SHARP_PARTS;
    return size.area > area && size.edge > sqrtf(fmaxf(fminf(s->split_above, area), 0.0f));
}

bool sl_patch_is_finished(const sl_patches *p, const sl_work_settings *settings, uint32_t patch) {
    for (int c = 0; c < sl_patch_corners(p, patch); c++)
        if (p->vertex[sl_patch_corner(p, patch, c)].evaluated == SL_VERTEX_NEVER) return false;
    sl_patch_place place = sl_patch_place_of(p, patch);
    return place.depth == p->settings.max_depth ||
           !is_large(p, settings, &place, sl_patch_projected(p, &place, settings->view));
}

/* Sorts the places of a patch by the child in which they lie, in their order otherwise. */
static void hand_on(worker *w, const sl_patch_place *place, uint32_t *index, size_t count, size_t begin[5]) {
    size_t at = 0;
    for (int child = 0; child < 4; child++) {
        begin[child] = at;
        for (size_t i = 0; i < count; i++) {
            const sl_chosen_place *chosen = &w->places[index[i]];
            if (sl_patch_child_at(place, (double)chosen->u, (double)chosen->v) == child)
                w->handed[at++] = index[i];
        }
    }
    begin[4] = at;
    for (size_t i = 0; i < count; i++) index[i] = w->handed[i];
}

static sl_status process(worker *w, const sl_patch_place *place, uint32_t *index, size_t count, int level);

/* A child with a crowd of places is cut as well, before it has all its corners: its children's are what will
 * be seen. */
static sl_status process_children(worker *w, const sl_patch_place *place, uint32_t *index, size_t count,
                                  int level, bool always) {
    size_t begin[5];
    sl_status status = SL_OK;
    hand_on(w, place, index, count, begin);
    for (int c = 0; c < 4 && status == SL_OK; c++) {
        size_t here = begin[c + 1] - begin[c];
        if (here == 0) continue;
        sl_patch_place child = sl_patch_child_place(w->patches, place, c);
        bool crowd = here >= CROWD && level < LEVELS;
        if (always || crowd) status = process(w, &child, index + begin[c], here, level);
        else ask_for_missing(w, &child);
    }
    return status;
}

/* level: splits above it in this update. */
static sl_status process(worker *w, const sl_patch_place *place, uint32_t *index, size_t count, int level) {
    uint32_t patch = place->patch;
    if (!sl_patch_is_leaf(w->patches, patch)) return process_children(w, place, index, count, level, true);
    if (level == 0 && ask_for_missing(w, place)) return SL_OK;
    sl_screen_size size = sl_patch_projected(w->patches, place, w->settings->view);
    bool noise = level == 0 && w->patches->sets && is_noise(w, patch);
    if (!noise && is_large(w->patches, w->settings, place, size)) {
        if (is_full_size(w, 0.25f * size.area) && ask_for_dense(w, place)) return SL_OK;
        sl_status status = sl_patch_split(w->patches, place, w->error);
        if (status != SL_OK) return status;
        if (!sl_patch_is_leaf(w->patches, patch)) {
            sl_count(w->counters, SL_COUNT_SPLITS, 1);
            return process_children(w, place, index, count, level + 1, false);
        }
    }
    if (level > 0) ask_for_missing(w, place);
    else if (w->patches->sets) ask_for_all(w, patch); /* one more set of samples */
    return SL_OK;
}

/* ---- all places ---- */

/* Processes the places of one patch after another's. */
static sl_status process_all(worker *w, size_t count, sl_coded *sorted, uint32_t *index) {
    sl_status status = SL_OK;
    for (uint32_t i = 0; i < count; i++) sorted[i] = (sl_coded){w->places[i].patch, i};
    sl_sort_coded(sorted, count);
    for (size_t begin = 0, end; begin < count && status == SL_OK; begin = end) {
        const uint32_t patch = (uint32_t)sorted[begin].code;
        for (end = begin; end < count && sorted[end].code == patch; end++) index[end] = sorted[end].item;
        if (patch >= w->patches->patch_count || !sl_patch_is_alive(w->patches, patch)) continue;
        sl_patch_place place = sl_patch_place_of(w->patches, patch);
        status = process(w, &place, index + begin, end - begin, 0);
    }
    return status;
}

sl_status sl_work_out(sl_patches *patches, const sl_work_settings *settings, size_t count,
                      const sl_chosen_place *places, uint32_t *vertex, size_t *vertex_count,
                      sl_counters *counters, sl_error *error) {
    *vertex_count = 0;
    if (count == 0) return SL_OK;
    worker w = {.patches = patches,
                .settings = settings,
                .places = places,
                .vertex = vertex,
                .counters = counters,
                .error = error};
    sl_coded *sorted = sl_allocate_unset(count, sizeof *sorted);
    uint32_t *index = sl_allocate_unset(2 * count, sizeof *index);
    sl_status status = sorted && index ? SL_OK : sl_fail_memory(error, "work");
    if (status == SL_OK) {
        w.handed = index + count;
        status = process_all(&w, count, sorted, index);
    }
    for (size_t i = 0; i < w.count; i++) patches->vertex[vertex[i]].asked = 0;
    *vertex_count = w.count;
    sl_free(sorted);
    sl_free(index);
    return status;
}
