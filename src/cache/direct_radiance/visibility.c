#include "cache/direct_radiance/visibility.h"

#include "cache/direct_radiance/receiver_kernels.h"

#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"

enum { BLOCK = 4, WORD_BITS = 32 };

struct sl_sight {
    const sl_light_pass *pass;
    const sl_receivers *receivers;
    sl_sight_kernels kernels;
    float offset;
    sl_vec3 *end;             /* of a photon's rays */
    /* By blocks: */
    int columns, rows;
    uint32_t *pixel;          /* which stands for the block; SL_NO_INDEX where none receives light */
    sl_block_planes planes;   /* positions and normals of those pixels */
    float *plane_memory;
    size_t words;             /* of 32 photons each */
    uint32_t *known, *seen;   /* a block's answers lie together */
};

static bool by_blocks(const sl_sight *s) { return s->pass->visibility == SL_VISIBILITY_BLOCKS; }

/* ---- rays ---- */

/* A photon that stands for several texels lies at their mean, which on a curved surface is a little inside. Within a group normals
 * differ by at most 20 degrees: the mean is at most 0.09 of the footprint's radius deep. */
static sl_vec3 ray_end(const sl_map_photon *p, float offset) {
    float area = p->cos_alpha > 0.0f ? p->footprint / p->cos_alpha : 0.0f, lift = 0.1f * sqrtf(area * (float)(1.0 / SL_PI));
    return sl_mad(p->position, lift > offset && isfinite(lift) ? lift : offset, p->normal);
}

static void set_ray(const sl_sight *s, const sl_receiver_tile *t, size_t i, sl_vec3 end, unsigned k, sl_ray16 *rays) {
    sl_vec3 origin = sl_mad(sl_v3(t->x[i], t->y[i], t->z[i]), s->offset, sl_v3(t->geometric_x[i], t->geometric_y[i], t->geometric_z[i]));
    rays->origin_x[k] = origin.x, rays->origin_y[k] = origin.y, rays->origin_z[k] = origin.z;
    rays->direction_x[k] = end.x - origin.x, rays->direction_y[k] = end.y - origin.y, rays->direction_z[k] = end.z - origin.z;
    rays->near[k] = 0.0f;
    rays->far[k] = 0.9999f;
    rays->skip[k] = s->receivers->gbuffer->id[t->pixel[i]];
}

/* Rays of one photon, sixteen neighbours at a time. */
static void trace(const sl_sight *s, const sl_receiver_tile *tile, size_t photon, size_t count, const uint32_t *lanes, float *visible,
                  sl_counters *counters) {
    sl_ray16 rays;
    for (size_t first = 0; first < count; first += SL_PACKET) {
        unsigned size = count - first < SL_PACKET ? (unsigned)(count - first) : SL_PACKET;
        for (unsigned k = 0; k < size; k++) set_ray(s, tile, lanes[first + k], s->end[photon], k, &rays);
        uint32_t occluded = sl_trace_occluded(s->pass->tracer, &rays, size, true, counters);
        for (unsigned k = 0; k < size; k++) visible[lanes[first + k]] = occluded >> k & 1u ? 0.0f : 1.0f;
    }
}

/* Asks for those whose answer is still below 0. */
static void trace_missing(const sl_sight *s, const sl_receiver_tile *tile, size_t photon, float *visible, sl_counters *counters) {
    uint32_t lanes[SL_TILE_PIXELS];
    size_t count = 0;
    for (uint32_t i = 0; i < tile->count; i++) {
        if (visible[i] < 0.0f) lanes[count++] = i;
    }
    trace(s, tile, photon, count, lanes, visible, counters);
}

/* ---- blocks ---- */

/* The first of a block's pixels, from its middle outwards, that receives light. */
static uint32_t standing_pixel(const sl_receivers *r, const sl_receiver_kinds *kinds, int column, int row) {
    static const uint8_t order[BLOCK * BLOCK] = {5, 10, 6, 9, 1, 14, 4, 11, 2, 13, 7, 8, 0, 15, 3, 12};
    for (int k = 0; k < BLOCK * BLOCK; k++) {
        int x = column * BLOCK + order[k] % BLOCK, y = row * BLOCK + order[k] / BLOCK;
        if (x >= r->width || y >= r->height) continue;
        size_t pixel = (size_t)y * (size_t)r->width + (size_t)x;
        if (sl_receiver_kind_at(kinds, r->gbuffer, pixel) != SL_RECEIVER_NONE) return (uint32_t)pixel;
    }
    return SL_NO_INDEX;
}

