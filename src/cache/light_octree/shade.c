#include "cache/light_octree/shade.h"

#include "base/code_sort.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"

/* ---- where a point lies ---- */

/* Its eight voxels are cell + {0,1}^3. */
typedef struct voxel_place {
    int32_t cell[3];
    float t[3];
} voxel_place;

static bool is_glossy(const sl_octree_point *p) { return sl_rgb_max(p->specular) > 0.0f; }

/* b = floor(p 2^d - 1/2), or the cell itself with the nearest filter. False: the point gets no light. */
static bool find_place(const sl_octree_shading *shading, const sl_octree_point *p, voxel_place *place) {
    const sl_voxel_texture *t = shading->texture;
    const double cells = (double)(1u << t->depth);
    const double u[3] = {((double)p->position.x - t->origin.x) * t->scale,
                         ((double)p->position.y - t->origin.y) * t->scale,
                         ((double)p->position.z - t->origin.z) * t->scale};
    float length = sl_dot(p->normal, p->normal);
    if (!(length > 0.0f && length < 4.0f)) return false;
    for (int axis = 0; axis < 3; axis++) {
        if (!(u[axis] >= 0.0 && u[axis] < cells)) return false; /* outside, or NaN */
        const double at = shading->filter == SL_VOXEL_NEAREST ? u[axis] : u[axis] - 0.5;
        const int32_t low = at < 0.0 ? -1 : (int32_t)at;
        place->cell[axis] = low;
        place->t[axis] = (float)(at - low);
    }
    return true;
}

/* ---- the voxels around ---- */

static void fetch_corner(const sl_voxel_texture *t, size_t at, sl_shade_corner *corner, uint64_t *fetches) {
    corner->sets = 0;
    if (at == SIZE_MAX) return;
    for (bool more = true; more && corner->sets < SL_VOXEL_SETS_MAX;) {
        sl_shade_set *set = &corner->set[corner->sets++];
        *set = sl_voxel_texture_set(t, at);
        at += (size_t)(1 + set->lights);
        *fetches += (uint64_t)(1 + set->lights);
        more = set->more;
    }
}

static void fetch_cells(const sl_octree_shading *shading, const int32_t first[3], sl_shade_cells *cells,
                        uint64_t *fetches) {
    const sl_voxel_texture *t = shading->texture;
    cells->corners = shading->filter == SL_VOXEL_NEAREST ? 1 : 8;
    cells->lobes = t->lobes;
    cells->keep_void_dark = shading->keep_void_dark;
    cells->facing = shading->facing;
    for (int k = 0; k < cells->corners; k++) {
        const int32_t cell[3] = {first[0] + (k & 1), first[1] + (k >> 1 & 1), first[2] + (k >> 2)};
        fetch_corner(t, sl_voxel_texture_find(t, cell, fetches), &cells->corner[k], fetches);
    }
}

/* ---- blocks of points that share them ---- */

/* One of n lights stands for what comes from a cap of 2 pi / n, whose mean squared chord to its axis is 1 /
 * n; a lobe's is 2 / (e + 2). Sharper ones would fall between the lights, and show dots on black: they are
 * widened to the cap, and reflect as much. */
static float widest_exponent(const sl_voxel_texture *t) {
    return t->lobes != SL_LOBES_NONE ? (float)(2 * t->lights - 2) : INFINITY;
}

static void load_point(const sl_octree_point *p, const voxel_place *place, bool glossy, float widest,
                       sl_shade_block *b, size_t at) {
    b->tx[at] = place->t[0];
    b->ty[at] = place->t[1];
    b->tz[at] = place->t[2];
    b->nx[at] = p->normal.x;
    b->ny[at] = p->normal.y;
    b->nz[at] = p->normal.z;
    b->mx[at] = b->my[at] = b->mz[at] = b->exponent[at] = 0.0f;
    if (!glossy) return;
    sl_vec3 mirrored = sl_sub(sl_scale(p->normal, 2.0f * sl_dot(p->normal, p->view)), p->view);
    b->mx[at] = mirrored.x;
    b->my[at] = mirrored.y;
    b->mz[at] = mirrored.z;
    b->exponent[at] = fminf(p->exponent, widest);
}

/* kd / pi E + ks lobes. */
static float reflect(float diffuse, float specular, bool glossy, float irradiance, float lobe) {
    float radiance = diffuse * (float)(1.0 / SL_PI) * irradiance;
    return glossy ? radiance + specular * lobe : radiance;
}

static void put_light(const sl_octree_points *points, size_t index, const sl_octree_point *p, bool glossy,
                      const sl_shade_block *b, size_t k) {
    const float diffuse[3] = {p->diffuse.r, p->diffuse.g, p->diffuse.b},
                specular[3] = {p->specular.r, p->specular.g, p->specular.b};
    float rgb[3];
    for (int c = 0; c < 3; c++)
        rgb[c] = reflect(diffuse[c], specular[c], glossy, b->irradiance[c][k], b->lobe[c][k]);
    points->put(points->context, index, rgb);
}

/* ---- all points ---- */

typedef struct worker_scratch {
    sl_shade_block block;
    sl_shade_cells cells;
    sl_octree_point point[SL_OCTREE_BLOCK];
    voxel_place place[SL_OCTREE_BLOCK];
    /* points one behind another in the same voxels: the cell and whether they are glossy, the first one's
     * number in the block; and by that number how many they are */
    sl_coded run[SL_OCTREE_BLOCK];
    uint16_t length[SL_OCTREE_BLOCK];
    uint16_t order[SL_OCTREE_BLOCK]; /* numbers of points that share their eight voxels */
    sl_counters counters;
} worker_scratch;

