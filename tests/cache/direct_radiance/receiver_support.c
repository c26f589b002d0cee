#include "unit_test.h"
#include "receiver_support.h"

#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "trace_scenes.h"

/* ---- receivers ---- */

sl_gbuffer *make_receivers(int width, int height, sl_vec3 eye) {
    const size_t pixels = (size_t)width * (size_t)height;
    sl_gbuffer *g = NULL;
    assert_int_equal(sl_gbuffer_create(width, height, &g, NULL), SL_OK);
    g->seen_from = sl_allocate(pixels, sizeof *g->seen_from);
    assert_non_null(g->seen_from);
    for (size_t i = 0; i < pixels; i++) {
        g->seen_from[i] = eye;
        g->material[i] = g->id[i] = SL_NO_INDEX;
    }
    return g;
}

void set_receiver(sl_gbuffer *receivers, size_t i, sl_vec3 position, sl_vec3 geometric, sl_vec3 shading,
                  sl_rgb diffuse, uint32_t material) {
    sl_gbuffer *g = receivers;
    g->id[i] = 0;
    g->position_x[i] = position.x, g->position_y[i] = position.y, g->position_z[i] = position.z;
    g->geometric_x[i] = geometric.x, g->geometric_y[i] = geometric.y, g->geometric_z[i] = geometric.z;
    g->normal_x[i] = shading.x, g->normal_y[i] = shading.y, g->normal_z[i] = shading.z;
    g->diffuse_r[i] = diffuse.r, g->diffuse_g[i] = diffuse.g, g->diffuse_b[i] = diffuse.b;
    g->material[i] = material;
}

sl_scene *receiver_scene(void) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_material(&mesh, 0.3f, 0.4f, 20.0f, 0.0f, 0.0f);
    trace_mesh_material(&mesh, 0.0f, 0.0f, 0.0f, 0.8f, 0.0f);
    trace_mesh_diffuse(&mesh, 0.0f);
    trace_mesh_material(&mesh, 0.0f, 0.5f, 0.0f, 0.0f, 0.0f);
    trace_mesh_box(&mesh, sl_v3(0, 0, 0), sl_v3(1, 1, 1), true, DIFFUSE_MATERIAL);
    return trace_mesh_build(&mesh);
}

int make_receiver_scene(void **state) {
    *state = receiver_scene();
    return 0;
}

int destroy_receiver_scene(void **state) {
    sl_scene_destroy(*state);
    return 0;
}

planes make_planes(size_t count) {
    planes p = {.count = count};
    for (int c = 0; c < 3; c++) {
        p.value[c] = calloc(count, sizeof *p.value[c]);
        assert_non_null(p.value[c]);
    }
    return p;
}

void free_planes(planes *p) {
    for (int c = 0; c < 3; c++) free(p->value[c]);
}

/* ---- light ---- */

static void light_picture(const sl_light_pass *pass, const sl_gbuffer *r, sl_lit_picture *picture,
                          sl_photon_sums *sums, sl_counters *counters) {
    const sl_direct_light direct = sl_direct_light_of(pass);
    sl_tile_target to;
    for (int k = 0; k < 3; k++) {
        to.direct[k] = picture->direct[k];
        to.indirect[k] = picture->indirect[k];
    }
    for (int y = 0; y < r->height; y += SL_TILE_HEIGHT)
        sl_light_strip(sums ? NULL : &direct, sums, pass->scene, r, y, &to, counters);
}

void light_directly(const sl_light_pass *pass, const sl_gbuffer *receivers, sl_lit_picture *picture,
                    sl_counters *counters) {
    light_picture(pass, receivers, picture, NULL, counters);
}

void light_indirectly(const sl_light_pass *pass, const sl_gbuffer *receivers, sl_lit_picture *picture,
                      sl_counters *counters) {
    sl_photon_sums *sums = NULL;
    if (!pass->photons || !pass->photons->count) return;
    assert_int_equal(sl_photon_sums_create(pass, &sums, NULL), SL_OK);
    light_picture(pass, receivers, picture, sums, counters);
    sl_photon_sums_destroy(sums);
}

/* Pi / A_q at one point, by the lanes' kernel. */
static float polygon_weight(const sl_map_photons *photons, size_t photon, const sl_photon_registers *p,
                            sl_vec3 x, sl_vec3 n, sl_vec3 shading) {
    sl_light_points at = {1, &x.x, &x.y, &x.z, &n.x, &n.y, &n.z, &shading.x, &shading.y, &shading.z};
    const sl_photon_polygon *polygon = &photons->polygon[photon];
    float pi[2] = {0.0f, 0.0f};
    for (int t = 0; t < 2; t++) sl_polygon_light_baseline(&at, &polygon->triangle[t], &pi[t]);
    return sl_polygon_weight(p, polygon, x, n, pi[0] + pi[1]);
}

