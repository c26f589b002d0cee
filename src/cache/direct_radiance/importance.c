/* Photons where the light is: dark and empty parts of the pictures cost no photons, bright ones get many.
 *
 * Texels lie in a row, along a Hilbert curve: neighbours on the curve are neighbours in the picture. With prefix sums of the luminance of
 * their flux, every number u in [0,1) belongs to the texel in whose share of the sum it falls. N photons, as many as regular samples:
 *
 *   Single texels (the filters that look at a photon's own texel): the numbers (i + 1/2) / N, the most even ones there are in one
 *   dimension, draw texels with probability p; a photon's flux is the texel's divided by N p. A texel is drawn N p times, rounded up or down,
 *   and each time stands for the N-th part of the light's luminance: that sum is exact, not only unbiased.
 *
 *   Groups (the flux filter): the row is cut at i / N. Each part is one piece of the picture, takes the place of a regular sample's
 *   block, and becomes a photon for every surface that it shows. Nothing is drawn, and nothing lost: the sum of Psi is exact. */
#include "base/error.h"
#include "base/memory.h"
#include "cache/direct_radiance/photon_groups.h"

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

/* The texels of a light's faces in their row. */
typedef struct texel_row {
    size_t count;
    struct row_texel {
        uint32_t face, column, row; /* face: of the light's */
        double luminance, before; /* before: of all texels before it */
        double block;             /* solid angle of its face's blocks, their mean */
    } *texel;
    double sum;
    uint64_t numbers; /* N */
} texel_row;

static double mean_block_angle(const sl_radiance_map *map, const sl_map_face *face) {
    double angle = 0.0;
    size_t texels = (size_t)face->width * (size_t)face->height;
    for (size_t i = 0; i < texels; i++) angle += (double)map->block_angle[face->first + i];
    return angle / ((double)face->columns * face->rows);
}

/* Texels as they follow each other on the curve. */
static void lay_out(const sl_photon_list *list, const sl_map_face *face, size_t face_count, texel_row *line) {
    for (size_t f = 0; f < face_count; f++) {
        uint32_t size = enclosing_power_of_two(face[f].width, face[f].height);
        double block = mean_block_angle(list->map, &face[f]);
        for (uint32_t d = 0; d < size * size; d++) {
            int column, row;
            hilbert_place(size, d, &column, &row);
            if (column >= face[f].width || row >= face[f].height) continue;
            sl_map_texel t;
            bool lit = sl_map_texel_read(list->scene, list->map, &face[f], column, row, NULL, &t);
            double luminance = lit ? t.luminance : 0.0;
            line->texel[line->count++] = (struct row_texel){(uint32_t)f, (uint32_t)column, (uint32_t)row, luminance, line->sum, block};
            line->sum += luminance;
        }
        line->numbers += (uint64_t)face[f].columns * (uint64_t)face[f].rows;
    }
}

/* ---- single texels ---- */

/* How many of the numbers (i + 1/2) / N fall below `share`. */
static uint64_t numbers_below(double share, uint64_t numbers) {
    double below = ceil(share * (double)numbers - 0.5);
    return below <= 0.0 ? 0 : below >= (double)numbers ? numbers : (uint64_t)below;
}

/* A photon of a texel that was drawn: `times` the texel, as a part of the picture of as many times its area. */
static void add_drawn(sl_photon_list *list, const sl_map_face *face, const struct row_texel *place, double times) {
    double x = place->column + 0.5, y = place->row + 0.5, half = 0.5 * sqrt(times);
    sl_map_texel t;
    if (!sl_map_texel_read(list->scene, list->map, face, (int)place->column, (int)place->row, NULL, &t)) return;
    sl_photon_sample sample = sl_photon_of_texel(list, &t, times, (sl_texel_rectangle){x - half, y - half, x + half, y + half});
    double own = (double)list->map->block_angle[sl_map_texel_index(face, (int)place->column, (int)place->row)];
    for (int k = 0; k < 3; k++) sample.radiance[k] *= times * own / place->block; /* printed weights count photons */
    sl_photon_add(list, face, &sample);
}

static void draw_texels(sl_photon_list *list, const sl_map_face *face, const texel_row *line) {
    uint64_t done = 0;
    for (size_t i = 0; i < line->count; i++) {
        const struct row_texel *t = &line->texel[i];
        uint64_t below = numbers_below((t->before + t->luminance) / line->sum, line->numbers);
        if (below == done) continue;
        double times = (double)(below - done) * (line->sum / t->luminance) / (double)line->numbers; /* 1 / (N p) for each */
        add_drawn(list, &face[t->face], t, times);
        done = below;
    }
}

/* ---- groups ---- */

/* The part of the row in which the texel's middle lies. */
static uint64_t part_of(const texel_row *line, const struct row_texel *t) {
    double u = (t->before + 0.5 * t->luminance) / line->sum * (double)line->numbers;
    return u < (double)line->numbers ? (uint64_t)u : line->numbers - 1;
}

static void group_parts(sl_photon_list *list, const sl_map_face *face, const texel_row *line) {
    sl_photon_groups groups = {.angle = 0.0};
    for (size_t i = 0; i < line->count; i++) {
        const struct row_texel *t = &line->texel[i];
        const sl_map_face *f = &face[t->face];
        sl_photon_groups_add(list, f, (int)t->column, (int)t->row, t->block, &groups);
        bool ends = i + 1 == line->count || t[1].face != t->face || part_of(line, &t[1]) != part_of(line, t);
        if (ends) sl_photon_groups_finish(list, f, &groups);
    }
}

sl_status sl_photons_by_importance(sl_photon_list *list, const sl_map_face *face, size_t face_count, sl_error *error) {
    texel_row line = {.count = 0};
    size_t texels = 0;
    for (size_t f = 0; f < face_count; f++) texels += (size_t)face[f].width * (size_t)face[f].height;
    line.texel = sl_allocate(texels, sizeof *line.texel);
    if (!line.texel) return sl_fail_memory(error, "importance of texels");
    lay_out(list, face, face_count, &line);
    if (!(line.sum > 0.0) || !isfinite(line.sum)) {
        list->photons->dropped += line.numbers;
    } else if (list->grouped) {
        group_parts(list, face, &line);
    } else {
        draw_texels(list, face, &line);
    }
    sl_free(line.texel);
    return SL_OK;
}
