/* The same irradiance everywhere: for tests of all that is not shading. */
#include "base/error.h"
#include "base/memory.h"
#include "cache/shading_cache/renderer_parts.h"

static void render_point(const void *state, const sl_sample_request *request, unsigned worker, sl_sample *sample, sl_counters *counters) {
    (void)request, (void)worker, (void)counters;
    sample->irradiance = *(const sl_rgb *)state;
}

static void render(const void *state, size_t count, const sl_sample_request *requests, unsigned threads, sl_sample *samples,
                   sl_counters *counters) {
    sl_render_each(render_point, state, count, requests, threads, samples, counters);
}

static sl_status edit(void *state, unsigned changes, sl_error *error) {
    (void)state, (void)changes, (void)error;
    return SL_OK;
}

sl_status sl_constant_renderer(sl_rgb irradiance, sl_sample_renderer *renderer, sl_error *error) {
    *renderer = (sl_sample_renderer){.name = "constant", .render = render, .edit = edit, .destroy = sl_free};
    sl_rgb *state = sl_allocate(1, sizeof *state);
    if (!state) return sl_fail_memory(error, "a sample renderer");
    *state = irradiance;
    renderer->state = state;
    return SL_OK;
}
