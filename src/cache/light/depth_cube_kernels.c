/* Look-ups in depth cubes, for many receivers at once.
 *
 * Reciprocal planar depth is linear across a picture: with the receiver P seen from the light and its normal
 * n, both in the picture's axes, the receiver's plane has at the tangents (a, b) 1/z = (n_x a + n_y b + n_z)
 * / n . P. So between P and the middle of a texel that lies da, db beside it, 1/z differs by at most beta =
 * (|n_x da| + |n_y db|) / |n . P|, exactly so if what the texel holds is the receiver's own plane. The
 * receiver is lit if 1/z >= stored - beta, less what rounding makes. With the nearest texel alone, da and db
 * are at most half a texel of 2/N: beta = (|n_x| + |n_y|) / (N |n . P|). Here the four texels around are
 * asked, each with its own beta, and their answers blended by distance (percentage-closer filtering; Reeves,
 * Salesin and Cook 1987). */
#include "cache/light/depth_cube.h"

#include <math.h>
#include <string.h>

typedef struct {
    int32_t texel[SL_LIGHT_BLOCK];                    /* lower left of the four */
    int32_t column[SL_LIGHT_BLOCK], row[SL_LIGHT_BLOCK]; /* its place in the picture */
    float across[SL_LIGHT_BLOCK], up[SL_LIGHT_BLOCK]; /* place between the four, in [0,1] */
    /* of the receiver, in the units stored, with room for rounding */
    float depth[SL_LIGHT_BLOCK];
    /* of its plane, from texel to texel, not negative */
    float change_x[SL_LIGHT_BLOCK], change_y[SL_LIGHT_BLOCK];
    float dark[SL_LIGHT_BLOCK];                       /* shares of the texels that hide it */
} lookups;

/* The texel whose middle lies at or below a continuous coordinate, so that the next one exists too; 0 for
 * NaN. */
static inline float cell(float position, float last) {
    position = position > 0.0f ? position : 0.0f;
    position = position < last ? position : last;
    return (float)(int32_t)position;
}

static inline float not_zero(float v) { return v > 1e-30f ? v : 1e-30f; }

static void locate_on_cube(const sl_depth_cube *map, size_t count, const float *restrict px,
                           const float *restrict py, const float *restrict pz, const float *restrict nx,
                           const float *restrict ny, const float *restrict nz, size_t at, lookups *out) {
    const sl_vec3 eye = map->eye, ex = map->frame.x, ey = map->frame.y, ez = map->frame.z;
    const float size = (float)map->size, half = 0.5f * (size - 2.0f) / map->tangent,
                middle = 0.5f * size - 0.5f, last = size - 2.0f;
    const float tangent = 2.0f * map->tangent / (size - 2.0f), rounding = map->rounding;
    const int32_t width = map->size;
    const int32_t *restrict start = map->start, *restrict mask = map->mask;
    int32_t *restrict texel = out->texel + at, *restrict columns = out->column + at,
                      *restrict rows = out->row + at;
    float *restrict across = out->across + at, *restrict up = out->up + at, *restrict depth = out->depth + at;
    float *restrict change_x = out->change_x + at, *restrict change_y = out->change_y + at;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float dx = px[i] - eye.x, dy = py[i] - eye.y, dz = pz[i] - eye.z;
        float x = ex.x * dx + ex.y * dy + ex.z * dz, y = ey.x * dx + ey.y * dy + ey.z * dz,
              z = ez.x * dx + ez.y * dy + ez.z * dz;
        float a = ex.x * nx[i] + ex.y * ny[i] + ex.z * nz[i], b = ey.x * nx[i] + ey.y * ny[i] + ey.z * nz[i],
              c = ez.x * nx[i] + ez.y * ny[i] + ez.z * nz[i];
        float ax = fabsf(x), ay = fabsf(y), az = fabsf(z);
        bool ahead = (az >= ax) & (az >= ay), sideways = !ahead & (ax >= ay);
        float major = ahead ? z : sideways ? x : y, s = ahead ? x : sideways ? y : x, t = ahead ? y : z;
        float ns = ahead ? a : sideways ? b : a, nt = ahead ? b : c;
        int32_t behind = major < 0.0f ? 1 : 0, first = sideways ? 1 : 3;
        int32_t side = ahead ? SL_LIGHT_BACK * behind : first + behind;
        float over = 1.0f / not_zero(fabsf(major)), facing = 1.0f / not_zero(fabsf(a * x + b * y + c * z));
        float column = s * over * half + middle, row = t * over * half + middle;
        float left = cell(column, last), below = cell(row, last);
        float cx = fabsf(ns) * facing * tangent, cy = fabsf(nt) * facing * tangent;
        columns[i] = (int32_t)left;
        rows[i] = (int32_t)below;
        texel[i] = start[side] + (mask[side] & ((int32_t)below * width + (int32_t)left));
        across[i] = sl_clamp_unitf(column - left);
        up[i] = sl_clamp_unitf(row - below);
        change_x[i] = cx * (1.0f + 1e-5f);
        change_y[i] = cy * (1.0f + 1e-5f);
        /* Rounded are the position, by a few units of its own size, and the unit normal, whose error a long
         * way multiplies. */
        depth[i] = over + (over * 1e-6f + facing * (rounding * over + 3e-7f)) + (cx + cy) * 4e-4f;
    }
}