typedef struct {
    sl_sight *sight;
    const sl_receiver_kinds *kinds;
    sl_weigh_photon *weigh;
    const void *context;
    sl_counters *counters; /* one a task */
} block_pass;

static void keep_planes(sl_sight *s, const sl_receiver_tile *t, const uint32_t *block) {
    const float *from[SL_BLOCK_PLANES] = {t->x,           t->y,        t->z,        t->geometric_x, t->geometric_y,
                                          t->geometric_z, t->normal_x, t->normal_y, t->normal_z};
    for (int p = 0; p < SL_BLOCK_PLANES; p++) {
        for (size_t i = 0; i < t->count; i++) s->planes.value[p][block[i]] = from[p][i];
    }
}

/* A tile's worth of blocks, one pixel of each, and all photons. */
static void trace_blocks(void *context, size_t index, unsigned worker) {
    (void)worker;
    const block_pass *b = context;
    sl_sight *s = b->sight;
    size_t blocks = (size_t)s->columns * (size_t)s->rows, first = index * SL_TILE_PIXELS;
    uint32_t block[SL_TILE_PIXELS];
    sl_receiver_tile tile = {.count = 0};
    for (size_t k = first; k < first + SL_TILE_PIXELS && k < blocks; k++) {
        s->pixel[k] = standing_pixel(s->receivers, b->kinds, (int)(k % (size_t)s->columns), (int)(k / (size_t)s->columns));
        block[tile.count] = (uint32_t)k;
        tile.pixel[tile.count] = s->pixel[k];
        tile.count += s->pixel[k] != SL_NO_INDEX ? 1 : 0;
    }
    if (tile.count == 0) return;
    sl_receiver_tile_fetch(s->receivers->gbuffer, sl_receiver_kernels_for(sl_isa_best()), &tile);
    keep_planes(s, &tile, block);
    for (size_t j = 0; j < s->pass->photons->count; j++) {
        float weight[SL_TILE_PIXELS], visible[SL_TILE_PIXELS];
        b->weigh(b->context, &tile, j, weight);
        for (size_t i = 0; i < tile.count; i++) visible[i] = weight[i] > 0.0f ? -1.0f : 0.0f;
        trace_missing(s, &tile, j, visible, &b->counters[index]);
        for (size_t i = 0; i < tile.count; i++) {
            size_t word = block[i] * s->words + j / WORD_BITS;
            s->known[word] |= (weight[i] > 0.0f ? 1u : 0u) << j % WORD_BITS;
            s->seen[word] |= (visible[i] > 0.0f ? 1u : 0u) << j % WORD_BITS;
        }
    }
}

static sl_status make_blocks(sl_sight *s, block_pass *pass, sl_counters *counters, sl_error *error) {
    size_t photons = s->pass->photons->count;
    s->columns = (s->receivers->width + BLOCK - 1) / BLOCK;
    s->rows = (s->receivers->height + BLOCK - 1) / BLOCK;
    s->words = (photons + WORD_BITS - 1) / WORD_BITS;
    size_t blocks = (size_t)s->columns * (size_t)s->rows, tasks = (blocks + SL_TILE_PIXELS - 1) / SL_TILE_PIXELS;
    if (blocks * s->words > INT32_MAX) return sl_fail_memory(error, "visibility of photons"); /* lanes index by 32 bits */
    s->pixel = sl_allocate(blocks, sizeof *s->pixel);
    s->plane_memory = sl_allocate(blocks, SL_BLOCK_PLANES * sizeof *s->plane_memory);
    s->known = sl_allocate(blocks, s->words * sizeof *s->known);
    s->seen = sl_allocate(blocks, s->words * sizeof *s->seen);
    pass->counters = sl_allocate(tasks, sizeof *pass->counters);
    bool made = s->pixel && s->plane_memory && s->known && s->seen && pass->counters;
    for (size_t p = 0; p < SL_BLOCK_PLANES && made; p++) s->planes.value[p] = s->plane_memory + p * blocks;
    if (made) sl_parallel_for(sl_thread_count(s->pass->threads), tasks, trace_blocks, pass);
    for (size_t i = 0; i < tasks && made; i++) sl_counters_add(counters, &pass->counters[i]);
    sl_free(pass->counters);
    return made ? SL_OK : sl_fail_memory(error, "visibility of photons");
}

