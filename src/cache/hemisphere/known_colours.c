#include "cache/hemisphere/gather_internal.h"

#include "base/counters.h"
#include "base/math.h"
#include "base/octahedral.h"

/* Rooms have edges along the axes, and so has the frame of a wall's normal. Then a whole row of pixels comes
 * to show something else at once as the point moves (with 128 x 128 pixels a step of 4 % of all its light,
 * seen as bands). Turned by 20.9 degrees pixels change one by one; the slope is that of the golden section,
 * 0.382, since with a slope of 1/3 they would change three by three. */
sl_frame sl_known_colours_frame(sl_vec3 normal) {
    const float c = 0.93417236f, s = 0.35682209f;
    sl_frame f = sl_frame_from_normal(normal);
    return (sl_frame){sl_mad(sl_scale(f.x, c), s, f.y), sl_mad(sl_scale(f.y, c), -s, f.x), f.z};
}

/* ---- an environment that is a picture ---- */

/* In the middle of a gather of 128 x 128 a pixel is 5 degrees wide. Looked up by the directions of pixels
 * alone, a sun would be seen by one of them, or by none. So the environment is averaged over the texels of an
 * octahedral texture, 1.4 times as wide as that pixel, and read linearly between them: then neighbouring
 * pixels share the sun in proportion to how near they are to it, and its light is kept, within 6 % (root mean
 * square, a sun of 3 degrees under 128 x 128 pixels), but moves to the texel's middle. */
enum { TEXELS_MAX = 512, SAMPLES_MAX = 64 };

/* Gives the mean over a texel of 2 / size, weighted by solid angle, at as many points as make one of each of
 * the environment's texels. */
static void average_texel(const sl_environment *environment, int size, int x, int y, int samples,
                          float rgba[4]) {
    double sum[3] = {0.0, 0.0, 0.0}, angle = 0.0;
    for (int k = 0; k < samples * samples; k++) {
        float u = (float)(2.0 * (x + (k % samples + 0.5) / samples) / size - 1.0),
              v = (float)(2.0 * (y + (k / samples + 0.5) / samples) / size - 1.0);
        sl_vec3 p = sl_octahedral_point(u, v);
        sl_rgb radiance = sl_environment_radiance(environment, sl_normalize_or(p, sl_v3(0.0f, 0.0f, 1.0f)));
        double squared = (double)sl_dot(p, p), weight = 1.0 / (squared * sqrt(squared));
        if (!sl_rgb_is_finite(radiance)) continue;
        sl_sum_colour(sum, weight, radiance);
        angle += weight;
    }
    for (int c = 0; c < 3; c++) rgba[c] = angle > 0.0 ? (float)(sum[c] / angle) : 0.0f;
}

sl_status sl_gather_sky_create(const sl_environment *environment, double pixel, sl_texture_image **sky,
                               sl_error *error) {
    *sky = NULL;
    if (!environment->present || environment->width <= 0) return SL_OK;
    double texels = sqrt(4.0 * SL_PI) / (1.4 * pixel);
    int size = texels < TEXELS_MAX ? (int)texels + 1 : TEXELS_MAX,
        samples = environment->width / (2 * size) + 1;
    sl_status status = sl_texture_image_create(size, size, sky, error);
    for (int i = 0; status == SL_OK && i < size * size; i++)
        average_texel(environment, size, i % size, i / size, samples < SAMPLES_MAX ? samples : SAMPLES_MAX,
                      (*sky)->texels + 4 * i);
    return status;
}

size_t sl_gather_sky_memory_bytes(const sl_texture_image *sky) {
    return sky ? sizeof *sky + (size_t)sky->width * (size_t)sky->height * 4 * sizeof(float) : 0;
}

/* ---- looking up ------------------------------------------------------------------------------ */

static void add_sky(const sl_texture_image *sky, const sl_colour_pixels *p) {
    if (!sky) return;
    for (int row = 0; row < p->height; row++) {
        sl_vec3 middle = sl_mad(p->frame.z, p->y[row * p->width], p->frame.y);
        for (int column = 0; column < p->width; column++) {
            size_t pixel = (size_t)row * (size_t)p->width + (size_t)column;
            if (p->id[pixel] != SL_NO_INDEX) continue;
            sl_vec3 d = sl_mad(middle, p->x[column], p->frame.x);
            if (!(sl_dot(d, p->horizon) > 0.0f)) continue;
            float u, v, rgba[4];
            sl_octahedral_place(d, &u, &v);
            sl_texture_image_sample(sky, 0.5f * u + 0.5f, 0.5f * v + 0.5f, rgba);
            for (int c = 0; c < 3; c++) {
                float radiance = rgba[c] > 0.0f ? rgba[c] : 0.0f;
                p->radiance[c][pixel] = radiance;
                p->weighted[c][pixel] = radiance * p->weight[pixel];
            }
        }
    }
}

/* ---- one gather ---- */

static float finite(double value) { return value > 0.0 && value < 1e37 ? (float)value : 0.0f; }

sl_rgb sl_gather_known_colours(const sl_gather *gather, const sl_gather_point *point, sl_gather_scratch *s,
                               sl_counters *counters) {
    const sl_gather_tables *t = gather->tables;
    sl_gather_view view = sl_gather_view_of(gather, point, s);
    view.frame = sl_known_colours_frame(view.frame.z);
    sl_gather_draw_plane(&view, NULL, counters);
    sl_colour_pixels pixels = {.width = t->width,
                               .height = t->height,
                               .id = s->cell_id,
                               .w1 = s->cell_w1,
                               .w2 = s->cell_w2,
                               .x = t->direction_x,
                               .y = t->direction_y,
                               .frame = view.frame,
                               .eye = view.eye,
                               .horizon = sl_normalize_or(point->geometric_normal, view.frame.z),
                               .scene = gather->scene,
                               .lattice = gather->colours,
                               .weight = t->weight,
                               .radiance = {s->planes.r, s->planes.g, s->planes.b}};
    for (size_t k = 0; k < 3; k++) pixels.weighted[k] = s->weighted + k * t->cells;
    SL_KERNEL_OF(gather->isa, sl_colour_pixels_shade)(&pixels);
    add_sky(gather->sky, &pixels);
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, t->cells);
    double sum[3];
    sl_raster_sum(s->weighted, t->size, 3, s->halved, sum, counters);
    return (sl_rgb){finite(sum[0]), finite(sum[1]), finite(sum[2])};
}
