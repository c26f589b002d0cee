/* Records, and how far their neighbours let them reach. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/splatting/splatting.h"

/* ---- reaches ---- */

static unsigned octant_of(sl_vec3 centre, sl_vec3 p) {
    return (unsigned)(p.x >= centre.x) | (unsigned)(p.y >= centre.y) << 1 | (unsigned)(p.z >= centre.z) << 2;
}

sl_status sl_reach_tree_insert(sl_reach_tree *tree, sl_vec3 position, float radius, sl_error *error) {
    if (!sl_make_room(&tree->nodes, tree->count, &tree->capacity, sizeof *tree->nodes))
        return sl_fail_memory(error, "records' reaches");
    uint32_t *link = NULL;
    for (uint32_t index = 0; index < tree->count; index = *link) {
        sl_reach_node *n = &tree->nodes[index];
        sl_box_add(&n->box, position);
        n->least = fminf(n->least, radius);
        if (n->position.x == position.x && n->position.y == position.y && n->position.z == position.z) {
            n->radius = fminf(n->radius, radius); /* the smaller one answers for both */
            return SL_OK;
        }
        link = &n->child[octant_of(n->position, position)];
        if (!*link) break;
    }
    if (link) *link = (uint32_t)tree->count;
    tree->nodes[tree->count++] = (sl_reach_node){
        .position = position, .radius = radius, .least = radius, .box = {position, position}};
    return SL_OK;
}

/* ---- the question ---- */

/* Returns at most the distance from p to anything in the box: rounding is paid for. */
static float distance_to_box(const sl_reach_node *n, sl_vec3 p) {
    return 0.9999f * sl_length(sl_outside_box(n->box, p));
}

static float limit_below(const sl_reach_tree *tree, uint32_t index, sl_vec3 p, float radius) {
    const sl_reach_node *n = &tree->nodes[index];
    if (!(n->least < radius) || !(n->least + distance_to_box(n, p) < radius)) return radius;
    radius = fminf(radius, n->radius + sl_length(sl_sub(p, n->position)));
    const unsigned nearest = octant_of(n->position, p); /* first, as it says most */
    for (unsigned k = 0; k < 8; k++) {
        if (n->child[nearest ^ k]) radius = limit_below(tree, n->child[nearest ^ k], p, radius);
    }
    return radius;
}

float sl_reach_tree_limit(const sl_reach_tree *tree, sl_vec3 position, float radius) {
    return tree->count ? limit_below(tree, 0, position, radius) : radius;
}

/* ---- the list ---- */

static bool make_room(sl_record_list *list, bool with_coefficients, size_t coefficient_count) {
    size_t capacity = list->capacity ? 2 * list->capacity : 1024;
    bool grown = sl_regrow(&list->records, list->count, capacity, sizeof *list->records);
    if (with_coefficients)
        grown =
            grown && sl_regrow(&list->coefficients, list->count, capacity, coefficient_count * sizeof(float));
    if (grown) list->capacity = capacity;
    return grown;
}

sl_status sl_record_list_append(sl_record_list *list, const sl_record *record, const float *coefficients,
                                size_t coefficient_count, sl_error *error) {
    if (list->count == list->capacity && !make_room(list, coefficients != NULL, coefficient_count))
        return sl_fail_memory(error, "records");
    sl_status status =
        sl_reach_tree_insert(&list->reaches, record->position, record->own_radius / record->stretch, error);
    if (status != SL_OK) return status;
    if (coefficients)
        memcpy(list->coefficients + list->count * coefficient_count, coefficients,
               coefficient_count * sizeof *coefficients);
    list->records[list->count++] = *record;
    return SL_OK;
}

/* ---- rule 5 ---- */

typedef struct {
    const sl_record_list *list;
    float *radii;
} clamp_context;

static void clamp_one(void *context, size_t index, unsigned worker) {
    (void)worker;
    const clamp_context *c = context;
    c->radii[index] = sl_record_clamped_radius(&c->list->reaches, &c->list->records[index]);
}

sl_status sl_record_list_clamp(sl_record_list *list, unsigned threads, bool *shrunk, sl_error *error) {
    float *radii = sl_allocate(list->count, sizeof *radii);
    if (!radii) return sl_fail_memory(error, "record radii");
    clamp_context context = {list, radii};
    sl_parallel_for(threads, list->count, clamp_one, &context);
    for (size_t i = 0; i < list->count; i++) {
        if (!(radii[i] < list->records[i].radius)) continue;
        sl_record_set_radius(&list->records[i], radii[i]);
        *shrunk = true;
    }
    sl_free(radii);
    return SL_OK;
}

void sl_record_list_clear(sl_record_list *list) {
    list->reaches.count = list->count = 0;
}

void sl_record_list_free(sl_record_list *list) {
    sl_free(list->records);
    sl_free(list->coefficients);
    sl_free(list->reaches.nodes);
    *list = (sl_record_list){0};
}
