/* Photon maps: what leaves the lights, where it lands and what it carries, against closed forms; and that
 * nothing but scene and seed decides. */
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "cache/photons/photons.h"
#include "trace/bsdf.h"
#include "trace_scenes.h"
#include "scene_parts.h"

static sl_tracer *make_tracer(const sl_scene *scene, const char *config) {
    sl_tracer *tracer;
    sl_error error;
    if (sl_tracer_create(scene, 1, config, &tracer, &error) != SL_OK) fail_msg("%s", error.message);
    return tracer;
}

/* All of a run, `chunks` chunks a call. */
static sl_photon_list *trace_with(const sl_scene *scene, const sl_tracer *tracer, sl_photon_options options,
                                  size_t chunks) {
    sl_photon_list *list = NULL;
    sl_counters counters = {{0}};
    sl_error error;
    if (options.threads == 0) options.threads = 2;
    for (bool done = false; !done;) {
        sl_status status = sl_photons_trace(scene, tracer, &options, chunks, &list, &done, &counters, &error);
        if (status != SL_OK) fail_msg("%s", error.message);
    }
    assert_int_equal(counters.value[SL_COUNT_PHOTONS_STORED], list->count);
    assert_int_equal(counters.value[SL_COUNT_PHOTONS_EMITTED], list->emitted);
    for (size_t i = 0; i < list->count; i++) {
        const sl_photon *p = &list->photon[i];
        for (int c = 0; c < 3; c++)
            assert_true(isfinite(p->position[c]) && isfinite(p->flux[c]) && p->flux[c] >= 0.0f);
    }
    return list;
}

static sl_photon_list *trace_scene(const sl_scene *scene, sl_photon_options options) {
    sl_tracer *tracer = make_tracer(scene, NULL);
    sl_photon_list *list = trace_with(scene, tracer, options, SIZE_MAX);
    sl_tracer_destroy(tracer);
    return list;
}

static void destroy_list(sl_photon_list *list, sl_scene *scene) { /* and its scene */
    sl_photon_list_destroy(list);
    sl_scene_destroy(scene);
}

/* So many chunks, whatever they store. */
static sl_photon_options emitted(size_t chunks, sl_photon_store store) {
    return (sl_photon_options){
        .stored = UINT32_MAX, .emitted_at_most = chunks * SL_PHOTON_CHUNK, .store = store, .seed = 1};
}

static unsigned bounces(const sl_photon *p) { return p->flags & SL_PHOTON_BOUNCES; }
static bool is_caustic(const sl_photon *p) { return p->flags & SL_PHOTON_CAUSTIC; }

static bool same_list(const sl_photon_list *a, const sl_photon_list *b) {
    return a->count == b->count && a->emitted == b->emitted && a->cut_flux == b->cut_flux &&
           a->emitted_flux == b->emitted_flux &&
           memcmp(a->photon, b->photon, a->count * sizeof *a->photon) == 0;
}

static sl_light point_light(float x, float y, float z, sl_rgb intensity) {
    return (sl_light){
        .type = SL_LIGHT_POINT, .position = {x, y, z}, .direction = {0, -1, 0}, .intensity = intensity};
}

static void add_light(trace_mesh *mesh, sl_light light) { mesh->lights[mesh->light_count++] = light; }

/* ---- closed forms ---------------------------------------------------------------------------- */

static sl_scene *diffuse_sphere(float albedo, unsigned rings) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_sphere(&mesh, sl_v3(1, 2, 3), 2.0f, rings, 0.0f, true, trace_mesh_diffuse(&mesh, albedo));
    trace_mesh_point_light(&mesh, sl_v3(1, 2, 3), sl_grey(1.0f));
    return trace_mesh_build(&mesh);
}

