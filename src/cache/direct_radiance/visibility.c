#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/direct_radiance/direct_radiance.h"
#include "cache/direct_radiance/receivers.h"

#include <string.h>

enum { BLOCK = 4 };

struct sl_sight {
    const sl_light_pass *pass;
    const sl_receivers *receivers;
    sl_sight_kernels kernels;
    sl_weigh_photon *weigh;
    const void *context;
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

/* A photon that stands for several texels lies at their mean, which on a curved surface is a little inside.
 * Within a group normals differ by at most 20 degrees: the mean is at most 0.09 of the footprint's radius
 * deep. */
static sl_vec3 ray_end(const sl_map_photon *p, float offset) {
    float area = p->cos_alpha > 0.0f ? p->footprint / p->cos_alpha : 0.0f,
          lift = 0.1f * sqrtf(area * (float)(1.0 / SL_PI));
    return sl_mad(p->position, lift > offset && isfinite(lift) ? lift : offset, p->normal);
}

static void set_ray(const sl_sight *s, const sl_receiver_tile *t, size_t i, sl_vec3 end, unsigned k,
                    sl_ray16 *rays) {
    sl_vec3 p = sl_v3(t->x[i], t->y[i], t->z[i]);
    sl_vec3 origin = sl_mad(p, sl_scene_offset_at(s->pass->scene, s->offset, p),
                            sl_v3(t->geometric_x[i], t->geometric_y[i], t->geometric_z[i]));
    sl_ray16_set(rays, k, origin, sl_sub(end, origin), 0.0f, 0.9999f, s->receivers->gbuffer->id[t->pixel[i]]);
}

/* Rays on their way, sixteen at a time: neighbours towards one photon where there are so many. */
typedef struct {
    sl_ray16 rays;
    unsigned count;
    uint8_t lane[SL_PACKET], bit[SL_PACKET];
} packet;
_Static_assert(SL_TILE_PIXELS <= UINT8_MAX + 1, "lanes are bytes");

static void flush(const sl_sight *s, packet *p, uint32_t *seen, sl_counters *counters) {
    if (p->count == 0) return;
    uint32_t occluded = sl_trace_occluded(s->pass->tracer, &p->rays, p->count, true, counters);
    for (unsigned k = 0; k < p->count; k++) seen[p->lane[k]] |= (~occluded >> k & 1u) << p->bit[k];
    p->count = 0;
}

/* The k-th lane of a whole tile, squares of 4 x 4 pixels one after another: neighbours' rays meet the same
 * triangles. */
static size_t lane_in_squares(const sl_receiver_tile *tile, size_t k) {
    return tile->whole ? k / BLOCK % BLOCK * SL_TILE_WIDTH + k / (BLOCK * BLOCK) * BLOCK + k % BLOCK : k;
}
_Static_assert((int)BLOCK == (int)SL_TILE_HEIGHT, "a tile is a row of squares");

/* A ray for every bit of what is unsure; adds to what is seen. */
static void ask(const sl_sight *s, const sl_receiver_tile *tile, size_t first, size_t count,
                const uint32_t *unsure, uint32_t *seen, sl_counters *counters) {
    packet p = {.count = 0};
    uint32_t any = 0;
    for (size_t i = 0; i < tile->count; i++) any |= unsure[i];
    for (unsigned bit = 0; bit < count; bit++) {
        for (size_t k = 0; k < tile->count && (any >> bit & 1u); k++) {
            size_t i = lane_in_squares(tile, k);
            if (!(unsure[i] >> bit & 1u)) continue;
            p.lane[p.count] = (uint8_t)i;
            p.bit[p.count] = (uint8_t)bit;
            set_ray(s, tile, i, s->end[first + bit], p.count++, &p.rays);
            if (p.count == SL_PACKET) flush(s, &p, seen, counters);
        }
    }
    flush(s, &p, seen, counters);
}

/* Marks the photons that would send light to each receiver. */
static void find_wanted(const sl_sight *s, const sl_receiver_tile *tile, size_t first, size_t count,
                        sl_tile_sight *around) {
    float weight[SL_TILE_PIXELS];
    memset(around->wanted, 0, sizeof around->wanted);
    for (unsigned bit = 0; bit < count; bit++) {
        s->weigh(s->context, tile, first + bit, weight);
        s->kernels.want(tile->padded, bit, weight, around);
    }
}

/* Traces a ray for each photon and receiver. */
static void see_by_rays(const sl_sight *s, const sl_receiver_tile *tile, size_t first, size_t count,
                        sl_tile_sight *around, sl_counters *counters) {
    find_wanted(s, tile, first, count, around);
    memset(around->seen, 0, sizeof around->seen);
    ask(s, tile, first, count, around->wanted, around->seen, counters);
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
    sl_counters *counters; /* one a task */
} block_pass;

static void keep_planes(sl_sight *s, const sl_receiver_tile *t, const uint32_t *block) {
    const float *from[SL_BLOCK_PLANES] = {t->x,           t->y,           t->z,
                                          t->geometric_x, t->geometric_y, t->geometric_z,
                                          t->normal_x,    t->normal_y,    t->normal_z};
    for (int p = 0; p < SL_BLOCK_PLANES; p++) {
        for (size_t i = 0; i < t->count; i++) s->planes.value[p][block[i]] = from[p][i];
    }
}

static size_t photons_of_word(const sl_sight *s, size_t word) {
    size_t left = s->pass->photons->count - word * SL_SIGHT_PHOTONS;
    return left < SL_SIGHT_PHOTONS ? left : SL_SIGHT_PHOTONS;
}

/* Pixels that stand for 32 x 4 blocks, squares of 4 x 4 blocks one after another; block: which they stand
 * for. */
static void list_blocks(const block_pass *b, int x0, int y0, sl_receiver_tile *tile,
                        uint32_t block[SL_TILE_PIXELS]) {
    sl_sight *s = b->sight;
    for (int k = 0; k < SL_TILE_PIXELS; k++) {
        int x = x0 + k / (BLOCK * BLOCK) * BLOCK + k % BLOCK, y = y0 + k / BLOCK % BLOCK;
        if (x >= s->columns || y >= s->rows) continue;
        uint32_t index = (uint32_t)(y * s->columns + x), pixel = standing_pixel(s->receivers, b->kinds, x, y);
        s->pixel[index] = pixel;
        block[tile->count] = index;
        tile->pixel[tile->count] = pixel;
        tile->count += pixel != SL_NO_INDEX ? 1 : 0;
    }
}

static int tiles_across(const sl_sight *s) { return (s->columns + SL_TILE_WIDTH - 1) / SL_TILE_WIDTH; }

/* A tile's worth of blocks, and all photons. */
static void trace_blocks(void *context, size_t index, unsigned worker) {
    (void)worker;
    const block_pass *b = context;
    sl_sight *s = b->sight;
    uint32_t block[SL_TILE_PIXELS];
    sl_receiver_tile tile = {.count = 0};
    int across = tiles_across(s);
    list_blocks(b, (int)index % across * SL_TILE_WIDTH, (int)index / across * SL_TILE_HEIGHT, &tile, block);
    if (tile.count == 0) return;
    const sl_receiver_kernels kernels = sl_receiver_kernels_for(sl_isa_best());
    sl_receiver_tile_fetch(s->receivers->gbuffer, &kernels, &tile);
    keep_planes(s, &tile, block);
    sl_tile_sight of_blocks;
    for (size_t word = 0; word < s->words; word++) {
        see_by_rays(s, &tile, word * SL_SIGHT_PHOTONS, photons_of_word(s, word), &of_blocks,
                    &b->counters[index]);
        for (size_t i = 0; i < tile.count; i++) {
            s->known[block[i] * s->words + word] = of_blocks.wanted[i];
            s->seen[block[i] * s->words + word] = of_blocks.seen[i];
        }
    }
}

static sl_status make_blocks(sl_sight *s, block_pass *pass, sl_counters *counters, sl_error *error) {
    size_t photons = s->pass->photons->count;
    s->columns = (s->receivers->width + BLOCK - 1) / BLOCK;
    s->rows = (s->receivers->height + BLOCK - 1) / BLOCK;
    s->words = (photons + SL_SIGHT_PHOTONS - 1) / SL_SIGHT_PHOTONS;
    size_t blocks = (size_t)s->columns * (size_t)s->rows;
    size_t tasks = (size_t)(tiles_across(s) * ((s->rows + SL_TILE_HEIGHT - 1) / SL_TILE_HEIGHT));
    /* lanes index by 32 bits */
    if (blocks * s->words > INT32_MAX) return sl_fail_memory(error, "visibility of photons");
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

sl_status sl_sight_create(const sl_light_pass *pass, const sl_receivers *receivers,
                          const sl_receiver_kinds *kinds, sl_weigh_photon *weigh, const void *context,
                          sl_sight **sight, sl_counters *counters, sl_error *error) {
    sl_sight *s = *sight = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "visibility of photons");
    *s = (sl_sight){.pass = pass, .receivers = receivers, .offset = 1e-5f * pass->scene->scale,
                    .kernels = sl_sight_kernels_for(sl_isa_best()), .weigh = weigh, .context = context,
                    .end = sl_allocate(pass->photons->count, sizeof *s->end)};
    if (!s->end) return sl_fail_memory(error, "visibility of photons");
    for (size_t j = 0; j < pass->photons->count; j++)
        s->end[j] = ray_end(&pass->photons->photon[j], s->offset);
    block_pass blocks = {s, kinds, NULL};
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

/* The pixel's own block and its nearest neighbours: across, up, and both; as far as they show the same
 * object. */
static void set_blocks(const sl_sight *s, uint32_t pixel, size_t i, sl_tile_sight *around) {
    int width = s->receivers->width, x = (int)pixel % width, y = (int)pixel / width, column = x / BLOCK,
        row = y / BLOCK;
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
        sl_vec3 to_eye =
            sl_sub(sl_receiver_eye(s->receivers, pixel), sl_v3(tile->x[i], tile->y[i], tile->z[i]));
        reach[i] = 0.01f * sl_dot(to_eye, to_eye);
        set_blocks(s, pixel, i, around);
    }
    s->kernels.fit(tile, &s->planes, reach, s->offset * s->offset, around);
}

void sl_sight_see(const sl_sight *s, const sl_receiver_tile *tile, sl_tile_sight *around, size_t first,
                  size_t count, sl_counters *counters) {
    if (!by_blocks(s)) {
        see_by_rays(s, tile, first, count, around, counters);
        return;
    }
    find_wanted(s, tile, first, count, around);
    s->kernels.agree(tile->padded, s->known, s->seen, s->words, first / SL_SIGHT_PHOTONS, around);
    for (size_t i = 0; i < tile->count; i++) {
        around->unsure[i] &= around->wanted[i];
        around->seen[i] &= ~around->unsure[i];
    }
    ask(s, tile, first, count, around->unsure, around->seen, counters);
}
