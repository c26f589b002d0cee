#include "scene/object_places.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"

static void add_vertex(sl_object_places *places, uint32_t object, uint32_t vertex, sl_vec3 p) {
    uint64_t *hash = &places->hash[object];
    *hash = sl_hash64(*hash ^ ((uint64_t)sl_float_bits(p.x) << 32 | sl_float_bits(p.y)));
    *hash = sl_hash64(*hash ^ ((uint64_t)sl_float_bits(p.z) << 32 | vertex));
    sl_box_add(&places->box[object], p);
}

sl_status sl_object_places_take(const sl_scene *scene, sl_object_places **places, sl_error *error) {
    *places = NULL;
    sl_object_places *p = sl_allocate(1, sizeof *p);
    if (p) {
        p->count = scene->object_count;
        p->hash = sl_allocate(p->count, sizeof *p->hash);
        p->box = sl_allocate(p->count, sizeof *p->box);
    }
    if (!p || !p->hash || !p->box) {
        sl_object_places_destroy(p);
        return sl_fail_memory(error, "the objects' places");
    }
    for (size_t i = 0; i < p->count; i++) p->box[i] = sl_box_empty();
    for (size_t t = 0; t < scene->triangle_count; t++) {
        for (int c = 0; c < 3; c++) {
            uint32_t vertex = scene->vertex[c][t];
            add_vertex(p, scene->object_index[t], vertex, sl_scene_position(scene, vertex));
        }
    }
    *places = p;
    return SL_OK;
}

void sl_object_places_destroy(sl_object_places *p) {
    if (!p) return;
    SL_FREE_ALL(p->hash, p->box, p);
}

size_t sl_object_moves(const sl_object_places *before, const sl_object_places *now, bool *moved,
                       sl_box *box) {
    size_t count = 0;
    for (size_t i = 0; i < now->count; i++) {
        const bool moves = sl_object_has_moved(before, now, i);
        if (moved) moved[i] = moves;
        if (!moves) continue;
        box[count++] = before->box[i];
        box[count++] = now->box[i];
    }
    return count;
}
