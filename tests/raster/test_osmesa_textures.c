/* Texture filtering, MIP maps and cube maps, ours and OSMesa's, both against evaluation in double precision:
 * ours must never be further from it, neither at most nor on average. OSMesa gets the same coordinates bit by
 * bit (from a texture, fetched), so that what is compared is filtering alone.
 *
 * Everything runs twice, since llvmpipe filters bytes with weights of 8 bits unless told otherwise: as it
 * comes, and at its most accurate (GALLIVM_PERF=no_quad_lod,no_aos_sampling). It reads that once a process,
 * so the first run is a child process. */
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
    printf("  %-58s  %8.1e %8.1e   %8.1e %8.1e\n", what, our.largest, our.sum / count, their.largest,
           their.sum / count);
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
             "void main() { vec4 p = texelFetch(places, ivec2(gl_FragCoord.xy), 0); color = %s; }",
             sampler_type, lookup);
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

static long within(long i, long n) {
    return i < 0 ? 0 : i >= n ? n - 1 : i;
}

/* Bilinear in one level; texels of `stride` a row. */
static void exact_bilinear(const float *texels, int width, int height, double s, double t, double out[4]) {
    double x = s * width - 0.5, y = t * height - 0.5, fx = x - floor(x), fy = y - floor(y);
    long i = (long)floor(x), j = (long)floor(y);
    for (int c = 0; c < 4; c++) {
        double v[4];
        for (int k = 0; k < 4; k++) {
            v[k] =
                (double)texels[4 * (within(j + (k >> 1), height) * width + within(i + (k & 1), width)) + c];
        }
        out[c] = (v[0] * (1 - fx) + v[1] * fx) * (1 - fy) + (v[2] * (1 - fx) + v[3] * fx) * fy;
    }
}

static void exact_trilinear(const sl_texture_image *m, double s, double t, double lod, double out[4]) {
    double last = m->levels - 1, l = lod < 0 ? 0 : lod > last ? last : lod, f = l - floor(l), coarse[4];
    int a = (int)floor(l), b = a + 1 < m->levels ? a + 1 : a;
    exact_bilinear(m->texels + 4 * (size_t)m->first[a], m->width[a], m->height[a], s, t, out);
    exact_bilinear(m->texels + 4 * (size_t)m->first[b], m->width[b], m->height[b], s, t, coarse);
    for (int c = 0; c < 4; c++) out[c] = out[c] * (1 - f) + coarse[c] * f;
}

/* ---- 2D ---- */

static sl_texture_image *random_image(int width, int height, bool mip) {
    sl_texture_image *m = NULL;
    assert_int_equal(sl_texture_image_create(width, height, mip, &m, NULL), SL_OK);
    uint64_t key = sl_random_key((uint64_t)(width * height), 3);
    for (size_t i = 0; i < 4 * (size_t)width * (size_t)height; i++) {
        m->texels[i] = sl_random_unit(key, i);
    }
    sl_texture_image_build(m, 1);
    return m;
}

/* Places in [low, high] each way, and p.z between -1 and `levels`. */
static void random_places(float low, float high, float levels) {
    uint64_t key = sl_random_key(99, (uint64_t)levels);
    for (uint64_t i = 0; i < COUNT; i++) {
        for (uint64_t c = 0; c < 4; c++) {
            coordinates[i][c] = c < 2 ? random_between(key, 4 * i + c, low, high)
                                      : random_between(key, 4 * i + c, -1, levels);
        }
        for (int c = 0; c < 4; c++) columns[c][i] = coordinates[i][c];
    }
}

static void compare_image(const char *what, int width, int height, bool mip) {
    sl_texture_image *m = random_image(width, height, mip);
    const void *level[SL_TEXTURE_LEVELS];
    for (int l = 0; l < m->levels; l++) level[l] = m->texels + 4 * (size_t)m->first[l];
    osmesa_texels texels = {TEXTURE_2D, TEXEL_RGBA32F, width, height, 1,
                            m->levels,  level,         false, true,   mip ? 2 : 0};
    random_places(-1.5f, 2.5f, (float)m->levels);
    look_up(&texels, "textureLod(image, p.xy, p.z)", "sampler2D");
    float *const plane[4] = {ours[0], ours[1], ours[2], ours[3]};
    sl_texture_sample_many(m, COUNT, columns[0], columns[1], mip ? columns[2] : NULL, plane);
    for (int i = 0; i < COUNT; i++) {
        double s = (double)coordinates[i][0], t = (double)coordinates[i][1];
        s = s < 0 ? 0 : s > 1 ? 1 : s, t = t < 0 ? 0 : t > 1 ? 1 : t;
        exact_trilinear(m, s, t, mip ? (double)coordinates[i][2] : 0.0, truth[i]);
    }
    compare(what, 4);
    sl_texture_image_destroy(m);
}

