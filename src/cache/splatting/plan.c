/* Decides what will run: the qualities, the paths, and which passes a scene needs. Only what the plan asks
 * for is made. */
#include "cache/splatting/state.h"

#include "scene/features.h"

/* The table of options has the accuracies. */
static const struct {
    double minimum_pixels;
    double steep;           /* of films whose records belong to the view (sl_radius_rules) */
    int gather_size;        /* N x N */
    uint32_t light_samples; /* a pixel */
} by_quality[] = {
    [SL_QUALITY_DRAFT] = {6.0, 0.0, 20, 8},
    [SL_QUALITY_NORMAL] = {4.0, 0.0, 32, 16},
    [SL_QUALITY_HIGH] = {2.0, 0.2, 52, 64},
};

void sl_splat_complete(sl_settings *settings) {
    sl_settings_complete(settings);
    if (settings->gather_size == 0) settings->gather_size = by_quality[settings->quality].gather_size;
    if (settings->spp == 0) settings->spp = by_quality[settings->quality].light_samples;
    if (settings->bounces == 0) settings->bounces = 1;
}

/* At 400 x 400, accuracies tuned to equal records: in the Cornell box the Hessian's error (relative RMS)
 * is 2.6 times below the harmonic mean's; in Sponza and the room, where R_min rules over details, all metrics
 * but the minimum distance are within 10 %. */
static sl_radius_metric chosen_metric(const sl_settings *settings) {
    return settings->metric == SL_METRIC_AUTO ? SL_METRIC_HESSIAN : settings->metric;
}

/* Rays, unless asked otherwise. A raster gather sees as much for less, but as good as N x N rays it has two
 * to seven times their cells to light. */
static sl_gather_settings chosen_gather(const sl_settings *settings) {
    sl_gather_settings g = sl_gather_defaults();
    if (settings->gather != SL_GATHER_AUTO) g.kind = settings->gather;
    g.size = settings->gather_size;
    g.hit_samples = settings->hit_samples ? settings->hit_samples : 1;
    g.seed = settings->seed;
    g.all_lobes = settings->bounces > 1;
    g.emission = false; /* what the direct pass samples is black in the gather */
    return g;
}

sl_splat_plan sl_splat_plan_make(const sl_scene *scene, const sl_settings *settings) {
    sl_features features = sl_scene_features(scene);
    bool light = features.light;
    return (sl_splat_plan){
        .minimum_pixels = by_quality[settings->quality].minimum_pixels,
        .steep = by_quality[settings->quality].steep,
        .gather = chosen_gather(settings),
        .metric = chosen_metric(settings),
        .harmonics_order = settings->harmonics_order ? settings->harmonics_order : sl_glossy_order_for(scene),
        .irradiance = features.diffuse_triangles && light,
        .radiance = features.glossy_triangles && light,
        .mirrors = features.mirror_triangles && light,
        .direct = (features.diffuse_triangles || features.glossy_triangles) && light,
    };
}

/* L S* E, L (D|G) S* E, and with one bounce, as in the paper, L D (D|G) S* E; with more of them all that
 * lies between light and eye reflects with all its lobes. */
void sl_splat_transport(const sl_settings *settings, sl_transport *transport) {
    *transport = (sl_transport){
        .emission = true,
        .sky_light = true,
        .eye_mirrors = true,
        .direct_lobes = SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY,
        .receiver_lobes = SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY,
        .bounce_lobes = settings->bounces > 1 ? SL_LOBE_ALL : SL_LOBE_DIFFUSE,
        .bounces = settings->bounces ? settings->bounces : 1,
        .direct_visibility = true,
        .bounce_visibility = true,
        .filter = SL_FILTER_CENTRE,
    };
}

void sl_splat_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer) {
    sl_features f = sl_scene_features(scene);
    const sl_splat_plan plan = sl_splat_plan_make(scene, settings);
    sl_plan_pass(writer, true, "G-buffer", "%d x %d pixels, %zu triangles", settings->width, settings->height,
                 scene->triangle_count);
    sl_plan_pass(writer, f.textured_triangles > 0, "textures", "%zu textured triangles",
                 f.textured_triangles);
    sl_plan_pass(writer, f.masked_triangles > 0, "alpha masks", "%zu masked triangles", f.masked_triangles);
    bool maps = settings->direct == SL_DIRECT_SHADOW_MAPS;
    sl_plan_pass(writer, maps && plan.direct, "shadow maps", "%s",
                 maps ? "for all lights, point samples of those with extent"
                      : "direct light is found by shadow rays");
    sl_plan_pass(writer, !maps && plan.direct && (f.emitters || f.environment), "light samples",
                 "%u a pixel, fewer where all agree, more in penumbrae, towards %zu emissive triangles%s",
                 (unsigned)settings->spp, f.emitters,
                 f.environment ? " and what stands out of the environment" : "");
    sl_plan_pass(writer, f.environment, "environment in the cache",
                 "up to %g times its mean it is the gathers' background", SL_SKY_CONTRAST);
    sl_plan_pass(writer, !maps && plan.direct && scene->light_count, "delta lights",
                 "%zu lights, one shadow ray each a pixel", scene->light_count);
    static const char *const instruments[] = {"what is cheapest at the error of so many rays",
                                              "the raster plane", "the raster hemicube", "rays"};
    sl_plan_pass(writer, plan.irradiance, "irradiance records",
                 "accuracy %g, gathers %d x %d by %s", settings->accuracy, settings->gather_size,
                 settings->gather_size, instruments[settings->gather]);
    sl_plan_pass(writer, plan.radiance, "radiance records", "%zu glossy triangles%s", f.glossy_triangles,
                 plan.radiance ? ", if one is seen" : "");
    const int order = plan.harmonics_order;
    double exponent, left_out = 100.0 * sl_glossy_truncation(scene, order, &exponent);
    if (plan.radiance)
        sl_plan_pass(writer, true, "hemispherical harmonics",
                     "order %d, %d coefficients a channel; accuracy %g; %.1f %% of the sharpest "
                     "lobe (exponent %g) left out%s",
                     order, order * order, settings->glossy_accuracy, left_out, exponent,
                     left_out > 5.0 ? ": it looks blurred" : "");
    else
        sl_plan_pass(writer, false, "hemispherical harmonics", "no glossy lobe to hold");
    bool more = settings->bounces > 1;
    sl_plan_pass(writer, more && plan.direct, "second-level records", "%u bounce%s",
                 (unsigned)settings->bounces,
                 more ? "s: what gathers see receives indirect light too"
                      : ": what gathers see receives direct light alone");
    sl_plan_pass(writer, plan.mirrors, "mirrors",
                 "%zu mirror triangles, rays from the eye follow them; %s", f.mirror_triangles,
                 more ? "gathers see what they show" : "gathers see them black");
    sl_plan_pass(writer, f.emitters || f.environment, "emission", "%zu emissive triangles%s", f.emitters,
                 f.environment ? ", environment" : "");
}
