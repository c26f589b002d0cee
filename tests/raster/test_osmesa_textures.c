/* Texture filtering, MIP maps, levels of detail and cube maps, ours and OSMesa's, both against evaluation in double precision:
 * ours must never be further from it, neither at most nor on average. OSMesa gets the same coordinates bit by bit (from a
 * texture, fetched), so that what is compared is filtering alone; the last case compares a whole pass in perspective.
 *
 * Everything runs twice, since llvmpipe filters bytes with weights of 8 bits unless told otherwise: as it comes, and at its most
 * accurate (GALLIVM_PERF=no_quad_lod,no_aos_sampling). It reads that once a process, so the first run is a child process. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "osmesa.h"
#include "raster_support.h"
#include "raster/textures/textures.h"

enum { SIDE = 256, COUNT = SIDE * SIDE };

static float coordinates[COUNT][4], theirs[COUNT][4], ours[4][COUNT], columns[4][COUNT];
static double truth[COUNT][4];

/* ---- the comparison ---- */

typedef struct {
    double largest, sum;
} error_sum;

static void add_error(error_sum *e, double difference) {
    double d = fabs(difference);
    if (!(d <= e->largest)) e->largest = d; /* NaN counts as the largest */
    e->sum += d;
}

static void judge(const char *what, error_sum our, error_sum their, double count) {
    printf("  %-58s  %8.1e %8.1e   %8.1e %8.1e\n", what, our.largest, our.sum / count, their.largest, their.sum / count);
    assert_true(our.largest <= their.largest && our.sum <= their.sum);
}

static void compare(const char *what, int channels) {
    error_sum our = {0, 0}, their = {0, 0};
    for (int i = 0; i < COUNT; i++) {
        for (int c = 0; c < channels; c++) {
            add_error(&our, (double)ours[c][i] - truth[i][c]);
            add_error(&their, (double)theirs[i][c] - truth[i][c]);
        }
    }
    judge(what, our, their, (double)COUNT * channels);
}

static bool opened;
static void open_or_skip(void) {
    const char *reason;
    opened = osmesa_open(0, &reason);
    if (opened) return;
    print_message("skipped: %s\n", reason);
    skip();
}

/* ---- OSMesa's lookups: one a pixel, at coordinates from a texture ---- */

static const char *const whole_screen =
    "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }";

static void look_up(const osmesa_texels *texels, const char *lookup, const char *sampler_type) {
    const osmesa_format format = PLANE_RGBA32F;
    char text[512];
    snprintf(text, sizeof text,
             "uniform sampler2D places; uniform %s image; out vec4 color;"
             "void main() { vec4 p = texelFetch(places, ivec2(gl_FragCoord.xy), 0); color = %s; }", sampler_type, lookup);
    osmesa_target target = osmesa_target_create(SIDE, SIDE, 1, &format, false);
    unsigned program = osmesa_program(whole_screen, text), image = osmesa_texture_filtered(texels);
    unsigned places = osmesa_texture(SIDE, SIDE, coordinates[0]);
    osmesa_mesh mesh = osmesa_mesh_create(0, NULL, 3, NULL);
    osmesa_input(program, "places", 0, places);
    osmesa_input_filtered(program, "image", 1, texels->shape, image);
    osmesa_clear(&target);
    osmesa_draw_all(program, &mesh);
    osmesa_read(&target, 0, theirs);
    osmesa_mesh_destroy(&mesh);
    osmesa_texture_destroy(places);
    osmesa_texture_destroy(image);
    osmesa_program_destroy(program);
    osmesa_target_destroy(&target);
}

/* ---- the truth, in double ---- */

static long wrap(long i, long n, bool repeat) {
    if (repeat) return ((i % n) + n) % n;
    return i < 0 ? 0 : i >= n ? n - 1 : i;
}

/* Bilinear in one level; texels of `stride` a row. */
static void exact_bilinear(const float *texels, int width, int height, double s, double t, bool repeat, double out[4]) {
    double x = s * width - 0.5, y = t * height - 0.5, fx = x - floor(x), fy = y - floor(y);
    long i = (long)floor(x), j = (long)floor(y);
    for (int c = 0; c < 4; c++) {
        double v[4];
        for (int k = 0; k < 4; k++) {
            v[k] = (double)texels[4 * (wrap(j + (k >> 1), height, repeat) * width + wrap(i + (k & 1), width, repeat)) + c];
        }
        out[c] = (v[0] * (1 - fx) + v[1] * fx) * (1 - fy) + (v[2] * (1 - fx) + v[3] * fx) * fy;
    }
}

