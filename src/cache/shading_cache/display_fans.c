/* Leaves beside finer ones are drawn as fans around their centre, through the vertices that hang on their edges (section on hanging nodes): so both sides of
 * an edge show the same colours. */
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "cache/shading_cache/display_parts.h"

void sl_fans_begin(sl_fans *fans) {
    fans->used = 0;
    for (int s = 0; s < SL_FAN_SIZES; s++) fans->free[s] = SL_NO_INDEX;
}

static size_t words_of(size_t vertices) { return 2 + vertices + (vertices + 1) / 2; }

static int size_of(size_t words) {
    int size = 0;
    while (((size_t)SL_FAN_SMALLEST << size) < words) size++;
    return size;
}

/* Offsets are counted in the smallest fans. */
static uint32_t *fan_at(const sl_fans *fans, uint32_t offset) { return fans->word + (size_t)SL_FAN_SMALLEST * offset; }

static bool take_room(sl_fans *fans, int size, uint32_t *offset) {
    *offset = fans->free[size];
    if (*offset != SL_NO_INDEX) {
        fans->free[size] = fan_at(fans, *offset)[0];
        return true;
    }
    size_t words = (size_t)SL_FAN_SMALLEST << size;
    void *word = fans->word;
    bool ok = (fans->used + words) / SL_FAN_SMALLEST < SL_FAN_BIT && sl_display_grow(&word, &fans->capacity, fans->used + words, sizeof *fans->word);
    fans->word = word;
    *offset = (uint32_t)(fans->used / SL_FAN_SMALLEST);
    if (ok) fans->used += words;
    return ok;
}

static uint32_t hanging_on(const uint32_t *fan, int edge) { return fan[edge / 2] >> 16 * (edge % 2) & 0xffff; }

void sl_fan_release(sl_fans *fans, uint32_t word) {
    uint32_t offset = word & (SL_FAN_BIT - 1), *fan = fan_at(fans, offset);
    size_t count = 0;
    for (int edge = 0; edge < 4; edge++) count += hanging_on(fan, edge);
    int size = size_of(words_of(count));
    fan[0] = fans->free[size];
    fans->free[size] = offset;
}

/* At most SL_PATCH_DYADIC - 1 vertices hang on an edge. Most leaves have one or two. */
enum { FEW = 64 };

static bool write_fan(sl_fans *fans, const size_t count[4], const uint32_t *vertex, const uint16_t *at, uint32_t *word) {
    size_t all = count[0] + count[1] + count[2] + count[3];
    uint32_t offset;
    if (!take_room(fans, size_of(words_of(all)), &offset)) return false;
    uint32_t *fan = fan_at(fans, offset);
    for (int pair = 0; pair < 2; pair++) fan[pair] = (uint32_t)(count[2 * pair] | count[2 * pair + 1] << 16);
    memcpy(fan + 2, vertex, all * sizeof *vertex);
    memcpy(fan + 2 + all, at, all * sizeof *at);
    *word = SL_FAN_BIT | offset;
    return true;
}

/* With room for so many in all. *enough is false where some found none. */
static bool try_fan(sl_fans *fans, const sl_patches *p, const sl_patch_place *leaf, uint32_t *vertex, uint16_t *at, size_t room, uint32_t *word,
                    bool *enough) {
    size_t count[4] = {0, 0, 0, 0}, all = 0;
    for (int edge = 0; edge < leaf->corners; edge++) {
        count[edge] = sl_patch_hanging_at(p, leaf, edge, vertex + all, at + all, room - all);
        all += count[edge];
    }
    *enough = all < room;
    if (!*enough) return true;
    *word = SL_DISPLAY_LEAF;
    return all == 0 || write_fan(fans, count, vertex, at, word);
}

sl_status sl_fan_of_leaf(sl_fans *fans, const sl_patches *p, const sl_patch_place *leaf, uint32_t *word, sl_error *error) {
    uint32_t vertex[FEW];
    uint16_t at[FEW];
    bool enough, ok = try_fan(fans, p, leaf, vertex, at, FEW, word, &enough);
    for (size_t room = 16 * FEW; ok && !enough; room *= 8) {
        uint32_t *many = sl_allocate_unset(room, sizeof *many);
        uint16_t *many_at = sl_allocate_unset(room, sizeof *many_at);
        ok = many && many_at && try_fan(fans, p, leaf, many, many_at, room, word, &enough);
        sl_free(many);
        sl_free(many_at);
    }
    return ok ? SL_OK : sl_fail_memory(error, "the display's fans");
}