static void bilinear_and_trilinear_float_textures(void **state) {
    (void)state;
    open_or_skip();
    compare_image("bilinear, float, 64 x 64", 64, 64, false);
    compare_image("bilinear, float, 1000 x 333", 1000, 333, false);
    compare_image("bilinear, float, 4096 x 4", 4096, 4, false);
    compare_image("trilinear at given levels, float, 256 x 256", 256, 256, true);
    compare_image("trilinear at given levels, float, 100 x 37", 100, 37, true);
}

/* The levels themselves: means over the texels' areas. OSMesa's glGenerateMipmap() filters by bilinear
 * lookups. */
static void generated_levels(void **state) {
    (void)state;
    open_or_skip();
    const int sizes[][2] = {{64, 64}, {100, 37}, {255, 255}};
    for (int k = 0; k < 3; k++) {
        int w = sizes[k][0], h = sizes[k][1];
        sl_texture_image *m = random_image(w, h, true);
        const void *level[1] = {m->texels};
        osmesa_texels texels = {TEXTURE_2D, TEXEL_RGBA32F, w, h, 1, 1, level, true, true, 2};
        unsigned texture = osmesa_texture_filtered(&texels);
        error_sum our = {0, 0}, their = {0, 0};
        double count = 0;
        for (int l = 1; l < m->levels; l++) {
            osmesa_read_level(texture, l, theirs[0]);
            for (int i = 0; i < m->width[l] * m->height[l]; i++) {
                /* The area of a texel of level l in texels of level 0; in chains of odd sizes the same, since
                 * every level is exact. */
                double x0 = (double)(i % m->width[l]) * w / m->width[l], x1 = x0 + (double)w / m->width[l];
                double y0 = (double)(i / m->width[l]) * h / m->height[l], y1 = y0 + (double)h / m->height[l],
                       sum[4] = {0}, area = 0;
                if (l > 1 && (w % (1 << l) || h % (1 << l))) continue; /* later levels average averages */
                for (int y = (int)y0; y < h && y < y1; y++) {
                    for (int x = (int)x0; x < w && x < x1; x++) {
                        double part = (fmin(x + 1, x1) - fmax(x, x0)) * (fmin(y + 1, y1) - fmax(y, y0));
                        area += part;
                        for (int c = 0; c < 4; c++) sum[c] += part * (double)m->texels[4 * (y * w + x) + c];
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
    *s = ((double)d[0] * (double)f.x.x + (double)d[1] * (double)f.x.y + (double)d[2] * (double)f.x.z) / m *
             0.5 +
         0.5;
    *t = ((double)d[0] * (double)f.y.x + (double)d[1] * (double)f.y.y + (double)d[2] * (double)f.y.z) / m *
             0.5 +
         0.5;
}

static void exact_cube(const sl_cube_map *cube, const float d[3], int level, double out[4]) {
    int face, size = cube->level_size[level];
    double s, t;
    exact_face_place(d, &face, &s, &t);
    double x = s * size - 0.5, y = t * size - 0.5, fx = x - floor(x), fy = y - floor(y);
    for (int c = 0; c < 4; c++) {
        double v[4];
        for (int k = 0; k < 4; k++) {
            v[k] = (double)sl_cube_map_texel(cube, level, face, (int)floor(x) + (k & 1),
                                             (int)floor(y) + (k >> 1))[c];
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
                memcpy(copy + 4 * n * y, sl_cube_map_texel(cube, l, face, 0, y),
                       (size_t)n * 4 * sizeof(float));
            }
        }
    }
    osmesa_texels texels = {
        TEXTURE_CUBE, TEXEL_RGBA32F, size,       size, 1, cube->levels, (const void *const *)copies,
        false,        true,          mip ? 2 : 0};
    for (uint64_t i = 0; i < COUNT; i++) {
        sl_vec3 d = random_direction(key, 100000 + i);
        if (corner > 0.0) { /* within that distance of a corner of the cube */
            d = sl_v3((i & 1 ? 1.0f : -1.0f) + (float)corner * d.x,
                      (i & 2 ? 1.0f : -1.0f) + (float)corner * d.y,
                      (i & 4 ? 1.0f : -1.0f) + (float)corner * d.z);
        }
        const float place[4] = {d.x, d.y, d.z,
                                mip ? random_between(key, 9000000 + i, -1, (float)cube->levels) : 0.0f};
        memcpy(coordinates[i], place, sizeof place);
        for (int c = 0; c < 4; c++) columns[c][i] = place[c];
    }
    look_up(&texels, "textureLod(image, p.xyz, p.w)", "samplerCube");
    float *const plane[4] = {ours[0], ours[1], ours[2], ours[3]};
    sl_cube_map_sample_many(cube, COUNT, columns[0], columns[1],
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

static int run(const char *setting) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bilinear_and_trilinear_float_textures),
        cmocka_unit_test(generated_levels),
        cmocka_unit_test(seamless_cube_maps),
    };
    if (setting) setenv("GALLIVM_PERF", setting, 1);
    else unsetenv("GALLIVM_PERF");
    printf("OSMesa %s\n  %-58s  ours: largest, mean  OSMesa's: largest, mean\n",
           setting ? setting : "as it comes", "differences to double precision, of values in [0,1]");
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