static void exact_trilinear(const sl_texture_image *m, double s, double t, double lod, bool repeat, double out[4]) {
    double last = m->levels - 1, l = lod < 0 ? 0 : lod > last ? last : lod, f = l - floor(l), coarse[4];
    int a = (int)floor(l), b = a + 1 < m->levels ? a + 1 : a;
    exact_bilinear(m->texels + 4 * (size_t)m->first[a], m->width[a], m->height[a], s, t, repeat, out);
    exact_bilinear(m->texels + 4 * (size_t)m->first[b], m->width[b], m->height[b], s, t, repeat, coarse);
    for (int c = 0; c < 4; c++) out[c] = out[c] * (1 - f) + coarse[c] * f;
}

/* ---- 2D ---- */

static sl_texture_image *random_image(int width, int height, bool mip, bool bytes) {
    sl_texture_image *m = NULL;
    assert_int_equal(sl_texture_image_create(width, height, mip, &m, NULL), SL_OK);
    uint64_t key = sl_random_key((uint64_t)(width * height), 3);
    for (size_t i = 0; i < 4 * (size_t)width * (size_t)height; i++) {
        float v = sl_random_unit(key, i);
        m->texels[i] = bytes ? floorf(v * 256.0f) / 255.0f : v;
    }
    sl_texture_image_build(m, 1);
    return m;
}

/* Places in [low, high] each way, and p.z between -1 and `levels`. */
static void random_places(float low, float high, float levels) {
    uint64_t key = sl_random_key(99, (uint64_t)levels);
    for (uint64_t i = 0; i < COUNT; i++) {
        for (uint64_t c = 0; c < 4; c++) {
            coordinates[i][c] = c < 2 ? random_between(key, 4 * i + c, low, high) : random_between(key, 4 * i + c, -1, levels);
        }
        for (int c = 0; c < 4; c++) columns[c][i] = coordinates[i][c];
    }
}

static void compare_image(const char *what, int width, int height, bool repeat, bool mip) {
    sl_texture_image *m = random_image(width, height, mip, false);
    const void *level[SL_TEXTURE_LEVELS];
    for (int l = 0; l < m->levels; l++) level[l] = m->texels + 4 * (size_t)m->first[l];
    osmesa_texels texels = {TEXTURE_2D, TEXEL_RGBA32F, width, height, 1, m->levels, level, repeat, true, mip ? 2 : 0};
    random_places(-1.5f, 2.5f, (float)m->levels);
    look_up(&texels, "textureLod(image, p.xy, p.z)", "sampler2D");
    sl_wrap kind = repeat ? SL_WRAP_REPEAT : SL_WRAP_CLAMP;
    float *const plane[4] = {ours[0], ours[1], ours[2], ours[3]};
    sl_texture_sample_many(m, (sl_sampler){kind, kind, kind, true, mip ? SL_MIP_LINEAR : SL_MIP_NONE}, COUNT, columns[0],
                           columns[1], columns[2], plane);
    for (int i = 0; i < COUNT; i++) {
        double s = (double)coordinates[i][0], t = (double)coordinates[i][1];
        if (!repeat) s = s < 0 ? 0 : s > 1 ? 1 : s, t = t < 0 ? 0 : t > 1 ? 1 : t;
        exact_trilinear(m, s, t, mip ? (double)coordinates[i][2] : 0.0, repeat, truth[i]);
    }
    compare(what, 4);
    sl_texture_image_destroy(m);
}

static void bilinear_and_trilinear_float_textures(void **state) {
    (void)state;
    open_or_skip();
    compare_image("bilinear, float, 64 x 64, repeated", 64, 64, true, false);
    compare_image("bilinear, float, 64 x 64, clamped", 64, 64, false, false);
    compare_image("bilinear, float, 1000 x 333, repeated", 1000, 333, true, false);
    compare_image("bilinear, float, 4096 x 4, clamped", 4096, 4, false, false);
    compare_image("trilinear at given levels, float, 256 x 256", 256, 256, true, true);
    compare_image("trilinear at given levels, float, 100 x 37, clamped", 100, 37, false, true);
}

