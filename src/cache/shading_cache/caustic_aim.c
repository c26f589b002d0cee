/* Where specular surfaces are few, most photons would miss them. A first, even emission tells for each light
 * from which cells of the directions' numbers photons end in caustics; later ones start there, all with the
 * same density, and a few anywhere (Jensen 1996, projection maps). They weigh 1 over the density: were it in
 * proportion to the count, photons beside each other would weigh differently, and that would be seen as
 * noise. Cells are stretched one number after another, so well-spread numbers stay well spread. */
#include <math.h>

#include "cache/shading_cache/caustic_map.h"

static const double everywhere = 0.25;

static uint32_t cell_of(float u, uint32_t count) {
    uint32_t i = (uint32_t)(u * (float)count);
    return i < count ? i : count - 1;
}

uint32_t sl_aim_cell(uint32_t light, const float whither[3]) {
    return (light % SL_AIM_LIGHTS * SL_AIM_CELLS + cell_of(whither[0], SL_AIM_CELLS)) * SL_AIM_CELLS +
           cell_of(whither[1], SL_AIM_CELLS);
}

/* The cell or a neighbour has hits: what the count has missed is likely to be there. The second number goes
 * around. */
static double is_wanted(const double *hits, int row, int column) {
    for (int r = row > 0 ? row - 1 : 0; r <= row + 1 && r < SL_AIM_CELLS; r++) {
        for (int k = -1; k <= 1; k++) {
            if (hits[r * SL_AIM_CELLS + (column + k + SL_AIM_CELLS) % SL_AIM_CELLS] > 0.0) return 1.0;
        }
    }
    return 0.0;
}

static void cumulate(const double *density, int count, float *sums) {
    double total = 0.0, sum = 0.0;
    for (int i = 0; i < count; i++) total += density[i];
    for (int i = 0; i < count; i++) {
        sums[i] = (float)(sum / total);
        sum += density[i];
    }
    sums[count] = 1.0f;
}

static void aim_light(const double *hits, uint32_t light, sl_caustic_aim *aim) {
    double total = 0.0, rows[SL_AIM_CELLS];
    for (int i = 0; i < SL_AIM_PLANE; i++) total += is_wanted(hits, i / SL_AIM_CELLS, i % SL_AIM_CELLS);
    for (int r = 0; r < SL_AIM_CELLS; r++) {
        double cells[SL_AIM_CELLS];
        rows[r] = 0.0;
        for (int c = 0; c < SL_AIM_CELLS; c++) {
            double wanted = total > 0.0 ? is_wanted(hits, r, c) / total : 1.0 / SL_AIM_PLANE;
            cells[c] = everywhere / SL_AIM_PLANE + (1.0 - everywhere) * wanted;
            rows[r] += cells[c];
        }
        cumulate(cells, SL_AIM_CELLS, aim->column_sums[light][r]);
    }
    cumulate(rows, SL_AIM_CELLS, aim->row_sums[light]);
    for (int i = 0; i < SL_AIM_PLANE; i++) { /* of the sums as they are rounded */
        int r = i / SL_AIM_CELLS, c = i % SL_AIM_CELLS;
        double p = (double)(aim->row_sums[light][r + 1] - aim->row_sums[light][r]) *
                   (double)(aim->column_sums[light][r][c + 1] - aim->column_sums[light][r][c]);
        aim->weight[light * SL_AIM_PLANE + (uint32_t)i] = p > 0.0 ? (float)(1.0 / (p * SL_AIM_PLANE)) : 0.0f;
    }
}

void sl_caustic_aim_make(const double hits[SL_AIM_ALL], sl_caustic_aim *aim) {
    for (uint32_t light = 0; light < SL_AIM_LIGHTS; light++)
        aim_light(hits + light * SL_AIM_PLANE, light, aim);
}

/* The cell into which u falls, u stretched to where that cell lies among even ones. */
static uint32_t stretch(const float *sums, uint32_t count, float *u) {
    uint32_t low = 0, high = count - 1;
    while (low < high) {
        uint32_t middle = (low + high + 1) / 2;
        if (*u < sums[middle]) high = middle - 1;
        else low = middle;
    }
    float width = sums[low + 1] - sums[low], within = width > 0.0f ? (*u - sums[low]) / width : 0.5f;
    *u = fminf(((float)low + fminf(within, 0x1.fffffep-1f)) / (float)count, 0x1.fffffep-1f);
    return low;
}

float sl_caustic_aim_warp(const sl_caustic_aim *aim, uint32_t light, float whither[3]) {
    uint32_t l = light % SL_AIM_LIGHTS, r = stretch(aim->row_sums[l], SL_AIM_CELLS, &whither[0]);
    uint32_t c = stretch(aim->column_sums[l][r], SL_AIM_CELLS, &whither[1]);
    return aim->weight[(l * SL_AIM_CELLS + r) * SL_AIM_CELLS + c];
}