sl_rgb sl_photon_irradiance(const sl_map_photons *photons, size_t photon, sl_photon_weight weight, sl_vec3 x,
                            sl_vec3 n, sl_vec3 shading) {
    sl_photon_registers p;
    sl_lobe_registers lobe;
    sl_weight_form form = sl_photon_load(photons, photon, weight, &p, &lobe);
    float w = form == SL_FORM_COSINE ? sl_cosine_weight(&p, x, n, shading)
              : form == SL_FORM_DISC ? sl_disc_weight(&p, x, n, shading)
                                     : polygon_weight(photons, photon, &p, x, n, shading);
    sl_rgb e = {p.red * w, p.green * w, p.blue * w};
    if (!photons->lobe) return e;
    sl_vec3 d = sl_v3(x.x - p.x, x.y - p.y, x.z - p.z);
    float power = sl_lobe_power(lobe.x * d.x + lobe.y * d.y + lobe.z * d.z, sl_dot(d, d), lobe.exponent),
          share = w * power;
    return (sl_rgb){e.r + lobe.colour.r * share, e.g + lobe.colour.g * share, e.b + lobe.colour.b * share};
}

/* ---- photons ---- */

sl_map_photons *make_photons(size_t count, float diagonal) {
    sl_map_photons *p = calloc(1, sizeof *p);
    assert_non_null(p);
    p->count = count;
    p->photon = calloc(count, sizeof *p->photon);
    assert_non_null(p->photon);
    p->nearest = 1e-6f * diagonal;
    p->box_diagonal = diagonal;
    return p;
}

void free_photons(sl_map_photons *photons) {
    free(photons->photon);
    free(photons->lobe);
    free(photons->polygon);
    free(photons);
}

bool meet_unit_sphere(const void *context, sl_vec3d light, sl_vec3d direction, sl_vec3d *position,
                      sl_vec3d *normal) {
    double length = sl_lengthd(direction);
    sl_vec3d d = sl_scaled(direction, 1.0 / length);
    double b = sl_dotd(light, d), t = -b + sqrt(b * b - sl_dotd(light, light) + 1.0);
    *position = sl_addd(light, sl_scaled(d, t));
    *normal = sl_scaled(*position, -1.0);
    return true;
}

bool meet_unit_cube(const void *context, sl_vec3d light, sl_vec3d direction, sl_vec3d *position,
                    sl_vec3d *normal) {
    const double o[3] = {light.x, light.y, light.z}, d[3] = {direction.x, direction.y, direction.z};
    double nearest = 1e300, n[3] = {0, 0, 0};
    for (int a = 0; a < 3; a++) {
        double t = d[a] > 0.0 ? (1.0 - o[a]) / d[a] : d[a] < 0.0 ? -o[a] / d[a] : 1e300;
        if (t >= nearest) continue;
        nearest = t;
        n[0] = n[1] = n[2] = 0.0;
        n[a] = d[a] > 0.0 ? -1.0 : 1.0;
    }
    *position = sl_addd(light, sl_scaled(direction, nearest));
    *normal = sl_v3d(n[0], n[1], n[2]);
    return true;
}

bool meet_floor(const void *context, sl_vec3d light, sl_vec3d direction, sl_vec3d *position,
                sl_vec3d *normal) {
    *normal = sl_v3d(0, 0, 1);
    if (!(direction.z < 0.0)) return false;
    *position = sl_addd(light, sl_scaled(direction, -light.z / direction.z));
    position->z = 0.0;
    return fabs(position->x) <= 1.0 + 1e-9 && fabs(position->y) <= 1.0 + 1e-9;
}

/* Face 0 looks down -z. */
static sl_vec3d face_direction(int face, double s, double t) {
    switch (face) {
    case 0: return sl_v3d(s, t, -1);
    case 1: return sl_v3d(t, s, 1);
    case 2: return sl_v3d(1, s, t);
    case 3: return sl_v3d(-1, t, s);
    case 4: return sl_v3d(t, 1, s);
    default: return sl_v3d(s, -1, t);
    }
}

static double corner_angle(double x, double y) { return atan(x * y / sqrt(1.0 + x * x + y * y)); }

static double solid_angle(double x0, double y0, double x1, double y1) {
    return corner_angle(x1, y1) - corner_angle(x0, y1) - corner_angle(x1, y0) + corner_angle(x0, y0);
}

typedef struct {
    int face;
    double s0, t0, s1, t1;
} block;

