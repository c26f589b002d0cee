/* Shadow maps, looked up for many points at once: percentage-closer filtering (Reeves, Salesin and Cook 1987)
 * of 2 x 2 texels, bilinear.
 *
 * A map that holds depths needs a bias, since a texel holds the depth at its own centre and not at the point:
 * too little of it darkens lit planes, too much lets light through thin walls. So these maps hold which
 * triangle is seen, and a texel is an obstacle only if both the point lies behind the triangle's plane (a
 * wall beside the point, seen by a neighbouring texel, is none), and what the texel's centre sees lies before
 * the point's own plane (the same surface, falling away beside the point, is none). For planes that is exact,
 * and smooth surfaces pass one of the two tests to second order, convex or concave: only rounding needs a
 * tolerance. Where all four texels see one triangle, the ray to the point passes through it, and the first
 * test says all. */
#include "cache/light/light_kernels.h"

/* ---- what arrives without shadows ---- */

static inline float above(float value) { return value > 0.0f ? value : 0.0f; } /* 0 for NaN */

/* 1 inside the inner cone, 0 outside the outer one, smoothstep of the cosine between. */
static inline float spot(float cosine, float inner, float outer) {
    float x = (cosine - outer) / (inner > outer ? inner - outer : 1.0f);
    x = x > 0.0f ? x : 0.0f;
    float smooth = x * x * (3.0f - 2.0f * x);
    return cosine >= inner ? 1.0f : cosine > outer ? smooth : 0.0f;
}

static void arrive_from_afar(const sl_light_points *points, const sl_light_source *source, sl_arrivals *out) {
    const float *restrict nx = points->normal_x, *restrict ny = points->normal_y,
                          *restrict nz = points->normal_z;
    const float *restrict gx = points->geometric_x, *restrict gy = points->geometric_y,
                          *restrict gz = points->geometric_z;
    float *restrict x = out->x, *restrict y = out->y, *restrict z = out->z, *restrict weight = out->weight;
    float dx = -source->direction.x, dy = -source->direction.y, dz = -source->direction.z;
    const size_t count = points->count;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        x[i] = dx;
        y[i] = dy;
        z[i] = dz;
        float cosine = above(nx[i] * dx + ny[i] * dy + nz[i] * dz),
              facing = gx[i] * dx + gy[i] * dy + gz[i] * dz;
        weight[i] = facing > 0.0f ? cosine : 0.0f;
    }
}

void SL_KERNEL(sl_light_arrive)(const sl_light_points *points, const sl_light_source *source,
                                sl_arrivals *out) {
    if (source->kind == SL_SOURCE_DIRECTIONAL) {
        arrive_from_afar(points, source, out);
        return;
    }
    const float *restrict px = points->x, *restrict py = points->y, *restrict pz = points->z;
    const float *restrict nx = points->normal_x, *restrict ny = points->normal_y,
                          *restrict nz = points->normal_z;
    const float *restrict gx = points->geometric_x, *restrict gy = points->geometric_y,
                          *restrict gz = points->geometric_z;
    float *restrict x = out->x, *restrict y = out->y, *restrict z = out->z, *restrict weight = out->weight;
    const sl_vec3 l = source->position, d = source->direction;
    const bool area = source->kind == SL_SOURCE_AREA;
    /* A cone that holds everything, where there is none. */
    const bool cone = source->kind == SL_SOURCE_SPOT;
    const float extent = area ? source->extent : 0.0f, inner = cone ? source->cos_inner : -2.0f,
                outer = cone ? source->cos_outer : -3.0f;
    const size_t count = points->count;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float tx = l.x - px[i], ty = l.y - py[i], tz = l.z - pz[i];
        float squared = tx * tx + ty * ty + tz * tz;
        float over = 1.0f / sqrtf(squared > 0.0f ? squared : 1.0f);
        tx = tx * over;
        ty = ty * over;
        tz = tz * over;
        float cosine = above(nx[i] * tx + ny[i] * ty + nz[i] * tz),
              facing = gx[i] * tx + gy[i] * ty + gz[i] * tz;
        float emitted = -(d.x * tx + d.y * ty + d.z * tz);
        float shape = area ? above(emitted) : spot(emitted, inner, outer);
        float value = cosine * shape / (squared + extent);
        x[i] = tx;
        y[i] = ty;
        z[i] = tz;
        weight[i] = facing > 0.0f && squared > 0.0f && squared < INFINITY ? value : 0.0f;
    }
}

