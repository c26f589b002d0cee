/* Direct light of pixels: the passes over a strip of rows.
 *
 *   1  every pixel         a ray to each light without extent, light samples of the others
 *   2  penumbrae           more samples for pixels that see a part of the lights, and those near them, since
 *                          nearly all of the noise is there
 *   3  the visible share   smoothed where it is noise (direct_filter.c)
 *   4  radiance
 *
 * Every pass reads a few rows around those of the next one. */
#include "base/batch.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/random.h"
#include "cache/light/direct_internal.h"
#include "cache/frame/picture_value.h"

#include <string.h>

enum {
    PILOT_MIN = 4,
    PILOT_MIN_SHARED = 2, /* of each of a pixel's sub-frames */
    PENUMBRA_FACTOR = 4,
    PENUMBRA_EMITTERS_MAX = 16, /* of one picture: under many emitters every pixel lies in some penumbra */
    /* Penumbrae are found by few samples, which may all agree by chance; refining only where they do not
     * would darken the faint edges of shadows and brighten the others. So pixels this near to a known
     * penumbra are refined as well. */
    PENUMBRA_MARGIN = 2,
    FILTER_MARGIN = 2,
    MARGIN = PENUMBRA_MARGIN + FILTER_MARGIN,
    SAMPLED_ROWS = 4,
    MANY_SAMPLES = 16 /* of a film's pixel */
};

/* Tells whether a pixel has samples in other sub-frames, too, and many of them all. */
static bool is_shared_out(const sl_direct *direct) { return direct->scene->sub_frame.share > 1; }
static bool has_many(const sl_direct *direct) {
    return is_shared_out(direct) && direct->settings.light_samples >= MANY_SAMPLES;
}

static bool refines_penumbrae(const sl_direct *direct) {
    return has_many(direct) || direct->sides.count <= PENUMBRA_EMITTERS_MAX;
}

static uint32_t samples_with_refinement(const sl_direct *direct) {
    return (refines_penumbrae(direct) ? 1 + PENUMBRA_FACTOR : 1) * sl_direct_samples(direct);
}

/* Of the first pass: what all agree on needs few, the others get more anyway. */
static uint32_t pilot_samples(const sl_direct *direct) {
    const uint32_t samples = sl_direct_samples(direct), quarter = (samples + 3) / 4,
                   least = is_shared_out(direct) ? PILOT_MIN_SHARED : PILOT_MIN;
    if (!refines_penumbrae(direct)) return samples;
    return quarter < least ? (uint32_t)sl_fewer(samples, least) : quarter;
}

/* ---- blocks of pixels ---- */

sl_light_points sl_lit_points(const sl_lit_block *b) {
    return (sl_light_points){b->count,       b->x,           b->y,        b->z,        b->geometric_x,
                             b->geometric_y, b->geometric_z, b->normal_x, b->normal_y, b->normal_z};
}

/* The bits of x and y in turn. */
static uint32_t z_order(uint32_t x, uint32_t y) {
    uint32_t rank = 0;
    for (uint32_t bit = 0; 1u << bit < SL_SAMPLE_TILE; bit++)
        rank |= (x >> bit & 1u) << 2 * bit | (y >> bit & 1u) << (2 * bit + 1);
    return rank;
}

void sl_lit_block_add(const sl_direct *direct, const sl_gbuffer *g, size_t p, sl_lit_block *b) {
    size_t i = b->count++;
    uint32_t x = (uint32_t)(p % (size_t)g->width), y = (uint32_t)(p / (size_t)g->width);
    b->pixel[i] = (uint32_t)p;
    b->triangle[i] = g->id[p];
    b->x[i] = g->position_x[p], b->y[i] = g->position_y[p], b->z[i] = g->position_z[p];
    b->geometric_x[i] = g->geometric_x[p], b->geometric_y[i] = g->geometric_y[p],
    b->geometric_z[i] = g->geometric_z[p];
    b->normal_x[i] = g->normal_x[p], b->normal_y[i] = g->normal_y[p], b->normal_z[i] = g->normal_z[p];
    if (direct->settings.maps) return; /* where nothing is random */
    b->rank[i] = z_order(x % SL_SAMPLE_TILE, y % SL_SAMPLE_TILE);
    b->tile_key[i] = sl_random_key(direct->settings.seed ^ 0xd1ecu,
                                   (uint64_t)(y / SL_SAMPLE_TILE) << 32 | x / SL_SAMPLE_TILE);
}