static void diffuse_sphere_has_the_light_of_an_integrating_sphere(void **state) {
    const double albedos[] = {0.3, 0.5, 0.8};
    for (int a = 0; a < 3; a++) {
        double rho = albedos[a], power = 4.0 * SL_PI;
        sl_scene *scene = diffuse_sphere((float)rho, 64);
        sl_photon_list *list = trace_scene(scene, emitted(15, SL_STORE_INDIRECT));
        double n = (double)list->emitted, flux = 0.0, cosine = 0.0, upper = 0.0;
        for (size_t i = 0; i < list->count; i++) {
            const sl_photon *p = &list->photon[i];
            flux += (double)p->flux[1];
            cosine += (double)sl_dot(sl_octahedral_decode(p->direction), sl_octahedral_decode(p->normal));
            upper += p->position[1] > 2.0f ? (double)p->flux[1] : 0.0;
        }
        double count = (double)list->count, deviation = sqrt(rho / n) / (1.0 - rho);
        assert_true(fabs(count / n - rho / (1.0 - rho)) < 3.0 * deviation);
        assert_true(fabs(flux / power - rho / (1.0 - rho)) < 3.0 * deviation);
        assert_true(fabs(cosine / count - 2.0 / 3.0) < 3.0 * sqrt(1.0 / 18.0 / count) + 1e-3);
        assert_true(fabs(upper / flux - 0.5) < 3.0 * sqrt(0.25 / count)); /* uniform irradiance */
        assert_true(list->cut_flux == 0.0);
        destroy_list(list, scene);
    }
}

static sl_light spot_light(sl_rgb intensity) {
    sl_light spot = point_light(0.1f, 0.2f, -0.1f, intensity);
    spot.type = SL_LIGHT_SPOT;
    spot.direction = sl_v3(0.6f, 0.0f, 0.8f);
    spot.cos_inner = 0.9f;
    spot.cos_outer = 0.5f;
    return spot;
}

/* Sum of first hits, by channel. */
static sl_vec3d first_flux(const sl_photon_list *list) {
    sl_vec3d sum = {0, 0, 0};
    for (size_t i = 0; i < list->count; i++) {
        const float *f = list->photon[i].flux;
        if (bounces(&list->photon[i]) == 0)
            sum = sl_addd(sum, sl_v3d((double)f[0], (double)f[1], (double)f[2]));
    }
    return sum;
}

static void power_of_every_light_in_a_closed_room_arrives(void **state) {
    const sl_rgb intensity = {1.0f, 2.0f, 0.5f};
    for (int kind = 0; kind < 4; kind++) {
        trace_mesh mesh = trace_mesh_begin();
        trace_mesh_box(&mesh, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, trace_mesh_diffuse(&mesh, 0.4f));
        double extent = 4.0 * SL_PI;
        if (kind == 0) add_light(&mesh, point_light(0.3f, 0, 0, intensity));
        if (kind == 1) {
            add_light(&mesh, spot_light(intensity));
            extent = 2.0 * SL_PI * (1.0 - 0.5 * (0.9 + 0.5));
        }
        if (kind >= 2) {
            uint32_t lamp = trace_mesh_lamp(&mesh, 1.0f);
            mesh.materials[lamp].emission = intensity;
            mesh.materials[lamp].emission_two_sided = kind == 3;
            trace_mesh_quad(&mesh, sl_v3(-0.5f, 0.5f, -0.5f), sl_v3(0.8f, 0.1f, 0), sl_v3(0, 0, 0.5f), lamp);
            extent = SL_PI * sqrt(0.8 * 0.8 + 0.1 * 0.1) * 0.5 * (kind == 3 ? 2.0 : 1.0);
        }
        sl_scene *scene = trace_mesh_build(&mesh);
        sl_photon_list *list = trace_scene(scene, emitted(2, SL_STORE_ALL));
        sl_vec3d sum = first_flux(list);
        assert_true(fabs(sum.x / extent - 1.0) < 1e-5);
        assert_true(fabs(sum.y / extent - 2.0) < 1e-5);
        assert_true(fabs(sum.z / extent - 0.5) < 1e-5);
        double luminance = 0.2126 * sum.x + 0.7152 * sum.y + 0.0722 * sum.z;
        assert_true(fabs(list->emitted_flux - luminance) < 1e-5 * luminance);
        destroy_list(list, scene);
    }
}

