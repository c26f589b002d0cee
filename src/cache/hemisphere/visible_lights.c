#include "cache/hemisphere/visible_lights.h"

#include "base/error.h"
#include "base/memory.h"

enum {
    CELLS_MAX = 1 << 15,
    CELLS_ALONG_MAX = 64,
    COARSE = 4,
    DIRECTIONS = 6,
    TRIALS_MIN = 8,
    NOWHERE = UINT32_MAX
};

/* Trials of the wider surroundings that a region's own are mixed with, the fewer its own, the more they
 * count. */
#define PRIOR_TRIALS 3.0
#define VISIBLE_MIN 0.05
#define WEIGHED_SHARE 0.98

/* ---- the grid ---- */

static void make_grid(const sl_scene *scene, sl_visible_lights *v) {
    sl_vec3 size = sl_sub(scene->central_max, scene->central_min);
    float side = fmaxf(size.x, fmaxf(size.y, size.z)) / (float)CELLS_ALONG_MAX;
    side = side > 0.0f ? side : 1.0f;
    const float extent[3] = {size.x, size.y, size.z};
    for (;; side *= 1.1f) {
        for (int a = 0; a < 3; a++) v->cells[a] = (int)(extent[a] / side) + 1;
        if (v->cells[0] * v->cells[1] * v->cells[2] <= CELLS_MAX) break;
    }
    v->low = scene->central_min;
    v->per_cell = 1.0f / side;
}

static int cell_along(float x, float low, float per_cell, int cells) {
    float c = (x - low) * per_cell;
    c = c > 0.0f ? c : 0.0f;
    return c < (float)(cells - 1) ? (int)c : cells - 1;
}

static uint32_t direction_of(sl_vec3 n) {
    float x = fabsf(n.x), y = fabsf(n.y), z = fabsf(n.z);
    if (x >= y && x >= z) return n.x < 0.0f ? 1 : 0;
    if (y >= z) return n.y < 0.0f ? 3 : 2;
    return n.z < 0.0f ? 5 : 4;
}

/* Entry in a grid whose cells are `wide` of the fine ones wide. */
static uint32_t entry_of(const sl_visible_lights *v, const int cell[3], int wide, uint32_t direction) {
    int nx = (v->cells[0] + wide - 1) / wide, ny = (v->cells[1] + wide - 1) / wide;
    int index = ((cell[2] / wide) * ny + cell[1] / wide) * nx + cell[0] / wide;
    return (uint32_t)index * DIRECTIONS + direction;
}

static uint32_t entry_of_trial(const sl_visible_lights *v, const sl_light_trial *t, int wide) {
    const int cell[3] = {cell_along(t->position.x, v->low.x, v->per_cell, v->cells[0]),
                         cell_along(t->position.y, v->low.y, v->per_cell, v->cells[1]),
                         cell_along(t->position.z, v->low.z, v->per_cell, v->cells[2])};
    return entry_of(v, cell, wide, direction_of(t->normal));
}

/* ---- counting trials ---- */

typedef struct tally {
    uint32_t trials;
    sl_vec3d position, normal; /* sums */
} tally;

/* Regions of one grid that were tried often enough. */
typedef struct level {
    int wide;
    size_t entries, count;
    uint32_t *region_of;   /* by entry; NOWHERE */
    tally *tallies;        /* by region */
    uint32_t *tests, *arrivals; /* by region and source */
} level;

static void drop_level(level *l) {
    sl_free(l->region_of);
    sl_free(l->tallies);
    sl_free(l->tests);
    sl_free(l->arrivals);
}

static void number_regions(level *l, uint32_t least) {
    for (size_t i = 0; i < l->entries; i++)
        l->region_of[i] = l->region_of[i] >= least ? (uint32_t)l->count++ : NOWHERE;
}

static void count_trials(level *l, const sl_visible_lights *v, const sl_light_trial *trials, size_t count,
                         size_t sources) {
    for (size_t i = 0; i < count; i++) {
        uint32_t r = l->region_of[entry_of_trial(v, &trials[i], l->wide)];
        if (r == NOWHERE) continue;
        tally *t = &l->tallies[r];
        t->trials++;
        t->position = sl_addd(t->position, sl_to_double(trials[i].position));
        t->normal = sl_addd(t->normal, sl_to_double(trials[i].normal));
        l->tests[r * sources + trials[i].source]++;
        l->arrivals[r * sources + trials[i].source] += trials[i].arrived;
    }
}

