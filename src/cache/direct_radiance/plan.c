/* Which passes run. Only what the plan asks for is made. */
#include "cache/direct_radiance/plan.h"

#include "base/math.h"
#include "scene/features.h"

void sl_radiance_complete(sl_settings *settings) {
    sl_radiance_map_settings *m = &settings->radiance_map;
    sl_settings_complete(settings);
    /* Whole texels to a sample, and at least two each way. */
    if (m->map_size < 2 * m->samples) m->map_size = 2 * m->samples;
    m->map_size = (m->map_size + m->samples - 1) / m->samples * m->samples;
    if (m->weight == SL_WEIGHT_AUTO) m->weight = settings->quality == SL_QUALITY_HIGH ? SL_WEIGHT_POLYGON : SL_WEIGHT_FLUX;
    if (m->filter == SL_MAP_FILTER_AUTO) m->filter = SL_MAP_FILTER_FLUX;
}

static bool weighs_facing(sl_photon_weight weight) { return weight != SL_WEIGHT_EVEN && weight != SL_WEIGHT_BOX; }

static bool has_receivers(const sl_features *f) {
    bool light = f->point_lights || f->spot_lights || f->directional_lights || f->emitters;
    return light && (f->diffuse_triangles || f->glossy_triangles);
}

bool sl_radiance_has_shadows(const sl_scene *scene, const sl_settings *settings) {
    const sl_features f = sl_scene_features(scene);
    return has_receivers(&f) && !settings->radiance_map.local_light_only && sl_scene_shadow_casters(scene) != SL_NO_SHADOWS;
}

sl_radiance_plan sl_radiance_plan_make(const sl_scene *scene, const sl_settings *settings, bool planar, bool curved) {
    const sl_radiance_map_settings *m = &settings->radiance_map;
    const sl_features f = sl_scene_features(scene);
    const bool receivers = has_receivers(&f), indirect = receivers && !m->local_light_only && !m->direct_light_only;
    return (sl_radiance_plan){
        .receivers = receivers,
        .shadows = sl_radiance_has_shadows(scene, settings),
        .map = indirect,
        .glossy = f.glossy_triangles > 0,
        .normals = indirect && (f.glossy_triangles > 0 || weighs_facing(m->weight) || m->filter == SL_MAP_FILTER_FLUX),
        .planar = planar,
        .curved = curved,
        .tracer = indirect && (m->visibility != SL_VISIBILITY_NONE || (m->traced_light_mirrors && f.mirror_triangles)),
        .environment = f.environment,
    };
}

/* L S* E, L D S* E, L D D S* E: exactly two events that are not mirrors. Light by way of mirrors (L S D) is computed where the mirrors are
 * planar, but is no part of the declaration: a path tracer cannot find it from a light without extent. The sky
 * is seen, directly and in mirrors, but lights nothing. */
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

static const char *const weight_words[] = {"by quality",          "(14) of the photon's flux, put right", "the photon's footprint as a polygon",
                                           "point to point",      "(11)",                                 "(14) as printed",
                                           "(15) as printed"};
static const char *const filter_words[] = {"by default", "the texel at each sample", "radiance from a MIP level", "the flux of all texels, in groups"};

static const char *why_cubes(const sl_scene *scene, const sl_radiance_plan *p, const sl_radiance_map_settings *m) {
    static const char *const words[] = {[SL_NO_SHADOWS] = "nothing can stand before a light: it is convex, with its lights inside",
                                        [SL_SHADOWS_OF_WALLS] = "of every light: it is convex, but a light shines from outside",
                                        [SL_SHADOWS_OF_SURFACES] = "of every light: surfaces can stand before others"};
    if (m->local_light_only) return "local light only";
    return p->receivers ? words[sl_scene_shadow_casters(scene)] : "nothing is lit";
}

/* Tells what the paper leaves out, as far as the scene has it. */
static void write_limits(const sl_scene *scene, const sl_radiance_plan *p, const sl_radiance_map_settings *m, sl_plan_writer *writer) {
    if (p->environment) sl_plan_limit(writer, "the environment is seen, but lights nothing");
    if (!p->map) return;
    sl_plan_limit(writer, "one bounce: light reflected more often is not there");
    if (m->visibility == SL_VISIBILITY_NONE && sl_scene_shadow_casters(scene) == SL_SHADOWS_OF_SURFACES)
        sl_plan_limit(writer, "indirect light goes through walls and furniture: --visibility rays stops it");
}

void sl_radiance_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer) {
    const sl_radiance_map_settings *m = &settings->radiance_map;
    sl_features f = sl_scene_features(scene);
    sl_radiance_plan p = sl_radiance_plan_make(scene, settings, false, false);
    size_t point_like = f.point_lights + f.spot_lights + f.directional_lights;
    sl_plan_pass(writer, p.shadows, "depth cubes", "%s", why_cubes(scene, &p, m));
    sl_plan_pass(writer, p.map, "direct radiance maps", "%zu lights without extent, %zu emissive triangles; %d x %d texels a face",
                 point_like, f.emitters, m->map_size, m->map_size);
    sl_plan_pass(writer, p.map && p.glossy, "map of true colour", "%zu glossy triangles", f.glossy_triangles);
    sl_plan_pass(writer, p.map && p.normals, "map of normals", "%s", p.normals ? "materials or weights ask for them" : "nothing asks for them");
    sl_plan_pass(writer, p.map, "sample photons", "%d x %d a face, %s", m->samples, m->samples, filter_words[m->filter]);
    sl_plan_pass(writer, true, "G-buffer", "%d x %d pixels, %zu triangles", settings->width, settings->height, scene->triangle_count);
    sl_plan_pass(writer, f.mirror_triangles > 0, "mirrors", "%zu mirror triangles: planar ones by the mirrored scene, curved ones by cubes of %d",
                 f.mirror_triangles, m->cube_size);
    sl_plan_pass(writer, p.receivers, "direct light", "each area light from %d x %d of its points", m->emitter_samples, m->emitter_samples);
    sl_plan_pass(writer, p.map, "indirect light", "weight: %s", weight_words[m->weight]);
    sl_plan_pass(writer, p.map && m->visibility != SL_VISIBILITY_NONE, "visibility of photons", "%s",
                 m->visibility == SL_VISIBILITY_NONE ? "the paper has none: no indirect shadows" : "shadow rays");
    sl_plan_pass(writer, f.emitters || f.environment, "emission", "%zu emissive triangles%s", f.emitters,
                 f.environment ? ", environment" : "");
    write_limits(scene, &p, m, writer);
}
