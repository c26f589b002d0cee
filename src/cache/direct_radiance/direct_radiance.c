/* One frame of Direct Radiance Mapping, pass by pass. */
#include "cache/direct_radiance/direct_radiance.h"

#include "base/error.h"
#include "base/memory.h"
#include "cache/frame/announce.h"
#include "cache/direct_radiance/emission.h"
#include "cache/direct_radiance/light_openings.h"
#include "cache/direct_radiance/light_receivers.h"
#include "cache/direct_radiance/map_report.h"
#include "cache/direct_radiance/mirrors.h"
#include "cache/direct_radiance/plan.h"
#include "cache/direct_radiance/story.h"
#include "cache/direct_radiance/strips.h"

#include <math.h>
#include <string.h>

enum { PLANAR_MIRRORS_MAX = 64, PLANES = 10 };

typedef struct radiance_state {
    const sl_scene *scene;
    sl_settings settings;
    sl_radiance_plan plan;

    sl_raster *raster;
    sl_tracer *tracer;             /* visibility and traced mirrors alone */
    sl_mirrors *planar;

    sl_map_lights *lights, *divided; /* divided: each point of them as a light that takes pictures of its own; or NULL */
    sl_light_openings openings;    /* what stands before them */
    sl_shadow_cubes *cubes;        /* pass 1 */
    sl_radiance_map *map;          /* pass 2 */
    sl_map_photons *photons;       /* pass 3 */
    sl_report_points *points;      /* where arriving flux is measured; they stay on their triangles */
    sl_map_report report;
    sl_curved_mirrors *curved;     /* pass 4 */
    sl_receivers *receivers;       /* passes 5 and 6 */
    float *planes;                 /* of light, as large as the picture; NULL where it is drawn in strips */
    sl_radiance_layers layers;
    sl_image *image;               /* drawn in strips; NULL: handed over already, or not drawn yet */
    sl_radiance_story *story;      /* what stories of this picture share; NULL: nobody has asked */

    sl_rgb trick_albedo;           /* of curved mirrors that receive indirect light as if they were diffuse */

    bool placed;                   /* raster, tracer and planar mirrors are those of the scene as it stands */
    bool lit;                      /* passes 1 to 3 as well */
    bool drawn;                    /* receivers and layers are those of this frame */
    sl_counters counters;
    sl_announcer announcer;
} radiance_state;

static void announce_picture(radiance_state *s, const char *name, const char *source, const float *planes) {
    sl_announce(&s->announcer, name, source, s->settings.width, s->settings.height, 3, planes, true);
}

/* ---- what depends on geometry alone ---- */

static void forget_geometry(radiance_state *s) {
    sl_mirrors_destroy(s->planar);
    sl_tracer_destroy(s->tracer);
    sl_raster_destroy(s->raster);
    s->planar = NULL;
    s->tracer = NULL;
    s->raster = NULL;
    s->placed = false;
}

static bool has_curved_mirrors(const sl_scene *scene, const sl_mirrors *planar) {
    size_t mirrors = 0;
    for (size_t m = 0; m < scene->material_count; m++) mirrors += sl_material_is_mirror(&scene->materials[m]);
    if (mirrors == 0) return false;
    for (size_t t = 0; t < scene->triangle_count; t++) {
        if (sl_material_is_mirror(&scene->materials[scene->material_index[t]]) && planar->of_triangle[t] == SL_NO_INDEX) return true;
    }
    return false;
}