static void compare_bytes(const char *what, bool srgb) {
    enum { N = 64 };
    static uint8_t bytes[4 * N * N];
    static float decoded[4 * N * N];
    uint64_t key = sl_random_key(8, srgb);
    for (uint64_t i = 0; i < 4 * N * N; i++) bytes[i] = (uint8_t)(sl_random_unit(key, i) * 256.0f);
    sl_texture texture = {.width = N, .height = N, .has_alpha = true, .texels = bytes};
    sl_texture_image *m = NULL;
    assert_int_equal(sl_texture_image_of_texture(&texture, 1, &m, NULL), SL_OK);
    m->levels = 1;
    const void *level[1] = {bytes};
    osmesa_texels texels = {TEXTURE_2D, srgb ? TEXEL_SRGB8_ALPHA8 : TEXEL_RGBA8, N, N, 1, 1, level, true, true, 0};
    random_places(-1.5f, 2.5f, 0.0f);
    look_up(&texels, "textureLod(image, vec2(p.x, 1.0 - p.y), 0.0)", "sampler2D"); /* a file's rows come from the top */
    for (int i = 0; i < 4 * N * N; i++) {
        double b = bytes[i] / 255.0, linear = b <= 0.04045 ? b / 12.92 : pow((b + 0.055) / 1.055, 2.4);
        int row = N - 1 - i / 4 / N, texel = 4 * (row * N + i / 4 % N) + i % 4;
        decoded[texel] = (float)(srgb && i % 4 < 3 ? linear : b);
        if (!srgb) m->texels[texel] = (float)b;
    }
    float *const plane[4] = {ours[0], ours[1], ours[2], ours[3]};
    sl_sampler sampler = {SL_WRAP_REPEAT, SL_WRAP_REPEAT, SL_WRAP_REPEAT, true, SL_MIP_NONE};
    sl_texture_sample_many(m, sampler, COUNT, columns[0], columns[1], NULL, plane);
    for (int i = 0; i < COUNT; i++) {
        exact_bilinear(decoded, N, N, (double)coordinates[i][0], (double)coordinates[i][1], true, truth[i]);
    }
    compare(what, 4);
    sl_texture_image_destroy(m);
}

static void bilinear_byte_textures(void **state) {
    (void)state;
    open_or_skip();
    compare_bytes("bilinear, bytes, 64 x 64", false);
    compare_bytes("bilinear, sRGB bytes, 64 x 64", true);
}

/* The nearest texel: ours is the one that holds the point, always. */
static void nearest_texels(void **state) {
    (void)state;
    open_or_skip();
    const int sizes[][2] = {{64, 64}, {1000, 333}};
    for (int k = 0; k < 2; k++) {
        int w = sizes[k][0], h = sizes[k][1], our_wrong = 0, their_wrong = 0;
        sl_texture_image *m = random_image(w, h, false, false);
        const void *level[1] = {m->texels};
        osmesa_texels texels = {TEXTURE_2D, TEXEL_RGBA32F, w, h, 1, 1, level, true, false, 0};
        random_places(-1.5f, 2.5f, 0.0f);
        look_up(&texels, "textureLod(image, p.xy, 0.0)", "sampler2D");
        float *const plane[4] = {ours[0], ours[1], ours[2], ours[3]};
        sl_texture_sample_many(m, (sl_sampler){.linear = false}, COUNT, columns[0], columns[1], NULL, plane);
        for (int i = 0; i < COUNT; i++) {
            long x = (long)floor((double)coordinates[i][0] * w), y = (long)floor((double)coordinates[i][1] * h);
            const float *texel = sl_texture_fetch(m, 0, (int)wrap(x, w, true), (int)wrap(y, h, true));
            our_wrong += ours[0][i] != texel[0] || ours[3][i] != texel[3];
            their_wrong += theirs[i][0] != texel[0] || theirs[i][3] != texel[3];
        }
        printf("  nearest texel, %4d x %-4d: %d of ours are another one, %d of OSMesa's (of %d)\n", w, h, our_wrong, their_wrong,
               (int)COUNT);
        assert_int_equal(our_wrong, 0);
        sl_texture_image_destroy(m);
    }
}

