#include "cache/light_octree/shade.h"

#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"

enum {
    TABLE = 2 * SL_OCTREE_BATCH,
    TILE = 64,
    NONE = -1
};

static const uint64_t NOWHERE = UINT64_MAX;

/* Where a point lies: its eight voxels are cell + {0,1}^3. */
typedef struct voxel_place {
    uint64_t key;          /* of cell, and whether the point is glossy; NOWHERE: it gets no light */
    float t[3];
} voxel_place;

typedef struct voxel_group {
    uint64_t key;
    int32_t cell[3];
    bool glossy;
    uint32_t count, first;
} voxel_group;

struct sl_octree_scratch {
    sl_shade_kernel *kernel;
    sl_shade_block block;
    sl_shade_cells cells;
    voxel_place place[SL_OCTREE_BATCH];
    voxel_group group[SL_OCTREE_BATCH];
    int32_t group_of[SL_OCTREE_BATCH];
    uint32_t order[SL_OCTREE_BATCH];
    int32_t table[TABLE];
    size_t groups;
    /* A tile of a G-buffer. */
    uint32_t pixel[SL_OCTREE_BATCH];
    sl_octree_point point[SL_OCTREE_BATCH];
    float out[3][SL_OCTREE_BATCH];
};

sl_status sl_octree_scratch_create(sl_octree_scratch **scratch, sl_error *error) {
    *scratch = sl_allocate(1, sizeof **scratch);
    if (!*scratch) return sl_fail_memory(error, "shading");
    (*scratch)->kernel = sl_shade_kernel_for(sl_isa_best());
    return SL_OK;
}

void sl_octree_scratch_destroy(sl_octree_scratch *scratch) { sl_free(scratch); }

/* ---- points by voxel ---- */

static bool is_glossy(const sl_octree_point *p) { return sl_rgb_max(p->specular) > 0.0f; }

/* b = floor(p 2^d - 1/2), or the cell itself with the nearest filter; 11 bits each, from -1 on. */
static voxel_place place_of(const sl_octree_shading *shading, const sl_octree_point *p, int32_t cell[3]) {
    const sl_voxel_texture *t = shading->texture;
    double cells = (double)(1u << t->depth), scale = cells / t->edge;
    bool nearest = shading->filter == SL_VOXEL_NEAREST;
    const double u[3] = {((double)p->position.x - t->origin.x) * scale,
                         ((double)p->position.y - t->origin.y) * scale,
                         ((double)p->position.z - t->origin.z) * scale};
    float length = sl_dot(p->normal, p->normal);
    voxel_place place = {.key = NOWHERE};
    if (!(length > 0.0f && length < 4.0f)) return place;
    for (int axis = 0; axis < 3; axis++) {
        if (!(u[axis] >= 0.0 && u[axis] < cells)) return place; /* outside, or NaN */
        double at = nearest ? u[axis] : u[axis] - 0.5, low = floor(at);
        cell[axis] = (int32_t)low;
        place.t[axis] = (float)(at - low);
    }
    place.key = (uint64_t)(cell[0] + 1) | (uint64_t)(cell[1] + 1) << 11 | (uint64_t)(cell[2] + 1) << 22 |
                (uint64_t)is_glossy(p) << 33;
    return place;
}

/* Neighbours mostly share a group, so the last one is asked first. */
static int32_t find_group(sl_octree_scratch *s, uint64_t key, int32_t last, const int32_t cell[3]) {
    if (last != NONE && s->group[last].key == key) return last;
    uint32_t slot = (uint32_t)((key * 0x9e3779b97f4a7c15u) >> 40) % TABLE;
    while (s->table[slot] != NONE && s->group[s->table[slot]].key != key) slot = (slot + 1) % TABLE;
    if (s->table[slot] == NONE) {
        s->table[slot] = (int32_t)s->groups;
        s->group[s->groups++] =
            (voxel_group){.key = key, .cell = {cell[0], cell[1], cell[2]}, .glossy = key >> 33 & 1};
    }
    return s->table[slot];
}

/* Groups in order of their first point, their points in order. */
static void group_points(const sl_octree_shading *shading, const sl_octree_point *point, size_t count,
                         sl_octree_scratch *s) {
    int32_t last = NONE;
    s->groups = 0;
    for (size_t i = 0; i < TABLE; i++) s->table[i] = NONE;
    for (size_t i = 0; i < count; i++) {
        int32_t cell[3] = {0, 0, 0};
        s->place[i] = place_of(shading, &point[i], cell);
        s->group_of[i] = NONE;
        if (s->place[i].key == NOWHERE) continue;
        s->group_of[i] = last = find_group(s, s->place[i].key, last, cell);
        s->group[last].count++;
    }
    uint32_t at = 0;
    for (size_t g = 0; g < s->groups; g++) {
        s->group[g].first = at;
        at += s->group[g].count;
        s->group[g].count = 0;
    }
    for (size_t i = 0; i < count; i++) {
        if (s->group_of[i] == NONE) continue;
        voxel_group *g = &s->group[s->group_of[i]];
        s->order[g->first + g->count++] = (uint32_t)i;
    }
}

