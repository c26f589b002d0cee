/* Copies that go past the caches, for planes so large that what is written is gone from the caches before
 * anyone reads it: an ordinary store would first fetch the line that it is about to overwrite. SSE2 is part
 * of every x86-64. */
#ifndef SL_BASE_STREAM_H
#define SL_BASE_STREAM_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

/* Whole cache lines are streamed, what is left at both ends is copied. Ends with sl_stream_end() before
 * another thread may read. */
static inline void sl_stream_copy(void *to, const void *from, size_t bytes) {
#ifdef __SSE2__
    uint8_t *t = to;
    const uint8_t *f = from;
    size_t head = (size_t)(-(uintptr_t)t & 63);
    if (head > bytes) head = bytes;
    memcpy(t, f, head);
    for (t += head, f += head, bytes -= head; bytes >= 64; t += 64, f += 64, bytes -= 64) {
        for (int k = 0; k < 64; k += 16) {
            _mm_stream_si128((__m128i *)(void *)(t + k),
                             _mm_loadu_si128((const __m128i *)(const void *)(f + k)));
        }
    }
    memcpy(t, f, bytes);
#else
    memcpy(to, from, bytes);
#endif
}

static inline void sl_stream_end(void) {
#ifdef __SSE2__
    _mm_sfence();
#endif
}

#endif
