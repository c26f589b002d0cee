/* The passes that run. Only passes of the plan are drawn. */
#include "cache/direct_radiance/direct_radiance.h"
#include "cache/direct_radiance/map.h"
#include "cache/frame/budget.h"
#include "scene/features.h"

void sl_radiance_complete(sl_settings *settings) {
    sl_radiance_map_settings *m = &settings->radiance_map;
    sl_settings_complete(settings);
    /* Whole texels to a sample, and at least two each way. */
    if (m->map_size < 2 * m->samples) m->map_size = 2 * m->samples;
    m->map_size = (m->map_size + m->samples - 1) / m->samples * m->samples;
    if (m->weight == SL_WEIGHT_AUTO)
        m->weight = settings->quality == SL_QUALITY_HIGH ? SL_WEIGHT_POLYGON : SL_WEIGHT_FLUX;
    if (m->filter == SL_MAP_FILTER_AUTO) m->filter = SL_MAP_FILTER_FLUX;
}

static bool weighs_facing(sl_photon_weight weight) {
    return weight != SL_WEIGHT_EVEN && weight != SL_WEIGHT_BOX;
}

static bool has_receivers(const sl_features *f) {
    bool light = f->point_lights || f->spot_lights || f->directional_lights || f->emitters;
    return light && (f->diffuse_triangles || f->glossy_triangles);
}

sl_radiance_plan sl_radiance_plan_make(const sl_scene *scene, const sl_settings *settings) {
    const sl_radiance_map_settings *m = &settings->radiance_map;
    const sl_features f = sl_scene_features(scene);
    const bool receivers = has_receivers(&f),
               indirect = receivers && !m->local_light_only && !m->direct_light_only;
    return (sl_radiance_plan){
        .receivers = receivers,
        .shadows = receivers && !m->local_light_only,
        .map = indirect,
        .glossy = f.glossy_triangles > 0,
        .normals = indirect &&
                   (f.glossy_triangles > 0 || weighs_facing(m->weight) || m->filter == SL_MAP_FILTER_FLUX),
        .mirrors = f.mirror_triangles > 0,
        .tracer = f.mirror_triangles || (indirect && m->visibility != SL_VISIBILITY_NONE),
        .environment = f.environment,
    };
}

/* L S* E, L D S* E, L D D S* E: exactly two events that are not mirrors. The map holds light by way of
 * mirrors (L S D) too, but that is no part of the declaration: a path tracer cannot find it from a light
 * without extent. The sky is seen, directly and in mirrors, but lights nothing. */
void sl_radiance_transport(const sl_settings *settings, sl_transport *transport) {
    const sl_radiance_map_settings *m = &settings->radiance_map;
    *transport = (sl_transport){
        .emission = true,
        .sky_light = false,
        .eye_mirrors = true,
        .direct_lobes = SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY,
        .receiver_lobes = m->local_light_only || m->direct_light_only ? 0 : SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY,
        .bounce_lobes = SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY,
        .bounces = 1,
        .direct_visibility = !m->local_light_only,
        .bounce_visibility = m->visibility != SL_VISIBILITY_NONE,
        .filter = SL_FILTER_CENTRE,
    };
}

/* ---- in words ---- */

static const char *const weight_words[] = {"by quality",
                                           "(14) of the photon's flux, put right",
                                           "the photon's footprint as a polygon",
                                           "point to point",
                                           "(11)",
                                           "(14) as printed",
                                           "(15) as printed"};
static const char *const filter_words[] = {"by default", "the texel at each sample",
                                           "radiance from a MIP level", "the flux of all texels, in groups"};

static const char *why_cubes(const sl_radiance_plan *p, const sl_radiance_map_settings *m) {
    if (m->local_light_only) return "local light only";
    if (!p->receivers) return "nothing is lit";
    return "of every light: surfaces can stand before others";
}

/* Tells what the paper leaves out, as far as the scene has it. */
static void write_limits(const sl_radiance_plan *p, const sl_radiance_map_settings *m,
                         sl_plan_writer *writer) {
    if (p->environment) sl_plan_limit(writer, "the environment is seen, but lights nothing");
    if (!p->map) return;
    sl_plan_limit(writer, "one bounce: light reflected more often is not there");
    if (m->visibility == SL_VISIBILITY_NONE && p->shadows)
        sl_plan_limit(writer, "indirect light goes through walls and furniture: --visibility rays stops it");
}