/* Objects that have moved, and meshes that have changed their shape, cost a walk over the vertices. */
static sl_status place(radiance_state *s, sl_error *error) {
    unsigned threads = s->settings.threads;
    sl_mirrors_destroy(s->planar);
    sl_tracer_destroy(s->tracer);
    s->planar = NULL;
    s->tracer = NULL;
    sl_status status = s->raster ? sl_raster_move(s->raster, threads, error) : sl_raster_create(s->scene, threads, &s->raster, error);
    if (status == SL_OK) status = sl_mirrors_find(s->scene, PLANAR_MIRRORS_MAX, &s->planar, error);
    if (status == SL_OK) {
        s->plan = sl_radiance_plan_make(s->scene, &s->settings, s->planar->count > 0, has_curved_mirrors(s->scene, s->planar));
        if (s->plan.tracer) status = sl_tracer_create(s->scene, threads, NULL, &s->tracer, error);
    }
    if (status == SL_OK && s->plan.curved && s->settings.radiance_map.mirror_light == SL_MIRROR_LIGHT_TRICK)
        s->trick_albedo = sl_trick_albedo(s->scene);
    s->placed = status == SL_OK;
    if (!s->placed) forget_geometry(s); /* a rasterizer that could not follow is of no use */
    return status;
}

/* ---- passes 1 to 3: what depends on the lights ---- */

static void darken(radiance_state *s) {
    sl_map_photons_destroy(s->photons);
    sl_radiance_map_destroy(s->map);
    sl_shadow_cubes_destroy(s->cubes);
    sl_map_lights_destroy(s->divided);
    sl_map_lights_destroy(s->lights);
    s->photons = NULL;
    s->map = NULL;
    s->cubes = NULL;
    s->divided = NULL;
    s->lights = NULL;
    s->lit = false;
}

/* Texel for texel, faces one above another; those of a hemicube's sides are lower. */
static void announce_map(radiance_state *s) {
    const sl_radiance_map *map = s->map;
    if (!map->face_count) return;
    int width = map->face[0].width, rows = (int)(map->texels / (size_t)width);
    if ((size_t)width * (size_t)rows != map->texels) return;
    const struct {
        const char *name;
        float *const *plane;
    } pictures[] = {{"map of positions", map->position}, {map->lambertian ? "map of radiance" : "map of true colour", map->color}, {"map of normals", map->normal}};
    for (size_t i = 0; i < sizeof pictures / sizeof pictures[0]; i++) {
        if (!pictures[i].plane[0]) continue;
        const float *const planes[3] = {pictures[i].plane[0], pictures[i].plane[1], pictures[i].plane[2]};
        sl_announce_planes(&s->announcer, pictures[i].name, "direct radiance map", width, rows, planes);
    }
}

static sl_status take_map(radiance_state *s, sl_error *error) {
    sl_radiance_map_options options = {.mirrors = s->plan.planar ? s->planar : NULL,
                                       .lambertian = !s->plan.glossy,
                                       .normals = s->plan.normals,
                                       .tracer = s->tracer,
                                       .threads = s->settings.threads};
    sl_status status = sl_map_lights_by_point(s->lights, &s->divided, error);
    const sl_map_lights *lights = s->divided ? s->divided : s->lights;
    if (status == SL_OK)
        status = sl_radiance_map_render(s->scene, s->raster, lights, &s->settings.radiance_map, &options, &s->map, &s->counters, error);
    if (status == SL_OK) announce_map(s);
    if (status == SL_OK) status = sl_map_photons_take(s->scene, s->map, &s->settings.radiance_map, &s->photons, &s->counters, error);
    if (status == SL_OK) sl_announce_photons(&s->announcer, s->photons);
    return status;
}

static sl_light_pass lighting(const radiance_state *s) {
    const sl_radiance_map_settings *m = &s->settings.radiance_map;
    return (sl_light_pass){.scene = s->scene,
                           .lights = s->lights,
                           .cubes = s->cubes,
                           .photons = s->photons,
                           .weight = m->weight,
                           .tracer = s->tracer,
                           .visibility = m->visibility,
                           .threads = s->settings.threads};
}

/* With visibility no light arrives that ought not to. */
static sl_status report_map(radiance_state *s, sl_error *error) {
    s->report = (sl_map_report){.captured = sl_radiance_maps_captured(s->map), .received = NAN,
                                .way = sl_radiance_map_mean_way(s->map), .diagonal = (double)s->scene->diagonal,
                                .openings = s->openings};
    if (s->settings.radiance_map.visibility != SL_VISIBILITY_NONE) return SL_OK;
    sl_light_pass light = lighting(s);
    sl_status status = s->points ? SL_OK : sl_report_points_spread(s->scene, &s->points, error);
    return status == SL_OK ? sl_flux_received(&light, s->points, &s->report.received, error) : status;
}

