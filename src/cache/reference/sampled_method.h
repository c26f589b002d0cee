/* A reference tracer as a method: one update is one more sample for every pixel. */
#ifndef SL_CACHE_REFERENCE_SAMPLED_METHOD_H
#define SL_CACHE_REFERENCE_SAMPLED_METHOD_H

#include "cache/frame/method.h"
#include "trace/trace.h"

typedef struct sl_sampled_film {
    const char *name;      /* of the method */
    const char *what;      /* for errors: "the path tracer" */
    uint32_t samples[3];   /* by quality */
    bool bidirectional;
} sl_sampled_film;

extern const sl_sampled_film sl_path_film, sl_bidirectional_film; /* methods.c */

/* The class's functions. */
void sl_sampled_complete(sl_settings *settings);
sl_status sl_sampled_create(const sl_scene *scene, const sl_settings *settings, const sl_transport *transport,
                            void **state, sl_error *error);
void sl_sampled_destroy(void *state);
sl_status sl_sampled_update(void *state, sl_progress *progress, sl_error *error);
sl_status sl_sampled_resolve(void *state, sl_image **image, sl_error *error);
sl_status sl_sampled_edit(void *state, unsigned changes, sl_error *error);
const sl_counters *sl_sampled_counters(const void *state);
size_t sl_sampled_memory_bytes(const void *state);
void sl_sampled_transport(const sl_settings *settings, sl_transport *transport);

#endif
