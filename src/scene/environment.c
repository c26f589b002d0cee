/* The sky: a latitude-longitude picture, every texel one constant piece of the sphere, or one constant
 * radiance.
 *
 * Sampling draws a texel with probability proportional to luminance times solid angle, first its row, then
 * its column, by inverting the cumulative sums; inside the texel directions are uniform. So pdf = P(texel) /
 * solid angle of the texel. */
#include <math.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "scene/derive.h"

/* Cosine of the polar angle at the upper edge of a row. */
static double row_edge(const sl_environment *e, int row) {
    return sl_cos(SL_PI * (double)row / (double)e->height);
}

static double solid_angle_between(const sl_environment *e, double top, double bottom) {
    return 2.0 * SL_PI / (double)e->width * (top - bottom);
}

static double texel_solid_angle(const sl_environment *e, int row) {
    return solid_angle_between(e, row_edge(e, row), row_edge(e, row + 1));
}

static sl_rgb texel_radiance(const sl_environment *e, int row, int column) {
    const float *t = e->texels + 3 * ((size_t)row * (size_t)e->width + (size_t)column);
    return (sl_rgb){t[0], t[1], t[2]};
}

/* ---- making ---------------------------------------------------------------------------------- */

static double cumulate(double *sums, int count) {
    double total = 0.0;
    for (int i = 0; i < count; i++) sums[i] = total += sums[i];
    return total;
}

/* Scales to end at exactly 1; a row without light is never chosen, so its sums only have to be valid. */
static void normalize_sums(double *sums, int count, double total) {
    for (int i = 0; i < count; i++) sums[i] = total > 0.0 ? sums[i] / total : (double)(i + 1) / (double)count;
    sums[count - 1] = 1.0;
}

/* Finds where a search among sums begins (Chen and Asau 1974). */
static void make_guide(const double *sums, int count, uint32_t *guide) {
    uint32_t i = 0;
    for (int k = 0; k < count; k++) {
        while (i + 1 < (uint32_t)count && sums[i] <= (double)k / (double)count) i++;
        guide[k] = i;
    }
}

static void make_sums(sl_environment *e) {
    for (int row = 0; row <= e->height; row++) e->row_edge[row] = row_edge(e, row);
    for (int row = 0; row < e->height; row++) {
        double *columns = e->column_cdf + (size_t)row * (size_t)e->width;
        for (int column = 0; column < e->width; column++)
            columns[column] = (double)sl_luminance(texel_radiance(e, row, column));
        double light = cumulate(columns, e->width);
        normalize_sums(columns, e->width, light);
        make_guide(columns, e->width, e->column_guide + (size_t)row * (size_t)e->width);
        e->row_cdf[row] = light * texel_solid_angle(e, row);
    }
    normalize_sums(e->row_cdf, e->height, cumulate(e->row_cdf, e->height));
    make_guide(e->row_cdf, e->height, e->row_guide);
}

static bool is_light(float value) { return value >= 0.0f && isfinite(value); }

/* A texel that is negative or not finite is no radiance: it becomes black. */
static size_t clear_what_is_not_light(sl_environment *e, bool *any) {
    size_t cleared = 0;
    for (size_t i = 0; i < 3 * (size_t)e->width * (size_t)e->height; i++) {
        if (!is_light(e->texels[i])) {
            e->texels[i] = 0.0f;
            cleared++;
        }
        *any |= e->texels[i] > 0.0f;
    }
    return cleared;
}

