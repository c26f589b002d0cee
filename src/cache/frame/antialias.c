#include "cache/frame/antialias.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/frame/antialias_kernels.h"
#include "cache/frame/picture_value.h"

#include <math.h>

enum { SAMPLES = SL_EDGE_SAMPLES };

/* A grid that is turned: no edge along rows or columns falls between its lines. */
static const float sample_right[SAMPLES] = {-0.125f, 0.375f, -0.375f, 0.125f},
                   sample_up[SAMPLES] = {-0.375f, -0.125f, 0.125f, 0.375f};

struct sl_antialias {
    int width, height;
    uint32_t *ids; /* at the centres, rows from the bottom */
    uint8_t *at_edge;
    float *colour; /* of pixels at edges, mixed */
    double *right; /* of the samples of each column, on a plane at unit distance before the eye */
};

static size_t pixels_of(const sl_antialias *a) { return (size_t)a->width * (size_t)a->height; }

sl_status sl_antialias_create(int width, int height, sl_antialias **antialias, sl_error *error) {
    sl_antialias *a = *antialias = sl_allocate(1, sizeof *a);
    if (!a) return sl_fail_memory(error, "antialiasing");
    a->width = width;
    a->height = height;
    a->ids = sl_allocate_unset(pixels_of(a), sizeof *a->ids);
    a->at_edge = sl_allocate_unset(pixels_of(a), sizeof *a->at_edge);
    a->colour = sl_allocate_unset(3 * pixels_of(a), sizeof *a->colour);
    a->right = sl_allocate_unset(SAMPLES * (size_t)width, sizeof *a->right);
    if (a->ids && a->at_edge && a->colour && a->right) return SL_OK;
    sl_antialias_destroy(a);
    *antialias = NULL;
    return sl_fail_memory(error, "antialiasing");
}

void sl_antialias_destroy(sl_antialias *a) {
    if (a) SL_FREE_ALL(a->ids, a->at_edge, a->colour, a->right, a);
}

/* ---- surfaces ---- */

/* Tells whether light goes on smoothly from one triangle to the other. */
static bool is_same_surface(const sl_scene *s, uint32_t a, uint32_t b) {
    const float SMOOTH = 0.9f; /* cosine */
    if (a == b) return true;
    if (a == SL_NO_INDEX || b == SL_NO_INDEX || s->object_index[a] != s->object_index[b] ||
        s->material_index[a] != s->material_index[b])
        return false;
    const float cosine = s->geometric_normal_x[a] * s->geometric_normal_x[b] +
                         s->geometric_normal_y[a] * s->geometric_normal_y[b] +
                         s->geometric_normal_z[a] * s->geometric_normal_z[b];
    return cosine >= SMOOTH;
}

/* ---- pixels ---- */

typedef struct pass {
    const sl_antialias *a;
    const sl_scene *scene;
    const uint32_t *id; /* at the centres */
    double top; /* of the view, at unit distance */
    sl_image *picture;
} pass;

/* Rows of pictures begin at the top. */
static size_t place_of(const sl_antialias *a, size_t x, size_t row) {
    return ((size_t)a->height - 1 - row) * (size_t)a->width + x;
}

/* Tells whether it shows where an edge between two pixels lies. */
static bool is_contrast(const pass *p, size_t one, size_t other) {
    const float SEEN = 0.1f;
    for (size_t c = 0; c < 3; c++) {
        const float *plane = p->picture->planes + c * pixels_of(p->a), a = plane[one], b = plane[other];
        if (fabsf(a - b) > SEEN * (a > b ? a : b)) return true;
    }
    return false;
}

static bool is_edge(const pass *p, size_t x, size_t row, size_t other_x, size_t other_row) {
    const size_t width = (size_t)p->a->width;
    return is_contrast(p, place_of(p->a, x, row), place_of(p->a, other_x, other_row)) &&
           !is_same_surface(p->scene, p->id[row * width + x], p->id[other_row * width + other_x]);
}