/* Returns whose turn it is: the pixels of a tile, then those of the next sub-frame. */
static uint32_t turn_of(const sl_direct *direct, uint32_t rank) {
    return direct->scene->sub_frame.turn * SL_SAMPLE_TILE * SL_SAMPLE_TILE + rank;
}

/* Returns the key of the pixel's own sequence: one over the pilot, and one over the sub-frames behind it,
 * which have fewer samples. */
static uint64_t own_key(const sl_direct *direct, const sl_lit_block *block, size_t i) {
    const uint64_t share = direct->scene->sub_frame.share;
    return block->tile_key[i] + share * SL_SAMPLE_TILE * SL_SAMPLE_TILE + block->rank[i];
}

/* Returns which point of it is sample `sample`, of `all` in this sub-frame. */
static uint32_t own_index(const sl_direct *direct, uint32_t sample, uint32_t all) {
    return direct->scene->sub_frame.turn * all + sample;
}

static void own_points(const sl_direct *direct, const sl_lit_block *block, sl_sample_range range,
                       uint64_t stream, size_t stride, float *const u[3]) {
    const uint32_t all = samples_with_refinement(direct);
    uint64_t key[SL_LIGHT_BLOCK];
    for (size_t i = 0; i < block->count; i++) key[i] = own_key(direct, block, i);
    for (uint32_t sample = range.first; sample < range.end; sample++) {
        const size_t to = (sample - range.first) * stride;
        /* the first two are spread best together */
        float *const point[3] = {u[1] + to, u[2] + to, u[0] + to};
        SL_KERNEL_OF(direct->isa, sl_sequence_points)(&direct->sequence, block->count, key, (uint32_t)stream,
                                                      own_index(direct, sample, all), point);
    }
}

/* Of a film a pixel has a sequence of its own. Where it is smoothed for want of samples, and in one picture,
 * the pixels of a tile of 8 x 8 take turns, in Z order, at one sequence (Roberts' R3), so that neighbours of
 * every size share samples that are spread evenly (Ahmed and Wonka 2020): what pixels are smoothed with then
 * tells most. */
void sl_direct_points(const sl_direct *direct, const sl_lit_block *block, sl_sample_range range,
                      uint64_t stream, size_t stride, float *u0, float *u1, float *u2) {
    static const uint32_t step[3] = {3518319155u, 2882110345u, 2360945575u}; /* powers of 1/g, g^4 = g + 1 */
    float *const u[3] = {u0, u1, u2};
    if (stream == SL_STREAM_SHARES ? has_many(direct) : is_shared_out(direct)) {
        own_points(direct, block, range, stream, stride, u);
        return;
    }
    const uint32_t all = samples_with_refinement(direct);
    for (uint64_t d = 0; d < 3; d++) {
        uint32_t start[SL_LIGHT_BLOCK];
        for (size_t i = 0; i < block->count; i++) {
            bool same_tile = i > 0 && block->tile_key[i] == block->tile_key[i - 1];
            start[i] = same_tile ? start[i - 1] : sl_random_bits(block->tile_key[i], 3 * stream + d);
        }
        for (uint32_t sample = range.first; sample < range.end; sample++) {
            float *restrict to = u[d] + (sample - range.first) * stride;
            for (size_t i = 0; i < block->count; i++) {
                uint32_t index = turn_of(direct, block->rank[i]) * all + sample;
                to[i] = sl_unit_of_bits(start[i] + index * step[d]);
            }
        }
    }
}

void sl_direct_point_2d(const sl_direct *direct, const sl_lit_block *block, size_t i, uint32_t sample,
                        uint64_t stream, float u[2]) {
    static const uint32_t step[2] = {3242174889u, 2447445414u}; /* of g^3 = g + 1 */
    const uint32_t all = 2 * sl_direct_samples(direct);
    if (is_shared_out(direct)) {
        float point[3];
        sl_sequence_point(&direct->sequence, own_key(direct, block, i), (uint32_t)stream,
                          own_index(direct, sample, all), point);
        u[0] = point[0], u[1] = point[1];
        return;
    }
    const uint32_t index = block->rank[i] * all + sample;
    for (uint64_t d = 0; d < 2; d++)
        u[d] = sl_unit_of_bits(sl_random_bits(block->tile_key[i], 3 * stream + d) + index * step[d]);
}

/* ---- rays, sixteen at a time ---- */