static void lights_share_the_paths_by_power_and_the_weakest_is_not_forgotten(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_box(&mesh, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, trace_mesh_diffuse(&mesh, 0.4f));
    add_light(&mesh, point_light(0, 0, 0, (sl_rgb){0, 1, 0}));
    /* a ten-thousandth of the luminance */
    add_light(&mesh, point_light(0, 0.1f, 0, (sl_rgb){1e-4f * 0.7152f / 0.2126f, 0, 0}));
    add_light(&mesh, point_light(0, 0.2f, 0, (sl_rgb){0, 0, 0}));
    add_light(&mesh, point_light(0, 0.3f, 0, (sl_rgb){0, 0, 0.5f * 0.7152f / 0.0722f}));
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_photon_list *list = trace_scene(scene, emitted(16, SL_STORE_ALL));
    double paths[3] = {0, 0, 0}, share[3] = {1e-4, 1.0, 0.5}, luminance[3] = {0.2126, 0.7152, 0.0722};
    for (size_t i = 0; i < list->count; i++) {
        if (bounces(&list->photon[i]) > 0) continue;
        for (int c = 0; c < 3; c++) {
            if (!(list->photon[i].flux[c] > 0.0f)) continue;
            paths[c]++;
            double power = luminance[c] * (double)list->photon[i].flux[c] * (double)list->emitted;
            assert_true(fabs(power / list->emitted_flux - 1.0) < 1e-6); /* equal power, whatever the light */
        }
    }
    for (int c = 0; c < 3; c++) assert_true(fabs(paths[c] - 65536.0 * share[c] / 1.5001) <= 1.0);
    assert_true(paths[0] + paths[1] + paths[2] == 65536.0);
    destroy_list(list, scene);
}

/* Irradiance at a point of the floor, green: by the lights' own formulas. */
static double floor_irradiance(const sl_scene *scene, sl_vec3 p) {
    double sum = 0.0;
    for (size_t l = 0; l < scene->light_count; l++) {
        sl_vec3 to;
        float distance;
        sl_rgb e;
        if (sl_light_illuminate(&scene->lights[l], p, &to, &distance, &e))
            sum += (double)e.g * fmax((double)to.y, 0.0);
    }
    for (uint32_t t = 0; t < scene->emitter_count; t++) {
        for (int k = 0; k < 256; k++) {
            sl_light_sample s;
            if (emitter_point(scene, t, p, ((float)(k / 16) + 0.5f) / 16.0f,
                                  ((float)(k % 16) + 0.5f) / 16.0f, &s)) {
                sum += (double)s.radiance.g * fmax((double)s.to_light.y, 0.0) / 256.0;
            }
        }
    }
    const sl_environment *e = &scene->environment;
    if (e->present && e->width == 0) sum += SL_PI * (double)e->constant.g;
    for (int row = 0; e->present && row < e->height; row++) {
        for (int column = 0; column < e->width; column++) {
            sl_rgb radiance;
            float solid_angle;
            sl_vec3 d = sl_environment_texel(e, row, column, &radiance, &solid_angle);
            sum += (double)radiance.g * (double)solid_angle * fmax((double)d.y, 0.0);
        }
    }
    return sum;
}

/* First hits on the square [low, low + 1]^2 of the floor against the integral of irradiance over it. */
static void compare_square(const sl_scene *scene, const sl_photon_list *list, float low_x, float low_z) {
    double expected = 0.0, found = 0.0, squares = 0.0;
    enum { STEPS = 16 };
    for (int i = 0; i < STEPS * STEPS; i++) {
        float x = low_x + ((float)(i % STEPS) + 0.5f) / STEPS,
              z = low_z + ((float)(i / STEPS) + 0.5f) / STEPS;
        expected += floor_irradiance(scene, sl_v3(x, 0, z)) / (STEPS * STEPS);
    }
    for (size_t i = 0; i < list->count; i++) {
        const sl_photon *p = &list->photon[i];
        if (bounces(p) > 0 || p->position[0] < low_x || p->position[0] >= low_x + 1.0f) continue;
        if (p->position[2] < low_z || p->position[2] >= low_z + 1.0f || fabsf(p->position[1]) > 1e-4f)
            continue;
        if (!(sl_octahedral_decode(p->normal).y > 0.0f)) continue; /* the floor is lit from below as well */
        found += (double)p->flux[1];
        squares += (double)p->flux[1] * (double)p->flux[1];
    }
    assert_true(expected > 0.0);
    assert_true(fabs(found - expected) < 3.0 * sqrt(squares) + 2e-3 * expected);
    assert_true(sqrt(squares) < 0.05 * expected);
}

