/* Random numbers as a pure function of (seed, stream, index): no state, so any order of evaluation and any
 * number of threads gives the same numbers. The mixing is that of Widynski's "Squares" generator (2020, four
 * rounds), keyed by a SplitMix64 hash of seed and stream. */
#pragma once

#include <stdint.h>
#include <string.h>

static inline uint64_t sl_hash64(uint64_t x) { /* SplitMix64's finalizer */
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/* Mixes bytes into a hash, eight at a time. */
static inline uint64_t sl_hash_bytes(uint64_t hash, const void *bytes, size_t count) {
    for (size_t i = 0; i < count; i += sizeof hash) {
        uint64_t word = 0;
        memcpy(&word, (const char *)bytes + i, count - i < sizeof word ? count - i : sizeof word);
        hash = sl_hash64(hash ^ word);
    }
    return hash;
}

static inline uint64_t sl_random_key(uint64_t seed, uint64_t stream) {
    return sl_hash64(sl_hash64(seed) ^ (stream * 0xd1342543de82ef95u)) | 1u;
}

static inline uint32_t sl_random_bits(uint64_t key, uint64_t index) {
    uint64_t x = index * key, y = x, z = y + key;
    x = x * x + y;
    x = (x >> 32) | (x << 32);
    x = x * x + z;
    x = (x >> 32) | (x << 32);
    x = x * x + y;
    x = (x >> 32) | (x << 32);
    return (uint32_t)((x * x + z) >> 32);
}

/* Returns the fraction bits / 2^32, in [0,1), to 24 bits. */
static inline float sl_unit_of_bits(uint32_t bits) { return (float)(bits >> 8) * 0x1p-24f; }

/* Uniform in [0,1), 24 bits. */
static inline float sl_random_unit(uint64_t key, uint64_t index) {
    return sl_unit_of_bits(sl_random_bits(key, index));
}

/* Radical inverse in base 2 of the low 32 bits, as a fraction of 2^32. */
static inline uint32_t sl_van_der_corput(uint32_t i) {
    i = (i << 16) | (i >> 16);
    i = ((i & 0x00ff00ffu) << 8) | ((i & 0xff00ff00u) >> 8);
    i = ((i & 0x0f0f0f0fu) << 4) | ((i & 0xf0f0f0f0u) >> 4);
    i = ((i & 0x33333333u) << 2) | ((i & 0xccccccccu) >> 2);
    return ((i & 0x55555555u) << 1) | ((i & 0xaaaaaaaau) >> 1);
}
