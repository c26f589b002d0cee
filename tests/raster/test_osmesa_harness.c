/* The harness over OSMesa (osmesa.h), on pictures known by hand: were it wrong, the comparisons that build on
 * it would be worth nothing. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "osmesa.h"

enum { WIDTH = 7, HEIGHT = 5, PIXELS = WIDTH * HEIGHT };

static void open_or_skip(void) {
    const char *reason;
    if (osmesa_open(0, &reason)) return;
    print_message("skipped: %s\n", reason);
    skip();
}

static const char *const straight_through =
    "layout(location = 0) in vec4 p; void main() { gl_Position = p; }";

/* The lower left half: pixels whose centres have x + y (in pixels of WIDTH x HEIGHT mapped to [0,1]) below 1.
 */
static const float lower_left[] = {-1, -1, 0.5f, 1, 1, -1, 0.5f, 1, -1, 1, 0.5f, 1};

static bool in_lower_left(int x, int y) { return (x + 0.5) / WIDTH + (y + 0.5) / HEIGHT < 1.0; }

static void several_planes_and_depth_are_drawn_at_once(void **state) {
    (void)state;
    open_or_skip();
    const osmesa_format formats[] = {PLANE_R32UI, PLANE_R32F, PLANE_RGB32F, PLANE_RGBA32F};
    osmesa_target target = osmesa_target_create(WIDTH, HEIGHT, 4, formats, true);
    unsigned program = osmesa_program(
        straight_through,
        "layout(location = 0) out uint id; layout(location = 1) out float a; layout(location = 2) out vec3 b;"
        "layout(location = 3) out vec4 c;"
        "void main() { id = uint(gl_PrimitiveID) + 7u; a = 1.5; b = vec3(2, 3, 4); c = vec4(gl_FragCoord.xy, "
        "5, 6); }");
    const osmesa_stream positions = {lower_left, 3, 4, false};
    osmesa_mesh mesh = osmesa_mesh_create(1, &positions, 0, NULL);
    osmesa_clear(&target);
    osmesa_state(true, false);
    osmesa_draw_all(program, &mesh);
    uint32_t id[PIXELS];
    float a[PIXELS], b[PIXELS][3], c[PIXELS][4], depth[PIXELS];
    osmesa_read(&target, 0, id);
    osmesa_read(&target, 1, a);
    osmesa_read(&target, 2, b);
    osmesa_read(&target, 3, c);
    osmesa_read_depth(&target, depth);
    for (int y = 0, i = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++, i++) {
            bool in = in_lower_left(x, y);
            assert_int_equal(id[i], in ? 7u : UINT32_MAX);
            assert_true(a[i] == (in ? 1.5f : 0.0f) && depth[i] == (in ? 0.75f : 1.0f));
            assert_true(b[i][0] == (in ? 2.0f : 0.0f) && b[i][2] == (in ? 4.0f : 0.0f));
            assert_true(c[i][0] == (in ? (float)x + 0.5f : 0.0f) && c[i][1] == (in ? (float)y + 0.5f : 0.0f));
            assert_true(c[i][3] == (in ? 6.0f : 0.0f));
        }
    }
    osmesa_mesh_destroy(&mesh);
    osmesa_program_destroy(program);
    osmesa_target_destroy(&target);
}

static void instances_indices_and_blending_add_up(void **state) {
    (void)state;
    open_or_skip();
    const osmesa_format format = PLANE_R32F;
    osmesa_target target = osmesa_target_create(WIDTH, HEIGHT, 1, &format, false);
    unsigned program = osmesa_program(
        "layout(location = 0) in vec2 p; layout(location = 1) in float v; flat out float value;"
        "void main() { gl_Position = vec4(p, 0, 1); value = v; }",
        "flat in float value; out float sum; void main() { sum = value; }");
    const float corners[] = {-1, -1, 1, -1, 1, 1, -1, 1}, values[] = {1, 10, 100};
    const osmesa_stream streams[] = {{corners, 4, 2, false}, {values, 3, 1, true}};
    const uint32_t quad[] = {0, 1, 2, 0, 2, 3};
    osmesa_mesh mesh = osmesa_mesh_create(2, streams, 6, quad);
    osmesa_clear(&target);
    osmesa_state(false, true);
    osmesa_viewport(1, 2, 3, 2);
    osmesa_draw(program, &mesh, 0, 6, 3);
    float sum[PIXELS];
    osmesa_read(&target, 0, sum);
    for (int i = 0; i < PIXELS; i++) {
        int x = i % WIDTH, y = i / WIDTH;
        assert_true(sum[i] == (x >= 1 && x < 4 && y >= 2 && y < 4 ? 111.0f : 0.0f));
    }
    osmesa_mesh_destroy(&mesh);
    osmesa_program_destroy(program);
    osmesa_target_destroy(&target);
}

static void full_screen_passes_read_textures_and_planes(void **state) {
    (void)state;
    open_or_skip();
    const osmesa_format format = PLANE_RGBA32F;
    osmesa_target first = osmesa_target_create(WIDTH, HEIGHT, 1, &format, false),
                  second = osmesa_target_create(WIDTH, HEIGHT, 1, &format, false);
    unsigned program = osmesa_program(
        "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }",
        "uniform sampler2D image; uniform float scale; uniform mat4 twist; out vec4 colour;"
        "void main() { colour = twist * (scale * texelFetch(image, ivec2(gl_FragCoord.xy), 0)); }");
    float texels[PIXELS][4], back[PIXELS][4];
    for (int i = 0; i < PIXELS; i++) for (int k = 0; k < 4; k++) texels[i][k] = (float)(4 * i + k);
    unsigned texture = osmesa_texture(WIDTH, HEIGHT, &texels[0][0]);
    const float two = 2, three = 3, same[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    const float rows[4][4] = {{0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}, {1, 0, 0, 0}};
    osmesa_mesh mesh = osmesa_mesh_create(0, NULL, 3, NULL);
    osmesa_state(false, false);
    osmesa_clear(&first);
    osmesa_clear(&second);
    osmesa_draw_to(&first);
    osmesa_input(program, "image", 1, texture);
    osmesa_uniform(program, "scale", 1, &two);
    osmesa_uniform_matrix(program, "twist", rows);
    osmesa_draw_all(program, &mesh);
    osmesa_draw_to(&second);
    osmesa_input(program, "image", 0, first.plane[0]);
    osmesa_uniform(program, "scale", 1, &three);
    osmesa_uniform_matrix(program, "twist", same);
    osmesa_draw_all(program, &mesh);
    osmesa_finish();
    osmesa_read(&second, 0, back);
    for (int i = 0; i < PIXELS; i++)
        for (int k = 0; k < 4; k++) assert_true(back[i][k] == 6.0f * texels[i][(k + 1) % 4]);
    osmesa_texture_destroy(texture);
    osmesa_mesh_destroy(&mesh);
    osmesa_program_destroy(program);
    osmesa_target_destroy(&first);
    osmesa_target_destroy(&second);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(several_planes_and_depth_are_drawn_at_once),
        cmocka_unit_test(instances_indices_and_blending_add_up),
        cmocka_unit_test(full_screen_passes_read_textures_and_planes),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    osmesa_close();
    return failed;
}
