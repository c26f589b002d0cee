#include "cache/hemisphere/light_scratch.h"

#include "base/error.h"
#include "base/memory.h"

typedef struct buffer {
    void *at; /* where the pointer to it goes */
    size_t count, size;
} buffer;

static size_t bytes_of(const buffer *b) { return (b->count * b->size + 63) / 64 * 64; }

static sl_status cut(sl_light_scratch *s, const buffer *buffers, size_t count, sl_error *error) {
    size_t bytes = 0;
    for (size_t i = 0; i < count; i++) bytes += bytes_of(&buffers[i]);
    s->block = sl_allocate(bytes, 1);
    if (!s->block) return sl_fail_memory(error, "a gather's light samples");
    char *next = s->block;
    for (size_t i = 0; i < count; i++) {
        *(void **)buffers[i].at = next;
        next += bytes_of(&buffers[i]);
    }
    return SL_OK;
}

sl_status sl_light_scratch_create(const sl_gather *gather, size_t slots, sl_light_scratch **out,
                                  sl_error *error) {
    *out = NULL;
    sl_light_scratch *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "a gather's light samples");
    size_t n = slots * gather->settings.hit_samples + 2;
    size_t padded = n + SL_SOURCE_LANES;
    s->capacity = n;
    const buffer buffers[] = {{&s->reflects, slots, 4},
                              {&s->of_block, slots * SL_SOURCE_BLOCKS_MAX, 4},
                              {&s->expected, slots, 4},
                              {&s->samples_at, slots, 4},
                              {&s->chosen, n, sizeof *s->chosen},
                              {&s->of_source, gather->sources->count + 1, 4},
                              {&s->sample_slot, padded, 4},
                              {&s->sample_source, padded, 4},
                              {&s->share, padded, 4},
                              {&s->u1, padded, 4},
                              {&s->u2, padded, 4},
                              {&s->origin_x, padded, 4},
                              {&s->origin_y, padded, 4},
                              {&s->origin_z, padded, 4},
                              {&s->direction_x, padded, 4},
                              {&s->direction_y, padded, 4},
                              {&s->direction_z, padded, 4},
                              {&s->arriving, padded, 4},
                              {&s->near, padded, 4}};
    sl_status status = cut(s, buffers, sizeof buffers / sizeof *buffers, error);
    if (status != SL_OK) {
        sl_light_scratch_destroy(s);
        return status;
    }
    *out = s;
    return SL_OK;
}

void sl_light_scratch_destroy(sl_light_scratch *scratch) {
    if (!scratch) return;
    sl_free(scratch->block);
    sl_free(scratch);
}