static void set_ray(const sl_direct *direct, const sl_lit_block *block, uint32_t lane, sl_aims aims,
                    unsigned k, sl_ray16 *rays) {
    const uint32_t i = lane % SL_LIGHT_BLOCK;
    const sl_vec3 p = sl_v3(block->x[i], block->y[i], block->z[i]);
    sl_ray16_set_shadow(rays, k, p,
                        sl_v3(block->geometric_x[i], block->geometric_y[i], block->geometric_z[i]),
                        sl_scene_offset_at(direct->scene, direct->offset, p),
                        sl_v3(aims.x[lane], aims.y[lane], aims.z[lane]), aims.far_away, block->triangle[i]);
}

void sl_direct_trace(const sl_direct *direct, const sl_lit_block *block, size_t count, const uint32_t *lanes,
                     sl_aims aims, float *visible, sl_counters *counters) {
    sl_ray16 rays;
    for (size_t first = 0; first < count; first += SL_PACKET) {
        unsigned size = count - first < SL_PACKET ? (unsigned)(count - first) : SL_PACKET;
        for (unsigned k = 0; k < size; k++) set_ray(direct, block, lanes[first + k], aims, k, &rays);
        uint32_t occluded = sl_trace_occluded(direct->tracer, &rays, size, true, counters);
        for (unsigned k = 0; k < size; k++) visible[lanes[first + k]] = occluded >> k & 1u ? 0.0f : 1.0f;
    }
}

void sl_direct_visible(const sl_direct *direct, const sl_lit_block *block, sl_aims aims, const float *wanted,
                       float *visible, sl_counters *counters) {
    uint32_t lanes[SL_LIGHT_BLOCK];
    size_t count = 0;
    for (uint32_t i = 0; i < block->count; i++) {
        visible[i] = 0.0f;
        if (wanted[i] > 0.0f) lanes[count++] = i;
    }
    sl_direct_trace(direct, block, count, lanes, aims, visible, counters);
}

/* ---- sums ---- */

/* Those that pixels around are asked for, by the penumbrae and by the filter, and the light itself, are what
 * passes give to other ranks; all else is of use to a pixel's own alone. */
enum {
    PLANES = 23,
    PENUMBRA_PLANE = 0,
    FILTER_PLANES = 1,
    OWN_PLANES = 9, /* no pixel around reads these */
    LIGHT_PLANES = 12,
    PLANES_WITHIN = 15
};

/* Not set: the first pass clears them row by row. */
static bool make_sums(size_t first, size_t count, sl_direct_sums *sums) {
    float **const planes[PLANES] = {
        &sums->partly,    &sums->seen[0],   &sums->seen[1],   &sums->seen[2],   &sums->all[0],
        &sums->all[1],    &sums->all[2],    &sums->samples,   &sums->scatter,   &sums->exact[0],
        &sums->exact[1],  &sums->exact[2],  &sums->light[0],  &sums->light[1],  &sums->light[2],
        &sums->plain[0],  &sums->plain[1],  &sums->plain[2],  &sums->glossy[0], &sums->glossy[1],
        &sums->glossy[2], &sums->odd_seen,  &sums->odd_all};
    sums->first = first;
    sums->count = count;
    sums->block = sl_allocate_unset(count, PLANES * sizeof *sums->block);
    for (size_t k = 0; sums->block && k < PLANES; k++) *planes[k] = sums->block + k * count;
    return sums->block != NULL;
}

/* ---- passes ---- */

typedef struct {
    const sl_direct *direct;
    const sl_gbuffer *gbuffer;
    int row0;               /* of the strip with its margin */
    int row, end;           /* of the pass: its first, and behind its last */
    int each;               /* rows of an item */
    sl_direct_sums *sums;
    sl_direct_scratch *scratch; /* by worker */
    sl_counters *counters;
    bool refine, last;      /* the second pass; all samples are taken by it */
} pass;

static sl_pixel_run shown(const pass *p, size_t first, size_t end) {
    return sl_sub_frame_run(&p->direct->scene->sub_frame, first, end);
}

static void clear_plane(const sl_direct_sums *sums, size_t plane, sl_pixel_run run) {
    memset(sums->block + plane * sums->count + run.first - sums->first, 0,
           (run.end - run.first) * sizeof *sums->block);
}

/* Clears what pixels around read of a row, and all of the pixels that are shown. */
static void clear_row(const pass *p, sl_pixel_run row) {
    for (size_t k = 0; k < OWN_PLANES; k++) clear_plane(p->sums, k, row);
    for (sl_pixel_run r = shown(p, row.first, row.end); r.first < r.end; r = shown(p, r.end, row.end))
        for (size_t k = OWN_PLANES; k < PLANES; k++) clear_plane(p->sums, k, r);
}