void SL_KERNEL(sl_light_accumulate)(size_t count, sl_rgb colour, const float *restrict a,
                                    const float *restrict b, float *restrict r, float *restrict g,
                                    float *restrict bl) {
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float term = a[i] * b[i];
        r[i] += colour.r * term;
        g[i] += colour.g * term;
        bl[i] += colour.b * term;
    }
}

/* ---- where the points lie on the map ---- */

typedef struct {
    int32_t texel[SL_LIGHT_BLOCK]; /* the lower left of the four; signed, as vectors gather by */
    float column[SL_LIGHT_BLOCK], row[SL_LIGHT_BLOCK]; /* of that texel */
    float across[SL_LIGHT_BLOCK], up[SL_LIGHT_BLOCK]; /* place between the four, in [0,1] */
    int32_t first_plane[SL_LIGHT_BLOCK]; /* of the triangle that the first of the four sees, in the table */
    float agree[SL_LIGHT_BLOCK]; /* 1: the four see one triangle */
} places;

/* The texel whose centre lies at or below a continuous coordinate, so that the next one exists too. */
static inline float cell(float position, float last) {
    position = position > 0.0f ? position : 0.0f;
    position = position < last ? position : last;
    return (float)(int)position;
}

/* Cube faces +x -x +y -y +z -z; the two axes of a face's picture are those that follow its own, x after z. */
static void locate_on_cube(const sl_light_points *points, const sl_shadow_map *map, places *out) {
    const float *restrict px = points->x, *restrict py = points->y, *restrict pz = points->z;
    const sl_vec3 eye = map->eye;
    const float size = (float)map->size, half = 0.5f * (size - 2.0f), middle = 0.5f * size - 0.5f,
                last = size - 2.0f;
    const int32_t width = map->size, face_texels = width * width;
    int32_t *restrict texel = out->texel;
    float *restrict column = out->column, *restrict row = out->row, *restrict across = out->across,
                    *restrict up = out->up;
    const size_t count = points->count;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float x = px[i] - eye.x, y = py[i] - eye.y, z = pz[i] - eye.z;
        float ax = fabsf(x), ay = fabsf(y), az = fabsf(z);
        bool is_x = ax >= ay && ax >= az, is_y = !is_x && ay >= az;
        float major = is_x ? x : is_y ? y : z, s = is_x ? y : is_y ? z : x, t = is_x ? z : is_y ? x : y;
        float over = 1.0f / (major != 0.0f ? fabsf(major) : 1.0f);
        int32_t face = (is_x ? 0 : is_y ? 2 : 4) + (major < 0.0f ? 1 : 0);
        float c = s * over * half + middle, r = t * over * half + middle;
        float left = cell(c, last), below = cell(r, last);
        column[i] = left;
        row[i] = below;
        across[i] = c - left;
        up[i] = r - below;
        texel[i] = face * face_texels + (int32_t)below * width + (int32_t)left;
    }
}

static void locate_on_plane(const sl_light_points *points, const sl_shadow_map *map, places *out) {
    const float *restrict px = points->x, *restrict py = points->y, *restrict pz = points->z;
    const sl_vec3 eye = map->eye, ex = map->frame.x, ey = map->frame.y;
    const float size = (float)map->size, middle = 0.5f * size - 0.5f, last = size - 2.0f;
    const float scale_x = 0.5f * size / map->reach_x, scale_y = 0.5f * size / map->reach_y;
    const int32_t width = map->size;
    int32_t *restrict texel = out->texel;
    float *restrict column = out->column, *restrict row = out->row, *restrict across = out->across,
                    *restrict up = out->up;
    const size_t count = points->count;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float x = px[i] - eye.x, y = py[i] - eye.y, z = pz[i] - eye.z;
        float c = (ex.x * x + ex.y * y + ex.z * z) * scale_x + middle,
              r = (ey.x * x + ey.y * y + ey.z * z) * scale_y + middle;
        float left = cell(c, last), below = cell(r, last), fc = c - left, fr = r - below;
        column[i] = left;
        row[i] = below;
        across[i] = fc > 0.0f ? (fc < 1.0f ? fc : 1.0f) : 0.0f;
        up[i] = fr > 0.0f ? (fr < 1.0f ? fr : 1.0f) : 0.0f;
        texel[i] = (int32_t)below * width + (int32_t)left;
    }
}