/* The levels themselves: means over the texels' areas. OSMesa's glGenerateMipmap() filters by bilinear lookups. */
static void generated_levels(void **state) {
    (void)state;
    open_or_skip();
    const int sizes[][2] = {{64, 64}, {100, 37}, {255, 255}};
    for (int k = 0; k < 3; k++) {
        int w = sizes[k][0], h = sizes[k][1];
        sl_texture_image *m = random_image(w, h, true, false);
        const void *level[1] = {m->texels};
        osmesa_texels texels = {TEXTURE_2D, TEXEL_RGBA32F, w, h, 1, 1, level, true, true, 2};
        unsigned texture = osmesa_texture_filtered(&texels);
        error_sum our = {0, 0}, their = {0, 0};
        double count = 0;
        for (int l = 1; l < m->levels; l++) {
            osmesa_read_level(texture, l, theirs[0]);
            for (int i = 0; i < m->width[l] * m->height[l]; i++) {
                /* The area of a texel of level l in texels of level 0; in chains of odd sizes the same, since every level is exact. */
                double x0 = (double)(i % m->width[l]) * w / m->width[l], x1 = x0 + (double)w / m->width[l];
                double y0 = (double)(i / m->width[l]) * h / m->height[l], y1 = y0 + (double)h / m->height[l], sum[4] = {0}, area = 0;
                if (l > 1 && (w % (1 << l) || h % (1 << l))) continue; /* later levels average averages */
                for (int y = (int)y0; y < h && y < y1; y++) {
                    for (int x = (int)x0; x < w && x < x1; x++) {
                        double part = (fmin(x + 1, x1) - fmax(x, x0)) * (fmin(y + 1, y1) - fmax(y, y0));
                        area += part;
                        for (int c = 0; c < 4; c++) sum[c] += part * (double)sl_texture_fetch(m, 0, x, y)[c];
                    }
                }
                for (int c = 0; c < 4; c++) {
                    add_error(&our, (double)m->texels[4 * (m->first[l] + i) + c] - sum[c] / area);
                    add_error(&their, (double)theirs[i][c] - sum[c] / area);
                    count++;
                }
            }
        }
        char what[64];
        snprintf(what, sizeof what, "generated levels, float, %d x %d", w, h);
        judge(what, our, their, count);
        osmesa_texture_destroy(texture);
        sl_texture_image_destroy(m);
    }
}

/* ---- cube maps ---- */

static void exact_face_place(const float d[3], int *face, double *s, double *t) {
    double a[3] = {fabs((double)d[0]), fabs((double)d[1]), fabs((double)d[2])};
    int axis = a[0] >= a[1] && a[0] >= a[2] ? 0 : a[1] >= a[2] ? 1 : 2;
    *face = 2 * axis + (d[axis] < 0);
    sl_frame f = sl_cube_face_frame(*face);
    const double m = a[axis];
    *s = ((double)d[0] * (double)f.x.x + (double)d[1] * (double)f.x.y + (double)d[2] * (double)f.x.z) / m * 0.5 + 0.5;
    *t = ((double)d[0] * (double)f.y.x + (double)d[1] * (double)f.y.y + (double)d[2] * (double)f.y.z) / m * 0.5 + 0.5;
}

static void exact_cube(const sl_cube_map *cube, const float d[3], int level, double out[4]) {
    int face, size = cube->level_size[level];
    double s, t;
    exact_face_place(d, &face, &s, &t);
    double x = s * size - 0.5, y = t * size - 0.5, fx = x - floor(x), fy = y - floor(y);
    for (int c = 0; c < 4; c++) {
        double v[4];
        for (int k = 0; k < 4; k++) {
            v[k] = (double)sl_cube_map_texel(cube, level, face, (int)floor(x) + (k & 1), (int)floor(y) + (k >> 1))[c];
        }
        out[c] = (v[0] * (1 - fx) + v[1] * fx) * (1 - fy) + (v[2] * (1 - fx) + v[3] * fx) * fy;
    }
}

