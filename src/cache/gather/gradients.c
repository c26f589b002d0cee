/* From sums over cells and walls to irradiance with gradients in the world frame. The sums themselves are in
 * gather_kernels.c, the walls' vectors in gather_tables.c; cache-math 3.2 has the principle that makes them. */
#include "cache/gather/gather_internal.h"

#include "base/math.h"

/* Where side faces of the hemicube meet. */
static void add_seams(const sl_gather_tables *t, const sl_gather_planes *p, sl_gather_sums *sums) {
    const float *channel[3] = {p->r, p->g, p->b};
    for (size_t i = 0; i < t->seam_count; i++) {
        const sl_gather_seam *s = &t->seams[i];
        double near_a = (double)p->nearness[s->a], near_b = (double)p->nearness[s->b], near = near_a > near_b ? near_a : near_b;
        for (int c = 0; c < 3; c++) {
            double step = ((double)channel[c][s->b] - (double)channel[c][s->a]) * near;
            sums->translational[c][0] += step * (double)s->x;
            sums->translational[c][1] += step * (double)s->y;
        }
    }
}

static sl_vec3 tangential(const sl_frame *f, const double v[2]) {
    return sl_to_float(sl_addd(sl_scaled(sl_to_double(f->x), v[0]), sl_scaled(sl_to_double(f->y), v[1])));
}

void sl_gather_finish(const sl_gather_view *view, sl_gather_sums *sums, sl_irradiance *out) {
    const sl_gather_tables *t = view->gather->tables;
    add_seams(t, &view->scratch->planes, sums);
    out->value = (sl_rgb){(float)sums->irradiance[0], (float)sums->irradiance[1], (float)sums->irradiance[2]};
    for (int c = 0; c < 3; c++) {
        out->rotational[c] = tangential(&view->frame, sums->rotational[c]);
        out->translational[c] = tangential(&view->frame, sums->translational[c]);
    }
    /* 1/R = (1/pi) sum W / r (radiance-cache-splatting 2.3); W need not sum to pi where a plane's border is left off. */
    out->harmonic_mean = sums->inverse_distance > 0.0 ? (float)(t->weight_sum / sums->inverse_distance) : INFINITY;
}
