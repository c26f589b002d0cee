/* What blocks of pixels saw of photons is carried to the pixels around, as a joint bilateral filter would: as far as they lie on one
 * surface. Where the blocks disagree a shadow's edge passes between them, and the pixels there are left to ask themselves. */
#include "cache/direct_radiance/sight_kernels.h"

#include <math.h>

/* A block fits where both points lie near each other's tangent plane (within 6 degrees of it, seen from one another),
 * their normals agree (within 25 degrees), and they are not farther apart than a tenth of the way to the eye. */
void SL_KERNEL(sl_sight_fit)(const sl_receiver_tile *t, const sl_block_planes *planes, const float *restrict reach_squared,
                             float offset_squared, sl_tile_sight *around) {
    const float *restrict x = planes->value[0], *restrict y = planes->value[1], *restrict z = planes->value[2];
    const float *restrict gx = planes->value[3], *restrict gy = planes->value[4], *restrict gz = planes->value[5];
    const float *restrict nx = planes->value[6], *restrict ny = planes->value[7], *restrict nz = planes->value[8];
    const size_t count = t->padded;
    for (int k = 0; k < SL_SIGHT_BLOCKS; k++) {
        const int32_t *restrict block = around->block[k];
        uint32_t *restrict fits = around->fits[k];
#pragma omp simd
        for (size_t i = 0; i < count; i++) {
            int32_t b = block[i];
            float ex = x[b] - t->x[i], ey = y[b] - t->y[i], ez = z[b] - t->z[i], squared = ex * ex + ey * ey + ez * ez;
            float here = t->geometric_x[i] * ex + t->geometric_y[i] * ey + t->geometric_z[i] * ez;
            float there = gx[b] * ex + gy[b] * ey + gz[b] * ez, limit = 0.01f * squared + offset_squared;
            float agree = t->normal_x[i] * nx[b] + t->normal_y[i] * ny[b] + t->normal_z[i] * nz[b];
            float sides = t->geometric_x[i] * gx[b] + t->geometric_y[i] * gy[b] + t->geometric_z[i] * gz[b];
            bool good = (here * here <= limit) & (there * there <= limit) & (agree > 0.9f) & (sides > 0.9f) &
                        (squared <= reach_squared[i]);
            fits[i] = good ? fits[i] : 0u;
        }
    }
}

void SL_KERNEL(sl_sight_agree)(size_t count, const uint32_t *restrict known, const uint32_t *restrict seen, size_t words, size_t word,
                               sl_tile_sight *around) {
    uint32_t *restrict lit = around->seen, *restrict unsure = around->unsure;
    const int32_t stride = (int32_t)words, first = (int32_t)word;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        uint32_t light = 0, dark = 0;
        for (int k = 0; k < SL_SIGHT_BLOCKS; k++) {
            int32_t at = around->block[k][i] * stride + first;
            uint32_t answers = known[at] & around->fits[k][i];
            light |= answers & seen[at];
            dark |= answers & ~seen[at];
        }
        lit[i] = light;
        unsure[i] = ~(light ^ dark); /* both, or neither */
    }
}

void SL_KERNEL(sl_sight_want)(size_t count, unsigned bit, const float *restrict weight, sl_tile_sight *around) {
    uint32_t *restrict wanted = around->wanted;
    const uint32_t mask = 1u << bit;
#pragma omp simd
    for (size_t i = 0; i < count; i++) wanted[i] |= weight[i] > 0.0f ? mask : 0u;
}

void SL_KERNEL(sl_sight_tell)(size_t count, const sl_tile_sight *around, unsigned bit, float *restrict visible) {
    const uint32_t *restrict seen = around->seen;
#pragma omp simd
    for (size_t i = 0; i < count; i++) visible[i] = seen[i] >> bit & 1u ? 1.0f : 0.0f;
}