/* ---- one triangle in all four texels ---- */

static void test_first_plane(const sl_light_points *points, const sl_shadow_map *map,
                             const sl_plane_table *table, places *at, float *restrict lit) {
    const float *restrict px = points->x, *restrict py = points->y, *restrict pz = points->z;
    const uint32_t *restrict id = map->id;
    const int32_t *restrict texel = at->texel;
    const float *plane_x = table->planes, *plane_y = plane_x + 1, *plane_z = plane_x + 2,
                *plane_h = plane_x + 3;
    const int32_t width = map->size;
    const sl_vec3 centre = table->centre, eye = map->eye, d = map->frame.z;
    const float tolerance = table->tolerance;
    const float near_light = map->directional ? 0.0f : 1.0f; /* a cube's frame is 0 */
    const float ex = eye.x - centre.x, ey = eye.y - centre.y, ez = eye.z - centre.z;
    float *restrict agree = at->agree;
    int32_t *restrict first_plane = at->first_plane;
    const size_t count = points->count;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        int32_t k = texel[i];
        uint32_t first = id[k], right = id[k + 1], upper = id[k + width], last = id[k + width + 1];
        agree[i] = first == right && first == upper && first == last ? 1.0f : 0.0f;
        first_plane[i] = (int32_t)(4u * (first + 1u));
    }
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        int32_t plane = first_plane[i];
        float nx = plane_x[plane], ny = plane_y[plane], nz = plane_z[plane], h = plane_h[plane];
        float of_point = nx * (px[i] - centre.x) + ny * (py[i] - centre.y) + nz * (pz[i] - centre.z) - h;
        float of_eye = nx * ex + ny * ey + nz * ez - h;
        /* > 0: the normal points away from the light */
        float towards = nx * d.x + ny * d.y + nz * d.z - near_light * of_eye;
        float behind = towards > 0.0f ? of_point : -of_point;
        lit[i] = behind > tolerance ? 0.0f : 1.0f;
    }
}

/* ---- four texels ---- */

/* The points around which the texels differ, one after the other; positions relative to the map's eye. */
typedef struct {
    size_t count;
    uint32_t index[SL_LIGHT_BLOCK];
    int32_t texel[SL_LIGHT_BLOCK], face[SL_LIGHT_BLOCK];
    float column[SL_LIGHT_BLOCK], row[SL_LIGHT_BLOCK], across[SL_LIGHT_BLOCK], up[SL_LIGHT_BLOCK];
    float x[SL_LIGHT_BLOCK], y[SL_LIGHT_BLOCK], z[SL_LIGHT_BLOCK];
    float nx[SL_LIGHT_BLOCK], ny[SL_LIGHT_BLOCK], nz[SL_LIGHT_BLOCK]; /* of the point's own plane */
    int32_t plane[SL_LIGHT_BLOCK];
    float dark[SL_LIGHT_BLOCK];
} edges;

static void collect(const sl_light_points *points, const sl_shadow_map *map, const places *at, edges *e) {
    const int32_t face_texels = map->size * map->size;
    size_t count = 0;
    for (size_t i = 0; i < points->count; i++) {
        e->index[count] = (uint32_t)i;
        count += at->agree[i] > 0.0f ? 0u : 1u;
    }
    e->count = count;
    for (size_t j = 0; j < count; j++) {
        uint32_t i = e->index[j];
        e->texel[j] = at->texel[i];
        e->face[j] = at->texel[i] / face_texels;
        e->column[j] = at->column[i];
        e->row[j] = at->row[i];
        e->across[j] = at->across[i];
        e->up[j] = at->up[i];
        e->x[j] = points->x[i] - map->eye.x;
        e->y[j] = points->y[i] - map->eye.y;
        e->z[j] = points->z[i] - map->eye.z;
        e->nx[j] = points->geometric_x[i];
        e->ny[j] = points->geometric_y[i];
        e->nz[j] = points->geometric_z[i];
        e->dark[j] = 0.0f;
    }
}

/* One of the four texels, right and up by 0 or 1: adds its bilinear share where it is an obstacle. The centre
 * of the texel is a ray from o along d, relative to the map's eye; it meets the triangle's plane n . v = h at
 * s = (h - n . o) / n . d, which lies n_p . (o + s d - p) before the point's own plane. */
