#include "cache/light_octree/surfel_kernels.h"

enum { LANES = SL_SURFEL_LANES };

typedef struct lane_sums {
    double front[LANES], back[LANES], front_flat[LANES], back_flat[LANES], front_height[LANES],
        back_height[LANES];
} lane_sums;

static inline double join(const double v[LANES]) {
    return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

/* Adds what of LANES surfels' areas is within a limit of delta^2, the cosine's sign telling the side. */
static inline void add_within(const float *restrict distance, const float *restrict height,
                              const float *restrict cosine, const float *restrict area, float limit,
                              lane_sums *restrict sums) {
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        double here = (double)(distance[l] <= limit ? area[l] : 0.0f),
               size = (double)(cosine[l] < 0.0f ? -cosine[l] : cosine[l]);
        double up = cosine[l] < 0.0f ? 0.0 : here, down = cosine[l] < 0.0f ? here : 0.0;
        sums->front[l] += up;
        sums->back[l] += down;
        sums->front_flat[l] += up * size;
        sums->back_flat[l] += down * size;
        sums->front_height[l] += up * (double)height[l];
        sums->back_height[l] += down * (double)height[l];
    }
}

void SL_KERNEL(sl_surfel_area)(const sl_surfels *s, size_t first, size_t end, const sl_surfel_query *q,
                               sl_surfel_sums *sums) {
    lane_sums lanes = {{0}, {0}, {0}, {0}, {0}, {0}};
    const float cx = q->centre.x, cy = q->centre.y, cz = q->centre.z, nx = q->normal.x, ny = q->normal.y,
                nz = q->normal.z;
    const float stretch = q->stretch, limit = q->limit, least = q->least_cosine;
    for (size_t i = first; i < end; i += LANES) {
        const float *restrict x = s->x + i, *restrict y = s->y + i, *restrict z = s->z + i,
                              *restrict area = s->area + i;
        const float *restrict mx = s->normal_x + i, *restrict my = s->normal_y + i,
                              *restrict mz = s->normal_z + i;
        float distance[LANES], height[LANES], cosine[LANES], counted[LANES];
        int some = 0;
#pragma omp simd reduction(| : some)
        for (int l = 0; l < LANES; l++) {
            float dx = x[l] - cx, dy = y[l] - cy, dz = z[l] - cz, u = dx * nx + dy * ny + dz * nz;
            float c = mx[l] * nx + my[l] * ny + mz[l] * nz, size = c < 0.0f ? -c : c;
            height[l] = u;
            cosine[l] = c;
            distance[l] = dx * dx + dy * dy + dz * dz + stretch * (u * u);
            counted[l] = size >= least ? area[l] : 0.0f;
            some |= distance[l] <= limit && size >= least;
        }
        if (some) add_within(distance, height, cosine, counted, limit, &lanes);
    }
    sums->front += join(lanes.front);
    sums->back += join(lanes.back);
    sums->front_flat += join(lanes.front_flat);
    sums->back_flat += join(lanes.back_flat);
    sums->front_height += join(lanes.front_height);
    sums->back_height += join(lanes.back_height);
}