/* The same with depth instead of its reciprocal: a plane changes by n_x / n_z across. */
static void locate_in_parallel(const sl_depth_cube *map, size_t count, const float *restrict px,
                               const float *restrict py, const float *restrict pz, const float *restrict nx,
                               const float *restrict ny, const float *restrict nz, size_t at, lookups *out) {
    const sl_vec3 eye = map->eye, ex = map->frame.x, ey = map->frame.y, ez = map->frame.z;
    const float size = (float)map->size, middle = 0.5f * size - 0.5f, last = size - 2.0f;
    const float scale_x = 0.5f * size / map->extent_x, scale_y = 0.5f * size / map->extent_y,
                scale_z = 0.5f / map->extent_z;
    const float step_x = scale_z / scale_x, step_y = scale_z / scale_y,
                rounding = map->rounding * scale_z + 3e-7f;
    const int32_t width = map->size, start = map->start[0], mask = map->mask[0];
    int32_t *restrict texel = out->texel + at, *restrict columns = out->column + at,
                      *restrict rows = out->row + at;
    float *restrict across = out->across + at, *restrict up = out->up + at, *restrict depth = out->depth + at;
    float *restrict change_x = out->change_x + at, *restrict change_y = out->change_y + at;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float dx = px[i] - eye.x, dy = py[i] - eye.y, dz = pz[i] - eye.z;
        float x = ex.x * dx + ex.y * dy + ex.z * dz, y = ey.x * dx + ey.y * dy + ey.z * dz,
              z = ez.x * dx + ez.y * dy + ez.z * dz;
        float a = ex.x * nx[i] + ex.y * ny[i] + ex.z * nz[i], b = ey.x * nx[i] + ey.y * ny[i] + ey.z * nz[i],
              c = ez.x * nx[i] + ez.y * ny[i] + ez.z * nz[i];
        float column = x * scale_x + middle, row = y * scale_y + middle, facing = 1.0f / not_zero(fabsf(c));
        float left = cell(column, last), below = cell(row, last);
        float cx = fabsf(a) * facing * step_x, cy = fabsf(b) * facing * step_y;
        columns[i] = (int32_t)left;
        rows[i] = (int32_t)below;
        texel[i] = start + (mask & ((int32_t)below * width + (int32_t)left));
        across[i] = sl_clamp_unitf(column - left);
        up[i] = sl_clamp_unitf(row - below);
        change_x[i] = cx * (1.0f + 1e-5f);
        change_y[i] = cy * (1.0f + 1e-5f);
        depth[i] = (0.5f - z * scale_z) + (1e-6f + facing * rounding) + (cx + cy) * 4e-4f;
    }
}

/* The four texels around each receiver: those of a row lie side by side, and are fetched together. */
typedef struct {
    float lower[2 * SL_LIGHT_BLOCK], upper[2 * SL_LIGHT_BLOCK];
} corners;