static void light_block(const pass *p, const sl_lit_block *block, unsigned worker, sl_counters *counters) {
    const sl_direct *direct = p->direct;
    sl_direct_scratch *scratch = &p->scratch[worker];
    uint32_t pilot = pilot_samples(direct);
    sl_sample_range range = {p->refine ? pilot : 0, p->refine ? samples_with_refinement(direct) : pilot};
    if (block->count == 0) return;
    if (direct->sides.count) sl_direct_exact(direct, block, range, scratch, p->sums, counters);
    if (p->refine) return;
    sl_direct_delta(direct, p->gbuffer, block, p->sums, counters);
    if (!direct->sides.count && direct->scene->emitter_count)
        sl_direct_sampled(direct, block, false, p->sums, counters);
    if (direct->settings.sun) sl_direct_sampled(direct, block, true, p->sums, counters);
}

static bool takes_part(const pass *p, size_t i) {
    if (!p->refine) return sl_pixel_reflects(p->gbuffer, p->direct->scene, i);
    return p->sums->samples[i - p->sums->first] > 0.0f &&
           sl_direct_is_near(p->sums, p->sums->partly, p->gbuffer, i, PENUMBRA_MARGIN);
}

/* Blocks are lit as they are full; the last one is left. */
static void sample_row(const pass *p, int y, sl_lit_block *block, unsigned worker, sl_counters *counters) {
    const sl_gbuffer *g = p->gbuffer;
    const size_t width = (size_t)g->width, row = (size_t)y * width;
    if (!p->refine) clear_row(p, (sl_pixel_run){row, row + width});
    for (sl_pixel_run r = shown(p, row, row + width); r.first < r.end; r = shown(p, r.end, row + width)) {
        for (size_t i = r.first; i < r.end; i++) {
            if (!takes_part(p, i)) continue;
            sl_lit_block_add(p->direct, g, i, block);
            if (block->count < SL_LIGHT_BLOCK) continue;
            light_block(p, block, worker, counters);
            block->count = 0;
        }
    }
}

/* Rows of an item that the pass looks at: the same item of every pass has the same rows. A few, so that what
 * is left of a block is little. */
static int first_row(const pass *p, size_t index) {
    return sl_greater(p->row, p->row0 + (int)index * p->each);
}
static int end_row(const pass *p, size_t index) {
    return sl_lesser(p->end, p->row0 + (int)(index + 1) * p->each);
}

static void sample_rows(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    (void)result;
    const pass *p = context;
    const int first = first_row(p, index), end = end_row(p, index);
    const size_t width = (size_t)p->gbuffer->width;
    sl_lit_block block;
    block.count = 0;
    for (int y = first; y < end; y++) sample_row(p, y, &block, worker, counters);
    light_block(p, &block, worker, counters);
    if (!p->last || first >= end) return;
    const size_t pixel = (size_t)first * width, behind = (size_t)end * width;
    for (sl_pixel_run r = shown(p, pixel, behind); r.first < r.end; r = shown(p, r.end, behind))
        sl_direct_find_scatter(p->sums, r.first - p->sums->first, r.end - r.first);
}

/* Pixels [first, end) of a row, whose visible shares are in the planes of light. */
static void finish_run(const pass *p, size_t first, size_t end, unsigned worker, sl_counters *counters) {
    const sl_gbuffer *g = p->gbuffer;
    const sl_direct *direct = p->direct;
    const float *diffuse[3] = {g->diffuse_r, g->diffuse_g, g->diffuse_b};
    for (size_t i = first; i < end; i++) {
        size_t k = i - p->sums->first;
        if (g->material[i] == SL_NO_INDEX) {
            for (int c = 0; c < 3; c++) p->sums->light[c][k] = 0.0f;
            continue;
        }
        bool lobe = direct->glossy && direct->sampler && sl_pixel_is_glossy(g, direct->scene, i);
        sl_rgb exact = {p->sums->exact[0][k], p->sums->exact[1][k], p->sums->exact[2][k]},
               glossy = {0.0f, 0.0f, 0.0f};
        if (lobe)
            glossy = sl_direct_lobe(direct, g, i, sl_luminance(exact) * direct->sides.unit,
                                    sl_direct_samples(direct), &p->scratch[worker],
                                    counters);
        const float lobes[3] = {glossy.r, glossy.g, glossy.b};
        for (int c = 0; c < 3; c++) {
            float e = p->sums->plain[c][k] + p->sums->exact[c][k] * p->sums->light[c][k] * direct->sides.unit;
            /* black times infinite is black */
            float reflected = sl_picture_value(diffuse[c][i] * (float)(1.0 / SL_PI) * e);
            p->sums->light[c][k] = sl_picture_value(reflected + p->sums->glossy[c][k] + lobes[c]);
        }
    }
}

