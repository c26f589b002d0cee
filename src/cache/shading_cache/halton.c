/* Halton's points (bases 2 and 3), their digits shifted by fixed numbers. */
#include "base/random.h"
#include "cache/shading_cache/renderer_parts.h"

sl_halton sl_halton_make(uint64_t key) {
    sl_halton h = {.shift_2 = sl_random_bits(sl_random_key(key, 2), 0)};
    uint64_t key_3 = sl_random_key(key, 3);
    double place[SL_HALTON_DIGITS], size = 1.0;
    for (int k = 0; k < SL_HALTON_DIGITS; k++) {
        h.shift_3[k] = (uint8_t)(sl_random_bits(key_3, (uint64_t)k) % 3);
        place[k] = size /= 3.0;
    }
    for (int k = SL_HALTON_DIGITS - 1; k >= 0; k--) h.rest_3[k] = h.rest_3[k + 1] + place[k] * (double)h.shift_3[k];
    return h;
}

void sl_halton_point(const sl_halton *h, uint32_t index, double point[2]) {
    point[0] = (double)(sl_van_der_corput(index) ^ h->shift_2) * 0x1p-32;
    double x = 0.0, place = 1.0;
    int k = 0;
    for (; k < SL_HALTON_DIGITS && index > 0; k++, index /= 3) {
        place /= 3.0;
        x += place * (double)((index + h->shift_3[k]) % 3);
    }
    x += h->rest_3[k];
    point[1] = x < 1.0 ? x : 0x1.fffffffffffffp-1;
}