static void direct_irradiance_on_a_plane_is_that_of_every_kind_of_light(void **state) {
    float texels[3 * 8 * 4];
    for (int i = 0; i < 3 * 8 * 4; i++)
        texels[i] = i / 24 < 2 ? 0.5f + sl_random_unit(sl_random_key(5, 5), (uint64_t)i) : 3.0f;
    texels[3 * 10 + 1] = 40.0f;
    const sl_environment constant = {.present = true, .constant = {1.0f, 2.0f, 3.0f}};
    const sl_environment picture = {.present = true, .width = 8, .height = 4, .texels = texels};
    for (int kind = 0; kind < 6; kind++) {
        trace_mesh mesh = trace_mesh_begin();
        trace_mesh_quad(&mesh, sl_v3(-3, 0, -3), sl_v3(0, 0, 6), sl_v3(6, 0, 0),
                        trace_mesh_diffuse(&mesh, 0.5f));
        sl_light light = point_light(0.3f, 1.5f, 0.2f, (sl_rgb){1, 2, 3});
        if (kind == 1) {
            light = spot_light((sl_rgb){1, 2, 3});
            light.position.y = 2.0f;
            light.direction = sl_v3(0.0f, -0.8f, 0.6f);
        }
        if (kind == 2) {
            light.type = SL_LIGHT_DIRECTIONAL;
            light.direction = sl_v3(0.36f, -0.8f, 0.48f);
        }
        if (kind < 3) add_light(&mesh, light);
        if (kind == 3) {
            trace_mesh_quad(&mesh, sl_v3(-0.5f, 2, -0.5f), sl_v3(1, 0, 0), sl_v3(0, 0.2f, 1),
                            trace_mesh_lamp(&mesh, 4.0f));
        }
        if (kind == 4) mesh.environment = &constant;
        if (kind == 5) mesh.environment = &picture;
        sl_scene *scene = trace_mesh_build(&mesh);
        sl_photon_list *list = trace_scene(scene, emitted(24, SL_STORE_ALL));
        compare_square(scene, list, 0.0f, 0.0f);
        compare_square(scene, list, -1.5f, 0.5f);
        compare_square(scene, list, 0.8f, 1.2f);
        destroy_list(list, scene);
    }
}

/* ---- scattering ------------------------------------------------------------------------------ */

/* A closed room whose walls differ: coloured, glossy, mirroring. */
static sl_scene *motley_room(void) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t coloured = trace_mesh_diffuse(&mesh, 0.5f);
    mesh.materials[coloured].diffuse = (sl_rgb){0.8f, 0.4f, 0.2f};
    uint32_t glossy = trace_mesh_material(&mesh, 0.2f, 0.6f, 20.0f, 0, 0);
    uint32_t mirror = trace_mesh_material(&mesh, 0, 0, 0, 0.7f, 0);
    trace_mesh_quad(&mesh, sl_v3(0, 0, 0), sl_v3(0, 0, 1), sl_v3(1, 0, 0), coloured);
    trace_mesh_quad(&mesh, sl_v3(0, 1, 0), sl_v3(0, 0, 1), sl_v3(1, 0, 0), coloured);
    trace_mesh_quad(&mesh, sl_v3(0, 0, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 1), glossy);
    trace_mesh_quad(&mesh, sl_v3(1, 0, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 1), glossy);
    trace_mesh_quad(&mesh, sl_v3(0, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), mirror);
    trace_mesh_quad(&mesh, sl_v3(0, 0, 1), sl_v3(1, 0, 0), sl_v3(0, 1, 0), coloured);
    trace_mesh_point_light(&mesh, sl_v3(0.5f, 0.6f, 0.4f), sl_grey(1.0f));
    return trace_mesh_build(&mesh);
}

