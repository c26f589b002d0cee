/* Leaves beside finer ones are drawn as fans around their centre, through the vertices that hang on their
 * edges: so both sides of an edge show the same colours. */
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "cache/shading_cache/display_parts.h"

void sl_fans_begin(sl_fans *fans) {
    fans->used = 0;
    for (int s = 0; s < SL_FAN_SIZES; s++) fans->free[s] = SL_NO_INDEX;
}

static size_t words_of(size_t vertices) { return vertices / 2 + 1 + vertices; }

static int size_of(size_t words) {
    int size = 0;
    while (((size_t)SL_FAN_SMALLEST << size) < words) size++;
    return size;
}

/* Offsets are counted in the smallest fans. */
static uint32_t *room_at(const sl_fans *fans, uint32_t offset) {
    return fans->word + (size_t)SL_FAN_SMALLEST * offset;
}

static bool take_room(sl_fans *fans, int size, uint32_t *offset) {
    *offset = fans->free[size];
    if (*offset != SL_NO_INDEX) {
        fans->free[size] = room_at(fans, *offset)[0];
        return true;
    }
    size_t words = (size_t)SL_FAN_SMALLEST << size;
    bool ok = (fans->used + words) / SL_FAN_SMALLEST < SL_FAN_BIT &&
              sl_display_grow(&fans->word, &fans->capacity, fans->used + words, sizeof *fans->word);
    *offset = (uint32_t)(fans->used / SL_FAN_SMALLEST);
    if (ok) fans->used += words;
    return ok;
}

void sl_fan_release(sl_fans *fans, uint32_t word) {
    uint32_t offset = word & (SL_FAN_BIT - 1), *fan = room_at(fans, offset);
    int size = size_of(words_of(sl_fan_count(fan)));
    fan[0] = fans->free[size];
    fans->free[size] = offset;
}

/* Most leaves have one or two; at most SL_PATCH_DYADIC - 1 hang on an edge. */
enum { FEW = 64 };

static bool write_fan(sl_fans *fans, size_t count, const uint32_t *vertex, const uint16_t *spoke,
                      uint32_t *word) {
    uint32_t offset;
    if (!take_room(fans, size_of(words_of(count)), &offset)) return false;
    uint32_t *fan = room_at(fans, offset), *numbers = fan + count / 2 + 1;
    fan[0] = (uint32_t)count;
    for (size_t k = 0; k < count; k++) {
        uint32_t code = spoke[k], upper = (uint32_t)(k + 1) % 2;
        fan[(k + 1) / 2] = upper ? fan[(k + 1) / 2] | code << 16 : code;
    }
    memcpy(numbers, vertex, count * sizeof *vertex);
    *word = SL_FAN_BIT | offset;
    return true;
}

/* With room for so many in all. *enough is false where some found none. */
static bool try_fan(sl_fans *fans, const sl_patches *p, const sl_patch_place *leaf, uint32_t *vertex,
                    uint16_t *spoke, size_t room, uint32_t *word, bool *enough) {
    size_t all = 0;
    for (int edge = 0; edge < leaf->corners; edge++) {
        const sl_hanging list = {vertex + all, spoke + all, room - all, SL_PATCH_DYADIC, 0};
        size_t count = sl_patch_hanging(p, leaf, edge, &list);
        for (size_t k = 0; k < count; k++) spoke[all + k] |= (uint16_t)(edge << SL_PATCH_DEPTH_MAX);
        all += count;
    }
    *enough = all < room;
    if (!*enough) return true;
    *word = SL_DISPLAY_LEAF;
    return all == 0 || write_fan(fans, all, vertex, spoke, word);
}

sl_status sl_fan_of_leaf(sl_fans *fans, const sl_patches *p, const sl_patch_place *leaf, uint32_t *word,
                         sl_error *error) {
    uint32_t vertex[FEW];
    uint16_t spoke[FEW];
    bool enough, ok = try_fan(fans, p, leaf, vertex, spoke, FEW, word, &enough);
    for (size_t room = 16 * FEW; ok && !enough; room *= 8) {
        uint32_t *many = sl_allocate_unset(room, sizeof *many);
        uint16_t *many_spokes = sl_allocate_unset(room, sizeof *many_spokes);
        ok = many && many_spokes && try_fan(fans, p, leaf, many, many_spokes, room, word, &enough);
        sl_free(many);
        sl_free(many_spokes);
    }
    return ok ? SL_OK : sl_fail_memory(error, "the display's fans");
}