static sl_status light_up(radiance_state *s, sl_error *error) {
    const sl_radiance_map_settings *m = &s->settings.radiance_map;
    sl_status status = sl_map_lights_find(s->scene, m->emitter_samples, &s->lights, error);
    if (status == SL_OK && s->plan.shadows)
        status = sl_map_lights_find_openings(s->scene, s->raster, (unsigned)m->emitter_samples, s->settings.threads, s->lights, &s->openings,
                                             &s->counters, error);
    if (status == SL_OK && s->plan.shadows) {
        status = sl_shadow_cubes_render(s->scene, s->raster, s->lights, m->shadow_size, s->settings.threads, &s->cubes, &s->counters, error);
        sl_announce_pass(&s->announcer, "depth cubes", "shadows in (5), (9)");
    }
    if (status == SL_OK && s->plan.map) status = take_map(s, error);
    if (status == SL_OK && s->plan.map) status = report_map(s, error);
    s->lit = status == SL_OK;
    if (!s->lit) darken(s); /* what is half done would be made again over what there is */
    return status;
}

/* ---- passes 4 to 7: the picture ---- */

static sl_status make_cubes(radiance_state *s, const sl_light_pass *light, sl_error *error) {
    const sl_radiance_map_settings *m = &s->settings.radiance_map;
    sl_mirror_pass pass = {.scene = s->scene,
                           .raster = s->raster,
                           .planar = s->planar,
                           .light = light,
                           .cube_size = m->cube_size,
                           .reflections = m->reflections,
                           .indirect = m->mirror_light == SL_MIRROR_LIGHT_FULL};
    return s->plan.curved ? sl_curved_mirrors_render(&pass, s->receivers, &s->curved, &s->counters, error) : SL_OK;
}

/* Curved mirrors may receive indirect light as if they were diffuse. */
static sl_light_pass tricked(const radiance_state *s, sl_light_pass light) {
    if (s->plan.curved && s->settings.radiance_map.mirror_light == SL_MIRROR_LIGHT_TRICK) light.trick_albedo = s->trick_albedo;
    return light;
}

/* The G-buffer stays for the next frame. */
static void forget_picture(radiance_state *s) {
    sl_radiance_story_destroy(s->story);
    s->story = NULL;
    sl_curved_mirrors_destroy(s->curved);
    sl_image_destroy(s->image);
    s->curved = NULL;
    s->image = NULL;
    s->drawn = false;
}

/* Whole planes, pass by pass, are for who looks at passes, and for visibility, which asks around each pixel. */
static bool in_strips(const radiance_state *s) {
    return !s->announcer.observer && (s->settings.radiance_map.visibility == SL_VISIBILITY_NONE || !s->photons);
}

static sl_status draw_strips(radiance_state *s, sl_image **image, sl_counters *counters, sl_error *error) {
    const sl_light_pass light = tricked(s, lighting(s));
    const sl_strip_pass pass = {.raster = s->raster,
                                .outline = s->receivers,
                                .light = &light,
                                .curved = s->curved,
                                .direct = s->plan.receivers && s->lights->point_count > 0,
                                .layers = !s->settings.radiance_map.without_layers};
    return sl_radiance_draw_strips(&pass, image, counters, error);
}

static sl_status ready_planes(radiance_state *s, sl_error *error) {
    const size_t pixels = (size_t)s->settings.width * (size_t)s->settings.height;
    if (s->planes) {
        memset(s->planes, 0, PLANES * pixels * sizeof *s->planes);
        return SL_OK;
    }
    s->planes = sl_allocate(PLANES * pixels, sizeof *s->planes);
    if (!s->planes) return sl_fail_memory(error, "the picture");
    for (size_t k = 0; k < 3; k++) {
        s->layers.emission[k] = s->planes + k * pixels;
        s->layers.direct[k] = s->planes + (3 + k) * pixels;
        s->layers.indirect[k] = s->planes + (6 + k) * pixels;
    }
    s->layers.spread = s->planes + 9 * pixels;
    return SL_OK;
}