/* A square metre of floor whose shading normals all lean to x, in a large, almost black box, under a spot. */
static sl_scene *leaning_floor(sl_vec3 lean) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t floor = trace_mesh_diffuse(&mesh, 0.8f), black = trace_mesh_diffuse(&mesh, 1e-6f);
    trace_mesh_quad(&mesh, sl_v3(-0.5f, 0, -0.5f), sl_v3(0, 0, 1), sl_v3(1, 0, 0), floor);
    trace_mesh_box(&mesh, sl_v3(-50, -1, -50), sl_v3(50, 50, 50), true, black);
    float normals[3 * 12] = {0};
    for (int v = 0; v < 4; v++) {
        normals[3 * v] = lean.x;
        normals[3 * v + 1] = lean.y;
        normals[3 * v + 2] = lean.z;
    }
    sl_light spot = spot_light((sl_rgb){1, 1, 1});
    spot.position = sl_v3(2, 5, 0);
    spot.direction = sl_normalize_or(sl_v3(-2, -5, 0), sl_v3(0, -1, 0));
    spot.cos_inner = 0.985f;
    spot.cos_outer = 0.98f;
    const sl_scene_parts parts = {.vertex_count = mesh.vertex_count,
                                  .positions = mesh.positions,
                                  .normals = normals,
                                  .triangle_count = mesh.triangle_count,
                                  .indices = mesh.indices,
                                  .material_index = mesh.material_index,
                                  .material_count = mesh.material_count,
                                  .materials = mesh.materials,
                                  .light_count = 1,
                                  .lights = &spot};
    sl_scene *scene = scene_built(&parts);
    trace_mesh_discard(&mesh);
    return scene;
}

/* Radiance is rho/pi times the irradiance on the shading normal's plane, whatever carries it: light leaves by
 * the geometric cosine, above both planes, and the integral of that cosine over the lune is pi (1 + cos b)
 * / 2. */
static void photons_see_shading_normals_as_the_eye_does(void **state) {
    const sl_vec3 leans[] = {{0, 1, 0}, {0.6f, 0.8f, 0}, {-0.6f, 0.8f, 0}};
    for (int k = 0; k < 3; k++) {
        sl_scene *scene = leaning_floor(leans[k]);
        enum { STEPS = 64 };
        double irradiance = 0.0;
        for (int i = 0; i < STEPS * STEPS; i++) {
            sl_vec3 p = sl_v3(((float)(i % STEPS) + 0.5f) / STEPS - 0.5f, 0,
                              ((float)(i / STEPS) + 0.5f) / STEPS - 0.5f),
                    to;
            float distance;
            sl_rgb e;
            if (sl_light_illuminate(&scene->lights[0], p, &to, &distance, &e)) {
                irradiance += (double)e.g * fmax((double)sl_dot(to, leans[k]), 0.0) / (STEPS * STEPS);
            }
        }
        double expected = 0.8 * irradiance * (1.0 + (double)leans[k].y) / 2.0, sum = 0.0, squares = 0.0;
        sl_photon_list *list = trace_scene(scene, emitted(10, SL_STORE_INDIRECT));
        for (size_t i = 0; i < list->count; i++) {
            assert_int_equal(bounces(&list->photon[i]), 1);
            sum += (double)list->photon[i].flux[1];
            squares += (double)list->photon[i].flux[1] * (double)list->photon[i].flux[1];
        }
        assert_true(fabs(sum - expected) < 3.0 * sqrt(squares));
        assert_true(sqrt(squares) < 0.02 * expected);
        destroy_list(list, scene);
    }
}

