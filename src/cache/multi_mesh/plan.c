/* The plan: settings completed, the paths, and which passes a scene needs. */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include "base/math.h"
#include "scene/features.h"

typedef struct by_quality {
    int gather_size;
    double coarse_edges; /* to the diagonal of the scene's central region */
} by_quality;

/* A leaf's edges are tested in their middles, so its samples are half as far apart as its size. In the
 * Cornell box (256 x 256, normal) leaves of 16, 64 and 256 pixels differ by a tenth in error, and take
 * 29,000, 9,800 and 5,100 samples of direct light; in the room (640 x 480) 62,000, 51,000 and 46,000 for
 * leaves of 64, 144 and 256, and 4 % between their errors. Leaves of 144 pixels are sure to find shadows of
 * twelve; smaller ones are found by probes (probes.c). A coarse mesh of depth 4 instead of 3 has a third of
 * the relative squared error in the box; deeper ones do not help. Gathers of 128 x 128 pixels take twice as
 * long as those of 64 x 64. What pixels make of small bright things moves from row to row as the point moves:
 * with 64 x 64 in streaks that can be seen, and leaves are cut for their sake. */
static const by_quality qualities[] = {
    [SL_QUALITY_DRAFT] = {64, 24.0},
    [SL_QUALITY_NORMAL] = {128, 24.0},
    [SL_QUALITY_HIGH] = {128, 48.0},
};

double sl_multi_mesh_coarse_edge(const sl_scene *scene, const sl_settings *settings) {
    double chosen = settings->multi_mesh.coarse_edge;
    return chosen > 0.0
               ? chosen
               : (double)sl_scene_central_diagonal(scene) / qualities[settings->quality].coarse_edges;
}

static int power_of_two(int value) {
    int power = 1;
    while (power < value) power *= 2;
    return power;
}

/* The coarse mesh is gathered once for every bounce after the first. */
static uint32_t bounces_of(const sl_settings *settings) { return settings->bounces ? settings->bounces : 1; }

void sl_multi_mesh_complete(sl_settings *settings) {
    sl_settings_complete(settings);
    settings->multi_mesh.light_size = power_of_two(settings->multi_mesh.light_size);
    if (!settings->gather_size) settings->gather_size = qualities[settings->quality].gather_size;
    settings->gather_size = power_of_two(settings->gather_size);
    if (settings->gather_size < SL_GATHER_COLOURED_LEAST) settings->gather_size = SL_GATHER_COLOURED_LEAST;
    settings->bounces = bounces_of(settings);
}

sl_multi_mesh_plan sl_multi_mesh_plan_make(const sl_scene *scene) {
    sl_features f = sl_scene_features(scene);
    bool lights = f.point_lights || f.spot_lights || f.directional_lights || f.emitters;
    return (sl_multi_mesh_plan){
        .lights = lights,
        .direct_diffuse = lights && f.diffuse_triangles,
        .direct_specular = lights && f.glossy_triangles,
        .indirect = f.diffuse_triangles && (lights || f.environment),
        .emission = f.emitters || f.environment,
        .specular_seen = f.glossy_triangles > 0,
    };
}

/* L E, L D E, L S E, L D D E, in Heckbert's letters with S for the lobe; each bounce more adds a D. The
 * environment comes in by the gather: its light on lobes is not computed. */
void sl_multi_mesh_transport(const sl_settings *settings, sl_transport *transport) {
    *transport = (sl_transport){
        .emission = true,
        .sky_light = true,
        .eye_mirrors = false,
        .direct_lobes = SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY,
        .receiver_lobes = SL_LOBE_DIFFUSE,
        .bounce_lobes = SL_LOBE_DIFFUSE,
        .bounces = bounces_of(settings),
        .direct_visibility = true,
        .bounce_visibility = true,
        .filter = SL_FILTER_CENTRE,
    };
}

void sl_multi_mesh_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer) {
    static const char *const estimators[] = {"a frustum around the light, ratio to the closed form",
                                             "a frustum around the light", "shadow rays"};
    const sl_multi_mesh_settings *m = &settings->multi_mesh;
    sl_features f = sl_scene_features(scene);
    sl_multi_mesh_plan p = sl_multi_mesh_plan_make(scene);
    sl_plan_pass(writer, true, "identifiers, visible sizes", "%d x %d pixels, %zu triangles", settings->width,
                 settings->height, scene->triangle_count);
    sl_plan_pass(writer, true, "material: k_d", "%zu diffuse triangles", f.diffuse_triangles);
    sl_plan_pass(writer, p.specular_seen, "material: k_s", "%zu glossy triangles", f.glossy_triangles);
    sl_plan_pass(writer, p.direct_diffuse || p.direct_specular, "irradiance meshes",
                 "%zu emissive triangles, by %s of %d x %d; %zu lights without extent", f.emitters,
                 estimators[m->estimator], m->light_size, m->light_size,
                 f.point_lights + f.spot_lights + f.directional_lights);
    sl_plan_pass(writer, p.direct_diffuse, "direct diffuse mesh", "%s",
                 p.direct_diffuse ? "equation (4)"
                 : p.lights       ? "nothing is diffuse"
                                  : "there is no light");
    sl_plan_pass(writer, p.direct_specular, "direct specular mesh", "%s",
                 p.direct_specular ? "equation (6)" : p.lights ? "nothing is glossy" : "there is no light");
    sl_plan_pass(writer, p.indirect, "coarse mesh", "of all surfaces, for gathers to see");
    sl_plan_pass(writer, p.indirect, "indirect mesh", "%d x %d pixels under %.0f degrees, bounces: %u%s",
                 settings->gather_size, settings->gather_size, m->gather_fov * 180.0 / SL_PI,
                 (unsigned)settings->bounces,
                 f.environment ? ", the environment in it" : "");
    sl_plan_pass(writer, p.emission, "emission", "%zu emissive triangles%s", f.emitters,
                 f.environment ? ", environment" : "");
    sl_plan_pass(writer, false, "highlights of what bounces", "%s",
                 !f.glossy_triangles ? "nothing is glossy"
                 : f.environment
                     ? "lobes reflect lamps alone: neither the environment nor what bounces, as in the paper"
                     : "lobes reflect lamps alone, as in the paper");
    sl_plan_pass(writer, f.mirror_triangles > 0, "mirrors", "%s",
                 f.mirror_triangles ? "black: reflections are not computed" : "there are none");
}