static sl_status draw_passes(radiance_state *s, sl_error *error) {
    unsigned threads = s->settings.threads;
    sl_status status = ready_planes(s, error);
    if (status != SL_OK) return status;
    sl_announce_gbuffer(&s->announcer, "importons", s->receivers->gbuffer);
    sl_add_emission(s->scene, s->receivers, threads, s->layers.emission, &s->counters);
    sl_light_pass light = lighting(s);
    sl_lit_picture picture = {{s->layers.direct[0], s->layers.direct[1], s->layers.direct[2]},
                              {s->layers.indirect[0], s->layers.indirect[1], s->layers.indirect[2]}};
    if (s->plan.receivers) status = sl_light_directly(&light, s->receivers, &picture, &s->counters, error);
    announce_picture(s, "direct light", "(5), (9)", s->layers.direct[0]);
    const sl_light_pass of_photons = tricked(s, light);
    if (status == SL_OK && s->photons)
        status = sl_light_indirectly(&of_photons, s->receivers, &picture, s->layers.spread, &s->counters, error);
    announce_picture(s, "indirect light", "(10)", s->layers.indirect[0]);
    if (status == SL_OK && s->plan.curved) {
        status = make_cubes(s, &light, error);
        if (status == SL_OK)
            sl_curved_mirrors_reflect(s->curved, s->receivers, threads, s->layers.emission, s->layers.direct, s->layers.indirect, &s->counters);
        announce_picture(s, "curved mirrors", "environment cubes", s->layers.direct[0]);
    }
    return status;
}

static sl_status draw_picture(radiance_state *s, sl_error *error) {
    const sl_radiance_map_settings *m = &s->settings.radiance_map;
    const sl_view view = sl_view_scene(s->scene, s->settings.width, s->settings.height);
    const bool strips = in_strips(s);
    sl_status status = (strips ? sl_receivers_outline : sl_receivers_render)(s->scene, s->raster, &view, s->plan.planar ? s->planar : NULL,
                                                                             m->reflections, s->settings.threads, &s->receivers,
                                                                             &s->counters, error);
    if (status != SL_OK) return status;
    if (!strips) return draw_passes(s, error);
    const sl_light_pass light = lighting(s);
    status = make_cubes(s, &light, error);
    return status == SL_OK ? draw_strips(s, &s->image, &s->counters, error) : status;
}

/* ---- the method ---- */

static void radiance_destroy(void *state) {
    radiance_state *s = state;
    if (!s) return;
    forget_picture(s);
    sl_receivers_destroy(s->receivers);
    darken(s);
    forget_geometry(s);
    sl_report_points_destroy(s->points);
    sl_free(s->planes);
    sl_free(s);
}

static sl_status radiance_create(const sl_scene *scene, const sl_settings *settings, const sl_transport *transport, void **state,
                                 sl_error *error) {
    (void)transport; /* its own: sl_radiance_transport() */
    radiance_state *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "direct radiance mapping");
    s->scene = scene;
    s->settings = *settings;
    s->announcer = (sl_announcer){.observer = settings->observer, .method = "direct-radiance", .counters = &s->counters};
    sl_status status = place(s, error);
    if (status != SL_OK) {
        radiance_destroy(s);
        return status;
    }
    *state = s;
    return SL_OK;
}

/* A whole frame: there is nothing to refine. */
static sl_status radiance_update(void *state, sl_progress *progress, sl_error *error) {
    radiance_state *s = state;
    sl_status status = s->placed ? SL_OK : place(s, error);
    if (status == SL_OK && !s->lit) status = light_up(s, error);
    forget_picture(s);
    if (status == SL_OK) status = draw_picture(s, error);
    s->drawn = status == SL_OK;
    progress->fraction = 1.0;
    progress->frame_done = progress->done = true;
    return status;
}

