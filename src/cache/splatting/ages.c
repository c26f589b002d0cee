/* Records while objects and lights move (not in the paper, whose records are of one state of a scene). With
 * a budget of records a frame they are kept: each goes along with what it lies on, shows the light that it
 * last gathered, and gathers anew in turns, those first that have waited longest and that have things moving
 * near them. They reach further then, and those that others cover go: so few are left that most can gather
 * for each picture, and none looks older than its neighbours. When nothing moves any more and all have had
 * their turn, records are made anew behind the picture that is shown: the last picture has the bits of a scene
 * in which nothing has ever moved. */
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "cache/splatting/state.h"

/* ---- what has moved ---- */

static void forget_places(sl_splat_ages *a) {
    sl_object_places_destroy(a->places);
    sl_free(a->placements);
    a->places = NULL;
    a->placements = NULL;
}

sl_status sl_splat_note_places(sl_splat_state *s, sl_error *error) {
    sl_splat_ages *a = &s->ages;
    forget_places(a);
    if (!s->settings.records_per_frame) return SL_OK;
    sl_status status = sl_object_places_take(s->scene, &a->places, error);
    return status == SL_OK ? sl_object_placements_take(s->scene, &a->placements, error) : status;
}

static sl_status note_moved(sl_splat_ages *a, const sl_object_places *before, sl_error *error) {
    sl_free(a->moved);
    a->moved = sl_allocate(2 * before->count, sizeof *a->moved);
    a->moved_count = a->moved ? sl_object_moves(before, a->places, NULL, a->moved) : 0;
    return a->moved ? SL_OK : sl_fail_memory(error, "what has moved");
}

/* ---- records go along ---- */

static sl_status carry_list(const sl_splat_state *s, const sl_object_motion *motion, sl_record_list *list,
                            sl_error *error) {
    sl_status status = SL_OK;
    list->reaches.count = 0;
    for (size_t i = 0; i < list->count && status == SL_OK; i++) {
        sl_record *r = &list->records[i];
        const sl_object_motion *m = &motion[s->scene->object_index[r->triangle]];
        if (m->moves) sl_record_carry(r, m);
        status = sl_reach_tree_insert(&list->reaches, r->position, r->own_radius / r->stretch, error);
    }
    return status;
}

/* ---- few of them ---- */

/* Records' own places, as pixels are to those of others. */
static sl_splat_receivers places_of(const sl_record_list *list, float *planes[6], uint32_t *receives) {
    for (size_t i = 0; i < list->count; i++) {
        const sl_record *r = &list->records[i];
        const float at[6] = {r->position.x, r->position.y, r->position.z,
                             r->normal.x,   r->normal.y,   r->normal.z};
        for (int k = 0; k < 6; k++) planes[k][i] = at[k];
        receives[i] = 1;
    }
    return (sl_splat_receivers){(int)list->count, 1, planes[0], planes[1], planes[2], planes[3], planes[4],
                                planes[5], receives};
}

static bool is_covered(const sl_record_list *kept, const sl_weight_rules *rules,
                       const sl_splat_receivers *places, size_t record, sl_isa isa) {
    const float enough = sl_covered_weight(rules->accuracy);
    float sum = 0.0f;
    for (size_t k = 0; k < kept->count && sum < enough; k++)
        sum += SL_KERNEL_OF(isa, sl_splat_weight)(&kept->records[k], rules, places, record);
    return sum >= enough;
}

static void keep_in_front(sl_record_list *list, size_t record, size_t floats) {
    list->records[list->count] = list->records[record];
    if (floats)
        memmove(list->coefficients + list->count * floats, list->coefficients + record * floats,
                floats * sizeof(float));
    list->count++;
}

/* Keeps, in their order, those that the ones before do not cover: coarse ones come first. */
static sl_status thin_out(const sl_splat_state *s, sl_receiver_class class, sl_record_list *list,
                          sl_error *error) {
    const float a = (float)sl_splat_accuracy(s, class);
    const sl_weight_rules rules = {a, 1.0f / a, 1e-5f * s->scene->scale};
    const size_t count = list->count, floats = sl_splat_coefficients(s, class);
    float *block = sl_allocate(6 * count, sizeof *block), *planes[6];
    uint32_t *receives = sl_allocate(count, sizeof *receives);
    const bool room = block && receives;
    if (room) {
        for (int k = 0; k < 6; k++) planes[k] = block + (size_t)k * count;
        const sl_splat_receivers places = places_of(list, planes, receives);
        const sl_isa isa = sl_isa_best();
        list->count = 0;
        for (size_t i = 0; i < count; i++) {
            if (!is_covered(list, &rules, &places, i, isa)) keep_in_front(list, i, floats);
        }
    }
    sl_free(receives);
    sl_free(block);
    return room ? SL_OK : sl_fail_memory(error, "records of what moves");
}