static void compare_cube(const char *what, int size, bool mip, double corner) {
    sl_cube_map *cube = NULL;
    assert_int_equal(sl_cube_map_create(size, mip, &cube, NULL), SL_OK);
    uint64_t key = sl_random_key(4, (uint64_t)size);
    for (int i = 0; i < 6 * size * size; i++) {
        float *texel = sl_cube_map_texel(cube, 0, i / (size * size), i % size, i / size % size);
        for (uint64_t c = 0; c < 4; c++) texel[c] = sl_random_unit(key, 4 * (uint64_t)i + c);
    }
    sl_cube_map_build(cube, 1);
    float *copies[6 * SL_TEXTURE_LEVELS] = {NULL};
    for (int l = 0; l < cube->levels; l++) {
        int n = cube->level_size[l];
        for (int face = 0; face < 6; face++) {
            float *copy = copies[6 * l + face] = malloc((size_t)n * (size_t)n * 4 * sizeof(float));
            assert_non_null(copy);
            for (int y = 0; y < n; y++) {
                memcpy(copy + 4 * n * y, sl_cube_map_texel(cube, l, face, 0, y), (size_t)n * 4 * sizeof(float));
            }
        }
    }
    osmesa_texels texels = {TEXTURE_CUBE, TEXEL_RGBA32F, size, size, 1, cube->levels, (const void *const *)copies, false, true, mip ? 2 : 0};
    for (uint64_t i = 0; i < COUNT; i++) {
        sl_vec3 d = random_direction(key, 100000 + i);
        if (corner > 0.0) { /* within that distance of a corner of the cube */
            d = sl_v3((i & 1 ? 1.0f : -1.0f) + (float)corner * d.x, (i & 2 ? 1.0f : -1.0f) + (float)corner * d.y, (i & 4 ? 1.0f : -1.0f) + (float)corner * d.z);
        }
        const float place[4] = {d.x, d.y, d.z, mip ? random_between(key, 9000000 + i, -1, (float)cube->levels) : 0.0f};
        memcpy(coordinates[i], place, sizeof place);
        for (int c = 0; c < 4; c++) columns[c][i] = place[c];
    }
    look_up(&texels, "textureLod(image, p.xyz, p.w)", "samplerCube");
    float *const plane[4] = {ours[0], ours[1], ours[2], ours[3]};
    sl_cube_map_sample_many(cube, (sl_sampler){.linear = true, .mip = mip ? SL_MIP_LINEAR : SL_MIP_NONE}, COUNT, columns[0], columns[1],
                            columns[2], columns[3], plane);
    for (int i = 0; i < COUNT; i++) {
        double last = cube->levels - 1, l = (double)coordinates[i][3], coarse[4];
        l = l < 0 ? 0 : l > last ? last : l;
        int a = (int)l, b = a + 1 < cube->levels ? a + 1 : a;
        exact_cube(cube, coordinates[i], a, truth[i]);
        exact_cube(cube, coordinates[i], b, coarse);
        for (int c = 0; c < 4; c++) truth[i][c] += (l - a) * (coarse[c] - truth[i][c]);
    }
    compare(what, 4);
    for (int i = 0; i < 6 * SL_TEXTURE_LEVELS; i++) free(copies[i]);
    sl_cube_map_destroy(cube);
}

static void seamless_cube_maps(void **state) {
    (void)state;
    open_or_skip();
    compare_cube("cube map, bilinear, 16 x 16, all directions", 16, false, 0.0);
    compare_cube("cube map, bilinear, 4 x 4, around corners", 4, false, 0.2);
    compare_cube("cube map, bilinear, 512 x 512", 512, false, 0.0);
    compare_cube("cube map, trilinear, 64 x 64", 64, true, 0.0);
}

/* ---- 3D ---- */

