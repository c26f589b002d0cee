/* Where the light of a map goes: the share of the lights' flux that it holds, and the share of its photons'
 * flux that arrives anywhere. What arrives beyond all there is (more than 100 %) is light behind what ought
 * to stop it, the price of having no indirect shadows. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "drm_bench.h"

enum { SIZE = 32, WEIGHTS = 6 };

static const char *const scene_paths[] = {
    "scenes/cornell-lamp.json",          "scenes/cornell-point.json",       "scenes/mirror-balls.json",
    "scenes/generated/mirror-cave.json", "bench/scenes/dull-cave.json",     "scenes/generated/room.json",
    "scenes/generated/atrium.json",      "scenes/generated/cathedral.json", "scenes/generated/figure.json",
    "bench/scenes/sponza.json",
};

static const sl_photon_weight weights[WEIGHTS] = {SL_WEIGHT_PLAIN, SL_WEIGHT_FLUX, SL_WEIGHT_POLYGON,
                                                  SL_WEIGHT_EVEN,  SL_WEIGHT_DISC, SL_WEIGHT_BOX};

static double told(const sl_image *image, const char *key) {
    const char *text = sl_image_metadata(image, key);
    return text ? 100.0 * strtod(text, NULL) : NAN;
}

static double measure(sl_scene *scene, sl_map_shape shape, sl_photon_weight weight, const char *key,
                      bool *warned) {
    sl_settings settings = sl_settings_default();
    drm_frames f;
    settings.method = "direct-radiance";
    settings.width = settings.height = SIZE;
    settings.threads = 1;
    settings.radiance_map.shape = shape;
    settings.radiance_map.weight = weight;
    drm_frames_open(&f, scene, &settings);
    drm_frame(&f, 0);
    double value = told(f.image, key);
    const char *warning = sl_image_metadata(f.image, "softlux.warning");
    *warned = warning && strstr(warning, "weight 15");
    drm_frames_close(&f);
    return value;
}

static void scene_row(bench_report *r, const bench_options *o, const char *path) {
    char name[64];
    sl_scene *scene;
    bool warned;
    double received[WEIGHTS];
    bench_scene_name(path, name);
    if (!bench_wants(o, name) || !bench_open_scene(r, path, &scene)) return;
    double frustum = measure(scene, SL_MAP_FRUSTUM, SL_WEIGHT_PLAIN, "softlux.flux_captured", &warned);
    double all = measure(scene, SL_MAP_AUTO, SL_WEIGHT_PLAIN, "softlux.flux_captured", &warned);
    for (int i = 0; i < WEIGHTS; i++)
        received[i] = measure(scene, SL_MAP_AUTO, weights[i], "softlux.flux_received", &warned);
    bench_row(r, "%s|%.1f|%.1f|%.1f|%.1f|%.1f|%.1f|%.1f|%.1f|%s", name, frustum, all, received[0],
              received[1], received[2], received[3], received[4], received[5], warned ? "yes" : "no");
    sl_scene_destroy(scene);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/direct-radiance");
    bench_report r;
    bench_report_open(&r, &o, "drm_flux");
    bench_say(&r, "\nMaps of 4 x 4 photons a face.\n");
    bench_table(
        &r, "flux",
        "scene|one frustum holds %|all faces hold %|arrives %: plain|flux|polygon|(11)|(14)|(15)|(15) warns");
    for (size_t i = 0; i < sizeof scene_paths / sizeof *scene_paths; i++) scene_row(&r, &o, scene_paths[i]);
    bench_report_close(&r);
    return 0;
}
