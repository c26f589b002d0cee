/* Shared by tests of priorities, work, change and display: vertices with shading as if it had been computed,
 * displays of them. */
#pragma once

#include "cache/patches/display/display.h"
#include "patch_support.h"

static inline void evaluate(hierarchy *h, uint32_t vertex, float irradiance, uint32_t now) {
    for (int c = 0; c < 3; c++) sl_vertex_value(h->patches, vertex)[c] = irradiance;
    sl_vertex_mark(&h->patches->vertex[vertex], now);
    if (h->patches->sets) h->patches->sets[vertex].count = 1;
}

static inline void evaluate_all(hierarchy *h, float irradiance, uint32_t now) {
    for (uint32_t i = 0; i < h->patches->vertex_count; i++) evaluate(h, i, irradiance, now);
}

static inline sl_display *display_of(const hierarchy *h, int width, int height, sl_rgb guess) {
    sl_display_settings settings = {width, height, guess, 1};
    sl_display *display;
    sl_error error = {0};
    if (sl_display_create(h->scene, h->primitives, &settings, &display, &error) != SL_OK)
        fail_msg("%s", error.message);
    return display;
}

static inline void display_discard(sl_display *display, hierarchy *h) {
    sl_display_destroy(display);
    hierarchy_discard(h);
}

static inline void build_display(sl_display *display, const hierarchy *h) {
    assert_int_equal(sl_display_build(display, h->patches, NULL), SL_OK);
}