sl_status sl_environment_complete(sl_environment *e, size_t *repaired, sl_error *error) {
    *repaired = 0;
    if (!e->present) {
        sl_environment_release(e);
        return SL_OK;
    }
    if (e->width == 0) {
        e->height = 0;
        e->present = sl_rgb_max(e->constant) > 0.0f;
        return SL_OK;
    }
    const size_t rows = (size_t)e->height, texels = (size_t)e->width * rows;
    e->row_cdf = sl_allocate(rows, sizeof *e->row_cdf);
    e->row_guide = sl_allocate(rows, sizeof *e->row_guide);
    e->row_edge = sl_allocate(rows + 1, sizeof *e->row_edge);
    e->column_cdf = sl_allocate(texels, sizeof *e->column_cdf);
    e->column_guide = sl_allocate(texels, sizeof *e->column_guide);
    if (!e->row_cdf || !e->row_guide || !e->row_edge || !e->column_cdf || !e->column_guide)
        return sl_fail_memory(error, "the environment");
    e->present = false;
    *repaired = clear_what_is_not_light(e, &e->present);
    make_sums(e);
    return SL_OK;
}

void sl_environment_release(sl_environment *e) {
    SL_FREE_ALL(e->texels, e->row_cdf, e->column_cdf, e->row_guide, e->column_guide, e->row_edge);
    *e = (sl_environment){0};
}

/* ---- looking up ------------------------------------------------------------------------------ */

static int clamp_index(double position, int count) {
    if (!(position > 0.0)) return 0;
    return position < (double)count ? (int)position : count - 1;
}

/* direction = (sin theta sin phi, cos theta, -sin theta cos phi), phi = 2 pi (u - 1/2), theta = pi v. */
static void texel_of(const sl_environment *e, sl_vec3 d, int *row, int *column) {
    double u = sl_atan2((double)d.x, -(double)d.z) / (2.0 * SL_PI) + 0.5, v = sl_acos((double)d.y) / SL_PI;
    *row = clamp_index(v * (double)e->height, e->height);
    *column = clamp_index(u * (double)e->width, e->width);
}

sl_rgb sl_environment_radiance(const sl_environment *e, sl_vec3 direction) {
    if (!e->present) return sl_grey(0.0f);
    if (e->width == 0) return e->constant;
    int row, column;
    texel_of(e, direction, &row, &column);
    return texel_radiance(e, row, column);
}

static double probability(const double *sums, int i) { return i > 0 ? sums[i] - sums[i - 1] : sums[0]; }

static float texel_pdf(const sl_environment *e, int row, int column) {
    double chance =
        probability(e->row_cdf, row) * probability(e->column_cdf + (size_t)row * (size_t)e->width, column);
    return (float)(chance / solid_angle_between(e, e->row_edge[row], e->row_edge[row + 1]));
}

float sl_environment_pdf(const sl_environment *e, sl_vec3 direction) {
    if (!e->present) return 0.0f;
    if (e->width == 0) return (float)(0.25 / SL_PI);
    int row, column;
    texel_of(e, direction, &row, &column);
    return texel_pdf(e, row, column);
}

/* ---- sampling -------------------------------------------------------------------------------- */

/* The first i with u < sums[i]; *within: where u lies in that interval, in [0,1). */
static int invert(const double *sums, const uint32_t *guide, int count, double u, double *within) {
    int i = (int)guide[clamp_index(u * (double)count, count)];
    while (i + 1 < count && u >= sums[i]) i++;
    double start = i > 0 ? sums[i - 1] : 0.0, width = sums[i] - start;
    *within = width > 0.0 ? fmin(fmax((u - start) / width, 0.0), 1.0) : 0.5;
    return i;
}

static sl_vec3 direction_at(double u, double cosine) {
    double sine = sqrt(fmax(0.0, 1.0 - cosine * cosine)), phi = 2.0 * SL_PI * (u - 0.5);
    return sl_to_float(sl_v3d(sine * sl_sin(phi), cosine, -sine * sl_cos(phi)));
}