/* A picture of strips is handed over; who wants it again has it drawn again, and that is not counted. */
static sl_status give_picture(radiance_state *s, sl_image **image, sl_error *error) {
    sl_counters ignored = {{0}};
    if (!in_strips(s))
        return sl_radiance_compose(&s->layers, s->receivers, !s->settings.radiance_map.without_layers, s->settings.threads, image, error);
    if (!s->image) return draw_strips(s, image, &ignored, error);
    *image = s->image;
    s->image = NULL;
    return SL_OK;
}

static sl_status radiance_resolve(void *state, sl_image **image, sl_error *error) {
    radiance_state *s = state;
    sl_progress ignored;
    sl_status status = s->drawn ? SL_OK : radiance_update(s, &ignored, error);
    if (status == SL_OK) status = give_picture(s, image, error);
    if (status == SL_OK && s->map) status = sl_map_report_stamp(&s->report, s->settings.radiance_map.weight, *image, error);
    if (status == SL_OK && s->plan.environment) status = sl_warn(*image, error, "the sky is seen, but lights nothing");
    return status;
}

/* Passes 1 to 3 do not know the camera. */
static sl_status radiance_edit(void *state, unsigned changes, sl_error *error) {
    (void)error;
    radiance_state *s = state;
    forget_picture(s);
    if (changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS)) darken(s);
    if (changes & SL_CHANGED_OBJECTS) {
        s->placed = false; /* and planned anew */
        sl_report_points_follow(s->points);
    }
    if (s->placed && (changes & SL_CHANGED_LIGHTS)) s->plan.shadows = sl_radiance_has_shadows(s->scene, &s->settings); /* they may have left a convex room */
    return SL_OK;
}

static const sl_counters *radiance_counters(const void *state) { return &((const radiance_state *)state)->counters; }

static size_t radiance_memory_bytes(const void *state) {
    const radiance_state *s = state;
    const size_t pixels = (size_t)s->settings.width * (size_t)s->settings.height;
    size_t bytes = sizeof *s + (s->planes ? PLANES * pixels * sizeof *s->planes : 0);
    if (s->image) bytes += (size_t)s->image->channels * pixels * sizeof *s->image->planes;
    if (s->raster) bytes += sl_raster_memory_bytes(s->raster);
    if (s->tracer) bytes += sl_tracer_memory_bytes(s->tracer);
    if (s->cubes) bytes += sl_shadow_cubes_bytes(s->cubes);
    if (s->map) bytes += sl_radiance_map_bytes(s->map);
    if (s->photons) bytes += sl_map_photons_bytes(s->photons);
    bytes += sl_report_points_bytes(s->points) + sl_radiance_story_bytes(s->story);
    if (s->curved) bytes += sl_curved_mirrors_bytes(s->curved);
    if (s->receivers) bytes += sl_receivers_bytes(s->receivers);
    return bytes;
}

static sl_status radiance_story(void *state, int x, int y, sl_story_writer *writer, sl_error *error) {
    radiance_state *s = state;
    const sl_view view = sl_view_scene(s->scene, s->settings.width, s->settings.height);
    sl_status status = SL_OK;
    if (!s->drawn || s->settings.radiance_map.without_layers) return sl_fail(error, SL_ERROR_USAGE, "stories want a picture with its layers");
    if (!s->story) {
        const sl_light_pass light = tricked(s, lighting(s));
        status = sl_radiance_story_create(&light, s->raster, &view, s->plan.planar ? s->planar : NULL,
                                          s->settings.radiance_map.reflections, &s->story, error);
    }
    if (status == SL_OK) sl_radiance_story_tell(s->story, x, y, writer);
    return status;
}

const sl_method_class sl_direct_radiance_method = {
    .name = "direct-radiance",
    .complete = sl_radiance_complete,
    .create = radiance_create,
    .destroy = radiance_destroy,
    .update = radiance_update,
    .resolve = radiance_resolve,
    .edit = radiance_edit,
    .counters = radiance_counters,
    .memory_bytes = radiance_memory_bytes,
    .need = sl_radiance_need,
    .concessions = sl_radiance_concessions,
    .story = radiance_story,
    .transport = sl_radiance_transport,
    .plan = sl_radiance_plan_write,
    .any_transport = false,
};