static inline void test_texel(const sl_shadow_map *map, const sl_plane_table *table, edges *e, int32_t right,
                              int32_t up, const bool directional) {
    const uint32_t *restrict id = map->id;
    const float *plane_x = table->planes, *plane_y = plane_x + 1, *plane_z = plane_x + 2,
                *plane_h = plane_x + 3;
    const int32_t step = right + up * map->size;
    const float shift_x = map->eye.x - table->centre.x, shift_y = map->eye.y - table->centre.y,
                shift_z = map->eye.z - table->centre.z;
    const float size = (float)map->size, middle = 0.5f * size - 0.5f, side = 1.0f / (0.5f * (size - 2.0f)),
                tolerance = table->tolerance;
    const float wide = directional ? 2.0f * map->reach_x / size : 0.0f,
                high = directional ? 2.0f * map->reach_y / size : 0.0f;
    const sl_vec3 ex = map->frame.x, ey = map->frame.y, ez = map->frame.z;
    const float right_share = right ? 1.0f : -1.0f, left_share = right ? 0.0f : 1.0f,
                up_share = up ? 1.0f : -1.0f, down_share = up ? 0.0f : 1.0f;
    for (size_t j = 0; j < e->count; j++) e->plane[j] = (int32_t)(4u * (id[e->texel[j] + step] + 1u));
#pragma omp simd
    for (size_t j = 0; j < e->count; j++) {
        int32_t plane = e->plane[j];
        float nx = plane_x[plane], ny = plane_y[plane], nz = plane_z[plane];
        float h = plane_h[plane] - (nx * shift_x + ny * shift_y + nz * shift_z);
        float column = e->column[j] + (float)right - middle, row = e->row[j] + (float)up - middle;
        float ox = 0.0f, oy = 0.0f, oz = 0.0f, dx = ez.x, dy = ez.y, dz = ez.z;
        if (directional) {
            float x = column * wide, y = row * high;
            ox = x * ex.x + y * ey.x;
            oy = x * ex.y + y * ey.y;
            oz = x * ex.z + y * ey.z;
        } else {
            int32_t axis = e->face[j] >> 1;
            float s = column * side, t = row * side, major = e->face[j] & 1 ? -1.0f : 1.0f;
            dx = axis == 0 ? major : axis == 1 ? t : s;
            dy = axis == 0 ? s : axis == 1 ? major : t;
            dz = axis == 0 ? t : axis == 1 ? s : major;
        }
        float slope = nx * dx + ny * dy + nz * dz, away = slope > 0.0f ? 1.0f : -1.0f; /* the normal's side */
        float behind = (nx * e->x[j] + ny * e->y[j] + nz * e->z[j] - h) * away;
        float over = e->nx[j] * (ox - e->x[j]) + e->ny[j] * (oy - e->y[j]) + e->nz[j] * (oz - e->z[j]);
        float steepness = e->nx[j] * dx + e->ny[j] * dy + e->nz[j] * dz,
              rise = h - (nx * ox + ny * oy + nz * oz);
        float before = (over * slope + steepness * rise) * away;
        float share = (left_share + right_share * e->across[j]) * (down_share + up_share * e->up[j]);
        float hidden = behind > tolerance ? share : 0.0f;
        e->dark[j] += before > tolerance * fabsf(slope) ? hidden : 0.0f;
    }
}

static inline void test_texels(const sl_shadow_map *map, const sl_plane_table *table, edges *e,
                               const bool directional) {
    for (int32_t k = 0; k < 4; k++) test_texel(map, table, e, k & 1, k >> 1, directional);
}

void SL_KERNEL(sl_shadow_map_lit)(const sl_light_points *points, const sl_shadow_map *map,
                                  const sl_plane_table *planes, float *lit) {
    places at;
    edges e;
    if (map->directional) locate_on_plane(points, map, &at);
    else locate_on_cube(points, map, &at);
    test_first_plane(points, map, planes, &at, lit);
    collect(points, map, &at, &e);
    if (map->directional) test_texels(map, planes, &e, true);
    else test_texels(map, planes, &e, false);
    for (size_t j = 0; j < e.count; j++) {
        float share = 1.0f - e.dark[j];
        lit[e.index[j]] = share > 1e-6f ? share : 0.0f; /* the four shares add up to 1 but for rounding */
    }
}
