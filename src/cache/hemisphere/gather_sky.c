/* In the middle of a gather of 128 x 128 a pixel is 5 degrees wide. Looked up by the directions of pixels
 * alone, a sun would be seen by one of them, or by none. So the environment is averaged over the texels of a
 * cube map with MIP levels, and looked up, bilinearly, in the level (between two) whose texels are 1.4 times
 * as wide as that pixel: then neighbouring pixels share the sun in proportion to how near they are to it, and
 * its light is kept, within 6 % (root mean square, a sun of 3 degrees under 128 x 128 pixels): narrower it
 * falls between pixels, wider it moves to the texel's middle. */
#include "cache/hemisphere/known_colours.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "raster/textures/textures.h"

enum { FACE = 64 /* texels of 1.4 degrees */, SAMPLES_MAX = 16, BLOCK = SL_TEXTURE_BLOCK };

struct sl_gather_sky {
    sl_cube_map *cube;
    float lod;
};

/* Gives the mean over a texel, weighted by solid angle, at as many points as make one of each of the
 * environment's texels. */
static void average_texel(const sl_environment *environment, const sl_frame *frame, int x, int y, int samples,
                          float rgba[4]) {
    double sum[3] = {0.0, 0.0, 0.0}, angle = 0.0;
    for (int k = 0; k < samples * samples; k++) {
        float s = (float)(2.0 * (x + (k % samples + 0.5) / samples) / FACE - 1.0),
              t = (float)(2.0 * (y + (k / samples + 0.5) / samples) / FACE - 1.0);
        sl_vec3 d = sl_normalize_or(sl_frame_to_world(frame, sl_v3(s, t, 1.0f)), frame->z);
        sl_rgb radiance = sl_environment_radiance(environment, d);
        double squared = 1.0 + (double)s * (double)s + (double)t * (double)t,
               weight = 1.0 / (squared * sqrt(squared));
        if (!sl_rgb_is_finite(radiance)) continue;
        sum[0] += weight * (double)radiance.r;
        sum[1] += weight * (double)radiance.g;
        sum[2] += weight * (double)radiance.b;
        angle += weight;
    }
    for (int c = 0; c < 3; c++) rgba[c] = angle > 0.0 ? (float)(sum[c] / angle) : 0.0f;
}

static void fill(sl_gather_sky *sky, const sl_environment *environment) {
    int samples = environment->width / (4 * FACE) + 1;
    if (samples > SAMPLES_MAX) samples = SAMPLES_MAX;
    for (int face = 0; face < 6; face++) {
        sl_frame frame = sl_cube_face_frame(face);
        for (int y = 0; y < FACE; y++) {
            for (int x = 0; x < FACE; x++) {
                average_texel(environment, &frame, x, y, samples,
                              sl_cube_map_texel(sky->cube, 0, face, x, y));
            }
        }
    }
    sl_cube_map_build(sky->cube, 1);
}

sl_status sl_gather_sky_create(const sl_environment *environment, double pixel, sl_gather_sky **sky,
                               sl_error *error) {
    *sky = NULL;
    if (!environment->present || environment->width <= 0) return SL_OK;
    sl_gather_sky *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "the gather's environment");
    sl_status status = sl_cube_map_create(FACE, true, &s->cube, error);
    if (status != SL_OK) {
        sl_free(s);
        return status;
    }
    fill(s, environment);
    float lod = sl_log2f((float)(1.4 * pixel * FACE / sqrt(4.0 * SL_PI / 6.0)));
    s->lod = lod > 0.0f ? lod : 0.0f;
    *sky = s;
    return SL_OK;
}

void sl_gather_sky_destroy(sl_gather_sky *sky) {
    if (!sky) return;
    sl_cube_map_destroy(sky->cube);
    sl_free(sky);
}

size_t sl_gather_sky_memory_bytes(const sl_gather_sky *sky) {
    if (!sky) return 0;
    size_t texels = 0;
    for (int l = 0; l < sky->cube->levels; l++)
        texels += 6 * (size_t)(sky->cube->level_size[l] + 2) * (size_t)(sky->cube->level_size[l] + 2);
    return sizeof *sky + sizeof *sky->cube + texels * 4 * sizeof(float);
}

/* ---- looking up ------------------------------------------------------------------------------ */

typedef struct batch {
    size_t count;
    size_t pixel[BLOCK];
    float x[BLOCK], y[BLOCK], z[BLOCK], lod[BLOCK], r[BLOCK], g[BLOCK], b[BLOCK];
} batch;

static void flush(const sl_gather_sky *sky, const sl_colour_pixels *p, batch *b) {
    sl_cube_map_sample_many(sky->cube, b->count, b->x, b->y, b->z, b->lod,
                            (float *const[4]){b->r, b->g, b->b, NULL});
    const float *rgb[3] = {b->r, b->g, b->b};
    for (int c = 0; c < 3; c++) {
        for (size_t k = 0; k < b->count; k++) {
            float radiance = rgb[c][k] > 0.0f ? rgb[c][k] : 0.0f;
            p->radiance[c][b->pixel[k]] = radiance;
            p->weighted[c][b->pixel[k]] = radiance * p->weight[b->pixel[k]];
        }
    }
    b->count = 0;
}

void sl_gather_sky_add(const sl_gather_sky *sky, const sl_colour_pixels *p) {
    if (!sky) return;
    batch b;
    b.count = 0;
    for (int row = 0; row < p->height; row++) {
        sl_vec3 middle = sl_mad(p->frame.z, p->y[row * p->width], p->frame.y);
        for (int column = 0; column < p->width; column++) {
            size_t pixel = (size_t)row * (size_t)p->width + (size_t)column;
            if (p->id[pixel] != SL_NO_INDEX) continue;
            sl_vec3 d = sl_mad(middle, p->x[column], p->frame.x);
            if (!(sl_dot(d, p->horizon) > 0.0f)) continue;
            b.pixel[b.count] = pixel;
            b.x[b.count] = d.x;
            b.y[b.count] = d.y;
            b.z[b.count] = d.z;
            b.lod[b.count] = sky->lod;
            if (++b.count == BLOCK) flush(sky, p, &b);
        }
    }
    if (b.count) flush(sky, p, &b);
}
