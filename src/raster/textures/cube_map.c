/* Cube maps: memory, MIP chain, and the borders that make lookups seamless.
 *
 * A texel (x, y) of face f of n texels has its centre at the point
 *
 *     s (2x + 1 - n) + t (2y + 1 - n) + m n          (s, t, m: the face's axes)
 *
 * on a cube of half-size n: whole numbers, so it is exact which texels are neighbours. A border texel, one
 * beyond the edge, is folded over it: its coordinate along the edge stays, the one across becomes +-n (the
 * neighbour's plane), and its depth becomes n - 1 (half a texel down the neighbour). */
#include "base/error.h"
#include "base/memory.h"
#include "raster/textures/textures.h"

sl_status sl_cube_map_create(int size, bool mip, sl_cube_map **cube, sl_error *error) {
    *cube = NULL;
    enum { SIZE_MAX_EACH = 8192 }; /* all faces and levels stay below 2^30 texels */
    if (size < 1 || size > SIZE_MAX_EACH) {
        return sl_fail(error, SL_ERROR_USAGE, "a cube map of %d texels: from 1 to %d", size,
                       (int)SIZE_MAX_EACH);
    }
    sl_cube_map *c = sl_allocate(1, sizeof *c);
    if (!c) return sl_fail_memory(error, "a cube map");
    *c = (sl_cube_map){
        .size = size, .levels = mip ? sl_mip_levels(size, size) : 1, .kernels = sl_texture_kernels_best()};
    int32_t texels = 0;
    for (int l = 0; l < c->levels; l++) {
        int n = l == 0 ? size : sl_half_size(c->level_size[l - 1]);
        c->level_size[l] = n;
        c->first[l] = texels;
        texels += 6 * (n + 2) * (n + 2);
    }
    c->texels = sl_allocate((size_t)texels, 4 * sizeof *c->texels);
    if (!c->texels) {
        sl_cube_map_destroy(c);
        return sl_fail_memory(error, "a cube map");
    }
    *cube = c;
    return SL_OK;
}

void sl_cube_map_destroy(sl_cube_map *cube) {
    if (!cube) return;
    sl_free(cube->texels);
    sl_free(cube);
}

float *sl_cube_map_texel(const sl_cube_map *cube, int level, int face, int x, int y) {
    size_t side = (size_t)cube->level_size[level] + 2;
    size_t texel = ((size_t)face * side + (size_t)(y + 1)) * side + (size_t)(x + 1);
    return cube->texels + 4 * ((size_t)cube->first[level] + texel);
}

/* ---- borders ---- */

typedef struct {
    int x, y, z;
} point;

static point on_axes(const sl_frame *f, int s, int t, int m) {
    return (point){(int)f->x.x * s + (int)f->y.x * t + (int)f->z.x * m,
                   (int)f->x.y * s + (int)f->y.y * t + (int)f->z.y * m,
                   (int)f->x.z * s + (int)f->y.z * t + (int)f->z.z * m};
}

static int along(sl_vec3 axis, point p) { return (int)axis.x * p.x + (int)axis.y * p.y + (int)axis.z * p.z; }

/* The texel whose centre is at p, a point of the cube of half-size n. */
static const float *texel_at(const sl_cube_map *cube, int level, point p) {
    int n = cube->level_size[level];
    for (int face = 0; face < 6; face++) {
        sl_frame f = sl_cube_face_frame(face);
        if (along(f.z, p) == n) {
            return sl_cube_map_texel(cube, level, face, (along(f.x, p) + n - 1) / 2,
                                     (along(f.y, p) + n - 1) / 2);
        }
    }
    return NULL; /* not on the cube */
}

static void copy_texel(float *to, const float *from) {
    for (int c = 0; c < 4; c++) to[c] = from[c];
}

static void border_edges(const sl_cube_map *cube, int level, int face) {
    int n = cube->level_size[level];
    sl_frame f = sl_cube_face_frame(face);
    for (int i = 0; i < n; i++) {
        int a = 2 * i + 1 - n;
        copy_texel(sl_cube_map_texel(cube, level, face, -1, i),
                   texel_at(cube, level, on_axes(&f, -n, a, n - 1)));
        copy_texel(sl_cube_map_texel(cube, level, face, n, i),
                   texel_at(cube, level, on_axes(&f, n, a, n - 1)));
        copy_texel(sl_cube_map_texel(cube, level, face, i, -1),
                   texel_at(cube, level, on_axes(&f, a, -n, n - 1)));
        copy_texel(sl_cube_map_texel(cube, level, face, i, n),
                   texel_at(cube, level, on_axes(&f, a, n, n - 1)));
    }
}

/* No fourth texel exists beyond a corner: the mean of the three that meet there, as OpenGL recommends. It is
 * summed in the faces' order, so that all three faces hold the same bits. */
static void border_corner(const sl_cube_map *cube, int level, int face, int x_end, int y_end) {
    int n = cube->level_size[level];
    sl_frame f = sl_cube_face_frame(face);
    int s = x_end ? n : -n, t = y_end ? n : -n;
    point p = on_axes(&f, s, t, n);
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    for (int other = 0; other < 6; other++) {
        sl_frame o = sl_cube_face_frame(other);
        if (along(o.z, p) != n) continue;
        const float *texel = sl_cube_map_texel(cube, level, other, along(o.x, p) > 0 ? n - 1 : 0,
                                               along(o.y, p) > 0 ? n - 1 : 0);
        for (int c = 0; c < 4; c++) sum[c] += (double)texel[c];
    }
    float *corner = sl_cube_map_texel(cube, level, face, x_end ? n : -1, y_end ? n : -1);
    for (int c = 0; c < 4; c++) corner[c] = (float)(sum[c] / 3.0);
}

void sl_cube_map_build(sl_cube_map *cube, unsigned threads) {
    for (int l = 0; l + 1 < cube->levels; l++) {
        int n = cube->level_size[l], half = cube->level_size[l + 1];
        for (int face = 0; face < 6; face++) {
            sl_mip_halve(sl_cube_map_texel(cube, l, face, 0, 0), n, n, (size_t)n + 2,
                         sl_cube_map_texel(cube, l + 1, face, 0, 0), (size_t)half + 2, threads);
        }
    }
    for (int l = 0; l < cube->levels; l++) {
        for (int face = 0; face < 6; face++) {
            border_edges(cube, l, face);
            for (int k = 0; k < 4; k++) border_corner(cube, l, face, k & 1, k >> 1);
        }
    }
}