enum { CELL_BITS = 11 /* from -1 on */ };

typedef struct shading_pass {
    const sl_octree_shading *shading;
    const sl_octree_points *points;
    sl_isa isa;
    worker_scratch *scratch;
} shading_pass;

/* Spreads neighbours over the sort's piles, by an odd factor (Knuth's of the golden ratio): any order of
 * cells will do. */
static uint64_t key_of(const sl_octree_point *p, const voxel_place *place) {
    uint64_t key = is_glossy(p);
    for (int axis = 0; axis < 3; axis++) key = key << CELL_BITS | (uint64_t)(place->cell[axis] + 1);
    return key * UINT64_C(0x9e3779b97f4a7c15);
}

/* Lists runs of a block's points that get light, those of the same eight voxels side by side; returns how
 * many. */
static size_t list_runs(const shading_pass *pass, size_t first, worker_scratch *s) {
    const float dark[3] = {0.0f, 0.0f, 0.0f};
    size_t left = pass->points->count - first, runs = 0, begin = 0, end = SIZE_MAX;
    uint64_t before = 0;
    for (size_t i = 0; i < SL_OCTREE_BLOCK && i < left; i++) {
        if (!pass->points->find(pass->points->context, first + i, &s->point[i])) continue;
        sl_count(&s->counters, SL_COUNT_FRAGMENTS_SHADED, 1);
        if (!find_place(pass->shading, &s->point[i], &s->place[i])) {
            pass->points->put(pass->points->context, first + i, dark);
            continue;
        }
        const uint64_t key = key_of(&s->point[i], &s->place[i]);
        if (i != end || key != before) {
            s->run[runs++] = (sl_coded){key, (uint32_t)i};
            s->length[begin = i] = 0;
        }
        s->length[begin]++;
        before = key;
        end = i + 1;
    }
    sl_sort_coded(s->run, runs);
    return runs;
}

/* Shades points of the same eight voxels, which have been fetched. */
static void shade_points(const shading_pass *pass, size_t first, const uint16_t *order, size_t count,
                         worker_scratch *s) {
    static const size_t LANES = SL_SHADE_LANES;
    bool glossy = is_glossy(&s->point[order[0]]);
    float widest = widest_exponent(pass->shading->texture);
    size_t padded = (count + LANES - 1) / LANES * LANES;
    for (size_t k = 0; k < padded; k++) {
        size_t i = order[k < count ? k : count - 1];
        load_point(&s->point[i], &s->place[i], glossy, widest, &s->block, k);
    }
    SL_KERNEL_OF(pass->isa, sl_shade_block)(&s->cells, padded, glossy, &s->block);
    for (size_t k = 0; k < count; k++)
        put_light(pass->points, first + order[k], &s->point[order[k]], glossy, &s->block, k);
}

/* Puts the points of runs of one key in order; returns how many. *run: the first one behind them. */
static size_t order_points(worker_scratch *s, size_t *run, size_t runs) {
    const uint64_t key = s->run[*run].code;
    size_t count = 0;
    for (; *run < runs && s->run[*run].code == key; ++*run) {
        const size_t begin = s->run[*run].item;
        for (size_t i = 0; i < s->length[begin]; i++) s->order[count++] = (uint16_t)(begin + i);
    }
    return count;
}

static void shade_block(void *context, size_t index, unsigned worker) {
    const shading_pass *pass = context;
    worker_scratch *s = &pass->scratch[worker];
    const size_t first = index * SL_OCTREE_BLOCK, runs = list_runs(pass, first, s);
    for (size_t run = 0; run < runs;) {
        const size_t count = order_points(s, &run, runs);
        uint64_t fetches = 0;
        fetch_cells(pass->shading, s->place[s->order[0]].cell, &s->cells, &fetches);
        sl_count(&s->counters, SL_COUNT_TEXTURE_FETCHES, fetches * count); /* as each fragment would */
        for (size_t at = 0; at < count; at += SL_SHADE_BLOCK)
            shade_points(pass, first, s->order + at,
                         count - at < SL_SHADE_BLOCK ? count - at : SL_SHADE_BLOCK, s);
    }
}

sl_status sl_octree_shade(const sl_octree_shading *shading, const sl_octree_points *points, unsigned threads,
                          sl_counters *counters, sl_error *error) {
    size_t blocks = (points->count + SL_OCTREE_BLOCK - 1) / SL_OCTREE_BLOCK;
    threads = sl_thread_count(threads);
    shading_pass pass = {shading, points, sl_isa_best(), sl_allocate_unset(threads, sizeof *pass.scratch)};
    if (!pass.scratch) return sl_fail_memory(error, "shading");
    for (unsigned i = 0; i < threads; i++) pass.scratch[i].counters = (sl_counters){{0}};
    sl_parallel_for(threads, blocks, shade_block, &pass);
    for (unsigned i = 0; i < threads; i++) sl_counters_add(counters, &pass.scratch[i].counters);
    sl_free(pass.scratch);
    return SL_OK;
}

bool sl_octree_see(const sl_octree_shading *shading, const sl_octree_point *point, sl_octree_seen *seen) {
    const float widest = widest_exponent(shading->texture);
    uint64_t fetches = 0;
    voxel_place place;
    if (!find_place(shading, point, &place)) return false;
    *seen = (sl_octree_seen){.cell = {place.cell[0], place.cell[1], place.cell[2]},
                             .glossy = is_glossy(point)};
    fetch_cells(shading, place.cell, &seen->cells, &fetches);
    for (size_t k = 0; k < SL_SHADE_LANES; k++)
        load_point(point, &place, seen->glossy, widest, &seen->block, k);
    return true;
}
