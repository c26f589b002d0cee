/* The order of visits in which each place is far from the one before: steps of the golden ratio. */
#pragma once

#include <stdint.h>

static inline uint64_t sl_greatest_common_divisor(uint64_t a, uint64_t b) {
    while (b) {
        uint64_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

/* `count` cells are visited as (i * step) mod count: every cell once, as step and count have no common
 * divisor. */
static inline uint64_t sl_golden_step(uint64_t count) {
    uint64_t step = (uint64_t)(0.6180339887498949 * (double)count);
    while (step > 1 && sl_greatest_common_divisor(step, count) != 1) step--;
    return step > 1 ? step : 1;
}
