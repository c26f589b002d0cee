/* Which pixels a triangle covers, how deep it lies there, and which triangle wins: the same as OSMesa's, in
 * every bit, for millions of random triangles of every kind. Coverage is compared triangle by triangle,
 * second-level ones included: each adds (h, 1) to the pixels it covers, h being a small integer of its own,
 * so that the sums are exact. Ours are drawn one by one by the plain rasterizer, whose pictures are those of
 * the fast one in every bit (test_raster_plain.c). */
#include "osmesa_soup.h"
#include "tests/raster/plain.h"

typedef struct tally {
    uint64_t triangles, fragments, coverage, id, depth;
} tally;
static tally tallies[SOUP_KINDS];

/* Of a kind, over all sizes. */
static const size_t how_many[SOUP_KINDS] = {
    [SOUP_BIG] = 800,        [SOUP_MEDIUM] = 200000, [SOUP_SMALL] = 3200000,        [SOUP_SUBPIXEL] = 1000000,
    [SOUP_SLIVER] = 40000,   [SOUP_MESH] = 400000,   [SOUP_PIXEL_CENTRES] = 200000, [SOUP_TIES] = 300000,
    [SOUP_PARTLY_OFF] = 400, [SOUP_FAR_OFF] = 500,   [SOUP_PERSPECTIVE] = 40000,    [SOUP_NEAR_CLIPPED] = 600,
};
enum { BATCH = 65536 }; /* times 255 is below 2^24: sums stay exact even where all cover one pixel */

typedef struct judge {
    const judged_size *size;
    osmesa_target sums, ids;
    unsigned count_program, id_program;
    float *ours_sums, *theirs_sums; /* theirs interleaved */
    uint32_t *ours_id, *theirs_id;
    float *ours_depth, *theirs_depth;
    size_t pixels;
} judge;

static judge judge_open(const judged_size *size) {
    judge j = {.size = size, .pixels = (size_t)size->target_width * (size_t)size->target_height};
    const osmesa_format sums = PLANE_RG32F, ids = PLANE_R32UI;
    j.sums = osmesa_target_create(size->target_width, size->target_height, 1, &sums, false);
    j.ids = osmesa_target_create(size->target_width, size->target_height, 1, &ids, true);
    j.count_program =
        program_in_view("", "", "out vec2 sum; void main() { sum = vec2(" TRIANGLE_NUMBER_GLSL ", 1); }");
    j.id_program = program_in_view("", "", "out uint id; void main() { id = uint(gl_PrimitiveID); }");
    j.ours_sums = checked_calloc(2 * j.pixels, 4);
    j.theirs_sums = checked_calloc(2 * j.pixels, 4);
    j.ours_id = checked_calloc(j.pixels, 4);
    j.theirs_id = checked_calloc(j.pixels, 4);
    j.ours_depth = checked_calloc(j.pixels, 4);
    j.theirs_depth = checked_calloc(j.pixels, 4);
    return j;
}

static void judge_close(judge *j) {
    void *memory[] = {j->ours_sums, j->theirs_sums, j->ours_id, j->theirs_id, j->ours_depth, j->theirs_depth};
    for (size_t i = 0; i < sizeof memory / sizeof memory[0]; i++) free(memory[i]);
    osmesa_target_destroy(&j->sums);
    osmesa_target_destroy(&j->ids);
    osmesa_program_destroy(j->count_program);
    osmesa_program_destroy(j->id_program);
}

static void report(const judge *j, const char *what, const soup *s, soup_kind kind, size_t pixel) {
    print_message("%s, %s: %s differs first at pixel (%zu, %zu)\n", j->size->name, soup_names[kind], what,
                  pixel % (size_t)j->size->target_width, pixel / (size_t)j->size->target_width);
    uint32_t ids[2] = {j->ours_id[pixel], j->theirs_id[pixel]};
    for (int i = 0; strcmp(what, "coverage") != 0 && i < 2; i++) {
        if (ids[i] == SL_NO_INDEX) continue;
        print_message("  %s triangle %u:", i ? "their" : "our", ids[i]);
        for (size_t k = 0; k < 9; k++) print_message(" %.9g", (double)s->position[k % 3][3 * ids[i] + k / 3]);
        print_message(" depth %.9g\n", (double)(i ? j->theirs_depth : j->ours_depth)[pixel]);
    }
}

static void compare_coverage(judge *j, const soup *s, soup_kind kind, const osmesa_mesh *mesh) {
    float *numbers = checked_calloc(s->triangles, sizeof *numbers);
    for (uint32_t t = 0; t < s->triangles; t++) numbers[t] = triangle_number(t);
    sl_raster_mesh drawn = soup_mesh(s);
    memset(j->ours_sums, 0, 2 * j->pixels * sizeof *j->ours_sums);
    sl_plain_layers(&drawn, &s->view, j->size->target_width, j->size->target_height, numbers, j->ours_sums);
    free(numbers);
    judge_draw(j->count_program, &j->sums, mesh, &s->view, false, true);
    osmesa_read(&j->sums, 0, j->theirs_sums);
    size_t differing = 0;
    for (size_t i = 0; i < j->pixels; i++) {
        tallies[kind].fragments += (uint64_t)j->theirs_sums[2 * i + 1];
        if (j->ours_sums[i] == j->theirs_sums[2 * i] &&
            j->ours_sums[j->pixels + i] == j->theirs_sums[2 * i + 1])
            continue;
        if (!differing++) report(j, "coverage", s, kind, i);
    }
    tallies[kind].coverage += differing;
}

