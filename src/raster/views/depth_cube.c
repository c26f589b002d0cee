/* A cube of depth maps around a light, and percentage-closer filtering (Reeves, Salesin and Cook 1987) of 2x2
 * texels.
 *
 * The comparison of a texel needs a bias, since the texel holds the depth at its own centre and not at p. For a
 * plane with normal n through p, w = n.q / n.d along the direction d = (s, t, 1) of a texel (q = p - eye). Moving d
 * by the distance of the centres, at most one texel (2 / size) in s and in t (and half a texel more where the filter
 * reaches round an edge of the cube), changes n.d by at most x n.d with
 *     x = 1.5 (2 / size) (|n_x| + |n_y| + |n_z|) / |n.d|,
 * so a texel of the same plane holds at least w / (1 + x), that is w - w x / (1 + x): that is the bias, exact for a
 * plane. Instead of jumping, a texel's share falls linearly from 1 to 0 over a second bias beyond the first, so the
 * result is continuous in p and n. The form is symmetric in the axes, so it is continuous over the edges of the cube
 * also. */
#include <math.h>

#include "base/error.h"
#include "base/memory.h"
#include "raster/view.h"

sl_status sl_raster_depth_cube(const sl_raster *raster, sl_vec3 eye, int size, float near, unsigned threads,
                               sl_depth_cube **cube, sl_counters *counters, sl_error *error) {
    *cube = NULL;
    if (size < 1 || size > SL_RASTER_MAX_SIZE) {
        return sl_fail(error, SL_ERROR_USAGE, "a depth cube of %d pixels: from 1 to %d", size, (int)SL_RASTER_MAX_SIZE);
    }
    size_t face_pixels = (size_t)size * (size_t)size;
    sl_depth_cube *c = sl_allocate(1, sizeof *c);
    if (c) {
        *c = (sl_depth_cube){.size = size, .eye = eye, .depth = sl_allocate(6 * face_pixels, sizeof *c->depth)};
    }
    if (!c || !c->depth) {
        sl_depth_cube_destroy(c);
        return sl_fail_memory(error, "a depth cube");
    }
    sl_view views[6];
    sl_target targets[6];
    for (int face = 0; face < 6; face++) {
        views[face] = sl_view_cube_face(eye, face, size, near);
        targets[face] = (sl_target){size, size, NULL, c->depth + (size_t)face * face_pixels};
    }
    sl_status status = sl_raster_ids(raster, 6, views, threads, targets, counters, error);
    if (status == SL_OK) *cube = c;
    else sl_depth_cube_destroy(c);
    return status;
}

void sl_depth_cube_destroy(sl_depth_cube *cube) {
    if (!cube) return;
    sl_free(cube->depth);
    sl_free(cube);
}

/* ---- lookup ---- */

static int face_of(sl_vec3 d) {
    float x = fabsf(d.x), y = fabsf(d.y), z = fabsf(d.z);
    if (x >= y && x >= z) return d.x >= 0.0f ? 0 : 1;
    if (y >= z) return d.y >= 0.0f ? 2 : 3;
    return d.z >= 0.0f ? 4 : 5;
}

static int texel_of(float s, int size) { /* nearest, s in [-1,1] */
    int i = (int)floorf((s + 1.0f) * 0.5f * (float)size);
    return i < 0 ? 0 : i >= size ? size - 1 : i;
}

/* The stored 1/w of the texel that holds direction d, and the depth of the receiver q along the same face's axis. */
static float fetch(const sl_depth_cube *cube, sl_vec3 d, sl_vec3 q, float *receiver) {
    int face = face_of(d);
    sl_frame f = sl_cube_face_frame(face);
    float w = sl_dot(f.z, d);
    int x = texel_of(sl_dot(f.x, d) / w, cube->size), y = texel_of(sl_dot(f.y, d) / w, cube->size);
    size_t size = (size_t)cube->size;
    *receiver = sl_dot(f.z, q);
    return cube->depth[((size_t)face * size + (size_t)y) * size + (size_t)x];
}

static float texel_share(float inverse_w, float receiver, float relative_bias) {
    float bias = receiver * relative_bias;
    float beyond = receiver * inverse_w - 1.0f; /* (receiver - stored) / stored, <= 0 where the texel is empty */
    if (!(beyond > 0.0f) || !(bias > 0.0f)) return 1.0f;
    float stored = 1.0f / inverse_w;
    float share = 1.0f - ((receiver - stored) - bias) / bias;
    return share < 0.0f ? 0.0f : share > 1.0f ? 1.0f : share;
}

float sl_depth_cube_lit(const sl_depth_cube *cube, sl_vec3 p, sl_vec3 n) {
    sl_vec3 q = sl_sub(p, cube->eye);
    int face = face_of(q);
    sl_frame f = sl_cube_face_frame(face);
    float w = sl_dot(f.z, q), size = (float)cube->size;
    if (!(w > 0.0f) || !sl_is_finite(q)) return 1.0f; /* at the light itself, or nowhere */
    float over = 1.0f / w, facing = fabsf(sl_dot(n, q)) * over;
    float reach = 3.0f / size * (fabsf(n.x) + fabsf(n.y) + fabsf(n.z));
    float relative_bias = reach / (facing + reach) + 1e-5f; /* x / (1 + x); 1e-5: the depth's own rounding */
    float u = (sl_dot(f.x, q) * over + 1.0f) * 0.5f * size - 0.5f;
    float v = (sl_dot(f.y, q) * over + 1.0f) * 0.5f * size - 0.5f;
    float u0 = floorf(u), v0 = floorf(v), fu = u - u0, fv = v - v0;
    float share[4];
    for (int k = 0; k < 4; k++) {
        float s = (u0 + (float)(k & 1) + 0.5f) * 2.0f / size - 1.0f;
        float t = (v0 + (float)(k >> 1) + 0.5f) * 2.0f / size - 1.0f;
        sl_vec3 d = sl_add(sl_add(sl_scale(f.x, s), sl_scale(f.y, t)), f.z);
        float receiver, stored = fetch(cube, d, q, &receiver);
        share[k] = texel_share(stored, receiver, relative_bias);
    }
    float low = share[0] + fu * (share[1] - share[0]), high = share[2] + fu * (share[3] - share[2]);
    return low + fv * (high - low); /* all equal: exactly their value */
}
