#include "cache/frame/rims.h"

#include <math.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

/* pixels of a block, both ways; samples along a pixel's side, and at most along a close-up's */
enum { BLOCK = 8, SAMPLES = 80, SIDE = 12 * SAMPLES };

/* sine and cosine of the angle whose tangent is the golden ratio's inverse */
static const double turn_sine = 0.52573111211913359, turn_cosine = 0.85065080835203993;

/* Pixels of the picture, those at x1 and y1 not among them. */
typedef struct block {
    int x0, x1, y0, y1;
} block;

/* A window of the picture along the turned axes. Lengths are in pixels, from the picture's middle. */
typedef struct close_up {
    const sl_scene *scene;
    int width, height; /* of the picture */
    block block;
    double left, bottom; /* of its first sample */
    int columns, rows;   /* of samples */
    sl_view view;
} close_up;

static int samples_along(double pixels) { return (int)ceil(pixels * SAMPLES); }

static close_up close_up_of(const sl_scene *scene, int width, int height, block k) {
    const sl_camera *camera = &scene->camera;
    const double pixel = 2.0 * sl_tan(0.5 * (double)camera->vertical_fov) / height;
    const double x = 0.5 * (k.x0 + k.x1 - width), y = 0.5 * (k.y0 + k.y1 - height), w = k.x1 - k.x0,
                 h = k.y1 - k.y0;
    const int columns = samples_along(w * turn_cosine + h * turn_sine),
              rows = samples_along(w * turn_sine + h * turn_cosine);
    const double half_a = 0.5 * columns / SAMPLES, a = x * turn_cosine + y * turn_sine,
                 half_b = 0.5 * rows / SAMPLES, b = y * turn_cosine - x * turn_sine;
    const float sine = (float)turn_sine, cosine = (float)turn_cosine;
    const sl_frame frame = {sl_add(sl_scale(camera->right, cosine), sl_scale(camera->up, sine)),
                            sl_sub(sl_scale(camera->up, cosine), sl_scale(camera->right, sine)),
                            sl_neg(camera->back)};
    const sl_view view = sl_view_pyramid(&frame, camera->eye, (float)(pixel * (a - half_a)),
                                         (float)(pixel * (a + half_a)), (float)(pixel * (b - half_b)),
                                         (float)(pixel * (b + half_b)), columns, rows, 1e-5f * scene->scale);
    return (close_up){.scene = scene, .width = width, .height = height, .block = k,
                      .left = a - half_a + 0.5 / SAMPLES, .bottom = b - half_b + 0.5 / SAMPLES,
                      .columns = columns, .rows = rows, .view = view};
}

/* ---- samples of a pixel ---- */

/* Returns the first sample of a row at or behind a place. */
static int sample_behind(const close_up *c, double a) {
    return (int)fmin(fmax(ceil((a - c->left) * SAMPLES), 0.0), c->columns);
}

/* Gives where a row of samples enters the block's columns and rows of pixels, and leaves the last. */
static void find_crossings(const close_up *c, int row, int columns[BLOCK + 1], int rows[BLOCK + 1]) {
    const block *k = &c->block;
    const double b = c->bottom + (double)row / SAMPLES;
    for (int x = k->x0; x <= k->x1; x++)
        columns[x - k->x0] = sample_behind(c, (x - 0.5 * c->width + b * turn_sine) / turn_cosine);
    for (int y = k->y0; y <= k->y1; y++)
        rows[y - k->y0] = sample_behind(c, (y - 0.5 * c->height - b * turn_cosine) / turn_sine);
}

static bool is_mirror(const sl_scene *s, uint32_t triangle) {
    return triangle != SL_NO_INDEX && sl_material_is_mirror(sl_triangle_material(s, triangle));
}

/* Sums up what a run of samples sees: emission, and how many there are. A triangle shines alike all over.
 * Returns whether none is a mirror. */
