/* Additive blending in float: every fragment in the order of submission, the same sums as OSMesa's in every bit, rounding by
 * rounding. Triangles, each with random values of its own, and splatted rectangles with a slope. (What is interpolated within a
 * triangle is more accurate in ours, and is compared with double precision in test_osmesa_attributes.c.) */
#include "osmesa_soup.h"

enum { CHANNELS = 3 };

typedef struct tally {
    uint64_t triangles, fragments, differing;
} tally;
static tally tallies[SOUP_KINDS];

/* Of a kind, over all sizes. */
static const size_t how_many[SOUP_KINDS] = {
    [SOUP_BIG] = 1000,       [SOUP_MEDIUM] = 50000,   [SOUP_SMALL] = 400000,         [SOUP_SUBPIXEL] = 200000,
    [SOUP_SLIVER] = 20000,   [SOUP_MESH] = 150000,    [SOUP_PIXEL_CENTRES] = 50000,  [SOUP_TIES] = 100000,
    [SOUP_PARTLY_OFF] = 400, [SOUP_FAR_OFF] = 600,    [SOUP_PERSPECTIVE] = 30000,    [SOUP_NEAR_CLIPPED] = 600,
};

/* ---- triangles ------------------------------------------------------------------------------------------------------- */

/* Three values of each triangle, in [1/8, 1]: no sum of theirs is a denormal number, which OSMesa flushes to zero. */
static float *random_values(size_t triangles, uint64_t seed) {
    float *values = checked_calloc(3 * CHANNELS * triangles, sizeof *values);
    uint64_t key = sl_random_key(2000, seed);
    for (size_t i = 0; i < 3 * CHANNELS * triangles; i++) {
        size_t t = i / (3 * CHANNELS), channel = i % CHANNELS;
        values[i] = 0.125f + 0.875f * sl_random_unit(key, CHANNELS * t + channel);
    }
    return values;
}

static size_t count_differing(const float *ours, const float *theirs, size_t pixels, uint64_t *fragments, const judged_size *size,
                              const char *name) {
    size_t differing = 0;
    for (size_t i = 0; i < pixels; i++) {
        *fragments += theirs[CHANNELS * i] != 0.0f;
        for (size_t k = 0; k < CHANNELS; k++) {
            float a = ours[k * pixels + i], b = theirs[CHANNELS * i + k];
            if (memcmp(&a, &b, sizeof a) == 0) continue;
            if (!differing++) {
                print_message("%s, %s: channel %zu differs first at pixel (%zu, %zu): %.9g, theirs %.9g\n", size->name, name, k,
                              i % (size_t)size->target_width, i / (size_t)size->target_width, (double)a, (double)b);
            }
        }
    }
    return differing;
}

static void compare_kind(soup_kind kind, const judged_size *size, const osmesa_target *target, unsigned program) {
    size_t wanted = soup_share((size_t)((double)how_many[kind] * size->share)) + 50;
    size_t pixels = (size_t)size->target_width * (size_t)size->target_height;
    uint64_t seed = 77 + (uint64_t)(size - judged_sizes);
    soup s = judged_soup(kind, seed, wanted, size);
    float *attributes = random_values(s.triangles, seed);
    float *ours = checked_calloc(CHANNELS * pixels, sizeof *ours), *theirs = checked_calloc(CHANNELS * pixels, sizeof *theirs);
    sl_raster *raster = soup_raster(&s);
    sl_counters counters = {{0}};
    sl_target size_of = {.width = size->target_width, .height = size->target_height};
    assert_int_equal(sl_raster_add(raster, &s.view, 1, attributes, CHANNELS, &size_of, ours, &counters, NULL), SL_OK);
    osmesa_mesh mesh = mesh_of(s.position, 3 * s.triangles, attributes, CHANNELS, 0, NULL);
    judge_draw(program, target, &mesh, &s.view, false, true);
    osmesa_read(target, 0, theirs);
    tallies[kind].triangles += s.triangles;
    tallies[kind].differing += count_differing(ours, theirs, pixels, &tallies[kind].fragments, size, soup_names[kind]);
    osmesa_mesh_destroy(&mesh);
    sl_raster_destroy(raster);
    free(ours);
    free(theirs);
    free(attributes);
    soup_free(&s);
}

static void sums_over_all_layers_agree_in_every_bit(void **state) {
    (void)state;
    open_or_skip();
    unsigned program = program_in_view("layout(location = 3) in vec3 a; flat out vec3 value;", "value = a;",
                                       "flat in vec3 value; out vec3 sum; void main() { sum = value; }");
    for (int n = 0; n < JUDGED_SIZES; n++) {
        const judged_size *size = &judged_sizes[n];
        const osmesa_format format = PLANE_RGB32F;
        osmesa_target target = osmesa_target_create(size->target_width, size->target_height, 1, &format, false);
        for (int kind = 0; kind < SOUP_KINDS; kind++) compare_kind((soup_kind)kind, size, &target, program);
        osmesa_target_destroy(&target);
    }
    osmesa_program_destroy(program);
    for (int kind = 0; kind < SOUP_KINDS; kind++) assert_int_equal(tallies[kind].differing, 0);
}

/* ---- splats ---------------------------------------------------------------------------------------------------------- */

typedef struct splat_field {
    int width;
    const float *value, *centre_x;
    float *plane;
} splat_field;

/* value * (x - centre_x) of the pixel's centre: one exact subtraction, one rounded product. */
static uint64_t add_slope(void *context, const sl_splat_tile *tile, size_t index, sl_splat_rect rect) {
    const splat_field *field = context;
    (void)tile;
    for (int y = rect.y0; y < rect.y1; y++) {
        float *row = field->plane + (size_t)y * (size_t)field->width;
        for (int x = rect.x0; x < rect.x1; x++) row[x] += field->value[index] * ((float)x + 0.5f - field->centre_x[index]);
    }
    return (uint64_t)(rect.x1 - rect.x0) * (uint64_t)(rect.y1 - rect.y0);
}

