#include "cache/light_octree/surfel_kernels.h"

enum { LANES = SL_SURFEL_LANES };

static inline double join(const double v[LANES]) { return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7])); }

void SL_KERNEL(sl_surfel_area)(const sl_surfels *s, size_t first, size_t end, const sl_surfel_query *q, sl_surfel_sums *sums) {
    double front[LANES] = {0}, back[LANES] = {0}, front_flat[LANES] = {0}, back_flat[LANES] = {0};
    double front_height[LANES] = {0}, back_height[LANES] = {0};
    const float cx = q->centre.x, cy = q->centre.y, cz = q->centre.z, nx = q->normal.x, ny = q->normal.y, nz = q->normal.z;
    const float stretch = q->stretch, limit = q->limit, least = q->least_cosine;
    for (size_t i = first; i < end; i += LANES) {
        const float *restrict x = s->x + i, *restrict y = s->y + i, *restrict z = s->z + i, *restrict area = s->area + i;
        const float *restrict mx = s->normal_x + i, *restrict my = s->normal_y + i, *restrict mz = s->normal_z + i;
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            float dx = x[l] - cx, dy = y[l] - cy, dz = z[l] - cz, u = dx * nx + dy * ny + dz * nz;
            float cosine = mx[l] * nx + my[l] * ny + mz[l] * nz, size = cosine < 0.0f ? -cosine : cosine;
            float inside = dx * dx + dy * dy + dz * dz + stretch * (u * u) <= limit ? area[l] : 0.0f;
            inside = size >= least ? inside : 0.0f;
            double here = (double)inside, up = cosine < 0.0f ? 0.0 : here, down = cosine < 0.0f ? here : 0.0;
            front[l] += up;
            back[l] += down;
            front_flat[l] += up * (double)size;
            back_flat[l] += down * (double)size;
            front_height[l] += up * (double)u;
            back_height[l] += down * (double)u;
        }
    }
    sums->front += join(front);
    sums->back += join(back);
    sums->front_flat += join(front_flat);
    sums->back_flat += join(back_flat);
    sums->front_height += join(front_height);
    sums->back_height += join(back_height);
}
