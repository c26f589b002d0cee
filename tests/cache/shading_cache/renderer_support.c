#include "renderer_support.h"

#include "base/memory.h"
#include "cache/shading_cache/renderers.h"

void shop_open(shop *s, sl_scene *scene) {
    *s = (shop){.scene = scene};
    assert_non_null(scene);
    s->tracer = tracer_of(scene);
    s->shown = s->tracer;
    s->settings = (sl_renderer_settings){.scene = scene, .tracer = &s->shown, .seed = 1, .threads = 3};
    s->settings.cache.area_samples = 64;
    s->settings.cache.indirect_samples = 400;
    s->settings.cache.path_depth = 6;
}

void shop_close(shop *s) {
    sl_tracer_destroy(s->tracer);
    sl_scene_destroy(s->scene);
}

sl_sample_renderer shop_renderer(shop *s, make_renderer *make) {
    sl_sample_renderer renderer;
    sl_error error;
    if (make(&s->settings, &renderer, &error) != SL_OK) fail_msg("no renderer: %s", error.message);
    return renderer;
}

sl_sample shop_sample(shop *s, const sl_sample_renderer *renderer, const sl_sample_request *request) {
    sl_sample sample;
    sl_render(renderer, 1, request, 1, &sample, &s->counters);
    return sample;
}

sl_sample_request request_on(const sl_scene *scene, uint32_t triangle, float w1, float w2, bool front) {
    sl_surface surface;
    sl_scene_surface(scene, triangle, w1, w2, sl_scale(sl_scene_geometric_normal(scene, triangle),
                                                       front ? 1.0f : -1.0f), &surface);
    return (sl_sample_request){.point = {surface.position, surface.normal, surface.geometric_normal,
                                         triangle}, .material = surface.material};
}

sl_sample_request request_at(sl_vec3 position, sl_vec3 normal) {
    return (sl_sample_request){.point = {position, normal, normal, SL_NO_INDEX}};
}

static void constant_point(const void *state, const sl_sample_request *request, unsigned worker,
                           sl_sample *sample, sl_counters *counters) {
    sample->irradiance = *(const sl_rgb *)state;
}

static sl_status constant_edit(void *state, sl_error *error) {
    return SL_OK;
}

sl_sample_renderer constant_renderer(sl_rgb irradiance) {
    sl_rgb *state = sl_allocate(1, sizeof *state);
    assert_non_null(state);
    *state = irradiance;
    return (sl_sample_renderer){
        .state = state, .render = constant_point, .edit = constant_edit, .destroy = sl_free};
}