static int clamped(int x, int most) { return x < 0 ? 0 : x > most ? most : x; }

/* Rectangles of every size, some outside in part or altogether; OSMesa's are not cut to the screen. */
static void make_rectangles(size_t count, uint64_t key, int width, int height, sl_splat_rect *rects, float *corners, float *value,
                            float *centre_x) {
    for (size_t i = 0; i < count; i++) {
        uint64_t r = 8 * i;
        int w = 1 + (int)(sl_random_unit(key, r) * (i % 7 ? 60.0f : 500.0f)), h = 1 + (int)(sl_random_unit(key, r + 1) * (i % 5 ? 60.0f : 300.0f));
        int x = (int)((sl_random_unit(key, r + 2) * 1.2f - 0.1f) * (float)width) - w / 2;
        int y = (int)((sl_random_unit(key, r + 3) * 1.2f - 0.1f) * (float)height) - h / 2;
        rects[i] = (sl_splat_rect){clamped(x, width), clamped(y, height), clamped(x + w, width), clamped(y + h, height)};
        const int box[4] = {x, y, x + w, y + h};
        for (int k = 0; k < 4; k++) corners[4 * i + (size_t)k] = (float)((double)box[k] * 2.0 / (k % 2 ? height : width) - 1.0);
        value[i] = sl_random_unit(key, r + 4) + 0.25f;
        centre_x[i] = (float)x - 10.0f + 0.125f * (float)(sl_random_bits(key, r + 5) % 64);
    }
}

static void compare_splats(int width, int height, size_t count, unsigned threads) {
    size_t pixels = (size_t)width * (size_t)height;
    sl_splat_rect *rects = checked_calloc(count, sizeof *rects);
    float *corners = checked_calloc(4 * count, sizeof *corners), *value = checked_calloc(count, sizeof *value);
    float *centre_x = checked_calloc(count, sizeof *centre_x);
    float *ours = checked_calloc(pixels, sizeof *ours), *theirs = checked_calloc(pixels, sizeof *theirs);
    make_rectangles(count, sl_random_key(31, (uint64_t)width), width, height, rects, corners, value, centre_x);
    sl_counters counters = {{0}};
    const sl_splat_program slope = {.shade = add_slope};
    splat_field field = {width, value, centre_x, ours};
    assert_int_equal(sl_raster_splats(width, height, count, rects, &slope, &field, threads, &counters, NULL), SL_OK);

    const float unit[] = {0, 0, 1, 0, 1, 1, 0, 1};
    const uint32_t quad[] = {0, 1, 2, 0, 2, 3};
    const osmesa_stream streams[] = {{unit, 4, 2, false}, {corners, count, 4, true}, {value, count, 1, true}, {centre_x, count, 1, true}};
    osmesa_mesh mesh = osmesa_mesh_create(4, streams, 6, quad);
    unsigned program = osmesa_program(
        "#version 400 core\n"
        "layout(location = 0) in vec2 p; layout(location = 1) in vec4 box; layout(location = 2) in float v;"
        "layout(location = 3) in float c; flat out float value; flat out float centre;"
        "void main() { gl_Position = vec4(p.x == 0.0 ? box.x : box.z, p.y == 0.0 ? box.y : box.w, 0, 1); value = v; centre = c; }",
        "#version 400 core\n"
        "flat in float value; flat in float centre; out float sum;"
        "void main() { precise float slope = value * (gl_FragCoord.x - centre); sum = slope; }");
    const osmesa_format format = PLANE_R32F;
    osmesa_target target = osmesa_target_create(width, height, 1, &format, false);
    osmesa_clear(&target);
    osmesa_state(false, true);
    osmesa_draw(program, &mesh, 0, 6, count);
    osmesa_read(&target, 0, theirs);
    size_t covered = 0, where = 0;
    for (size_t i = 0; i < pixels; i++) covered += theirs[i] != 0.0f;
    assert_true(covered > pixels / 2);
    size_t differing = differing_words(ours, theirs, pixels, &where);
    if (differing) {
        print_message("splats %dx%d: %zu pixels differ, first (%zu, %zu): %.9g, theirs %.9g\n", width, height, differing,
                      where % (size_t)width, where / (size_t)width, (double)ours[where], (double)theirs[where]);
    }
    assert_int_equal(differing, 0);
    osmesa_target_destroy(&target);
    osmesa_program_destroy(program);
    osmesa_mesh_destroy(&mesh);
    free(rects), free(corners), free(value), free(centre_x), free(ours), free(theirs);
}

static void sums_of_splats_agree_in_every_bit(void **state) {
    (void)state;
    open_or_skip();
    compare_splats(1000, 1000, soup_share(4000) + 200, 1);
    compare_splats(640, 480, soup_share(4000) + 200, 2);
    compare_splats(33, 71, 300, 1);
}

static int print_table(void **state) {
    (void)state;
    char a[32], b[32];
    print_message("%-16s %12s %16s %16s\n", "class", "triangles", "pixels drawn", "sums differ");
    for (int kind = 0; kind < SOUP_KINDS; kind++) {
        print_message("%-16s %12s %16s %16llu\n", soup_names[kind], with_commas(tallies[kind].triangles, a),
                      with_commas(tallies[kind].fragments, b), (unsigned long long)tallies[kind].differing);
    }
    osmesa_close();
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_over_all_layers_agree_in_every_bit),
        cmocka_unit_test(sums_of_splats_agree_in_every_bit),
    };
    return cmocka_run_group_tests(tests, NULL, print_table);
}