sl_vec3 sl_environment_sample(const sl_environment *e, float u1, float u2, sl_rgb *radiance, float *pdf) {
    if (!e->present || e->width == 0) {
        *radiance = e->present ? e->constant : sl_grey(0.0f);
        *pdf = e->present ? (float)(0.25 / SL_PI) : 0.0f;
        return direction_at((double)u2, 1.0 - 2.0 * (double)u1);
    }
    double down, across;
    int row = invert(e->row_cdf, e->row_guide, e->height, (double)u1, &down);
    const size_t first = (size_t)row * (size_t)e->width;
    int column = invert(e->column_cdf + first, e->column_guide + first, e->width, (double)u2, &across);
    *radiance = texel_radiance(e, row, column);
    *pdf = texel_pdf(e, row, column);
    /* uniform in the cosine is uniform in solid angle */
    double top = e->row_edge[row], bottom = e->row_edge[row + 1];
    return direction_at(((double)column + across) / (double)e->width, top + down * (bottom - top));
}

/* ---- splitting ------------------------------------------------------------------------------- */

/* Mean of min(Y, limit) over the sphere, Y the luminance. */
static double mean_below(const sl_environment *e, double limit) {
    double sum = 0.0;
    for (int row = 0; row < e->height; row++) {
        double line = 0.0;
        for (int column = 0; column < e->width; column++)
            line += fmin((double)sl_luminance(texel_radiance(e, row, column)), limit);
        sum += line * texel_solid_angle(e, row);
    }
    return sum / (4.0 * SL_PI);
}

/* The limit T = threshold x mean of min(Y, T): the repetition falls monotonically to it from above, since the
 * mean is concave in T. */
static double sky_limit(const sl_environment *e, double threshold) {
    enum { STEPS_MAX = 64 };
    double limit = INFINITY;
    for (int i = 0; i < STEPS_MAX; i++) {
        double next = threshold * mean_below(e, limit);
        if (next >= limit * (1.0 - 1e-4)) break;
        limit = next;
    }
    return limit;
}

/* One colour of sky and sun at every texel. The difference is what the sky leaves, so the sum is the whole
 * but for its last bit. */
static void divide_texels(const sl_environment *all, double limit, float *sky, float *sun) {
    for (size_t i = 0; i < (size_t)all->width * (size_t)all->height; i++) {
        const float *t = all->texels + 3 * i;
        double luminance = (double)sl_luminance((sl_rgb){t[0], t[1], t[2]});
        float share = luminance > limit ? (float)(limit / luminance) : 1.0f;
        for (size_t c = 3 * i; c < 3 * i + 3; c++) {
            sky[c] = all->texels[c] * share;
            sun[c] = all->texels[c] - sky[c];
        }
    }
}

static sl_status complete_part(sl_environment *part, sl_error *error) {
    size_t repaired;
    sl_status status = sl_environment_complete(part, &repaired, error);
    if (!part->present) sl_environment_release(part);
    return status;
}

sl_status sl_environment_split(const sl_environment *all, double threshold_over_mean, sl_environment *sky,
                               sl_environment *sun, sl_error *error) {
    *sky = *sun = (sl_environment){0};
    if (!all->present || all->width == 0) {
        *sky = (sl_environment){.present = all->present, .constant = all->constant};
        return SL_OK;
    }
    const size_t values = 3 * (size_t)all->width * (size_t)all->height;
    for (int k = 0; k < 2; k++) {
        *(k ? sun : sky) = (sl_environment){.present = true, .width = all->width, .height = all->height,
                                            .texels = sl_allocate(values, sizeof(float))};
    }
    sl_status status = sky->texels && sun->texels ? SL_OK : sl_fail_memory(error, "sky and sun");
    if (status == SL_OK) {
        divide_texels(all, sky_limit(all, threshold_over_mean), sky->texels, sun->texels);
        status = complete_part(sky, error);
    }
    if (status == SL_OK) status = complete_part(sun, error);
    if (status != SL_OK) {
        sl_environment_release(sky);
        sl_environment_release(sun);
    }
    return status;
}

sl_vec3 sl_environment_texel(const sl_environment *e, int row, int column, sl_rgb *radiance,
                             float *solid_angle) {
    *radiance = texel_radiance(e, row, column);
    *solid_angle = (float)texel_solid_angle(e, row);
    return direction_at(((double)column + 0.5) / (double)e->width,
                        0.5 * (row_edge(e, row) + row_edge(e, row + 1)));
}
