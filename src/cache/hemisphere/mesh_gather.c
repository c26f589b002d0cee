/* The gather: the scene's triangle ids from the point, under 160 degrees both ways; their colours;
 * times weights; summed by halving to 16 x 16, which are read back and added. Beyond 160 degrees:
 * nothing, made up for by division by the share that is seen (the loss is 2.5 % under an even sky, but all of
 * what stands lower than 10 degrees above the horizon). */
#include "cache/hemisphere/mesh_gather.h"

#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/hemisphere/hemisphere_tables.h"

enum { REDUCED = 16 }; /* pixels a side that are read back */

struct sl_mesh_gather {
    const sl_scene *scene;
    const sl_raster *raster;
    sl_lattice_colours colours;
    sl_mesh_gather_settings settings;
    sl_mesh_gather_kernel *shade;
    float tangent;                 /* of half the field of view */
    float near;
    double over_coverage;          /* 1 / C */
    float *triangle;               /* SL_MESH_GATHER_FLOATS each */
    /* tangents of the columns (and rows) of the view above; weights of its pixels */
    float *x, *weight;
    sl_gather_sky *sky;            /* NULL: no environment, or a constant one */
};

struct sl_mesh_gather_scratch {
    int size;
    uint32_t *id;
    float *planes;                 /* three of the picture, three times weights */
    float *halved, *sums;
    sl_raster_scratch *raster;
};

/* ---- making it ------------------------------------------------------------------------------- */

static void fill_triangles(sl_mesh_gather *g) {
    const sl_scene *s = g->scene;
    for (size_t t = 0; t < s->triangle_count; t++) {
        sl_vec3 p[3];
        for (int k = 0; k < 3; k++) p[k] = sl_scene_position(s, s->vertex[k][t]);
        p[1] = sl_sub(p[1], p[0]);
        p[2] = sl_sub(p[2], p[0]);
        memcpy(g->triangle + t * SL_MESH_GATHER_FLOATS, p, sizeof p);
    }
}

/* Pixels of the view above, an octant from the middle outwards: eight have the same bits. The midpoint rule
 * is off by up to 1 % for a pixel of 64 x 64 at 160 degrees. */
static void fill_weights(int size, double t, float *weight) {
    int half = size / 2;
    double step = t / half;
    for (int j = 0; j < half; j++) {
        for (int i = 0; i <= j; i++) {
            float w = (float)sl_plane_cosine_weight(i * step, (i + 1) * step, j * step, (j + 1) * step);
            for (int turn = 0; turn < 8; turn++) {
                int a = turn & 1 ? i : j, b = turn & 1 ? j : i;
                int x = turn & 2 ? half + a : half - 1 - a, y = turn & 4 ? half + b : half - 1 - b;
                weight[y * size + x] = w;
            }
        }
    }
}

static void fill_tables(sl_mesh_gather *g) {
    int n = g->settings.size;
    double t = (double)g->tangent;
    for (int i = 0; i < n; i++) g->x[i] = (float)(t * ((2.0 * i + 1.0) / n - 1.0));
    fill_weights(n, t, g->weight);
}

static sl_status make_tables(sl_mesh_gather *g, sl_error *error) {
    size_t n = (size_t)g->settings.size;
    g->triangle = sl_allocate(g->scene->triangle_count + 1, SL_MESH_GATHER_FLOATS * sizeof *g->triangle);
    g->x = sl_allocate(n, sizeof *g->x);
    g->weight = sl_allocate(n * n, sizeof *g->weight);
    if (!g->triangle || !g->x || !g->weight) return sl_fail_memory(error, "the gather's tables");
    fill_triangles(g);
    fill_tables(g);
    return sl_gather_sky_create(&g->scene->environment, 2.0 * (double)g->tangent / (double)n, &g->sky, error);
}

sl_status sl_mesh_gather_create(const sl_scene *scene, const sl_raster *raster,
                                const sl_lattice_colours *colours, const sl_mesh_gather_settings *settings,
                                sl_mesh_gather **gather, sl_error *error) {
    *gather = NULL;
    /* kernels index floats by int32_t */
    if (scene->triangle_count >= (size_t)INT32_MAX / SL_MESH_GATHER_FLOATS)
        return sl_fail(error, SL_ERROR_RESOURCES, "gather: too many triangles");
    sl_mesh_gather *g = sl_allocate(1, sizeof *g);
    if (!g) return sl_fail_memory(error, "the gather");
    *g = (sl_mesh_gather){.scene = scene,
                          .raster = raster,
                          .colours = *colours,
                          .settings = *settings,
                          .near = 1e-5f * scene->scale};
    g->shade = sl_mesh_gather_kernel_for(sl_isa_best());
    g->tangent = (float)sl_tan(0.5 * (double)settings->fov);
    double t = (double)g->tangent;
    g->over_coverage = SL_PI / sl_plane_cosine_weight(-t, t, -t, t);
    sl_status status = make_tables(g, error);
    if (status == SL_OK) *gather = g;
    else sl_mesh_gather_destroy(g);
    return status;
}