static sl_status make_level(level *l, int wide, const sl_visible_lights *v, const sl_light_trial *trials,
                            size_t count, size_t sources, sl_error *error) {
    size_t entries = DIRECTIONS;
    for (int a = 0; a < 3; a++) entries *= (size_t)((v->cells[a] + wide - 1) / wide);
    *l = (level){.wide = wide, .entries = entries, .region_of = sl_allocate(entries, sizeof *l->region_of)};
    if (!l->region_of) return sl_fail_memory(error, "visible lights");
    for (size_t i = 0; i < count; i++) l->region_of[entry_of_trial(v, &trials[i], wide)]++;
    number_regions(l, TRIALS_MIN);
    l->tallies = sl_allocate(l->count, sizeof *l->tallies);
    l->tests = sl_allocate(l->count * sources, sizeof *l->tests);
    l->arrivals = sl_allocate(l->count * sources, sizeof *l->arrivals);
    if (!l->tallies || !l->tests || !l->arrivals) return sl_fail_memory(error, "visible lights");
    count_trials(l, v, trials, count, sources);
    return SL_OK;
}

/* ---- what matters where ---- */

/* What a source may give to surfaces about a place, unhindered, to those at most `side` nearer to it than the
 * place. */
static double reach(const sl_light_sources *s, size_t i, sl_vec3d place, sl_vec3d normal, double side) {
    size_t block = i / SL_SOURCE_LANES;
    double strength = (double)s->strength[i];
    sl_vec3d to = sl_v3d((double)s->x[i], (double)s->y[i], (double)s->z[i]);
    if (i == s->sky) return (double)fmaxf(s->sky_irradiance[2], 1e-3f);
    if (block >= s->first_block[SL_SAMPLED_FAR]) return strength * fmax(0.05, sl_dotd(to, normal));
    sl_vec3d d = sl_scaled(sl_subd(to, place), (double)s->unit);
    double extent = (double)s->extent[i], slack = side * (double)s->unit;
    if (block >= s->first_block[SL_SAMPLED_POINT]) extent = 0.0;
    double length = fmax(sl_lengthd(d) - slack, fmax(0.5 * extent, 0.1 * slack)), squared = length * length;
    double above = fmin(fmax(0.0, sl_dotd(d, normal) + extent + slack), length);
    if (block >= s->first_block[SL_SAMPLED_POINT]) return strength * above / (squared * length);
    double front =
        -((double)s->normal_x[i] * d.x + (double)s->normal_y[i] * d.y + (double)s->normal_z[i] * d.z);
    front = fmin(fmax(0.0, (s->two_sided[i] > 0.0f ? fabs(front) : front) + slack), length);
    return strength * above * front / (squared * squared);
}

static double shrunk(double arrivals, double tests, double expected) {
    return (arrivals + PRIOR_TRIALS * expected) / (tests + PRIOR_TRIALS);
}

static double seen_in(const level *l, uint32_t region, size_t source, size_t sources, double expected) {
    if (region == NOWHERE) return expected;
    return shrunk((double)l->arrivals[region * sources + source], (double)l->tests[region * sources + source],
                  expected);
}

/* Blocks are weighed source by source, the best first, until almost all that may come is covered. */
static void choose_blocks(sl_light_region *region, const double *block, size_t blocks) {
    double total = 0.0, sum = 0.0;
    for (size_t b = 0; b < blocks; b++) total += block[b];
    *region = (sl_light_region){0};
    for (size_t chosen = 0; chosen < blocks && (chosen == 0 || sum < WEIGHED_SHARE * total); chosen++) {
        size_t best = blocks;
        for (size_t b = 0; b < blocks; b++) {
            if (!(region->blocks >> b & 1u) && (best == blocks || block[b] > block[best])) best = b;
        }
        region->blocks |= 1u << best;
        sum += block[best];
    }
    bool all = region->blocks == (1u << blocks) - 1;
    region->rest = all ? 0.0f : (float)fmax(fmax(total - sum, 1e-3 * total), 1e-9);
}

/* Region `region` of level `own` (which may be `coarse` itself), in surroundings of the coarse one. */
static void describe(sl_visible_lights *v, const sl_light_sources *s, const level *coarse, uint32_t around,
                     const level *own, uint32_t region, const double *everywhere, size_t index) {
    const tally *t = &own->tallies[region];
    sl_vec3d place = sl_scaled(t->position, 1.0 / t->trials), normal = t->normal;
    double length = sl_lengthd(normal), side = (double)own->wide / (double)v->per_cell,
           block[SL_SOURCE_BLOCKS_MAX] = {0};
    normal = length > 0.0 ? sl_scaled(normal, 1.0 / length) : normal;
    uint8_t *seen = v->visible + index * v->sources;
    for (size_t i = 0; i < s->count; i++) {
        double visible = seen_in(coarse, around, i, s->count, everywhere[i]);
        if (own != coarse) visible = seen_in(own, region, i, s->count, visible);
        seen[i] = (uint8_t)fmax(255.0 * VISIBLE_MIN, 255.0 * visible + 0.5);
        block[i / SL_SOURCE_LANES] += reach(s, i, place, normal, side) * visible;
    }
    choose_blocks(&v->regions[index], block, s->blocks);
}