static void white_room_is_cut_at_64_bounces_and_says_what_was_lost(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_box(&mesh, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, trace_mesh_diffuse(&mesh, 1.0f));
    trace_mesh_point_light(&mesh, sl_v3(0, 0, 0), sl_grey(1.0f));
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_photon_list *list = trace_scene(scene, emitted(2, SL_STORE_ALL));
    unsigned most = 0;
    for (size_t i = 0; i < list->count; i++)
        most = bounces(&list->photon[i]) > most ? bounces(&list->photon[i]) : most;
    assert_int_equal(most, 64);
    /* all that was emitted is still under way */
    assert_true(fabs(list->cut_flux / (4.0 * SL_PI) - 1.0) < 0.05);
    destroy_list(list, scene);
}

/* ---- what is stored -------------------------------------------------------------------------- */

/* A floor, and a mirror that stands on its edge. */
static sl_scene *mirror_over_floor(void) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_quad(&mesh, sl_v3(-4, 0, -4), sl_v3(0, 0, 8), sl_v3(8, 0, 0), trace_mesh_diffuse(&mesh, 0.5f));
    trace_mesh_quad(&mesh, sl_v3(2, 0.01f, -2), sl_v3(0, 0, 4), sl_v3(0, 2, 0),
                    trace_mesh_material(&mesh, 0, 0, 0, 0.8f, 0));
    trace_mesh_point_light(&mesh, sl_v3(0.5f, 1.0f, 0.0f), sl_grey(1.0f));
    return trace_mesh_build(&mesh);
}

static void caustic_photons_come_by_mirrors_alone(void **state) {
    sl_scene *scene = mirror_over_floor();
    sl_photon_list *list = trace_scene(scene, emitted(4, SL_STORE_ALL));
    size_t caustics = 0;
    for (size_t i = 0; i < list->count; i++) {
        const sl_photon *p = &list->photon[i];
        if (!is_caustic(p)) continue;
        caustics++;
        assert_int_equal(bounces(p), 1);
        assert_true(fabsf(p->position[1]) < 1e-5f);
        /* Back along its direction, past the mirror's plane, lies the light's image at (3.5, 1, 0). */
        sl_vec3 d = sl_octahedral_decode(p->direction);
        sl_vec3 to = sl_sub(sl_v3(3.5f, 1.0f, 0.0f), sl_v3(p->position[0], p->position[1], p->position[2]));
        assert_true(sl_length(sl_cross(d, to)) < 1e-3f * sl_length(to));
        assert_true(fabs((double)p->flux[0] / (4.0 * SL_PI / (double)list->emitted) - 1.0) < 1e-5);
    }
    assert_true(caustics > 300);
    destroy_list(list, scene);
}

static void storage_rules_choose_from_the_same_photons(void **state) {
    sl_scene *scenes[2] = {mirror_over_floor(), motley_room()};
    for (int s = 0; s < 2; s++) {
        sl_photon_list *all = trace_scene(scenes[s], emitted(3, SL_STORE_ALL));
        sl_photon_list *indirect = trace_scene(scenes[s], emitted(3, SL_STORE_INDIRECT));
        sl_photon_list *caustic = trace_scene(scenes[s], emitted(3, SL_STORE_CAUSTIC));
        size_t i = 0, c = 0;
        for (size_t k = 0; k < all->count; k++) {
            const sl_photon *p = &all->photon[k];
            if (bounces(p) > 0) assert_memory_equal(p, &indirect->photon[i++], sizeof *p);
            if (is_caustic(p)) assert_memory_equal(p, &caustic->photon[c++], sizeof *p);
        }
        assert_int_equal(i, indirect->count);
        assert_int_equal(c, caustic->count);
        assert_true(c > 100 && all->count > i && (s == 0 || i > c));
        sl_photon_list_destroy(all);
        sl_photon_list_destroy(indirect);
        sl_photon_list_destroy(caustic);
        sl_scene_destroy(scenes[s]);
    }
}