void sl_mesh_gather_destroy(sl_mesh_gather *g) {
    if (!g) return;
    sl_free(g->triangle);
    sl_free(g->x);
    sl_free(g->weight);
    sl_gather_sky_destroy(g->sky);
    sl_free(g);
}

size_t sl_mesh_gather_memory_bytes(const sl_mesh_gather *g) {
    size_t n = (size_t)g->settings.size;
    size_t floats = (g->scene->triangle_count + 1) * SL_MESH_GATHER_FLOATS + n + n * n;
    return sizeof *g + sl_gather_sky_memory_bytes(g->sky) + floats * sizeof(float);
}

sl_status sl_mesh_gather_scratch_create(const sl_mesh_gather *g, sl_mesh_gather_scratch **scratch,
                                        sl_error *error) {
    *scratch = NULL;
    sl_mesh_gather_scratch *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "a gather's scratch");
    size_t n = (size_t)g->settings.size, pixels = n * n;
    s->size = g->settings.size;
    s->id = sl_allocate(pixels, sizeof *s->id);
    s->planes = sl_allocate(6 * pixels, sizeof *s->planes);
    s->halved = sl_allocate(pixels / 2 + 1, sizeof *s->halved);
    s->sums = sl_allocate(3 * REDUCED * REDUCED, sizeof *s->sums);
    sl_status status = SL_OK;
    if (!s->id || !s->planes || !s->halved || !s->sums)
        status = sl_fail_memory(error, "a gather's pictures");
    if (status == SL_OK) status = sl_raster_scratch_create(g->raster, s->size, s->size, &s->raster, error);
    if (status == SL_OK) *scratch = s;
    else sl_mesh_gather_scratch_destroy(s);
    return status;
}

void sl_mesh_gather_scratch_destroy(sl_mesh_gather_scratch *s) {
    if (!s) return;
    sl_raster_scratch_destroy(s->raster);
    sl_free(s->id);
    sl_free(s->planes);
    sl_free(s->halved);
    sl_free(s->sums);
    sl_free(s);
}

/* ---- where it looks from, and which way up --------------------------------------------------- */

/* A gather in progress. */
typedef struct shot {
    const sl_mesh_gather *gather;
    sl_mesh_gather_scratch *scratch;
    sl_counters *counters;
    sl_vec3 eye;
    sl_frame frame;
    sl_vec3 horizon;
    uint32_t skip;
} shot;

/* Rooms have edges along the axes, and so has the frame of a wall's normal. Then a whole row of pixels comes
 * to show something else at once as the point moves (with 128 x 128 pixels a step of 4 % of all its light,
 * seen as bands). Turned by 20.9 degrees pixels change one by one; the slope is that of the golden section,
 * 0.382, since with a slope of 1/3 they would change three by three. */
sl_frame sl_mesh_gather_frame(sl_vec3 normal) {
    const float c = 0.93417236f, s = 0.35682209f;
    sl_frame f = sl_frame_from_normal(normal);
    return (sl_frame){sl_mad(sl_scale(f.x, c), s, f.y), sl_mad(sl_scale(f.y, c), -s, f.x), f.z};
}

/* A point on a crease lies in the plane of the faces beyond: it would see them edge-on, and half of what is
 * behind them. What is meant is the limit from within its own face, so the eye moves towards that face's
 * middle by a little (far enough for the near plane not to cut from the wall what the picture shows of it).
 * Where the face falls below the tangent plane (a bulge) the eye stays in the plane, so as not to dive. Where
 * it rises above it (a hollow) it is raised off the face and sees it: else it would look out through it. On a
 * flat face and a bulge it must not see its own, which it lies in. */