static void fetch_corners(const sl_depth_cube *map, size_t begin, size_t end, const lookups *at, corners *c) {
    const float *stored = map->depth;
    for (size_t i = begin; i < end; i++) {
        memcpy(c->lower + 2 * i, stored + at->texel[i], 2 * sizeof *c->lower);
        memcpy(c->upper + 2 * i, stored + at->texel[i] + map->size, 2 * sizeof *c->upper);
    }
}

/* Shares that are not lit are added up, so that where all four are lit the result is 1 exactly. */
static void compare(size_t count, const corners *c, lookups *at) {
    const float *restrict across = at->across, *restrict up = at->up, *restrict depth = at->depth;
    const float *restrict change_x = at->change_x, *restrict change_y = at->change_y;
    const float *restrict lower = c->lower, *restrict upper = c->upper;
    float *restrict out = at->dark;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float right = across[i], left = 1.0f - right, above = up[i], below = 1.0f - above;
        float to_left = right * change_x[i], to_right = left * change_x[i], down = above * change_y[i],
              upward = below * change_y[i];
        float z = depth[i];
        float dark = lower[2 * i] > z + (to_left + down) ? left * below : 0.0f;
        dark += lower[2 * i + 1] > z + (to_right + down) ? right * below : 0.0f;
        dark += upper[2 * i] > z + (to_left + upward) ? left * above : 0.0f;
        dark += upper[2 * i + 1] > z + (to_right + upward) ? right * above : 0.0f;
        out[i] = dark;
    }
}

/* ---- corners ---- */

static inline bool is_part(float dark) { return (dark > 0.0f) & (dark < 1.0f - 1e-6f); }

/* Copies those that are dark in part, and not dark anyway. Returns how many. */
static size_t list_parts(const lookups *at, const float *lit, size_t count, lookups *part, uint8_t *place) {
    size_t parts = 0;
    for (size_t i = 0; i < count; i++) {
        place[parts] = (uint8_t)i;
        parts += is_part(at->dark[i]) & (lit[i] > 0.0f);
    }
    for (size_t j = 0; j < parts; j++) {
        const size_t i = place[j];
        part->texel[j] = at->texel[i], part->column[j] = at->column[i], part->row[j] = at->row[i];
        part->across[j] = at->across[i], part->up[j] = at->up[i], part->depth[j] = at->depth[i];
        part->change_x[j] = at->change_x[i], part->change_y[j] = at->change_y[i];
        part->dark[j] = 0.0f;
    }
    return parts;
}

/* Tells whether the neighbour behind texel k in a row or a column, k's place in it, is the one by which the
 * depth changes there: the one on the far side of the receiver, which lies `away` texels from k's middle,
 * since on the near side the surface may end. */
static inline bool is_behind(int32_t place, int32_t size, float away) {
    return (place > 0) & ((away > 0.0f) | (place + 1 == size));
}

/* Of one of the four texels: what it holds, and its slopes. */
typedef struct {
    float held[SL_LIGHT_BLOCK], slope_x[SL_LIGHT_BLOCK], slope_y[SL_LIGHT_BLOCK];
} texels;

/* right, above: of the lower left one. */
static void fetch_slopes(const sl_cube_looks *of, const uint8_t *place, size_t count, int32_t right,
                         int32_t above, const lookups *part, texels *t) {
    const int32_t size = of->cube[0]->size;
    for (size_t j = 0; j < count; j++) {
        const float *held = of->cube[place[j] / of->each]->depth + part->texel[j] + right + above * size;
        const bool left = is_behind(part->column[j] + right, size, part->across[j] - (float)right),
                   below = is_behind(part->row[j] + above, size, part->up[j] - (float)above);
        const float *x = left ? held - 1 : held, *y = below ? held - size : held;
        t->held[j] = *held;
        t->slope_x[j] = x[1] - x[0];
        t->slope_y[j] = y[size] - y[0];
    }
}

