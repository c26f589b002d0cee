/* What the rasterizer's tests share: scenes from triangle lists, plain views, small renders. */
#ifndef TESTS_RASTER_SUPPORT_H
#define TESTS_RASTER_SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/random.h"
#include "raster/raster.h"

/* Triangles as nine floats each, one grey material. NULL camera. */
static inline sl_scene *scene_of_triangles(const float *xyz, size_t count) {
    uint32_t *indices = malloc((3 * count + 1) * sizeof *indices);
    assert_non_null(indices);
    for (uint32_t i = 0; i < 3 * count; i++) indices[i] = i;
    sl_material grey = {.diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX};
    sl_scene_parts parts = {.vertex_count = 3 * count, .positions = xyz, .triangle_count = count, .indices = indices,
                            .material_count = 1, .materials = &grey};
    sl_scene *scene = NULL;
    sl_error error;
    if (sl_scene_build(&parts, &scene, &error) != SL_OK) fail_msg("%s", error.message);
    free(indices);
    return scene;
}

/* Clip coordinates are the positions themselves, w = 1. */
static inline sl_view flat_view(int width, int height) {
    sl_view view = {.width = width, .height = height, .depth = SL_DEPTH_WINDOW, .skip_triangle = SL_NO_INDEX};
    for (int k = 0; k < 4; k++) view.clip[k][k] = 1.0f;
    return view;
}

static inline sl_raster *raster_of(const sl_scene *scene) {
    sl_raster *raster = NULL;
    assert_int_equal(sl_raster_create(scene, 1, &raster, NULL), SL_OK);
    return raster;
}

static inline sl_counters render(const sl_raster *raster, const sl_view *view, unsigned threads, uint32_t *id, float *depth) {
    sl_counters counters = {{0}};
    sl_target target = {view->width, view->height, id, depth};
    assert_int_equal(sl_raster_id(raster, view, threads, &target, &counters, NULL), SL_OK);
    return counters;
}

static inline sl_counters render_small(const sl_raster *raster, const sl_view *view, uint32_t *id, float *depth) {
    sl_counters counters = {{0}};
    sl_target target = {view->width, view->height, id, depth};
    sl_raster_scratch *scratch = NULL;
    assert_int_equal(sl_raster_scratch_create(raster, view->width, view->height, &scratch, NULL), SL_OK);
    sl_raster_id_small(raster, view, &target, scratch, &counters);
    sl_raster_scratch_destroy(scratch);
    return counters;
}

static inline float random_between(uint64_t key, uint64_t index, float low, float high) {
    return low + (high - low) * sl_random_unit(key, index);
}

#endif