static void look_from(shot *s, const sl_lit_point *point, uint32_t face) {
    const sl_scene *scene = s->gather->scene;
    uint32_t triangle = face / 2;
    s->eye = point->position;
    s->skip = point->triangle != SL_NO_INDEX ? point->triangle : triangle;
    if (triangle >= scene->triangle_count) return;
    sl_vec3d middle = sl_v3d(0.0, 0.0, 0.0), p = sl_to_double(point->position), n = sl_to_double(s->horizon);
    for (int k = 0; k < 3; k++)
        middle = sl_addd(middle, sl_to_double(sl_scene_position(scene, scene->vertex[k][triangle])));
    sl_vec3d way = sl_subd(sl_scaled(middle, 1.0 / 3.0), p);
    double length = sl_lengthd(way), step = 4e-4 * (double)scene->scale;
    if (!(length > 0.0)) return;
    step = step < 0.25 * length ? step : 0.25 * length;
    way = sl_scaled(way, step / length);
    double rise = sl_dotd(way, n);
    if (rise < 0.0) way = sl_subd(way, sl_scaled(n, rise));
    if (rise > 0.02 * step) {
        s->skip = SL_NO_INDEX;
        way = sl_addd(way, sl_scaled(sl_to_double(sl_scene_geometric_normal(scene, triangle)),
                                      (face % 2 ? -0.25 : 0.25) * step));
    }
    s->eye = sl_to_float(sl_addd(p, way));
}

/* ---- the view above -------------------------------------------------------------------------- */

/* Three planes of size x size to one sum each: what is read back is added row by row. */
static void add_up(const shot *s, const float *planes, int size, double sum[3]) {
    int reduced = size < REDUCED ? size : REDUCED;
    size_t count = (size_t)reduced * (size_t)reduced;
    sl_raster_reduce(planes, size, 3, reduced, s->scratch->halved, s->scratch->sums, s->counters);
    for (size_t k = 0; k < 3; k++) {
        for (size_t i = 0; i < count; i++) sum[k] += (double)s->scratch->sums[k * count + i];
    }
}

static void gather_above(const shot *s, double sum[3]) {
    const sl_mesh_gather *g = s->gather;
    int n = g->settings.size;
    size_t plane = (size_t)n * (size_t)n;
    float t = g->tangent;
    sl_view view = sl_view_pyramid(&s->frame, s->eye, -t, t, -t, t, n, n, g->near);
    view.skip_triangle = s->skip;
    sl_target target = {.width = n, .height = n, .id = s->scratch->id};
    sl_raster_id_small(g->raster, &view, &target, s->scratch->raster, s->counters);
    sl_mesh_gather_pixels pixels = {.width = n,
                                    .height = n,
                                    .id = s->scratch->id,
                                    .x = g->x,
                                    .y = g->x,
                                    .frame = s->frame,
                                    .eye = s->eye,
                                    .horizon = s->horizon,
                                    .triangle = g->triangle,
                                    .triangle_count = (uint32_t)g->scene->triangle_count,
                                    .colours = g->colours,
                                    .weight = g->weight};
    for (size_t k = 0; k < 3; k++) {
        pixels.radiance[k] = s->scratch->planes + k * plane;
        pixels.weighted[k] = s->scratch->planes + (k + 3) * plane;
    }
    g->shade(&pixels);
    sl_gather_sky_add(g->sky, &pixels);
    sl_count(s->counters, SL_COUNT_FRAGMENTS_SHADED, plane);
    add_up(s, s->scratch->planes + 3 * plane, n, sum);
}

/* ---- all of it ------------------------------------------------------------------------------- */

static float finite(double value) { return value > 0.0 && value < 1e37 ? (float)value : 0.0f; }

sl_rgb sl_mesh_gather_take(const sl_mesh_gather *g, const sl_lit_point *point, uint32_t face,
                           sl_mesh_gather_scratch *scratch, sl_counters *counters) {
    sl_count(counters, SL_COUNT_INDIRECT_SAMPLES, 1);
    sl_vec3 normal = sl_normalize_or(point->normal, point->geometric_normal);
    if (!sl_is_finite(point->position) || !(sl_dot(normal, normal) > 0.5f)) { /* no number, no direction */
        sl_count(counters, SL_COUNT_NONFINITE, 1);
        memset(scratch->planes, 0,
               3 * (size_t)scratch->size * (size_t)scratch->size * sizeof *scratch->planes);
        return sl_grey(0.0f);
    }
    shot s = {.gather = g, .scratch = scratch, .counters = counters, .frame = sl_mesh_gather_frame(normal)};
    s.horizon = sl_normalize_or(point->geometric_normal, normal);
    look_from(&s, point, face);
    double sum[3] = {0.0, 0.0, 0.0};
    gather_above(&s, sum);
    return (sl_rgb){finite(g->over_coverage * sum[0]), finite(g->over_coverage * sum[1]),
                    finite(g->over_coverage * sum[2])};
}

void sl_mesh_gather_picture(const sl_mesh_gather_scratch *scratch, int *size, const float *planes[3]) {
    *size = scratch->size;
    for (size_t k = 0; k < 3; k++)
        planes[k] = scratch->planes + k * (size_t)scratch->size * (size_t)scratch->size;
}