/* ---- all of it ---- */

static void describe_all(sl_visible_lights *v, const sl_light_sources *s, const level *fine,
                         const level *coarse, const double *everywhere) {
    for (size_t i = 0; i < s->count; i++) v->visible[i] = 255;
    v->regions[0] = (sl_light_region){.blocks = (1u << s->blocks) - 1};
    for (uint32_t r = 0; r < coarse->count; r++) describe(v, s, coarse, r, coarse, r, everywhere, 1 + r);
    for (int z = 0; z < v->cells[2]; z++) {
        for (int y = 0; y < v->cells[1]; y++) {
            for (int x = 0; x < v->cells[0]; x++) {
                for (uint32_t d = 0; d < DIRECTIONS; d++) {
                    const int cell[3] = {x, y, z};
                    uint32_t entry = entry_of(v, cell, 1, d),
                             around = coarse->region_of[entry_of(v, cell, coarse->wide, d)];
                    uint32_t region = fine->region_of[entry];
                    v->region_of[entry] = around == NOWHERE ? 0 : 1 + around;
                    if (region == NOWHERE) continue;
                    v->region_of[entry] = 1 + (uint32_t)coarse->count + region;
                    describe(v, s, coarse, around, fine, region, everywhere, v->region_of[entry]);
                }
            }
        }
    }
}

static void see_everywhere(const sl_light_trial *trials, size_t count, size_t sources, double *everywhere,
                           uint32_t *tests) {
    for (size_t i = 0; i < count; i++) {
        tests[trials[i].source]++;
        everywhere[trials[i].source] += trials[i].arrived ? 1.0 : 0.0;
    }
    for (size_t i = 0; i < sources; i++) everywhere[i] = shrunk(everywhere[i], (double)tests[i], 0.5);
}

static sl_status learn(sl_visible_lights *v, const sl_light_sources *s, const sl_light_trial *trials,
                       size_t count, level *fine, level *coarse, sl_error *error) {
    sl_status status = make_level(fine, 1, v, trials, count, s->count, error);
    if (status == SL_OK) status = make_level(coarse, COARSE, v, trials, count, s->count, error);
    if (status != SL_OK) return status;
    v->region_count = 1 + coarse->count + fine->count;
    v->regions = sl_allocate(v->region_count, sizeof *v->regions);
    v->sources = s->count;
    v->visible = sl_allocate(v->region_count * v->sources, sizeof *v->visible);
    v->region_of = sl_allocate(fine->entries, sizeof *v->region_of);
    double *everywhere = sl_allocate(s->count, sizeof *everywhere);
    uint32_t *tests = sl_allocate(s->count, sizeof *tests);
    if (v->regions && v->visible && v->region_of && everywhere && tests) {
        see_everywhere(trials, count, s->count, everywhere, tests);
        describe_all(v, s, fine, coarse, everywhere);
    } else {
        status = sl_fail_memory(error, "visible lights");
    }
    sl_free(everywhere);
    sl_free(tests);
    return status;
}

sl_status sl_visible_lights_create(const sl_light_sources *sources, const sl_light_trial *trials,
                                   size_t count, sl_visible_lights **out, sl_error *error) {
    *out = NULL;
    sl_visible_lights *v = sl_allocate(1, sizeof *v);
    if (!v) return sl_fail_memory(error, "visible lights");
    level fine = {0}, coarse = {0};
    make_grid(sources->scene, v);
    sl_status status = learn(v, sources, trials, count, &fine, &coarse, error);
    drop_level(&fine);
    drop_level(&coarse);
    if (status != SL_OK) sl_visible_lights_destroy(v);
    else *out = v;
    return status;
}

void sl_visible_lights_destroy(sl_visible_lights *v) {
    if (!v) return;
    sl_free(v->region_of);
    sl_free(v->regions);
    sl_free(v->visible);
    sl_free(v);
}

size_t sl_visible_lights_bytes(const sl_visible_lights *v) {
    size_t cells = (size_t)v->cells[0] * (size_t)v->cells[1] * (size_t)v->cells[2];
    return sizeof *v + cells * DIRECTIONS * sizeof *v->region_of +
           v->region_count * (sizeof *v->regions + v->sources * sizeof *v->visible);
}
