/* Photons where the light is: texels are drawn in proportion to the luminance of their flux, so that dark and empty parts of the pictures
 * cost no photons and bright ones get many.
 *
 * With prefix sums of luminance, number u in [0,1) picks the texel in whose share of the sum it falls, with probability p; its flux is divided
 * by N p, N numbers in all. The numbers are (i + 1/2) / N: the most even ones there are in one dimension. What is one dimension here is the
 * order of the texels, along a Hilbert curve: neighbours on the curve are neighbours in the picture, so numbers that are evenly
 * spaced are photons that are, too. A texel is drawn N p times, rounded up or down: every photon's luminance is the
 * N-th part of the light's, and the sum of luminances is exact, not only unbiased. */
#include "base/error.h"
#include "base/memory.h"
#include "cache/direct_radiance/photon_list.h"

/* Place `d` on the Hilbert curve through a square of side 2^k = size. */
static void hilbert_place(uint32_t size, uint32_t d, int *column, int *row) {
    uint32_t x = 0, y = 0;
    for (uint32_t s = 1; s < size; s *= 2) {
        uint32_t right = 1u & (d / 2), up = 1u & (d ^ right);
        if (!up) { /* the quarter's curve is turned */
            if (right) {
                x = s - 1 - x;
                y = s - 1 - y;
            }
            uint32_t swap = x;
            x = y;
            y = swap;
        }
        x += s * right;
        y += s * up;
        d /= 4;
    }
    *column = (int)x;
    *row = (int)y;
}

static uint32_t enclosing_power_of_two(int width, int height) {
    uint32_t size = 1;
    while (size < (uint32_t)width || size < (uint32_t)height) size *= 2;
    return size;
}

/* luminance[texel - first] of the faces' texels; the sum of all. */
static double read_luminances(const sl_photon_list *list, const sl_map_face *face, size_t face_count, double *luminance) {
    double sum = 0.0;
    for (const sl_map_face *f = face; f < face + face_count; f++) {
        for (int row = 0; row < f->height; row++) {
            for (int column = 0; column < f->width; column++) {
                sl_map_texel t;
                bool lit = sl_map_texel_read(list->scene, list->map, f, column, row, NULL, &t);
                luminance[sl_map_texel_index(f, column, row) - face->first] = lit ? t.luminance : 0.0;
                sum += lit ? t.luminance : 0.0;
            }
        }
    }
    return sum;
}

/* How many of the numbers (i + 1/2) / N fall below `share`. */
static uint64_t numbers_below(double share, uint64_t numbers) {
    double below = ceil(share * (double)numbers - 0.5);
    return below <= 0.0 ? 0 : below >= (double)numbers ? numbers : (uint64_t)below;
}

/* Draws: drawn[texel - first] counts. */
static void draw(const sl_map_face *face, size_t face_count, const double *luminance, double sum, uint64_t numbers, uint32_t *drawn) {
    double before = 0.0;
    uint64_t done = 0;
    size_t last = SIZE_MAX;
    for (const sl_map_face *f = face; f < face + face_count; f++) {
        uint32_t size = enclosing_power_of_two(f->width, f->height);
        for (uint32_t d = 0; d < size * size; d++) {
            int column, row;
            hilbert_place(size, d, &column, &row);
            if (column >= f->width || row >= f->height) continue;
            size_t i = sl_map_texel_index(f, column, row) - face->first;
            if (!(luminance[i] > 0.0)) continue;
            before += luminance[i];
            uint64_t below = numbers_below(before / sum, numbers);
            drawn[i] = (uint32_t)(below - done);
            done = below;
            last = i;
        }
    }
    if (last != SIZE_MAX) drawn[last] += (uint32_t)(numbers - done); /* which rounding of the sums left over */
}

/* A part of the picture of `times` the texel's area, around its middle. */
static sl_texel_rectangle part_of_texel(int column, int row, double times) {
    double x = column + 0.5, y = row + 0.5, half = 0.5 * sqrt(times);
    return (sl_texel_rectangle){x - half, y - half, x + half, y + half};
}

static sl_status take(sl_photon_list *list, const sl_map_face *face, size_t face_count, double *luminance, uint32_t *drawn) {
    uint64_t numbers = 0;
    for (size_t f = 0; f < face_count; f++) numbers += (uint64_t)face[f].columns * (uint64_t)face[f].rows;
    double sum = read_luminances(list, face, face_count, luminance);
    if (!(sum > 0.0) || !isfinite(sum)) {
        list->photons->dropped += numbers;
        return SL_OK;
    }
    draw(face, face_count, luminance, sum, numbers, drawn);
    for (const sl_map_face *f = face; f < face + face_count; f++) {
        for (int row = 0; row < f->height; row++) {
            for (int column = 0; column < f->width; column++) {
                size_t i = sl_map_texel_index(f, column, row) - face->first;
                sl_map_texel t;
                if (!drawn[i] || !sl_map_texel_read(list->scene, list->map, f, column, row, NULL, &t)) continue;
                double times = (double)drawn[i] * (sum / luminance[i]) / (double)numbers; /* 1 / (N p) for each time */
                sl_photon_sample sample = sl_photon_of_texel(list, &t, times, part_of_texel(column, row, times));
                sl_photon_add(list, f, &sample);
            }
        }
    }
    return SL_OK;
}

sl_status sl_photons_by_importance(sl_photon_list *list, const sl_map_face *face, size_t face_count, sl_error *error) {
    const sl_map_face *last = &face[face_count - 1];
    size_t texels = last->first + (size_t)last->width * (size_t)last->height - face->first;
    double *luminance = sl_allocate(texels, sizeof *luminance);
    uint32_t *drawn = sl_allocate(texels, sizeof *drawn);
    sl_status status = luminance && drawn ? take(list, face, face_count, luminance, drawn) : sl_fail_memory(error, "importance of texels");
    sl_free(luminance);
    sl_free(drawn);
    return status;
}