/* Most pixels show the triangle that those around show. */
static void find_edges_of_row(const pass *p, size_t row) {
    const size_t width = (size_t)p->a->width;
    const uint32_t *id = p->id + row * width, *below = row ? id - width : id,
                   *above = row + 1 < (size_t)p->a->height ? id + width : id;
    uint8_t *at_edge = p->a->at_edge + row * width;
    at_edge[0] = at_edge[width - 1] = 1;
    for (size_t x = 1; x + 1 < width; x++)
        at_edge[x] = (id[x - 1] != id[x]) | (id[x + 1] != id[x]) | (below[x] != id[x]) | (above[x] != id[x]);
    for (size_t x = 0; x < width; x++) {
        const size_t left = x ? x - 1 : x, right = x + 1 < width ? x + 1 : x;
        if (!at_edge[x]) continue;
        at_edge[x] = (id[left] != id[x] && is_edge(p, x, row, left, row)) ||
                     (id[right] != id[x] && is_edge(p, x, row, right, row)) ||
                     (below[x] != id[x] && is_edge(p, x, row, x, row - 1)) ||
                     (above[x] != id[x] && is_edge(p, x, row, x, row + 1));
    }
}

/* Those that were made last: pixels side by side show the same triangles. */
enum { CONES = 64 };
typedef struct cones {
    int used[CONES]; /* the column of the last pixel that asked for it; -1: it is not made */
    uint32_t id[CONES];
    sl_edge_cone cone[CONES];
} cones;

/* The pixels around, the own one first. */
enum { AROUND = 9 };
static const int8_t around_right[AROUND] = {0, -1, 1, 0, -1, 1, 0, -1, 1},
                    around_up[AROUND] = {0, 0, 0, -1, -1, -1, 1, 1, 1};

/* Those that their centres show, the own one first; SL_NO_INDEX is one, infinitely far away. */
typedef struct candidates {
    size_t count;
    uint32_t id[AROUND];
    const sl_edge_cone *cone[AROUND];
    uint8_t surface[AROUND]; /* the first candidate that is of the same */
    uint8_t shows[AROUND];
} candidates;

static double along(sl_vec3 axis, sl_vec3d d) {
    return (double)axis.x * d.x + (double)axis.y * d.y + (double)axis.z * d.z;
}

static sl_vec3d from_eye(const sl_scene *s, uint32_t triangle, int corner) {
    const sl_vec3 at = sl_scene_position(s, s->vertex[corner][triangle]);
    const sl_camera *c = &s->camera;
    const sl_vec3d d = sl_v3d((double)at.x - (double)c->eye.x, (double)at.y - (double)c->eye.y,
                              (double)at.z - (double)c->eye.z);
    return sl_v3d(along(c->right, d), along(c->up, d), -along(c->back, d));
}

static sl_edge_cone make_cone(const sl_scene *s, uint32_t id) {
    sl_edge_cone c = {.everywhere = id == SL_NO_INDEX};
    if (c.everywhere) return c;
    const sl_vec3d p[3] = {from_eye(s, id, 0), from_eye(s, id, 1), from_eye(s, id, 2)};
    for (int k = 0; k < 3; k++) c.side[k] = sl_crossd(p[(k + 1) % 3], p[(k + 2) % 3]);
    const double volume = sl_dotd(p[0], c.side[0]);
    c.flat = volume == 0.0;
    c.inverse_volume = c.flat ? 0.0 : 1.0 / volume;
    c.masked = sl_scene_has_alpha(s, id);
    return c;
}

/* Finds or makes a triangle's; those that the pixel in column x has asked for stay where they are. */
static const sl_edge_cone *cone_of(const sl_scene *s, uint32_t id, int x, cones *last) {
    size_t slot = id % CONES;
    while (last->used[slot] == x) slot = (slot + 1) % CONES;
    if (last->used[slot] < 0 || last->id[slot] != id) last->cone[slot] = make_cone(s, id);
    last->id[slot] = id;
    last->used[slot] = x;
    return &last->cone[slot];
}

static uint8_t candidate_of(const pass *p, uint32_t id, int x, cones *last, candidates *all) {
    uint8_t k = 0, same = 0;
    while (k < all->count && all->id[k] != id) k++;
    if (k < all->count) return k;
    all->id[k] = id;
    all->cone[k] = cone_of(p->scene, id, x, last);
    all->count++;
    while (same < k && !is_same_surface(p->scene, all->id[same], id)) same++;
    all->surface[k] = same;
    return k;
}

static void find_candidates(const pass *p, int x, int y, cones *last, candidates *all) {
    const sl_antialias *a = p->a;
    const uint32_t *own = p->id + (size_t)y * (size_t)a->width + (size_t)x;
    all->count = 0;
    for (int k = 0; k < AROUND; k++) {
        const int u = x + around_right[k], v = y + around_up[k];
        const bool inside = (u >= 0) & (v >= 0) & (u < a->width) & (v < a->height);
        const uint32_t id = inside ? own[around_up[k] * a->width + around_right[k]] : *own;
        all->shows[k] = id == *own && k ? 0 : candidate_of(p, id, x, last, all);
    }
}