static void compare_volume(const char *what, sl_volume_format format, bool repeat) {
    enum { W = 32, H = 16, D = 20 };
    sl_volume *v = NULL;
    assert_int_equal(sl_volume_create(W, H, D, format, &v, NULL), SL_OK);
    uint64_t key = sl_random_key(5, (uint64_t)format);
    for (uint64_t i = 0; i < 4 * W * H * D; i++) {
        if (format == SL_VOLUME_RGBA8) v->bytes[i] = (uint8_t)(sl_random_unit(key, i) * 256.0f);
        else v->texels[i] = sl_random_unit(key, i);
    }
    const void *level[1] = {format == SL_VOLUME_RGBA8 ? (const void *)v->bytes : (const void *)v->texels};
    osmesa_texels texels = {TEXTURE_3D, format == SL_VOLUME_RGBA8 ? TEXEL_RGBA8 : TEXEL_RGBA32F, W, H, D, 1, level, repeat, true, 0};
    for (uint64_t i = 0; i < COUNT; i++) {
        for (uint64_t c = 0; c < 4; c++) columns[c][i] = coordinates[i][c] = random_between(key, 1000000 + 4 * i + c, -1, 2);
    }
    look_up(&texels, "textureLod(image, p.xyz, 0.0)", "sampler3D");
    sl_wrap kind = repeat ? SL_WRAP_REPEAT : SL_WRAP_CLAMP;
    float *const plane[4] = {ours[0], ours[1], ours[2], ours[3]};
    sl_volume_sample_many(v, (sl_sampler){kind, kind, kind, true, SL_MIP_NONE}, COUNT, columns[0], columns[1], columns[2], plane);
    for (int i = 0; i < COUNT; i++) {
        const int size[3] = {W, H, D};
        double f[3], sum[4] = {0};
        long low[3];
        for (int k = 0; k < 3; k++) {
            double u = (double)coordinates[i][k], x = (repeat ? u : u < 0 ? 0 : u > 1 ? 1 : u) * size[k] - 0.5;
            low[k] = (long)floor(x);
            f[k] = x - floor(x);
        }
        for (int n = 0; n < 8; n++) {
            long x = wrap(low[0] + (n & 1), W, repeat), y = wrap(low[1] + (n >> 1 & 1), H, repeat), z = wrap(low[2] + (n >> 2), D, repeat);
            double weight = (n & 1 ? f[0] : 1 - f[0]) * (n & 2 ? f[1] : 1 - f[1]) * (n & 4 ? f[2] : 1 - f[2]);
            for (int c = 0; c < 4; c++) {
                long texel = 4 * ((z * H + y) * W + x) + c;
                sum[c] += weight * (format == SL_VOLUME_RGBA8 ? v->bytes[texel] / 255.0 : (double)v->texels[texel]);
            }
        }
        memcpy(truth[i], sum, sizeof sum);
    }
    compare(what, 4);
    sl_volume_destroy(v);
}

static void volumes(void **state) {
    (void)state;
    open_or_skip();
    compare_volume("3D texture, trilinear, float, repeated", SL_VOLUME_RGBA32F, true);
    compare_volume("3D texture, trilinear, float, clamped", SL_VOLUME_RGBA32F, false);
    compare_volume("3D texture, trilinear, bytes, clamped", SL_VOLUME_RGBA8, false);
}

/* ---- a whole pass ---- */

static const float floor_positions[] = {-10, 0, 0, 10, 0, 0, 10, 0, -40, -10, 0, -40}, floor_uv[] = {0, 0, 8, 0, 8, 16, 0, 16};
static const uint32_t floor_indices[] = {0, 1, 2, 0, 2, 3};

static sl_view floor_view(void) {
    sl_camera camera;
    assert_true(sl_camera_look_at(&camera, sl_v3(0.5f, 2.0f, 3.0f), sl_v3(0, 1, -10), sl_v3(0.05f, 1, 0), 1.0f));
    return sl_view_camera(&camera, SIDE, SIDE, 0.1f, 100.0f);
}

/* Where the line of sight at a place of the window meets the floor y = 0, in texture coordinates. */
static void floor_at(const sl_view *view, double x, double y, double *s, double *t) {
    double a[2][3];
    for (int k = 0; k < 2; k++) {
        for (int c = 0; c < 3; c++) a[k][c] = (double)view->clip[k][c] - ((k ? y : x) * 2 / SIDE - 1) * (double)view->clip[3][c];
    }
    double qy = -(double)view->origin.y, d = a[0][0] * a[1][2] - a[0][2] * a[1][0];
    *s = (qy * (a[0][2] * a[1][1] - a[0][1] * a[1][2]) / d + (double)view->origin.x + 10.0) * 0.4;
    *t = -(qy * (a[0][1] * a[1][0] - a[0][0] * a[1][1]) / d + (double)view->origin.z) * 0.4;
}