static bool add_run(const close_up *c, const uint32_t *id, int first, int end, int row, double sum[4]) {
    for (int i = first, next; i < end; i = next) {
        const uint32_t triangle = id[i];
        for (next = i + 1; next < end && triangle != SL_NO_INDEX && id[next] == triangle;) next++;
        if (is_mirror(c->scene, triangle)) return false;
        const sl_rgb e = sl_view_emission(&c->view, c->scene, triangle, (size_t)i, (size_t)row);
        const double count = next - i;
        sum[0] += count * (double)e.r, sum[1] += count * (double)e.g, sum[2] += count * (double)e.b;
        sum[3] += count;
    }
    return true;
}

/* Sums up what a row of samples sees, by pixel of the block. */
static void add_row(const close_up *c, int row, const uint32_t *id, uint8_t *wanted,
                    double sum[BLOCK][BLOCK][4]) {
    const block *k = &c->block;
    int columns[BLOCK + 1], rows[BLOCK + 1];
    find_crossings(c, row, columns, rows);
    for (int y = 0; y < k->y1 - k->y0; y++) {
        uint8_t *w = wanted + (size_t)(k->y0 + y) * (size_t)c->width + k->x0;
        for (int x = 0; x < k->x1 - k->x0; x++) {
            const int first = sl_greater(columns[x], rows[y]), end = sl_lesser(columns[x + 1], rows[y + 1]);
            w[x] = w[x] && add_run(c, id, first, end, row, sum[y][x]);
        }
    }
}

static void put_means(const close_up *c, const uint8_t *wanted, double sum[BLOCK][BLOCK][4],
                      float *emission) {
    const block *k = &c->block;
    for (int y = k->y0; y < k->y1; y++) {
        for (int x = k->x0; x < k->x1; x++) {
            const size_t pixel = (size_t)y * (size_t)c->width + (size_t)x;
            const double *s = sum[y - k->y0][x - k->x0];
            for (size_t channel = 0; channel < 3 && wanted[pixel] && s[3] > 0.0; channel++)
                emission[3 * pixel + channel] = (float)(s[channel] / s[3]);
        }
    }
}

/* ---- blocks ---- */

/* Returns the least block that holds the wanted pixels of one; empty where there are none. */
static block wanted_block(const uint8_t *wanted, int width, block all) {
    block k = {all.x1, all.x0, all.y1, all.y0};
    for (int y = all.y0; y < all.y1; y++) {
        for (int x = all.x0; x < all.x1; x++) {
            if (!wanted[(size_t)y * (size_t)width + (size_t)x]) continue;
            k.x0 = sl_lesser(k.x0, x), k.x1 = sl_greater(k.x1, x + 1);
            k.y0 = sl_lesser(k.y0, y), k.y1 = sl_greater(k.y1, y + 1);
        }
    }
    return k;
}

static sl_status look_at(const close_up *c, const sl_raster *raster, uint32_t *id, uint8_t *wanted,
                         float *emission, sl_counters *counters, sl_error *error) {
    const sl_target target = {c->columns, c->rows, id, NULL};
    double sum[BLOCK][BLOCK][4] = {{{0.0}}};
    const sl_status status = sl_raster_id(raster, &c->view, 1, &target, counters, error);
    if (status != SL_OK) return status;
    for (int row = 0; row < c->rows; row++)
        add_row(c, row, id + (size_t)row * (size_t)c->columns, wanted, sum);
    put_means(c, wanted, sum, emission);
    return SL_OK;
}

sl_status sl_rims_look(const sl_scene *scene, const sl_raster *raster, int width, int height, uint8_t *wanted,
                       float *emission, sl_counters *counters, sl_error *error) {
    uint32_t *id = sl_allocate_unset((size_t)SIDE * SIDE, sizeof *id);
    sl_status status = id ? SL_OK : sl_fail_memory(error, "a film");
    for (int y = 0; y < height && status == SL_OK; y += BLOCK) {
        for (int x = 0; x < width && status == SL_OK; x += BLOCK) {
            const block all = {x, sl_lesser(x + BLOCK, width), y, sl_lesser(y + BLOCK, height)},
                        k = wanted_block(wanted, width, all);
            if (k.x0 >= k.x1) continue;
            const close_up c = close_up_of(scene, width, height, k);
            status = look_at(&c, raster, id, wanted, emission, counters, error);
        }
    }
    sl_free(id);
    return status;
}
