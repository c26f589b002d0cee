/* Additive blending in float: every fragment in the order of submission, the same sums as OSMesa's in every
 * bit, rounding by rounding, of splatted rectangles with a slope. */
#include "osmesa_soup.h"

typedef struct splat_field {
    int width;
    const float *value, *centre_x;
    float *plane;
} splat_field;

/* value * (x - centre_x) of the pixel's centre: one exact subtraction, one rounded product. */
static uint64_t add_slope(void *context, const sl_splat_tile *tile, size_t index, sl_splat_rect rect) {
    const splat_field *field = context;
    for (int y = rect.y0; y < rect.y1; y++) {
        float *row = field->plane + (size_t)y * (size_t)field->width;
        for (int x = rect.x0; x < rect.x1; x++)
            row[x] += field->value[index] * ((float)x + 0.5f - field->centre_x[index]);
    }
    return (uint64_t)(rect.x1 - rect.x0) * (uint64_t)(rect.y1 - rect.y0);
}

static int clamped(int x, int most) { return x < 0 ? 0 : x > most ? most : x; }

/* Rectangles of every size, some outside in part or altogether; OSMesa's are not cut to the screen. */
static void make_rectangles(size_t count, uint64_t key, int width, int height, sl_splat_rect *rects,
                            float *corners, float *value, float *centre_x) {
    for (size_t i = 0; i < count; i++) {
        uint64_t r = 8 * i;
        int w = 1 + (int)(sl_random_unit(key, r) * (i % 7 ? 60.0f : 500.0f)),
            h = 1 + (int)(sl_random_unit(key, r + 1) * (i % 5 ? 60.0f : 300.0f));
        int x = (int)((sl_random_unit(key, r + 2) * 1.2f - 0.1f) * (float)width) - w / 2;
        int y = (int)((sl_random_unit(key, r + 3) * 1.2f - 0.1f) * (float)height) - h / 2;
        rects[i] = (sl_splat_rect){clamped(x, width), clamped(y, height), clamped(x + w, width),
                                   clamped(y + h, height)};
        const int box[4] = {x, y, x + w, y + h};
        for (int k = 0; k < 4; k++)
            corners[4 * i + (size_t)k] = (float)((double)box[k] * 2.0 / (k % 2 ? height : width) - 1.0);
        value[i] = sl_random_unit(key, r + 4) + 0.25f;
        centre_x[i] = (float)x - 10.0f + 0.125f * (float)(sl_random_bits(key, r + 5) % 64);
    }
}

static void compare_splats(int width, int height, size_t count, unsigned threads) {
    size_t pixels = (size_t)width * (size_t)height;
    sl_splat_rect *rects = checked_calloc(count, sizeof *rects);
    float *corners = checked_calloc(4 * count, sizeof *corners),
          *value = checked_calloc(count, sizeof *value);
    float *centre_x = checked_calloc(count, sizeof *centre_x);
    float *ours = checked_calloc(pixels, sizeof *ours), *theirs = checked_calloc(pixels, sizeof *theirs);
    make_rectangles(count, sl_random_key(31, (uint64_t)width), width, height, rects, corners, value,
                    centre_x);
    sl_counters counters = {{0}};
    const sl_splat_program slope = {.shade = add_slope};
    splat_field field = {width, value, centre_x, ours};
    assert_int_equal(sl_raster_splats(width, height, count, rects, &slope, &field, threads, &counters, NULL),
                     SL_OK);

    const float unit[] = {0, 0, 1, 0, 1, 1, 0, 1};
    const uint32_t quad[] = {0, 1, 2, 0, 2, 3};
    const osmesa_stream streams[] = {
        {unit, 4, 2, false}, {corners, count, 4, true}, {value, count, 1, true}, {centre_x, count, 1, true}};
    osmesa_mesh mesh = osmesa_mesh_create(4, streams, 6, quad);
    unsigned program = osmesa_program(
        "#version 400 core\n"
        "layout(location = 0) in vec2 p; layout(location = 1) in vec4 box; layout(location = 2) in float v;"
        "layout(location = 3) in float c; flat out float value; flat out float centre;"
        "void main() { gl_Position = vec4(p.x == 0.0 ? box.x : box.z, p.y == 0.0 ? box.y : box.w, 0, 1); "
        "value = v; centre = c; }",
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
        print_message("splats %dx%d: %zu pixels differ, first (%zu, %zu): %.9g, theirs %.9g\n", width, height,
                      differing, where % (size_t)width, where / (size_t)width, (double)ours[where],
                      (double)theirs[where]);
    }
    assert_int_equal(differing, 0);
    osmesa_target_destroy(&target);
    osmesa_program_destroy(program);
    osmesa_mesh_destroy(&mesh);
    free(rects), free(corners), free(value), free(centre_x), free(ours), free(theirs);
}

static void sums_of_splats_agree_in_every_bit(void **state) {
    open_or_skip();
    compare_splats(1000, 1000, soup_share(4000) + 200, 1);
    compare_splats(640, 480, soup_share(4000) + 200, 2);
    compare_splats(33, 71, 300, 1);
}

static int close_group(void **state) {
    osmesa_close();
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(sums_of_splats_agree_in_every_bit)};
    return cmocka_run_group_tests(tests, NULL, close_group);
}
