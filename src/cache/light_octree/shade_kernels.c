/* Eight points at a time against lights that are the same for all of them. Colours are blended between
 * voxels after they are reflected: directions of unrelated clusters must not be averaged. */
#include "cache/light_octree/shade.h"

#include "base/math.h"

enum { LANES = SL_SHADE_LANES };

typedef float lanes __attribute__((vector_size(4 * SL_SHADE_LANES)));
typedef int32_t masks __attribute__((vector_size(4 * SL_SHADE_LANES)));

typedef struct light_sum {
    lanes irradiance[3], lobe[3]; /* lobe: of glossy points alone */
} light_sum;

/* The part of the points that the loops need. */
typedef struct point_lanes {
    lanes tx, ty, tz, nx, ny, nz, mx, my, mz, exponent;
    const sl_shade_cells *cells;
    bool glossy;
} point_lanes;

static inline lanes load(const float *p) { return *(const lanes *)p; }
static inline lanes choose(masks m, lanes a, lanes b) { return (lanes)(((masks)a & m) | ((masks)b & ~m)); }
static inline lanes positive(lanes a) { return (lanes)((masks)a & (a > 0.0f)); } /* NaN: 0 */

/* Modified Phong: (e+2)/(2 pi) cos^e. */
static inline lanes phong(lanes cosine, lanes exponent) {
    float c[LANES] __attribute__((aligned(64))), e[LANES] __attribute__((aligned(64))),
        v[LANES] __attribute__((aligned(64)));
    *(lanes *)c = cosine;
    *(lanes *)e = exponent;
#pragma omp simd
    for (int l = 0; l < LANES; l++) v[l] = (e[l] + 2.0f) * (float)(0.5 / SL_PI) * sl_powf(c[l], e[l]);
    return *(lanes *)v;
}

/* L_o = sum f_r c (n . d)+, without kd / pi and ks; c without cosine where it is the irradiance on the
 * surface. */
static inline light_sum directional(const point_lanes *p, const sl_shade_set *set) {
    light_sum s = {{{0}}, {{0}}};
    bool cosine = p->cells->lobes == SL_LOBES_PERPENDICULAR;
    for (int j = 0; j < set->lights; j++) {
        const sl_unpacked_light *light = &set->light[j];
        const float *d = light->direction;
        lanes weight = positive(p->nx * d[0] + p->ny * d[1] + p->nz * d[2]);
        if (!cosine) weight = weight * 0.0f + 1.0f;
        for (int c = 0; c < 3; c++) s.irradiance[c] += weight * light->color[c];
        if (!p->glossy) continue;
        lanes reflected = weight * phong(positive(p->mx * d[0] + p->my * d[1] + p->mz * d[2]), p->exponent);
        for (int c = 0; c < 3; c++) s.lobe[c] += reflected * light->color[c];
    }
    return s;
}

/* One irradiance has no direction: gloss reflects it as a diffuse surface would. */
static inline light_sum one_colour(const point_lanes *p, const sl_shade_set *set) {
    light_sum s = {{{0}}, {{0}}};
    for (int c = 0; c < 3; c++) {
        float e = set->lights > 0 ? set->light[0].color[c] : 0.0f;
        s.irradiance[c] += e;
        if (p->glossy) s.lobe[c] += (float)(1.0 / SL_PI) * e;
    }
    return s;
}

static inline light_sum of_set(const point_lanes *p, const sl_shade_set *set) {
    if (p->cells->lobes == SL_LOBES_NONE) return one_colour(p, set);
    return directional(p, set);
}

static inline lanes cosine_to(const point_lanes *p, const sl_shade_set *set) {
    lanes c = p->nx * set->normal.x + p->ny * set->normal.y + p->nz * set->normal.z;
    return set->turn ? (lanes)((masks)c & 0x7fffffff) : c;
}

/* Rates how well a set suits the points: by its normal, and of layers by how far above or below them it lies,
 * in voxels. */
static inline lanes suits(const point_lanes *p, const sl_shade_corner *corner, const sl_shade_set *set) {
    lanes cosine = cosine_to(p, set);
    if (!set->layer) return cosine;
    const sl_shade_cells *cells = p->cells;
    int k = (int)(corner - cells->corner);
    float x = cells->corners == 1 ? 0.5f : (float)(k & 1),
          y = cells->corners == 1 ? 0.5f : (float)(k >> 1 & 1),
          z = cells->corners == 1 ? 0.5f : (float)(k >> 2);
    lanes above =
        (p->tx - x) * set->normal.x + (p->ty - y) * set->normal.y + (p->tz - z) * set->normal.z - set->height;
    return cosine - (lanes)((masks)above & 0x7fffffff);
}