static block block_at(int index, int m) {
    int face = index / (m * m), row = index / m % m, column = index % m;
    double step = 2.0 / m;
    return (block){face, -1.0 + column * step, -1.0 + row * step, -1.0 + (column + 1) * step,
                   -1.0 + (row + 1) * step};
}

static bool sample(meet_surface *meet, const void *context, sl_vec3d light, block b, sl_vec3d *y,
                   sl_vec3d *n) {
    return meet(context, light, face_direction(b.face, 0.5 * (b.s0 + b.s1), 0.5 * (b.t0 + b.t1)), y, n);
}

/* The corner rays on y's tangent plane. */
static sl_photon_polygon polygon_of(sl_vec3d light, block b, sl_vec3d y, sl_vec3d n) {
    const double s[4] = {b.s0, b.s1, b.s1, b.s0}, t[4] = {b.t0, b.t0, b.t1, b.t1};
    sl_vec3d corner[4];
    sl_vec3 rounded[4];
    double above = -sl_dotd(n, sl_subd(y, light)), farthest = 4.0 * sl_lengthd(sl_subd(y, light));
    for (int c = 0; c < 4; c++) {
        sl_vec3d d = face_direction(b.face, s[c], t[c]);
        double down = -sl_dotd(n, d), way = down > 0.0 ? above / down : -1.0;
        if (!(way > 0.0) || way * sl_lengthd(d) > farthest) return (sl_photon_polygon){.over_area = 0};
        corner[c] = sl_addd(light, sl_scaled(d, way));
        rounded[c] = sl_to_float(corner[c]);
    }
    sl_vec3d cross = sl_crossd(sl_subd(corner[2], corner[0]), sl_subd(corner[3], corner[1]));
    return sl_photon_polygon_of(rounded, sl_to_float(n), (float)(0.5 * sl_lengthd(cross)), 0.0f);
}

static void set_photon(sl_map_photons *photons, sl_vec3d light, block b, int m, double reflectance,
                       sl_vec3d y, sl_vec3d n) {
    sl_vec3d to_light = sl_subd(light, y);
    double distance = sl_lengthd(to_light), cosine = sl_dotd(n, to_light) / distance;
    double angle = solid_angle(b.s0, b.t0, b.s1, b.t1), flux = reflectance * angle / SL_PI;
    double radiance = reflectance / SL_PI * cosine / (distance * distance),
           side = 2.0 * distance * tan(SL_PI / (4.0 * m));
    photons->photon[photons->count] = (sl_map_photon){.position = sl_to_float(y),
                                                      .footprint = (float)(distance * distance * angle),
                                                      .flux = sl_grey((float)flux),
                                                      .cos_alpha = (float)cosine,
                                                      .normal = sl_to_float(n),
                                                      .printed_area = (float)(side * side / cosine),
                                                      .radiance = sl_grey((float)radiance)};
    photons->polygon[photons->count++] = polygon_of(light, b, y, n);
}

sl_map_photons *cube_photons(meet_surface *meet, const void *context, sl_vec3d light, int faces, int m,
                             double reflectance, double diagonal) {
    int count = faces * m * m;
    sl_map_photons *photons = make_photons((size_t)count, (float)diagonal);
    photons->polygon = calloc((size_t)count, sizeof *photons->polygon);
    assert_non_null(photons->polygon);
    photons->count = 0;
    for (int i = 0; i < count; i++) {
        block b = block_at(i, m);
        sl_vec3d y, n;
        if (sample(meet, context, light, b, &y, &n)) set_photon(photons, light, b, m, reflectance, y, n);
    }
    return photons;
}

double exact_irradiance(meet_surface *meet, const void *context, sl_vec3d light, int faces, int m,
                        double reflectance, sl_vec3d x, sl_vec3d n_x) {
    double sum = 0.0;
    for (int i = 0; i < faces * m * m; i++) {
        block b = block_at(i, m);
        sl_vec3d y, n;
        if (!sample(meet, context, light, b, &y, &n)) continue;
        sl_vec3d d = sl_subd(y, x);
        double squared = sl_dotd(d, d), here = sl_dotd(n_x, d), there = -sl_dotd(n, d);
        if (!(here > 0.0) || !(there > 0.0)) continue;
        sum += reflectance / SL_PI * solid_angle(b.s0, b.t0, b.s1, b.t1) * here * there / (squared * squared);
    }
    return sum;
}

double irradiance_at(const sl_map_photons *photons, sl_photon_weight weight, sl_vec3d x, sl_vec3d n) {
    double sum = 0.0;
    for (size_t j = 0; j < photons->count; j++)
        sum +=
            (double)sl_photon_irradiance(photons, j, weight, sl_to_float(x), sl_to_float(n), sl_to_float(n))
                .r;
    return sum;
}