void sl_radiance_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer) {
    const sl_radiance_map_settings *m = &settings->radiance_map;
    sl_features f = sl_scene_features(scene);
    sl_radiance_plan p = sl_radiance_plan_make(scene, settings);
    size_t point_like = f.point_lights + f.spot_lights + f.directional_lights;
    sl_plan_pass(writer, p.shadows, "depth cubes", "%s", why_cubes(&p, m));
    sl_plan_pass(writer, p.map, "direct radiance maps",
                 "%zu lights without extent, %zu emissive triangles; %d x %d texels a face", point_like,
                 f.emitters, m->map_size, m->map_size);
    sl_plan_pass(writer, p.map && p.glossy, "map of true colour", "%zu glossy triangles", f.glossy_triangles);
    sl_plan_pass(writer, p.map && p.normals, "map of normals", "%s",
                 p.normals ? "materials or weights ask for them" : "nothing asks for them");
    sl_plan_pass(writer, p.map, "sample photons", "%d x %d a face, %s", m->samples, m->samples,
                 filter_words[m->filter]);
    sl_plan_pass(writer, true, "G-buffer", "%d x %d pixels, %zu triangles", settings->width, settings->height,
                 scene->triangle_count);
    sl_plan_pass(writer, p.mirrors, "mirrors", "%zu mirror triangles, followed by rays", f.mirror_triangles);
    sl_plan_pass(writer, p.receivers, "direct light", "each area light from %d x %d of its points",
                 m->emitter_samples, m->emitter_samples);
    sl_plan_pass(writer, p.map, "indirect light", "weight: %s", weight_words[m->weight]);
    sl_plan_pass(writer, p.map && m->visibility != SL_VISIBILITY_NONE, "visibility of photons", "%s",
                 m->visibility == SL_VISIBILITY_NONE ? "the paper has none: no indirect shadows"
                                                     : "shadow rays");
    sl_plan_pass(writer, f.emitters || f.environment, "emission", "%zu emissive triangles%s", f.emitters,
                 f.environment ? ", environment" : "");
    write_limits(&p, m, writer);
}

/* ---- memory: pictures from the lights, for the most part ---- */

/* A picture has the order of receivers 4 and 12 layers; mirrors tell of two ways a pixel. A texel of a map:
 * 20 planes and the rasterizer's 6; while it is drawn a G-buffer's 17, which counts where a face is large. A
 * sample: four photons with their lobes, and their polygons. Texels of a depth cube are there twice while it
 * is drawn. */
enum {
    FACES = 6,
    A_PIXEL = 8,
    OF_MIRRORS = 60,
    A_TEXEL = 27 * 4,
    A_TEXEL_DRAWN = 17 * 4,
    A_SAMPLE = 512,
    A_THREAD = 2000000
};

static double smaller(double a, double b) { return a < b ? a : b; }

/* Maps and depth cubes are taken from no more points than that; a solid lamp of 12 triangles has 24 n x n. */
static double light_points(const sl_scene *scene, const sl_radiance_map_settings *m) {
    const double n = m->emitter_samples, emitters = sl_need_emitters(scene);
    const double points = n * n * emitters * (emitters > 8.0 ? 2.0 : 1.0);
    return smaller((double)scene->light_count + points, SL_MAP_LIGHTS_MAX);
}

static double map_bytes(const sl_radiance_map_settings *m, double pictures, double directional) {
    const double texels = (double)m->map_size * m->map_size, samples = (double)m->samples * m->samples;
    const double wide = (double)m->samples * sl_parallel_texels(m->samples, m->map_size / m->samples + 1);
    const double polygons =
        m->weight == SL_WEIGHT_POLYGON ? (double)SL_PHOTON_GROUPS * sizeof(sl_photon_polygon) : 0.0;
    return pictures * FACES * (texels * A_TEXEL + samples * (A_SAMPLE + polygons)) +
           directional * wide * wide * (A_TEXEL + A_TEXEL_DRAWN);
}

sl_memory_need sl_radiance_need(const sl_scene *scene, const sl_settings *settings) {
    const sl_radiance_map_settings *m = &settings->radiance_map;
    const sl_features f = sl_scene_features(scene);
    const double points = light_points(scene, m);
    const double cube = (double)m->shadow_size * m->shadow_size * FACES * sizeof(float);
    const double layers = m->without_layers ? 3.0 : SL_COMPOSED_CHANNELS,
                 triangles = (double)scene->triangle_count;
    const bool rays = m->visibility != SL_VISIBILITY_NONE || f.mirror_triangles;
    const double suns = smaller((double)f.directional_lights, SL_MAP_LIGHTS_MAX);
    return (sl_memory_need){.hierarchies = rays ? sl_tracer_memory_need(scene) +
                                                      sl_raster_memory_kept(scene->triangle_count)
                                                : sl_raster_memory_need(scene->triangle_count),
                            .caches = points * cube + map_bytes(m, points, suns) +
                                      sl_need_of_threads(settings, A_THREAD) + 8.0 * triangles + 4e6,
                            .picture = sl_need_of_pixels(
                                settings, A_PIXEL + 4.0 * layers + (f.mirror_triangles ? OF_MIRRORS : 0))};
}