/* ---- a group's voxels ---- */

static void fetch_corner(const sl_voxel_texture *t, size_t at, sl_shade_corner *corner, uint64_t *fetches) {
    corner->sets = 0;
    if (at == SIZE_MAX) return;
    for (bool more = true; more && corner->sets < SL_VOXEL_SETS_MAX;) {
        sl_set_head head = sl_voxel_texture_head(t, at);
        const float *d = t->unpacked[at].direction;
        sl_vec3 normal = head.has_normal ? sl_v3(d[0], d[1], d[2]) : sl_v3(0.0f, 0.0f, 0.0f);
        corner->set[corner->sets++] = (sl_shade_set){
            t->unpacked + at + 1, head.lights, normal, head.turn, head.one_sided, head.layer, head.height};
        at += (size_t)(1 + head.lights);
        *fetches += (uint64_t)(1 + head.lights);
        more = head.more;
    }
}

static void fetch_cells(const sl_octree_shading *shading, const voxel_group *group, sl_shade_cells *cells,
                        uint64_t *fetches) {
    const sl_voxel_texture *t = shading->texture;
    cells->corners = shading->filter == SL_VOXEL_NEAREST ? 1 : 8;
    cells->lobes = t->lobes;
    cells->keep_void_dark = shading->keep_void_dark;
    cells->facing = shading->facing;
    for (int k = 0; k < cells->corners; k++) {
        const int32_t cell[3] = {group->cell[0] + (k & 1), group->cell[1] + (k >> 1 & 1),
                                 group->cell[2] + (k >> 2)};
        fetch_corner(t, sl_voxel_texture_find(t, cell, fetches), &cells->corner[k], fetches);
    }
}

/* ---- blocks of a group's points ---- */

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

static void shade_block(const sl_octree_point *point, const voxel_group *group, size_t from, size_t count,
                        float widest, sl_octree_scratch *s, float *const out[3]) {
    static const size_t LANES = SL_SHADE_LANES;
    const uint32_t *order = s->order + group->first + from;
    size_t padded = (count + LANES - 1) / LANES * LANES;
    for (size_t k = 0; k < padded; k++) {
        uint32_t i = order[k < count ? k : count - 1];
        load_point(&point[i], &s->place[i], group->glossy, widest, &s->block, k);
    }
    s->kernel(&s->cells, padded, group->glossy, &s->block);
    for (size_t k = 0; k < count; k++) {
        const sl_octree_point *p = &point[order[k]];
        const float diffuse[3] = {p->diffuse.r, p->diffuse.g, p->diffuse.b},
                    specular[3] = {p->specular.r, p->specular.g, p->specular.b};
        for (int c = 0; c < 3; c++)
            out[c][order[k]] = reflect(diffuse[c], specular[c], group->glossy, s->block.irradiance[c][k],
                                       s->block.lobe[c][k]);
    }
}

void sl_octree_shade(const sl_octree_shading *shading, const sl_octree_point *point, size_t all,
                     sl_octree_scratch *s, float *r, float *g, float *b, sl_counters *counters) {
    float widest = widest_exponent(shading->texture);
    for (size_t first = 0; first < all; first += SL_OCTREE_BATCH) {
        size_t count = all - first < SL_OCTREE_BATCH ? all - first : SL_OCTREE_BATCH;
        float *const out[3] = {r + first, g + first, b + first};
        group_points(shading, point + first, count, s);
        for (int c = 0; c < 3; c++) memset(out[c], 0, count * sizeof *r);
        for (size_t k = 0; k < s->groups; k++) {
            const voxel_group *group = &s->group[k];
            uint64_t fetches = 0;
            fetch_cells(shading, group, &s->cells, &fetches);
            sl_count(counters, SL_COUNT_TEXTURE_FETCHES, fetches * group->count); /* as each fragment would */
            for (size_t from = 0; from < group->count; from += SL_SHADE_BLOCK) {
                size_t left = group->count - from;
                shade_block(point + first, group, from, left < SL_SHADE_BLOCK ? left : SL_SHADE_BLOCK, widest,
                            s, out);
            }
        }
    }
}

/* ---- a G-buffer ---- */

typedef struct tile_pass {
    const sl_octree_shading *shading;
    const sl_scene *scene;
    const sl_gbuffer *gbuffer;
    sl_vec3 eye;
    float *const *out;
    int tiles_across;
    sl_octree_scratch **scratch;
    sl_counters *counters;
} tile_pass;

