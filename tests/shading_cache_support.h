/* What tests of priorities, work and change share: vertices with shading as if it had been computed. */
#ifndef TESTS_SHADING_CACHE_SUPPORT_H
#define TESTS_SHADING_CACHE_SUPPORT_H

#include "patch_support.h"

static inline void evaluate(hierarchy *h, uint32_t vertex, float irradiance, uint32_t now) {
    sl_patch_vertex *v = &h->patches->vertex[vertex];
    for (int c = 0; c < 3; c++) v->value[c] = irradiance;
    sl_vertex_mark(v, now);
    if (h->patches->sets) h->patches->sets[vertex].count = 1;
}

static inline void evaluate_all(hierarchy *h, float irradiance, uint32_t now) {
    for (uint32_t i = 0; i < h->patches->vertex_count; i++) evaluate(h, i, irradiance, now);
}

#endif