/* A voxel's share at the points: light, and the cosine towards it, (n . n_v)+, 1 where there is no normal. */
typedef struct voxel_share {
    light_sum light;
    lanes facing;
} voxel_share;

/* A split voxel: each point takes the group that suits it best; ties go to the first. */
static inline voxel_share of_corner(const point_lanes *p, const sl_shade_corner *corner) {
    const sl_vec3 n = corner->set[0].normal;
    voxel_share best = {of_set(p, &corner->set[0]), cosine_to(p, &corner->set[0])};
    lanes nearest = suits(p, corner, &corner->set[0]);
    for (int k = 1; k < corner->sets; k++) {
        lanes here = suits(p, corner, &corner->set[k]);
        masks closer = here > nearest;
        light_sum s = of_set(p, &corner->set[k]);
        nearest = choose(closer, here, nearest);
        best.facing = choose(closer, cosine_to(p, &corner->set[k]), best.facing);
        for (int c = 0; c < 3; c++) {
            best.light.irradiance[c] = choose(closer, s.irradiance[c], best.light.irradiance[c]);
            if (p->glossy) best.light.lobe[c] = choose(closer, s.lobe[c], best.light.lobe[c]);
        }
    }
    bool no_normal = n.x == 0.0f && n.y == 0.0f && n.z == 0.0f;
    best.facing = no_normal ? p->tx * 0.0f + 1.0f : positive(best.facing);
    return best;
}

/* ---- weights: L = sum w m L_j / sum w m over the voxels around, w trilinear, m the facing; void voxels
 * count in neither sum ---- */

static inline lanes trilinear(const point_lanes *p, int corner) {
    if (p->cells->corners == 1) return p->tx * 0.0f + 1.0f;
    lanes x = corner & 1 ? p->tx : 1.0f - p->tx, y = corner & 2 ? p->ty : 1.0f - p->ty,
          z = corner & 4 ? p->tz : 1.0f - p->tz;
    return x * y * z;
}

/* The voxel that the point itself lies in. */
static inline masks own_voxel(const point_lanes *p, int corner) {
    masks x = p->tx >= 0.5f, y = p->ty >= 0.5f, z = p->tz >= 0.5f;
    return (corner & 1 ? x : ~x) & (corner & 2 ? y : ~y) & (corner & 4 ? z : ~z);
}

static inline void shade_lanes(const point_lanes *p, sl_shade_block *block, size_t first) {
    const sl_shade_cells *cells = p->cells;
    lanes zero = p->tx * 0.0f, one = zero + 1.0f, sum = zero, faced = zero;
    masks own_there = {0};
    voxel_share share[8];
    light_sum total = {{{0}}, {{0}}};
    for (int k = 0; k < cells->corners; k++) {
        if (cells->corner[k].sets == 0) continue;
        share[k] = of_corner(p, &cells->corner[k]);
        faced += trilinear(p, k) * share[k].facing;
        own_there |= own_voxel(p, k);
    }
    masks enough = faced >= 1e-3f;
    for (int k = 0; k < cells->corners; k++) {
        if (cells->corner[k].sets == 0) continue;
        lanes weight = trilinear(p, k);
        if (cells->facing && cells->corners > 1) /* else the point's own voxel, or plain where that is void */
            weight = choose(enough, weight * share[k].facing,
                            choose(own_there, choose(own_voxel(p, k), one, zero), weight));
        sum += weight;
        for (int c = 0; c < 3; c++) {
            total.irradiance[c] += weight * share[k].light.irradiance[c];
            if (p->glossy) total.lobe[c] += weight * share[k].light.lobe[c];
        }
    }
    masks some = sum > 0.0f;
    lanes scale =
        cells->keep_void_dark && !cells->facing ? one : positive(one / choose(some, sum, one));
    for (int c = 0; c < 3; c++) {
        *(lanes *)&block->irradiance[c][first] = total.irradiance[c] * scale;
        if (p->glossy) *(lanes *)&block->lobe[c][first] = total.lobe[c] * scale;
    }
}

static inline __attribute__((always_inline)) void shade_points(const sl_shade_cells *cells, size_t count,
                                                               bool glossy, sl_shade_block *b) {
    for (size_t i = 0; i < count; i += LANES) {
        point_lanes p = {load(b->tx + i), load(b->ty + i),       load(b->tz + i), load(b->nx + i),
                         load(b->ny + i), load(b->nz + i),       load(b->mx + i), load(b->my + i),
                         load(b->mz + i), load(b->exponent + i), cells,           glossy};
        shade_lanes(&p, b, i);
    }
}

void SL_KERNEL(sl_shade_block)(const sl_shade_cells *cells, size_t count, bool glossy, sl_shade_block *b) {
    if (glossy) shade_points(cells, count, true, b);
    else shade_points(cells, count, false, b);
}
