/* Step 6 of Algorithm 2: means of E', filled where nothing reached, times albedo / pi, plus direct light and emission. */
#include "base/math.h"
#include "cache/splatting/splatting.h"

#include <string.h>

static sl_rgb emission_at(const sl_scene *scene, const sl_gbuffer *g, size_t pixel) {
    int x = (int)(pixel % (size_t)g->width), y = (int)(pixel / (size_t)g->width);
    if (g->material[pixel] == SL_NO_INDEX) {
        const sl_camera *camera = &scene->camera;
        if (!scene->environment.present) return sl_grey(0.0f);
        float top = (float)sl_tan(0.5 * (double)camera->vertical_fov);
        float right = top * (float)g->width / (float)g->height;
        float u = (2.0f * ((float)x + 0.5f) / (float)g->width - 1.0f) * right;
        float v = (2.0f * ((float)y + 0.5f) / (float)g->height - 1.0f) * top;
        sl_vec3 direction = sl_mad(sl_mad(sl_neg(camera->back), u, camera->right), v, camera->up);
        return sl_environment_radiance(&scene->environment, sl_normalize_or(direction, sl_neg(camera->back)));
    }
    const sl_material *m = &scene->materials[g->material[pixel]];
    if (!sl_material_is_emitter(m)) return sl_grey(0.0f);
    sl_vec3 geometric = sl_v3(g->geometric_x[pixel], g->geometric_y[pixel], g->geometric_z[pixel]);
    bool front = sl_dot(geometric, sl_scene_geometric_normal(scene, g->id[pixel])) > 0.0f;
    return front || m->emission_two_sided ? m->emission : sl_grey(0.0f);
}

const char *const sl_layer_names[SL_LAYERS] = {"R",          "G",          "B",          "emission.R", "emission.G",
                                                "emission.B", "direct.R",   "direct.G",   "direct.B",   "indirect.R",
                                                "indirect.G", "indirect.B", "weight.Y",   "records.Y"};

sl_status sl_compose(const sl_composition *parts, float *layers, sl_error *error) {
    const sl_gbuffer *g = parts->gbuffer;
    size_t pixels = (size_t)g->width * (size_t)g->height;
    float *picture = layers, *emission = layers + 3 * pixels, *direct = layers + 6 * pixels, *indirect = layers + 9 * pixels;
    const float *sums[3] = {parts->splats.r, parts->splats.g, parts->splats.b};
    const float *albedo[3] = {g->diffuse_r, g->diffuse_g, g->diffuse_b};
    for (size_t i = 0; i < pixels; i++) {
        float w = parts->splats.weight[i];
        for (int c = 0; c < 3; c++) indirect[(size_t)c * pixels + i] = w > 0.0f ? sums[c][i] / w : 0.0f;
    }
    sl_status status = sl_fill_uncovered(g->width, g->height, parts->splats.weight, parts->receives, indirect, indirect + pixels,
                                         indirect + 2 * pixels, error);
    if (status != SL_OK) return status;
    for (size_t i = 0; i < pixels; i++) {
        sl_rgb e = parts->drawn ? emission_at(parts->scene, g, i) : sl_grey(0.0f);
        const float emitted[3] = {e.r, e.g, e.b};
        for (size_t c = 0; c < 3; c++) {
            size_t at = c * pixels + i;
            indirect[at] *= parts->receives[i] ? albedo[c][i] * (float)(1.0 / SL_PI) : 0.0f;
            emission[at] = emitted[c];
            direct[at] = parts->direct[c][i];
            picture[at] = emission[at] + direct[at] + indirect[at];
        }
    }
    memcpy(layers + 12 * pixels, parts->splats.weight, pixels * sizeof *layers);
    memcpy(layers + 13 * pixels, parts->splats.count, pixels * sizeof *layers);
    return SL_OK;
}