static double floor_lod(const sl_view *view, double x, double y, int size) {
    const double h = 1e-4;
    double s1, t1, s2, t2, s3, t3, s4, t4;
    floor_at(view, x + h, y, &s1, &t1);
    floor_at(view, x - h, y, &s2, &t2);
    floor_at(view, x, y + h, &s3, &t3);
    floor_at(view, x, y - h, &s4, &t4);
    double dx = hypot(s1 - s2, t1 - t2), dy = hypot(s3 - s4, t3 - t4);
    return log2((dx > dy ? dx : dy) / (2 * h) * size);
}

/* The floor in OSMesa: colour, and (s, t, level of detail). */
static void draw_floor(const sl_view *view, const sl_texture_image *m, float (*color)[4], float (*place)[4]) {
    const osmesa_format formats[] = {PLANE_RGBA32F, PLANE_RGBA32F};
    const void *level[SL_TEXTURE_LEVELS];
    for (int l = 0; l < m->levels; l++) level[l] = m->texels + 4 * (size_t)m->first[l];
    osmesa_texels texels = {TEXTURE_2D, TEXEL_RGBA32F, m->width[0], m->height[0], 1, m->levels, level, true, true, 2};
    osmesa_target target = osmesa_target_create(SIDE, SIDE, 2, formats, true);
    unsigned image = osmesa_texture_filtered(&texels);
    unsigned program = osmesa_program(
        "#version 400 core\nlayout(location = 0) in vec3 p; layout(location = 1) in vec2 c; uniform mat4 clip; uniform vec3 eye;"
        "out vec2 st; void main() { gl_Position = clip * vec4(p - eye, 1); st = c; }",
        "#version 400 core\nin vec2 st; uniform sampler2D image; layout(location = 0) out vec4 color; layout(location = 1) out vec4 place;"
        "void main() { color = texture(image, st); place = vec4(st, textureQueryLod(image, st).y, 1); }");
    const osmesa_stream streams[] = {{floor_positions, 4, 3, false}, {floor_uv, 4, 2, false}};
    osmesa_mesh mesh = osmesa_mesh_create(2, streams, 6, floor_indices);
    const float eye[3] = {view->origin.x, view->origin.y, view->origin.z};
    osmesa_uniform_matrix(program, "clip", view->clip);
    osmesa_uniform(program, "eye", 3, eye);
    osmesa_input_filtered(program, "image", 0, TEXTURE_2D, image);
    osmesa_clear(&target);
    osmesa_state(true, false);
    osmesa_draw_all(program, &mesh);
    osmesa_state(false, false);
    osmesa_read(&target, 0, color);
    osmesa_read(&target, 1, place);
    osmesa_mesh_destroy(&mesh);
    osmesa_program_destroy(program);
    osmesa_texture_destroy(image);
    osmesa_target_destroy(&target);
}

static float theirs_place[COUNT][4], our_place[3][COUNT];
static uint32_t id[COUNT];

static void shade_floor(const sl_view *view, const sl_texture_image *m, sl_lod_rule rule) {
    const float x[] = {-10, 10, 10, -10}, y[] = {0, 0, 0, 0}, z[] = {0, 0, -40, -40};
    const uint32_t corner0[] = {0, 0}, corner1[] = {1, 2}, corner2[] = {2, 3};
    const float corners[] = {0, 0, 8, 0, 8, 16, 0, 0, 8, 16, 0, 16};
    sl_raster_mesh mesh = {4, 2, x, y, z, {corner0, corner1, corner2}};
    sl_raster *raster = NULL;
    assert_int_equal(sl_raster_create_mesh(&mesh, 1, &raster, NULL), SL_OK);
    render(raster, view, 1, id, NULL);
    sl_textured_pass pass = {NULL, m, corners, {SL_WRAP_REPEAT, SL_WRAP_REPEAT, SL_WRAP_REPEAT, true, SL_MIP_LINEAR}, rule, 0.0f};
    sl_textured_planes out = {{ours[0], ours[1], ours[2], ours[3]}, {NULL, NULL, NULL}, our_place[0], our_place[1], our_place[2]};
    sl_counters counters = {{0}};
    sl_raster_textured(raster, view, 1, id, &pass, &out, &counters);
    sl_raster_destroy(raster);
}

/* llvmpipe's logarithm: linear between powers of two, so at most 0.0861 too low. */
static double piecewise_log2(double x) {
    int exponent;
    double mantissa = 2.0 * frexp(x, &exponent);
    return exponent - 1 + (mantissa - 1.0);
}