static sl_status thin_all(sl_splat_state *s, sl_error *error) {
    sl_status status = SL_OK;
    for (int c = 0; c < SL_RECEIVER_CLASSES && status == SL_OK; c++)
        if (s->cache[c].list.count)
            status = thin_out(s, (sl_receiver_class)c, &s->cache[c].list, error);
    return status;
}

static sl_status carry(sl_splat_state *s, const sl_affine *before, sl_error *error) {
    const size_t objects = s->scene->object_count;
    sl_object_motion *motion = sl_allocate(objects, sizeof *motion);
    if (!motion) return sl_fail_memory(error, "records of what moves");
    for (size_t i = 0; i < objects; i++)
        motion[i] = sl_object_motion_between(&before[i], &s->ages.placements[i]);
    sl_status status = SL_OK;
    for (int c = 0; c < SL_RECEIVER_CLASSES && status == SL_OK; c++)
        status = carry_list(s, motion, &s->cache[c].list, error);
    if (status == SL_OK && s->second)
        status = sl_second_cache_move(s->second, s->tracer, s->maps, motion, error);
    sl_free(motion);
    return status;
}

bool sl_splat_keeps_records(const sl_splat_state *s) {
    const bool some = s->cache[0].list.count + s->cache[1].list.count > 0;
    return s->settings.records_per_frame && !s->scene->sub_frame.share && s->raster && some;
}

sl_status sl_splat_age_records(sl_splat_state *s, sl_error *error) {
    sl_object_places *places = s->ages.places;
    sl_affine *placements = s->ages.placements;
    s->ages.places = NULL;
    s->ages.placements = NULL;
    const bool begins = !s->ages.aged;
    s->ages.aged = true;
    s->ages.edits++;
    sl_status status = sl_splat_renew_lights(s, error);
    if (status == SL_OK) status = note_moved(&s->ages, places, error);
    if (status == SL_OK && begins) status = thin_all(s, error);
    if (status == SL_OK) status = carry(s, placements, error);
    if (status != SL_OK) sl_splat_destroy_transport(s); /* the next edit makes all anew */
    sl_object_places_destroy(places);
    sl_free(placements);
    return status;
}

/* ---- in turns ---- */

typedef struct turn {
    double urgency;
    size_t record;
} turn;

/* By how much more urgent a record is for things that have moved near it: as large as it sees them. */
static double nearness(const sl_splat_ages *a, sl_vec3 p) {
    double sum = 1.0;
    for (size_t i = 0; i < a->moved_count; i++) {
        const sl_box *b = &a->moved[i];
        const sl_vec3 way = sl_outside_box(*b, p), across = sl_sub(b->high, b->low);
        const double size = (double)sl_dot(across, across), away = (double)sl_dot(way, way);
        if (size > 0.0) sum += 8.0 * size / (size + away);
    }
    return sum;
}

static int more_urgent(const void *x, const void *y) {
    const turn *a = x, *b = y;
    if (a->urgency != b->urgency) return a->urgency > b->urgency ? -1 : 1;
    return a->record < b->record ? -1 : a->record > b->record;
}

/* Lists those that were not renewed since things last moved; returns how many. */
static size_t list_turns(const sl_splat_ages *a, const sl_record_list *list, turn *turns) {
    size_t count = 0;
    for (size_t i = 0; i < list->count; i++) {
        const sl_record *r = &list->records[i];
        if (r->renewed == a->edits) continue;
        turns[count++] = (turn){(double)(a->edits - r->renewed) * nearness(a, r->position), i};
    }
    qsort(turns, count, sizeof *turns, more_urgent);
    return count;
}

static bool is_renewed(const sl_splat_state *s) {
    if (s->second && !sl_second_cache_is_renewed(s->second)) return false;
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        const sl_record_list *list = &s->cache[c].list;
        for (size_t i = 0; i < list->count; i++)
            if (list->records[i].renewed != s->ages.edits) return false;
    }
    return true;
}

static sl_gather_point point_of(const sl_splat_state *s, const sl_record *r) {
    sl_vec3 geometric = sl_scene_geometric_normal(s->scene, r->triangle);
    if (sl_dot(geometric, r->normal) < 0.0f) geometric = sl_neg(geometric);
    return (sl_gather_point){r->position, geometric, r->normal, r->triangle,
                             (uint64_t)r->key[1] << 32 | r->key[0]};
}

