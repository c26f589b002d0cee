/* Sample renderers of the shading cache for tests: a scene with its tracer, and requests at its points. */
#pragma once

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "unit_test.h"
#include "base/counters.h"
#include "base/math.h"
#include "base/random.h"
#include "cache/shading_cache/renderers.h"
#include "rendering.h"
#include "trace_scenes.h"

typedef struct shop {
    sl_scene *scene;
    sl_tracer *tracer;
    const sl_tracer *shown;    /* where renderers look for it */
    sl_renderer_settings settings;
    sl_counters counters;
} shop;

/* Not to be copied: renderers look at its `shown`. 64 points a light, 400 paths of up to 6 surfaces. */
void shop_open(shop *s, sl_scene *scene);
void shop_close(shop *s);

typedef sl_status make_renderer(const sl_renderer_settings *settings, sl_sample_renderer *renderer,
                                sl_error *error);
sl_sample_renderer shop_renderer(shop *s, make_renderer *make);
sl_sample shop_sample(shop *s, const sl_sample_renderer *renderer, const sl_sample_request *request);

/* A point of a triangle, on its front or its back; no lobe wanted. */
sl_sample_request request_on(const sl_scene *scene, uint32_t triangle, float w1, float w2, bool front);
/* A point that belongs to no triangle; no material. */
sl_sample_request request_at(sl_vec3 position, sl_vec3 normal);

/* The same irradiance everywhere. */
sl_sample_renderer constant_renderer(sl_rgb irradiance);