static void tracing_stops_with_the_chunk_that_stores_enough(void **state) {
    sl_scene *scene = diffuse_sphere(0.5f, 16);
    sl_photon_list *list = trace_scene(scene, (sl_photon_options){.stored = 30000, .seed = 3});
    assert_true(list->count >= 30000 && list->count < 30000 + 6000);
    assert_true(list->emitted % SL_PHOTON_CHUNK == 0);
    sl_photon_list *less =
        trace_scene(scene, emitted(list->emitted / SL_PHOTON_CHUNK - 1, SL_STORE_INDIRECT));
    sl_photon_options same_seed = emitted(list->emitted / SL_PHOTON_CHUNK - 1, SL_STORE_INDIRECT);
    same_seed.seed = 3;
    sl_photon_list_destroy(less);
    less = trace_scene(scene, same_seed);
    assert_true(less->count < 30000);
    assert_memory_equal(less->photon[less->count - 1].position, list->photon[less->count - 1].position, 12);
    sl_photon_list_destroy(list);
    sl_photon_list_destroy(less);
    sl_scene_destroy(scene);
}

/* ---- nothing to do --------------------------------------------------------------------------- */

static sl_photon_list *of_box(float diffuse, float mirror, float intensity, sl_photon_store store) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_box(&mesh, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true,
                   trace_mesh_material(&mesh, diffuse, 0, 0, mirror, 0));
    trace_mesh_point_light(&mesh, sl_v3(0, 0, 0), sl_grey(intensity));
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_photon_list *list = trace_scene(scene, (sl_photon_options){.stored = 1000, .store = store, .seed = 1});
    sl_scene_destroy(scene);
    return list;
}

static void nothing_is_traced_where_nothing_can_be_stored(void **state) {
    sl_photon_list *lists[] = {of_box(0.5f, 0, 0, SL_STORE_INDIRECT), of_box(0, 0, 1, SL_STORE_INDIRECT),
                               of_box(0.5f, 0, 1, SL_STORE_CAUSTIC), of_box(0, 0.9f, 1, SL_STORE_ALL),
                               of_box(0, 0, 1, SL_STORE_ALL)};
    for (int i = 0; i < 5; i++) {
        assert_int_equal(lists[i]->count, 0);
        assert_int_equal(lists[i]->emitted, 0);
        sl_photon_list_destroy(lists[i]);
    }
}

/* ---- the same everywhere --------------------------------------------------------------------- */

static sl_scene *bumpy_hall(void) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_sphere(&mesh, sl_v3(0, 0, 0), 2.0f, 40, 0.3f, true,
                      trace_mesh_material(&mesh, 0.5f, 0.3f, 10, 0, 0));
    trace_mesh_sphere(&mesh, sl_v3(0.5f, 0, 0), 0.4f, 20, 0.2f, false,
                      trace_mesh_material(&mesh, 0, 0, 0, 0.9f, 0));
    trace_mesh_quad(&mesh, sl_v3(-0.5f, 1, -0.5f), sl_v3(0.8f, 0.1f, 0), sl_v3(0, 0, 0.5f),
                    trace_mesh_lamp(&mesh, 5));
    add_light(&mesh, spot_light((sl_rgb){1, 2, 3}));
    return trace_mesh_build(&mesh);
}

static void photons_are_the_same_at_any_number_of_threads_and_calls(void **state) {
    sl_scene *scene = bumpy_hall();
    sl_tracer *tracer = make_tracer(scene, NULL);
    sl_photon_options options = {.stored = 50000, .seed = 7, .threads = 1};
    sl_photon_list *first = trace_with(scene, tracer, options, SIZE_MAX);
    for (unsigned run = 0; run < 4; run++) {
        options.threads = run == 0 ? 2 : run == 1 ? 3 : 1;
        sl_photon_list *again = trace_with(scene, tracer, options, run < 2 ? SIZE_MAX : run == 2 ? 1 : 3);
        assert_true(same_list(first, again));
        sl_photon_list_destroy(again);
    }
    options.seed = 8;
    sl_photon_list *other = trace_with(scene, tracer, options, SIZE_MAX);
    assert_false(same_list(first, other));
    sl_photon_list_destroy(other);
    sl_photon_list_destroy(first);
    sl_tracer_destroy(tracer);
    sl_scene_destroy(scene);
}