/* The texture on a floor in perspective. OSMesa's level of detail comes from differences of 2 x 2 pixels; taken the same way, with the
 * same logarithm, ours is the same. */
static void a_floor_in_perspective(void **state) {
    (void)state;
    open_or_skip();
    sl_view view = floor_view();
    sl_texture_image *m = random_image(64, 64, true, false);
    draw_floor(&view, m, theirs, theirs_place);
    error_sum lod_ours = {0, 0}, lod_theirs = {0, 0}, st_ours = {0, 0}, st_theirs = {0, 0}, our = {0, 0}, their = {0, 0};
    error_sum quads = {0, 0};
    double count = 0;
    shade_floor(&view, m, SL_LOD_DIFFERENCES);
    for (int i = 0; i < COUNT; i++) {
        bool drawn = id[i] != SL_NO_INDEX;
        assert_true(drawn == (theirs_place[i][3] > 0.0f));
        int quad = i / SIDE / 2 * 2 * SIDE + i % SIDE / 2 * 2; /* a quad at the edge, or of two triangles, has other neighbours */
        bool whole = drawn && id[quad] == id[i] && id[quad + 1] == id[i] && id[quad + SIDE] == id[i] && id[quad + SIDE + 1] == id[i];
        double same = 0.5 * piecewise_log2(exp2(2.0 * (double)our_place[2][i]));
        if (whole) add_error(&quads, same - (double)theirs_place[i][2]);
    }
    shade_floor(&view, m, SL_LOD_EXACT);
    for (int i = 0; i < COUNT; i++) {
        if (id[i] == SL_NO_INDEX) continue;
        double s, t, x = i % SIDE + 0.5, y = i / SIDE + 0.5, exact[4];
        floor_at(&view, x, y, &s, &t);
        if (!(s > 0 && s < 8 && t > 0 && t < 16)) continue; /* within a 512th of a pixel of the edge */
        double lod = floor_lod(&view, x, y, 64);
        exact_trilinear(m, s, t, lod, true, exact);
        count++;
        add_error(&st_ours, fmax(fabs((double)our_place[0][i] - s), fabs((double)our_place[1][i] - t)));
        add_error(&st_theirs, fmax(fabs((double)theirs_place[i][0] - s), fabs((double)theirs_place[i][1] - t)));
        add_error(&lod_ours, (double)our_place[2][i] - lod);
        add_error(&lod_theirs, (double)theirs_place[i][2] - lod);
        for (int c = 0; c < 4; c++) {
            add_error(&our, (double)ours[c][i] - exact[c]);
            add_error(&their, (double)theirs[i][c] - exact[c]);
        }
    }
    assert_true(count > COUNT / 4);
    judge("floor: texture coordinates", st_ours, st_theirs, count);
    judge("floor: level of detail", lod_ours, lod_theirs, count);
    judge("floor: colour, trilinear, float, 64 x 64", our, their, 4 * count);
    printf("  floor: level of detail by 2 x 2 differences, ours against OSMesa's: at most %.1e apart\n", quads.largest);
    assert_true(quads.largest < 2e-3);
    sl_texture_image_destroy(m);
}

static int run(const char *setting) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bilinear_and_trilinear_float_textures),
        cmocka_unit_test(bilinear_byte_textures),
        cmocka_unit_test(nearest_texels),
        cmocka_unit_test(generated_levels),
        cmocka_unit_test(seamless_cube_maps),
        cmocka_unit_test(volumes),
        cmocka_unit_test(a_floor_in_perspective),
    };
    if (setting) setenv("GALLIVM_PERF", setting, 1);
    else unsetenv("GALLIVM_PERF");
    printf("OSMesa %s\n  %-58s  ours: largest, mean  OSMesa's: largest, mean\n", setting ? setting : "as it comes",
           "differences to double precision, of values in [0,1]");
    fflush(stdout);
    int failed = cmocka_run_group_tests_name("textures beside OSMesa's", tests, NULL, NULL);
    if (opened) osmesa_close();
    return failed;
}

int main(void) {
    fflush(NULL);
    pid_t child = fork();
    if (child < 0) return 1;
    if (child == 0) exit(run(NULL) != 0);
    int status = 0;
    if (waitpid(child, &status, 0) != child || status != 0) return 1;
    return run("no_quad_lod,no_aos_sampling");
}