static void finish_row(const pass *p, int y, unsigned worker, sl_counters *counters) {
    const size_t width = (size_t)p->gbuffer->width, row = (size_t)y * width;
    for (sl_pixel_run r = shown(p, row, row + width); r.first < r.end; r = shown(p, r.end, row + width)) {
        /* The mean of sub-frames that are all blurred alike does not converge, and that of many is smooth. */
        sl_direct_filter_run(p->sums, p->gbuffer, y, r, !has_many(p->direct));
        finish_run(p, r.first, r.end, worker, counters);
    }
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, width);
}

static void finish_rows(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    (void)result;
    const pass *p = context;
    for (int y = first_row(p, index); y < end_row(p, index); y++) finish_row(p, y, worker, counters);
}

/* ---- a strip ---- */

/* Runs a pass over rows [first, end) and `margin` more on either side, as far as there are any. It gives
 * planes [plane, behind) of the sums to who reads them next. */
static void run(pass *p, sl_batch_work *work, int first, int end, int margin, size_t plane, size_t behind) {
    sl_batch_plane planes[PLANES];
    const size_t item = (size_t)p->each * (size_t)p->gbuffer->width,
                 rows = p->sums->count / (size_t)p->gbuffer->width;
    p->row = sl_greater(first - margin, 0);
    p->end = sl_lesser(end + margin, p->gbuffer->height);
    for (size_t k = plane; k < behind; k++)
        planes[k - plane] = (sl_batch_plane){p->sums->block + k * p->sums->count, item * sizeof(float)};
    const sl_batch batch = {.count = rows / (size_t)p->each, .work = work, .context = p, .shared = true,
                            .planes = planes, .plane_count = (unsigned)(behind - plane)};
    sl_batch_run(&batch, p->direct->settings.threads, p->counters);
}

static void run_all(pass *p, int first, int end) {
    const bool refined = samples_with_refinement(p->direct) > pilot_samples(p->direct);
    p->last = !refined;
    run(p, sample_rows, first, end, MARGIN, refined ? PENUMBRA_PLANE : FILTER_PLANES,
        refined ? FILTER_PLANES : LIGHT_PLANES);
    p->refine = p->last = true;
    if (refined) run(p, sample_rows, first, end, FILTER_MARGIN, FILTER_PLANES, LIGHT_PLANES);
    run(p, finish_rows, first, end, 0, LIGHT_PLANES, PLANES_WITHIN);
}

static void put_row(const pass *p, int y, float *const radiance[3]) {
    const size_t width = (size_t)p->gbuffer->width, row = (size_t)y * width;
    for (sl_pixel_run r = shown(p, row, row + width); r.first < r.end; r = shown(p, r.end, row + width))
        for (int c = 0; c < 3; c++)
            memcpy(radiance[c] + r.first, p->sums->light[c] + (r.first - p->sums->first),
                   (r.end - r.first) * sizeof(float));
}

static sl_status light_strip(const sl_direct *direct, const sl_gbuffer *gbuffer, int first, int end,
                             float *const radiance[3], sl_counters *counters, sl_error *error) {
    const int each = SAMPLED_ROWS, row0 = sl_greater(first - MARGIN, 0),
              lines = sl_lesser(end + MARGIN, gbuffer->height) - row0 + each - 1;
    const size_t width = (size_t)gbuffer->width;
    sl_direct_sums sums;
    pass p = {direct, gbuffer, .row0 = row0, .each = each, .sums = &sums, .counters = counters};
    p.scratch = sl_allocate_unset(sl_thread_count(direct->settings.threads), sizeof *p.scratch);
    const bool made = make_sums((size_t)row0 * width, (size_t)(lines - lines % each) * width, &sums) &&
                      p.scratch;
    if (made) run_all(&p, first, end);
    for (int y = first; made && y < end; y++) put_row(&p, y, radiance);
    sl_free(sums.block);
    sl_free(p.scratch);
    return made ? SL_OK : sl_fail_memory(error, "direct light");
}

sl_status sl_direct_rows(const sl_direct *direct, const sl_gbuffer *gbuffer, int rows, int *row,
                         float *const radiance[3], sl_counters *counters, sl_error *error) {
    const int first = *row, end = *row = sl_lesser(first + rows, gbuffer->height);
    return sl_direct_is_mapped(direct)
               ? sl_direct_mapped_rows(direct, gbuffer, first, end, radiance, counters, error)
               : light_strip(direct, gbuffer, first, end, radiance, counters, error);
}