static void photons_are_the_same_on_every_instruction_set_of_embree(void **state) {
    static const char *const configs[] = {NULL, "isa=sse2", "isa=avx", "isa=avx2"};
    sl_scene *scene = bumpy_hall();
    sl_photon_list *first = NULL;
    for (int i = 0; i < 4; i++) {
        sl_tracer *tracer = make_tracer(scene, configs[i]);
        sl_photon_list *list = trace_with(scene, tracer, emitted(4, SL_STORE_ALL), SIZE_MAX);
        if (i == 0) first = list;
        else assert_true(same_list(first, list));
        if (i > 0) sl_photon_list_destroy(list);
        sl_tracer_destroy(tracer);
    }
    assert_true(first->count > 20000);
    sl_photon_list_destroy(first);
    sl_scene_destroy(scene);
}

/* ---- directions in 32 bits ------------------------------------------------------------------- */

static void directions_survive_their_32_bits(void **state) {
    double worst = 0.0;
    for (uint64_t i = 0; i < 200000; i++) {
        uint64_t key = sl_random_key(11, i);
        sl_vec3 d =
            sl_direction_around(sl_v3(0, 0, 1), 1.0f - 2.0f * sl_random_unit(key, 0), sl_random_unit(key, 1));
        sl_vec3d a = sl_to_double(d), b = sl_to_double(sl_octahedral_decode(sl_octahedral_encode(d)));
        worst = fmax(worst, sl_lengthd(sl_crossd(a, b)));
        assert_true(sl_dotd(a, b) > 0.9);
        assert_true(fabs(sl_dotd(b, b) - 1.0) < 1e-6);
    }
    assert_true(worst < 6.5e-5);
    for (int i = 0; i < 6; i++) {
        float sign = i < 3 ? 1.0f : -1.0f;
        sl_vec3 axis = sl_v3(i % 3 == 0 ? sign : 0.0f, i % 3 == 1 ? sign : 0.0f, i % 3 == 2 ? sign : 0.0f);
        sl_vec3 back = sl_octahedral_decode(sl_octahedral_encode(axis));
        assert_true(back.x == axis.x && back.y == axis.y && back.z == axis.z);
    }
}

static void what_is_no_direction_gets_one(void **state) {
    const sl_vec3 odd[] = {{0, 0, 0}, {NAN, 0, 1}, {INFINITY, 0, 0}, {1e30f, -1e30f, 1e30f}, {1e-40f, 0, 0}};
    for (int i = 0; i < 5; i++) {
        sl_vec3 d = sl_octahedral_decode(sl_octahedral_encode(odd[i]));
        assert_true(fabsf(sl_length(d) - 1.0f) < 1e-5f);
    }
    for (uint32_t code = 0; code < UINT32_MAX - 70000; code += 65111)
        assert_true(fabsf(sl_length(sl_octahedral_decode(code)) - 1.0f) < 1e-5f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(diffuse_sphere_has_the_light_of_an_integrating_sphere),
        cmocka_unit_test(power_of_every_light_in_a_closed_room_arrives),
        cmocka_unit_test(lights_share_the_paths_by_power_and_the_weakest_is_not_forgotten),
        cmocka_unit_test(direct_irradiance_on_a_plane_is_that_of_every_kind_of_light),
        cmocka_unit_test(photons_see_shading_normals_as_the_eye_does),
        cmocka_unit_test(white_room_is_cut_at_64_bounces_and_says_what_was_lost),
        cmocka_unit_test(caustic_photons_come_by_mirrors_alone),
        cmocka_unit_test(storage_rules_choose_from_the_same_photons),
        cmocka_unit_test(tracing_stops_with_the_chunk_that_stores_enough),
        cmocka_unit_test(nothing_is_traced_where_nothing_can_be_stored),
        cmocka_unit_test(photons_are_the_same_at_any_number_of_threads_and_calls),
        cmocka_unit_test(photons_are_the_same_on_every_instruction_set_of_embree),
        cmocka_unit_test(directions_survive_their_32_bits),
        cmocka_unit_test(what_is_no_direction_gets_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
