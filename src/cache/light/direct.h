/* Direct light of every pixel of a G-buffer, by shadow rays or by shadow maps: for methods whose own light is
 * indirect. direct_internal.h says in which order to read. */
#pragma once

#include "cache/light/shadow_maps.h"
#include "trace/trace.h"

typedef struct sl_direct_settings {
    uint32_t light_samples;   /* shadow rays a pixel towards lights with extent */
    uint64_t seed;
    unsigned threads;
    const sl_shadow_maps *maps; /* NULL: shadow rays */
    /* the part of the environment that is sampled here; the records carry the rest. NULL: none */
    const sl_environment *sun;
} sl_direct_settings;

typedef struct sl_direct sl_direct;

/* tracer may be NULL where shadow maps are given. */
sl_status sl_direct_create(const sl_scene *scene, const sl_tracer *tracer, const sl_direct_settings *settings,
                           sl_direct **direct, sl_error *error);
/* The same for frames in motion, which have no time for penumbrae by rays: by shadow maps that it draws and
 * owns; by the rays of the settings, which hold no maps, where lights are too many for maps, or may_map is
 * false. */
sl_status sl_direct_create_quick(const sl_scene *scene, const sl_raster *raster, const sl_tracer *tracer,
                                 const sl_direct_settings *settings, bool may_map, sl_direct **direct,
                                 sl_counters *counters, sl_error *error);
/* Has neighbouring pixels share what they ask of an emitter's shadow maps, or not. That of frames in motion
 * does from the start. NULL is allowed. */
void sl_direct_interleave(sl_direct *direct, bool interleaves);
void sl_direct_destroy(sl_direct *direct);
/* Returns bytes of its own maps. NULL: 0. */
size_t sl_direct_map_bytes(const sl_direct *direct);
bool sl_direct_is_mapped(const sl_direct *direct);
/* Direct light of the next `rows` rows of a G-buffer from *row on, which moves on: diffuse and glossy lobes,
 * radiance into three planes (bottom row first). The same bits whatever the strips; with maps, if they are
 * multiples of 8 rows. */
enum { SL_DIRECT_ROWS = 64 }; /* enough of them for many threads */
sl_status sl_direct_rows(const sl_direct *direct, const sl_gbuffer *gbuffer, int rows, int *row,
                         float *const radiance[3], sl_counters *counters, sl_error *error);