/* Returns which of the pixels around has the centre that is nearest to a sample, of those that show the
 * surface of candidate `seen`: the own one where it does. */
static int find_centre(const candidates *all, uint8_t seen, int sample) {
    static const uint8_t nearest[SAMPLES][AROUND - 1] = {{3, 1, 4, 2, 5, 6, 7, 8},
                                                         {2, 3, 5, 6, 8, 1, 4, 7},
                                                         {1, 6, 7, 3, 4, 2, 8, 5},
                                                         {6, 2, 8, 1, 7, 3, 5, 4}};
    if (all->surface[seen] == all->surface[0]) return 0;
    for (int k = 0; k < AROUND - 1; k++) {
        const uint8_t at = nearest[sample][k];
        if (all->surface[all->shows[at]] == all->surface[seen]) return at;
    }
    return 0;
}

/* up: of the samples of its row, on the plane at unit distance. */
static void mix_pixel(const pass *p, sl_isa isa, int x, int row, const double up[SAMPLES], cones *last) {
    const sl_antialias *a = p->a;
    const size_t pixel = (size_t)row * (size_t)a->width + (size_t)x;
    float sum[3] = {0.0f, 0.0f, 0.0f};
    uint8_t seen[SAMPLES];
    candidates all;
    find_candidates(p, x, row, last, &all);
    SL_KERNEL_OF(isa, sl_edge_see)(all.count, all.cone, a->right + SAMPLES * x, up, seen);
    for (int k = 0; k < SAMPLES; k++) {
        const int at = find_centre(&all, seen[k], k);
        const size_t from = place_of(a, (size_t)(x + around_right[at]), (size_t)(row + around_up[at]));
        for (size_t c = 0; c < 3; c++) sum[c] += p->picture->planes[c * pixels_of(a) + from];
    }
    for (size_t c = 0; c < 3; c++)
        a->colour[c * pixels_of(a) + pixel] = sl_picture_value(sum[c] * (1.0f / SAMPLES));
}

static void mix_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const pass *p = context;
    const sl_antialias *a = p->a;
    const sl_isa isa = sl_isa_best();
    cones last;
    double up[SAMPLES];
    find_edges_of_row(p, row);
    for (int k = 0; k < CONES; k++) last.used[k] = -1;
    for (int k = 0; k < SAMPLES; k++)
        up[k] = (2.0 * ((double)row + 0.5 + (double)sample_up[k]) / a->height - 1.0) * p->top;
    for (int x = 0; x < a->width; x++)
        if (a->at_edge[row * (size_t)a->width + (size_t)x]) mix_pixel(p, isa, x, (int)row, up, &last);
}

static void put_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const pass *p = context;
    const sl_antialias *a = p->a;
    for (size_t x = 0; x < (size_t)a->width; x++) {
        const size_t pixel = row * (size_t)a->width + x, place = place_of(a, x, row);
        if (!a->at_edge[pixel]) continue;
        for (size_t c = 0; c < 3; c++)
            p->picture->planes[c * pixels_of(a) + place] = a->colour[c * pixels_of(a) + pixel];
    }
}

/* right: of the view, at unit distance. */
static void place_columns(const sl_antialias *a, double right) {
    for (int x = 0; x < a->width; x++)
        for (int k = 0; k < SAMPLES; k++)
            a->right[SAMPLES * x + k] = (2.0 * (x + 0.5 + (double)sample_right[k]) / a->width - 1.0) * right;
}

sl_status sl_antialias_edges(sl_antialias *a, const sl_scene *scene, const sl_raster *raster,
                             const uint32_t *id, unsigned threads, sl_image *picture, sl_counters *counters,
                             sl_error *error) {
    const size_t rows = (size_t)a->height;
    const double top = sl_tan(0.5 * (double)scene->camera.vertical_fov);
    pass p = {a, scene, id ? id : a->ids, top, picture};
    if (!id) {
        const sl_view view = sl_view_scene(scene, a->width, a->height);
        const sl_target target = {a->width, a->height, a->ids, NULL};
        sl_status status = sl_raster_id(raster, &view, threads, &target, counters, error);
        if (status != SL_OK) return status;
    }
    place_columns(a, top * a->width / a->height);
    sl_parallel_for(threads, rows, mix_row, &p);
    sl_parallel_for(threads, rows, put_row, &p);
    size_t mixed = 0;
    for (size_t i = 0; i < pixels_of(a); i++) mixed += a->at_edge[i];
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, SAMPLES * mixed);
    return SL_OK;
}