/* Looks at the texel once more. It hides a receiver that does not lie before the plane of what it holds. That
 * is not asked of what lies more than four texels' sizes before: that is no corner. Nor where the receiver's
 * own plane, seen at a grazing angle, rises as much from texel to texel: there facets are too narrow to tell
 * their planes. */
static void look_again(const sl_depth_cube *map, size_t count, int32_t right, int32_t above, const texels *t,
                       lookups *part) {
    const float *restrict across = part->across, *restrict up = part->up, *restrict depth = part->depth;
    const float *restrict change_x = part->change_x, *restrict change_y = part->change_y;
    const float *restrict held = t->held, *restrict slope_x = t->slope_x, *restrict slope_y = t->slope_y;
    float *restrict dark = part->dark;
    const float extent = map->extent_x > map->extent_y ? map->extent_x : map->extent_y,
                far_texel = map->directional ? extent / (map->extent_z * (float)map->size) : 0.0f,
                near_texel = map->directional ? 0.0f : 2.0f * map->tangent / (float)(map->size - 2);
#pragma omp simd
    for (size_t j = 0; j < count; j++) {
        const float x = across[j] - (float)right, y = up[j] - (float)above, ax = fabsf(x), ay = fabsf(y);
        const float excess = held[j] - depth[j], there = held[j] + slope_x[j] * x + slope_y[j] * y,
                    room = 0.02f * (fabsf(slope_x[j]) + fabsf(slope_y[j]));
        const bool grazes = excess <= change_x[j] + change_y[j],
                   far = excess > 4.0f * (far_texel + near_texel * held[j]);
        const bool before = grazes | (!far & (there <= depth[j] + room)),
                   hides = (held[j] > depth[j] + (ax * change_x[j] + ay * change_y[j])) & !before;
        dark[j] += hides ? (1.0f - ax) * (1.0f - ay) : 0.0f;
    }
}

static void look_at_corners(const sl_cube_looks *of, size_t count, const float *lit, lookups *at) {
    lookups part;
    uint8_t place[SL_LIGHT_BLOCK + 1];
    const size_t parts = list_parts(at, lit, count, &part, place);
    texels held;
    for (int32_t t = 0; t < 4 && parts; t++) {
        fetch_slopes(of, place, parts, t & 1, t >> 1, &part, &held);
        look_again(of->cube[0], parts, t & 1, t >> 1, &held, &part);
    }
    for (size_t j = 0; j < parts; j++) at->dark[place[j]] = part.dark[j];
}

static bool some_are_dark_in_part(size_t count, const lookups *at) {
    const float *restrict dark = at->dark;
    uint32_t any = 0;
#pragma omp simd reduction(| : any)
    for (size_t i = 0; i < count; i++) any |= is_part(dark[i]) ? 1u : 0u;
    return any != 0;
}

static void look(const sl_light_points *p, size_t first, size_t count, const sl_depth_cube *cube, size_t at,
                 lookups *out) {
    const float *px = p->x + first, *py = p->y + first, *pz = p->z + first;
    const float *nx = p->geometric_x + first, *ny = p->geometric_y + first, *nz = p->geometric_z + first;
    if (cube->directional) locate_in_parallel(cube, count, px, py, pz, nx, ny, nz, at, out);
    else locate_on_cube(cube, count, px, py, pz, nx, ny, nz, at, out);
}

void SL_KERNEL(sl_depth_cube_lit)(const sl_light_points *points, const sl_cube_looks *of, float *lit) {
    const size_t each = of->each, count = of->cubes * each;
    lookups at;
    corners c;
    for (size_t k = 0, first = 0; k < count; k += each) {
        const sl_depth_cube *cube = of->cube[k / each];
        look(points, first, each, cube, k, &at);
        fetch_corners(cube, k, k + each, &at, &c);
        first = first + each < points->count ? first + each : 0;
    }
    compare(count, &c, &at);
    if (some_are_dark_in_part(count, &at)) look_at_corners(of, count, lit, &at);
    const float *restrict dark = at.dark;
    float *restrict out = lit;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float share = 1.0f - dark[i];
        out[i] *= share > 1e-6f ? share : 0.0f;
    }
}
