#include "cache/hemisphere/gather_internal.h"

#include "base/counters.h"

/* Rooms have edges along the axes, and so has the frame of a wall's normal. Then a whole row of pixels comes
 * to show something else at once as the point moves (with 128 x 128 pixels a step of 4 % of all its light,
 * seen as bands). Turned by 20.9 degrees pixels change one by one; the slope is that of the golden section,
 * 0.382, since with a slope of 1/3 they would change three by three. */
sl_frame sl_known_colours_frame(sl_vec3 normal) {
    const float c = 0.93417236f, s = 0.35682209f;
    sl_frame f = sl_frame_from_normal(normal);
    return (sl_frame){sl_mad(sl_scale(f.x, c), s, f.y), sl_mad(sl_scale(f.y, c), -s, f.x), f.z};
}

/* Three planes of size x size to one sum each: halved on the hardware to SL_GATHER_REDUCED a side, read back,
 * and added row by row. */
static void add_up(const sl_gather_scratch *s, int size, sl_counters *counters, double sum[3]) {
    int reduced = size < SL_GATHER_REDUCED ? size : SL_GATHER_REDUCED;
    size_t count = (size_t)reduced * (size_t)reduced;
    sl_raster_reduce(s->weighted, size, 3, reduced, s->halved, s->reduced, counters);
    for (size_t k = 0; k < 3; k++) {
        sum[k] = 0.0;
        for (size_t i = 0; i < count; i++) sum[k] += (double)s->reduced[k * count + i];
    }
}

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
    sl_gather_sky_add(gather->sky, &pixels);
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, t->cells);
    double sum[3];
    add_up(s, t->size, counters, sum);
    return (sl_rgb){finite(sum[0]), finite(sum[1]), finite(sum[2])};
}