/* ---- a frame's ---- */

sl_status sl_sight_create(const sl_light_pass *pass, const sl_receivers *receivers, const sl_receiver_kinds *kinds,
                          sl_weigh_photon *weigh, const void *context, sl_sight **sight, sl_counters *counters, sl_error *error) {
    sl_sight *s = *sight = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "visibility of photons");
    *s = (sl_sight){.pass = pass, .receivers = receivers, .offset = 1e-5f * pass->scene->diagonal,
                    .kernels = sl_sight_kernels_for(sl_isa_best()), .end = sl_allocate(pass->photons->count, sizeof *s->end)};
    if (!s->end) return sl_fail_memory(error, "visibility of photons");
    for (size_t j = 0; j < pass->photons->count; j++) s->end[j] = ray_end(&pass->photons->photon[j], s->offset);
    block_pass blocks = {s, kinds, weigh, context, NULL};
    return by_blocks(s) ? make_blocks(s, &blocks, counters, error) : SL_OK;
}

void sl_sight_destroy(sl_sight *s) {
    if (!s) return;
    sl_free(s->end);
    sl_free(s->pixel);
    sl_free(s->plane_memory);
    sl_free(s->known);
    sl_free(s->seen);
    sl_free(s);
}

/* ---- a tile's ---- */

static uint32_t object_at(const sl_sight *s, uint32_t pixel) {
    uint32_t triangle = s->receivers->gbuffer->id[pixel];
    return triangle < s->pass->scene->triangle_count ? s->pass->scene->object_index[triangle] : SL_NO_INDEX;
}

/* The pixel's own block and its nearest neighbours: across, up, and both; as far as they show the same object. */
static void set_blocks(const sl_sight *s, uint32_t pixel, size_t i, sl_tile_sight *around) {
    int width = s->receivers->width, x = (int)pixel % width, y = (int)pixel / width, column = x / BLOCK, row = y / BLOCK;
    int across = x % BLOCK < BLOCK / 2 ? -1 : 1, up = y % BLOCK < BLOCK / 2 ? -1 : 1;
    uint32_t object = object_at(s, pixel);
    for (int k = 0; k < SL_SIGHT_BLOCKS; k++) {
        int c = column + (k & 1 ? across : 0), r = row + (k & 2 ? up : 0);
        bool inside = c >= 0 && r >= 0 && c < s->columns && r < s->rows;
        int block = inside ? r * s->columns + c : row * s->columns + column;
        uint32_t standing = s->pixel[block];
        around->block[k][i] = block;
        around->fits[k][i] = standing != SL_NO_INDEX && object_at(s, standing) == object ? UINT32_MAX : 0u;
    }
}

void sl_sight_begin_tile(const sl_sight *s, const sl_receiver_tile *tile, sl_tile_sight *around) {
    if (!by_blocks(s)) return;
    float reach[SL_TILE_PIXELS];
    for (size_t i = 0; i < tile->padded; i++) {
        uint32_t pixel = tile->pixel[i < tile->count ? i : 0];
        sl_vec3 to_eye = sl_sub(sl_receiver_eye(s->receivers, pixel), sl_v3(tile->x[i], tile->y[i], tile->z[i]));
        reach[i] = 0.01f * sl_dot(to_eye, to_eye);
        set_blocks(s, pixel, i, around);
    }
    s->kernels.fit(tile, &s->planes, reach, s->offset * s->offset, around);
}

void sl_sight_see(const sl_sight *s, const sl_receiver_tile *tile, sl_tile_sight *around, size_t photon, const float *weight,
                  float *visible, sl_counters *counters) {
    if (by_blocks(s)) {
        if (photon % WORD_BITS == 0) s->kernels.agree(tile->padded, s->known, s->seen, s->words, photon / WORD_BITS, around);
        s->kernels.tell(tile->padded, around, photon % WORD_BITS, weight, visible);
    } else {
        for (size_t i = 0; i < tile->padded; i++) visible[i] = weight[i] > 0.0f ? -1.0f : 0.0f;
    }
    trace_missing(s, tile, photon, visible, counters);
}