static void compare_visibility(judge *j, const soup *s, soup_kind kind, const sl_raster *raster,
                               const osmesa_mesh *mesh) {
    sl_view view = s->view;
    view.corner_planes = true;
    sl_counters counters = {{0}};
    sl_target target = {.width = j->size->target_width,
                        .height = j->size->target_height,
                        .id = j->ours_id,
                        .depth = j->ours_depth};
    for (size_t i = 0; i < j->pixels; i++) { /* what lies outside the viewport is left as it was */
        j->ours_id[i] = SL_NO_INDEX;
        j->ours_depth[i] = 1.0f;
    }
    assert_int_equal(sl_raster_id(raster, &view, 1, &target, &counters, NULL), SL_OK);
    judge_draw(j->id_program, &j->ids, mesh, &s->view, true, false);
    osmesa_read(&j->ids, 0, j->theirs_id);
    osmesa_read_depth(&j->ids, j->theirs_depth);
    size_t where = 0, ids = differing_words(j->ours_id, j->theirs_id, j->pixels, &where);
    if (ids) report(j, "id", s, kind, where);
    size_t depths = differing_words(j->ours_depth, j->theirs_depth, j->pixels, &where);
    if (depths) report(j, "depth", s, kind, where);
    tallies[kind].id += ids;
    tallies[kind].depth += depths;
}

static void compare_batch(judge *j, soup_kind kind, uint64_t seed, size_t triangles) {
    soup s = judged_soup(kind, seed, triangles, j->size);
    sl_raster *raster = soup_raster(&s);
    osmesa_mesh mesh = mesh_of(s.position, 3 * s.triangles, NULL, 0, 0, NULL);
    tallies[kind].triangles += s.triangles;
    compare_coverage(j, &s, kind, &mesh);
    compare_visibility(j, &s, kind, raster, &mesh);
    osmesa_mesh_destroy(&mesh);
    sl_raster_destroy(raster);
    soup_free(&s);
}

static void compare_kind(judge *j, soup_kind kind) {
    size_t wanted = soup_share((size_t)((double)how_many[kind] * j->size->share)) + 50, drawn = 0;
    size_t most = kind == SOUP_MESH ? 2 * BATCH : BATCH; /* a mesh covers a pixel once */
    uint64_t before = tallies[kind].triangles;
    for (uint64_t seed = 0; drawn < wanted && seed < 1000; seed++) {
        size_t count = kind == SOUP_MESH ? most : wanted - drawn < most ? wanted - drawn : most;
        compare_batch(j, kind, sl_hash64(seed * 100 + (uint64_t)(j->size - judged_sizes)), count);
        drawn = (size_t)(tallies[kind].triangles - before);
    }
}

static void compare_size(int which) {
    open_or_skip();
    judge j = judge_open(&judged_sizes[which]);
    for (int kind = 0; kind < SOUP_KINDS; kind++) {
        compare_kind(&j, (soup_kind)kind);
        assert_int_equal(tallies[kind].coverage, 0);
        assert_int_equal(tallies[kind].id, 0);
        assert_int_equal(tallies[kind].depth, 0);
    }
    judge_close(&j);
}

static void square_power_of_two_agrees_in_every_bit(void **state) { (void)state, compare_size(0); }
static void rectangle_agrees_in_every_bit(void **state) { (void)state, compare_size(1); }
static void viewport_within_a_larger_target_agrees_in_every_bit(void **state) {
    (void)state, compare_size(2);
}
static void odd_size_agrees_in_every_bit(void **state) { (void)state, compare_size(3); }
static void narrow_and_tall_agrees_in_every_bit(void **state) { (void)state, compare_size(4); }
static void single_pixel_agrees_in_every_bit(void **state) { (void)state, compare_size(5); }

static int print_table(void **state) {
    char a[32], b[32];
    tally sum = {0};
    print_message("%-16s %12s %16s %18s %12s %12s\n", "class", "triangles", "fragments", "coverage differs",
                  "id differs", "depth differs");
    for (int kind = 0; kind <= SOUP_KINDS; kind++) {
        const tally *t = kind < SOUP_KINDS ? &tallies[kind] : &sum;
        print_message("%-16s %12s %16s %18llu %12llu %12llu\n", kind < SOUP_KINDS ? soup_names[kind] : "all",
                      with_commas(t->triangles, a), with_commas(t->fragments, b),
                      (unsigned long long)t->coverage, (unsigned long long)t->id,
                      (unsigned long long)t->depth);
        if (kind == SOUP_KINDS) break;
        sum.triangles += t->triangles;
        sum.fragments += t->fragments;
        sum.coverage += t->coverage;
        sum.id += t->id;
        sum.depth += t->depth;
    }
    print_message("differing pixels: %llu\n", (unsigned long long)(sum.coverage + sum.id + sum.depth));
    osmesa_close();
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(square_power_of_two_agrees_in_every_bit),
        cmocka_unit_test(rectangle_agrees_in_every_bit),
        cmocka_unit_test(viewport_within_a_larger_target_agrees_in_every_bit),
        cmocka_unit_test(odd_size_agrees_in_every_bit),
        cmocka_unit_test(narrow_and_tall_agrees_in_every_bit),
        cmocka_unit_test(single_pixel_agrees_in_every_bit),
    };
    return cmocka_run_group_tests(tests, NULL, print_table);
}