/* It reaches as far as it did: few rays tell light well, and distances badly. */
static void take_light(sl_record *r, const sl_record *again, uint32_t edits) {
    r->irradiance = again->irradiance;
    memcpy(r->rotational, again->rotational, sizeof r->rotational);
    memcpy(r->translational, again->translational, sizeof r->translational);
    memcpy(r->rotational_length, again->rotational_length, sizeof r->rotational_length);
    sl_record_set_radius(r, r->radius);
    r->renewed = edits;
}

static void commit(sl_splat_state *s, sl_record_list *list, const sl_record_batch *b, const turn *turns) {
    const size_t floats = b->coefficient_count;
    for (size_t k = 0; k < b->count; k++) {
        const size_t i = turns[k].record;
        take_light(&list->records[i], &b->record[k], s->ages.edits);
        if (floats)
            memcpy(list->coefficients + i * floats, b->coefficients + k * floats, floats * sizeof(float));
    }
}

static void gather_batch(sl_splat_state *s, sl_record_cache *cache, sl_record_batch *b, const turn *turns) {
    for (size_t k = 0; k < b->count; k++) b->point[k] = point_of(s, &cache->list.records[turns[k].record]);
    sl_record_batch_gather(b, &s->counters);
    commit(s, &cache->list, b, turns);
}

/* At most `budget` of a class's records, the most urgent ones. */
static sl_status renew_class(sl_splat_state *s, sl_record_cache *cache, size_t budget, sl_error *error) {
    sl_record_list *list = &cache->list;
    const size_t floats = sl_splat_coefficients(s, cache->class);
    sl_status status = sl_splat_open_cache(s, cache, error);
    if (status == SL_OK) status = sl_splat_open_gathers(s, cache, error);
    if (status != SL_OK) return status;
    turn *turns = sl_allocate(list->count, sizeof *turns);
    float *coefficients = floats ? sl_allocate(SL_BATCH_MAX, floats * sizeof *coefficients) : NULL;
    sl_record_batch *b = sl_allocate(1, sizeof *b);
    if (b && turns && (coefficients || !floats)) {
        const size_t waiting = list_turns(&s->ages, list, turns), end = waiting < budget ? waiting : budget;
        *b = (sl_record_batch){.scene = s->scene, .tracer = s->tracer, .gathers = &cache->gathers,
                               .radii = cache->pass.radii, .coefficient_count = floats,
                               .coefficients = coefficients};
        for (size_t first = 0; first < end; first += b->count) {
            b->count = end - first < SL_BATCH_MAX ? end - first : SL_BATCH_MAX;
            gather_batch(s, cache, b, turns + first);
        }
    } else {
        status = sl_fail_memory(error, "records that are renewed");
    }
    sl_free(b);
    sl_free(coefficients);
    sl_free(turns);
    return status;
}

sl_status sl_splat_renew_records(sl_splat_state *s, sl_error *error) {
    const size_t budget = s->settings.records_per_frame, second = (budget + 1) / 2;
    sl_status status =
        s->second ? sl_second_cache_renew(s->second, second, &s->counters, error) : SL_OK;
    for (int c = 0; c < SL_RECEIVER_CLASSES && status == SL_OK; c++)
        if (s->cache[c].list.count) status = renew_class(s, &s->cache[c], budget, error);
    s->phase = SL_PHASE_GBUFFER;
    return status;
}

/* ---- at rest ---- */

static void swap_records(sl_splat_state *s) {
    sl_splat_ages *a = &s->ages;
    sl_second_cache *second = a->kept_second;
    a->kept_second = s->second;
    s->second = second;
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        const sl_record_list list = a->kept[c];
        a->kept[c] = s->cache[c].list;
        s->cache[c].list = list;
        s->cache[c].clamped = 0;
    }
    sl_splat_close_gathers(s);
}

static void drop_kept(sl_splat_ages *a) {
    sl_second_cache_destroy(a->kept_second);
    a->kept_second = NULL;
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) sl_record_list_free(&a->kept[c]);
}

sl_status sl_splat_rest(sl_splat_state *s, sl_error *error) {
    sl_splat_ages *a = &s->ages;
    sl_status status = SL_OK;
    if (is_renewed(s)) {
        a->anew = true;
        swap_records(s);
        status = sl_splat_renew_direct(s, error);
    }
    sl_splat_begin_view(s);
    return status;
}

void sl_splat_stir(sl_splat_state *s) {
    sl_splat_ages *a = &s->ages;
    if (!a->anew) return;
    a->anew = false;
    swap_records(s);
    drop_kept(a);
}

void sl_splat_settle(sl_splat_state *s) {
    drop_kept(&s->ages);
    s->ages.aged = s->ages.anew = false;
}

void sl_splat_ages_free(sl_splat_ages *a) {
    drop_kept(a);
    forget_places(a);
    sl_free(a->moved);
}
