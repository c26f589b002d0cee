#include "cache/frame/rims.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

/* pixels of a block, both ways; samples of a close-up, both ways */
enum { BLOCK = 8, SIDE = 880 };

/* sine and cosine of the angle whose tangent is the golden ratio's inverse */
static const double turn_sine = 0.52573111211913359, turn_cosine = 0.85065080835203993;

typedef struct close_up {
    const sl_scene *scene;
    int width, height, x0, y0; /* of the picture; the block's first pixel */
    double pixel;              /* side of one, at unit distance */
    double left, bottom;       /* of the picture */
    double centre_a, centre_b, half; /* of the window, along the turned axes */
    sl_view view;
} close_up;

static close_up close_up_of(const sl_scene *scene, int width, int height, int x0, int y0) {
    const sl_camera *camera = &scene->camera;
    const double top = sl_tan(0.5 * (double)camera->vertical_fov), pixel = 2.0 * top / height;
    close_up c = {scene, width, height, x0, y0, pixel, -0.5 * pixel * width, -top, 0.0, 0.0, 0.0, {0}};
    const double x = c.left + pixel * (x0 + BLOCK / 2), y = c.bottom + pixel * (y0 + BLOCK / 2);
    const float sine = (float)turn_sine, cosine = (float)turn_cosine;
    const sl_frame frame = {sl_add(sl_scale(camera->right, cosine), sl_scale(camera->up, sine)),
                            sl_sub(sl_scale(camera->up, cosine), sl_scale(camera->right, sine)),
                            sl_neg(camera->back)};
    c.centre_a = x * turn_cosine + y * turn_sine;
    c.centre_b = y * turn_cosine - x * turn_sine;
    c.half = 0.5 * pixel * BLOCK * (turn_cosine + turn_sine);
    c.view = sl_view_pyramid(&frame, camera->eye, (float)(c.centre_a - c.half), (float)(c.centre_a + c.half),
                             (float)(c.centre_b - c.half), (float)(c.centre_b + c.half), SIDE, SIDE,
                             1e-5f * scene->scale);
    return c;
}

/* Returns the pixel of the picture in which sample (i, j) lies; beyond the block: none. */
static size_t pixel_of(const close_up *c, int i, int j) {
    const double a = c->centre_a + c->half * ((2.0 * i + 1.0) / SIDE - 1.0),
                 b = c->centre_b + c->half * ((2.0 * j + 1.0) / SIDE - 1.0);
    const double x = (a * turn_cosine - b * turn_sine - c->left) / c->pixel,
                 y = (a * turn_sine + b * turn_cosine - c->bottom) / c->pixel;
    const bool within = x >= c->x0 && y >= c->y0 && x < c->x0 + BLOCK && y < c->y0 + BLOCK && x < c->width &&
                        y < c->height;
    return within ? (size_t)y * (size_t)c->width + (size_t)x : SIZE_MAX;
}

static bool is_mirror(const sl_scene *s, uint32_t triangle) {
    return triangle != SL_NO_INDEX && sl_material_is_mirror(sl_triangle_material(s, triangle));
}

/* Sums up what the samples see, by pixel of the block. */
static void add_samples(const close_up *c, const uint32_t *id, uint8_t *wanted,
                        double sum[BLOCK * BLOCK][4]) {
    for (int j = 0; j < SIDE; j++) {
        for (int i = 0; i < SIDE; i++) {
            const size_t pixel = pixel_of(c, i, j), width = (size_t)c->width;
            if (pixel == SIZE_MAX || !wanted[pixel]) continue;
            const uint32_t triangle = id[j * SIDE + i];
            const sl_rgb e = sl_view_emission(&c->view, c->scene, triangle, (size_t)i, (size_t)j);
            double *s = sum[(pixel / width - (size_t)c->y0) * BLOCK + pixel % width - (size_t)c->x0];
            s[0] += (double)e.r, s[1] += (double)e.g, s[2] += (double)e.b, s[3] += 1.0;
            if (is_mirror(c->scene, triangle)) wanted[pixel] = 0;
        }
    }
}

static bool is_wanted(const uint8_t *wanted, int width, int height, int x0, int y0) {
    for (int y = y0; y < y0 + BLOCK && y < height; y++) {
        for (int x = x0; x < x0 + BLOCK && x < width; x++) {
            if (wanted[(size_t)y * (size_t)width + (size_t)x]) return true;
        }
    }
    return false;
}

static void put_means(const close_up *c, const uint8_t *wanted, double sum[BLOCK * BLOCK][4],
                      float *emission) {
    for (int k = 0; k < BLOCK * BLOCK; k++) {
        const int x = c->x0 + k % BLOCK, y = c->y0 + k / BLOCK;
        if (x >= c->width || y >= c->height) continue;
        const size_t pixel = (size_t)y * (size_t)c->width + (size_t)x;
        for (size_t channel = 0; channel < 3 && wanted[pixel] && sum[k][3] > 0.0; channel++)
            emission[3 * pixel + channel] = (float)(sum[k][channel] / sum[k][3]);
    }
}

sl_status sl_rims_look(const sl_scene *scene, const sl_raster *raster, int width, int height, uint8_t *wanted,
                       float *emission, sl_counters *counters, sl_error *error) {
    uint32_t *id = sl_allocate_unset((size_t)SIDE * SIDE, sizeof *id);
    sl_status status = id ? SL_OK : sl_fail_memory(error, "a film");
    for (int y0 = 0; y0 < height && status == SL_OK; y0 += BLOCK) {
        for (int x0 = 0; x0 < width && status == SL_OK; x0 += BLOCK) {
            if (!is_wanted(wanted, width, height, x0, y0)) continue;
            const close_up c = close_up_of(scene, width, height, x0, y0);
            const sl_target target = {SIDE, SIDE, id, NULL};
            double sum[BLOCK * BLOCK][4] = {{0.0}};
            status = sl_raster_id(raster, &c.view, 1, &target, counters, error);
            if (status != SL_OK) break;
            add_samples(&c, id, wanted, sum);
            put_means(&c, wanted, sum, emission);
        }
    }
    sl_free(id);
    return status;
}