static sl_octree_point point_of_pixel(const sl_scene *scene, const sl_gbuffer *g, sl_vec3 eye, size_t pixel) {
    const sl_material *m = &scene->materials[g->material[pixel]];
    sl_vec3 place = sl_v3(g->position_x[pixel], g->position_y[pixel], g->position_z[pixel]);
    sl_vec3 n = sl_v3(g->normal_x[pixel], g->normal_y[pixel], g->normal_z[pixel]);
    sl_vec3 from = g->seen_from ? g->seen_from[pixel] : eye;
    return (sl_octree_point){.position = place,
                             .normal = n,
                             .view = sl_material_is_glossy(m) ? sl_normalize_or(sl_sub(from, place), n) : n,
                             .diffuse = {g->diffuse_r[pixel], g->diffuse_g[pixel], g->diffuse_b[pixel]},
                             .specular = m->specular,
                             .exponent = m->exponent};
}

bool sl_octree_pixel_cells(const sl_octree_shading *shading, const sl_scene *scene, const sl_gbuffer *gbuffer,
                           sl_vec3 eye, size_t pixel, sl_octree_pixel *out) {
    uint64_t fetches = 0;
    *out = (sl_octree_pixel){.point = point_of_pixel(scene, gbuffer, eye, pixel)};
    voxel_place place = place_of(shading, &out->point, out->cell);
    if (place.key == NOWHERE) return false;
    voxel_group group = {.cell = {out->cell[0], out->cell[1], out->cell[2]}};
    out->glossy = is_glossy(&out->point);
    fetch_cells(shading, &group, &out->cells, &fetches);
    for (size_t k = 0; k < SL_SHADE_LANES; k++)
        load_point(&out->point, &place, out->glossy, widest_exponent(shading->texture), &out->block, k);
    return true;
}

static void shade_tile(void *context, size_t index, unsigned worker) {
    const tile_pass *pass = context;
    const sl_gbuffer *g = pass->gbuffer;
    sl_octree_scratch *s = pass->scratch[worker];
    int x0 = (int)(index % (size_t)pass->tiles_across) * TILE,
        y0 = (int)(index / (size_t)pass->tiles_across) * TILE;
    int x1 = x0 + TILE < g->width ? x0 + TILE : g->width, y1 = y0 + TILE < g->height ? y0 + TILE : g->height;
    size_t count = 0;
    for (int y = y0; y < y1; y++) {
        for (int x = x0; x < x1; x++) {
            uint32_t pixel = (uint32_t)(y * g->width + x), material = g->material[pixel];
            for (int c = 0; c < 3; c++) pass->out[c][pixel] = 0.0f;
            if (material == SL_NO_INDEX || sl_material_is_mirror(&pass->scene->materials[material])) continue;
            s->point[count] = point_of_pixel(pass->scene, g, pass->eye, pixel);
            s->pixel[count++] = pixel;
        }
    }
    sl_octree_shade(pass->shading, s->point, count, s, s->out[0], s->out[1], s->out[2],
                    &pass->counters[worker]);
    for (size_t i = 0; i < count; i++) {
        for (int c = 0; c < 3; c++) pass->out[c][s->pixel[i]] = s->out[c][i];
    }
    sl_count(&pass->counters[worker], SL_COUNT_FRAGMENTS_SHADED, count);
}

sl_status sl_octree_shade_gbuffer(const sl_octree_shading *shading, const sl_scene *scene,
                                  const sl_gbuffer *gbuffer, sl_vec3 eye, unsigned threads, float *r,
                                  float *g, float *b, sl_counters *counters, sl_error *error) {
    threads = sl_thread_count(threads);
    float *const out[3] = {r, g, b};
    int across = (gbuffer->width + TILE - 1) / TILE, up = (gbuffer->height + TILE - 1) / TILE;
    tile_pass pass = {.shading = shading,
                      .scene = scene,
                      .gbuffer = gbuffer,
                      .eye = eye,
                      .out = out,
                      .tiles_across = across,
                      .scratch = sl_allocate(threads, sizeof *pass.scratch),
                      .counters = sl_allocate(threads, sizeof *pass.counters)};
    sl_status status = pass.scratch && pass.counters ? SL_OK : sl_fail_memory(error, "shading");
    for (unsigned i = 0; status == SL_OK && i < threads; i++)
        status = sl_octree_scratch_create(&pass.scratch[i], error);
    if (status == SL_OK) {
        sl_parallel_for(threads, (size_t)across * (size_t)up, shade_tile, &pass);
        for (unsigned i = 0; i < threads; i++) sl_counters_add(counters, &pass.counters[i]);
    }
    for (unsigned i = 0; pass.scratch && i < threads; i++) sl_octree_scratch_destroy(pass.scratch[i]);
    sl_free(pass.scratch);
    sl_free(pass.counters);
    return status;
}
