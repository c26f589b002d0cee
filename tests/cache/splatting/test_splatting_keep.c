/* Records kept on disk: what a second run makes of them, and what becomes of files that do not fit or are
 * damaged. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "unit_test.h"
#include "base/random.h"
#include "image_support.h"
#include "rendering.h"

typedef struct {
    char folder[64], path[96];
} place;

static int make_place(void **state) {
    place *p = calloc(1, sizeof *p);
    assert_non_null(p);
    strcpy(p->folder, "/tmp/softlux-test-XXXXXX");
    assert_non_null(mkdtemp(p->folder));
    snprintf(p->path, sizeof p->path, "%s/cache", p->folder);
    *state = p;
    return 0;
}

static int clear_place(void **state) {
    place *p = *state;
    unlink(p->path);
    int status = rmdir(p->folder); /* nothing else may have been left there */
    free(p);
    return status;
}

static void save(const sl_method *method, const char *path) {
    sl_error error;
    if (sl_method_save(method, path, &error) != SL_OK) fail_msg("%s", error.message);
}

static void load(sl_method *method, const char *path) {
    sl_error error;
    if (sl_method_load(method, path, &error) != SL_OK) fail_msg("%s", error.message);
}

static void write_file(const char *path, const uint8_t *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* ---- a second run ---- */

static void expect_the_same_again(const place *p, const char *scene_path, sl_settings settings) {
    sl_scene *scene = load_scene(scene_path);
    sl_method *first = created_method(scene, &settings);
    sl_image *before = finished_picture(first);
    save(first, p->path);
    assert_true(count_of(first, SL_COUNT_RECORDS) > 0);
    settings.threads = 1; /* does not matter */
    sl_method *second = created_method(scene, &settings);
    load(second, p->path);
    sl_image *after = finished_picture(second);
    assert_int_equal(count_of(second, SL_COUNT_RECORDS), 0);
    assert_int_equal(count_of(second, SL_COUNT_GATHERS), 0);
    assert_int_equal(count_of(second, SL_COUNT_SECOND_LEVEL_RECORDS), 0);
    assert_true(same_picture(before, after));
    /* Saved again it is the same file. */
    size_t size, again_size;
    uint8_t *bytes = read_file(p->path, &size);
    save(second, p->path);
    uint8_t *again = read_file(p->path, &again_size);
    assert_int_equal(size, again_size);
    assert_memory_equal(bytes, again, size);
    free(bytes);
    free(again);
    destroy_pictures(before, after);
    sl_method_destroy(first);
    destroy_method(second, scene);
}

static void a_second_run_makes_no_records_and_the_same_picture(void **state) {
    expect_the_same_again(*state, "scenes/cornell.json", small_settings("splatting", 48, 40));
}

static void so_it_does_with_radiance_records(void **state) {
    sl_settings settings = small_settings("splatting", 40, 40);
    settings.harmonics_order = 4;
    expect_the_same_again(*state, "scenes/cornell-glossy.json", settings);
}

static void so_it_does_with_more_bounces(void **state) {
    sl_settings settings = small_settings("splatting", 32, 32);
    settings.bounces = 3;
    expect_the_same_again(*state, "scenes/cornell.json", settings);
}

/* ---- under a bound on memory ---- */

static uint64_t need_of(const sl_scene *scene, const sl_settings *settings) {
    sl_error error;
    uint64_t need = 0;
    if (sl_method_memory_need(scene, settings, &need, &error) != SL_OK) fail_msg("%s", error.message);
    return need;
}

/* Where there is no room for more records there is none for those of the file either. Returns whether records
 * did end. */
static bool expect_the_same_end(const place *p, sl_method *first, const sl_scene *scene,
                                const sl_settings *settings) {
    sl_image *before = finished_picture(first);
    const char *told = sl_method_reduction(first);
    const bool ended = told && strstr(told, "records end at");
    save(first, p->path);
    sl_method *second = created_method(scene, settings);
    load(second, p->path);
    sl_image *after = finished_picture(second);
    assert_int_equal(count_of(second, SL_COUNT_RECORDS), 0);
    assert_true(same_picture(before, after));
    destroy_pictures(before, after);
    sl_method_destroy(second);
    return ended;
}

static void records_from_a_file_end_where_those_that_were_made_did(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    sl_settings settings = small_settings("splatting", 40, 40);
    settings.threads = 1;
    settings.harmonics_order = 4;
    for (uint32_t bounces = 1; bounces <= 3; bounces += 2) {
        int ended = 0;
        settings.bounces = bounces;
        settings.memory_bytes = 0;
        const uint64_t need = need_of(scene, &settings);
        /* the bare need, and within or beyond what a bounce's records take */
        for (uint64_t more = 0; more < 5; more++) {
            settings.memory_bytes = need + more * 200000;
            sl_method *first = created_method(scene, &settings);
            ended += expect_the_same_end(*state, first, scene, &settings);
            sl_method_destroy(first);
        }
        print_message("%u bounces: records end in %d of 5\n", (unsigned)bounces, ended);
        assert_true(ended > 1);
    }
    sl_scene_destroy(scene);
}

/* ---- other views, and what is not finished ---- */

/* From elsewhere the records are of use, and what is new is added to them. */
static void another_view_starts_with_what_it_sees_again(void **state) {
    const place *p = *state;
    const float eye[3] = {320, 300, -300}, target[3] = {60, 100, 300}, up[3] = {0, 1, 0};
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = small_settings("splatting", 48, 48);
    sl_method *first = created_method(scene, &settings);
    sl_image_destroy(finished_picture(first));
    save(first, p->path);
    sl_error error;
    assert_int_equal(sl_scene_set_camera(scene, eye, target, up, 0.8f, &error), SL_OK);
    sl_method *alone = created_method(scene, &settings), *helped = created_method(scene, &settings);
    load(helped, p->path);
    sl_image_destroy(finished_picture(alone));
    sl_image_destroy(finished_picture(helped));
    assert_true(count_of(helped, SL_COUNT_RECORDS) > 0);
    assert_true(2 * count_of(helped, SL_COUNT_RECORDS) < count_of(alone, SL_COUNT_RECORDS));
    sl_method_destroy(first);
    sl_method_destroy(alone);
    destroy_method(helped, scene);
}

/* ---- what does not fit ---- */

static void expect_refusal(const char *path, const char *scene_path, const sl_settings *settings,
                           const char *why) {
    sl_scene *scene = load_scene(scene_path);
    sl_method *method = created_method(scene, settings);
    sl_error error = {SL_OK, ""};
    sl_status status = sl_method_load(method, path, &error);
    if (status == SL_OK || !strstr(error.message, why))
        fail_msg("expected '%s', got '%s'", why, error.message);
    assert_int_equal(status, SL_ERROR_INPUT);
    assert_null(strchr(error.message, '\n'));
    destroy_method(method, scene);
}

static void caches_of_other_scenes_and_settings_are_refused(void **state) {
    const place *p = *state;
    sl_scene *scene = load_scene("scenes/cornell.json");
    const sl_settings settings = small_settings("splatting", 24, 24);
    sl_method *method = created_method(scene, &settings);
    sl_image_destroy(finished_picture(method));
    save(method, p->path);
    destroy_method(method, scene);
    expect_refusal(p->path, "scenes/cornell-glossy.json", &settings, "made for another scene");
    sl_settings other = settings;
    other.accuracy = 0.25;
    expect_refusal(p->path, "scenes/cornell.json", &other, "another accuracy");
    other = settings;
    other.gather_size = 24;
    expect_refusal(p->path, "scenes/cornell.json", &other, "another gather size");
    other = settings;
    other.seed = 7;
    expect_refusal(p->path, "scenes/cornell.json", &other, "another seed");
    other = settings;
    other.bounces = 2;
    expect_refusal(p->path, "scenes/cornell.json", &other, "another number of bounces");
    other = settings;
    other.gather = SL_GATHER_PLANE;
    expect_refusal(p->path, "scenes/cornell.json", &other, "another gather");
    other = settings;
    other.metric = SL_METRIC_HESSIAN;
    expect_refusal(p->path, "scenes/cornell.json", &other, "another metric");
    expect_refusal("scenes/cornell.json", "scenes/cornell.json", &settings, "is not a cache");
    expect_refusal("/tmp", "scenes/cornell.json", &settings, "/tmp");
    expect_refusal("/dev/null", "scenes/cornell.json", &settings, "expected a file");
    expect_refusal("/nonexistent/cache", "scenes/cornell.json", &settings, "/nonexistent/cache: cannot be opened");
}

/* ---- damage ---- */

typedef struct {
    sl_scene *scene;
    sl_settings settings;
    sl_method *method;
    sl_image *picture;  /* what it shows, as long as no load succeeds */
    uint8_t *bytes;
    size_t size;
} sample;

/* A small cache with records of both classes and second-level ones. */
static sample sample_new(const place *p) {
    sample s = {.scene = load_scene("scenes/cornell-glossy.json"),
                .settings = small_settings("splatting", 10, 10)};
    s.settings.bounces = 2;
    s.settings.gather_size = 4;
    s.settings.harmonics_order = 1;
    s.settings.accuracy = s.settings.glossy_accuracy = 2.0;
    s.method = created_method(s.scene, &s.settings);
    s.picture = finished_picture(s.method);
    save(s.method, p->path);
    s.bytes = read_file(p->path, &s.size);
    return s;
}

static void sample_free(sample *s) {
    free(s->bytes);
    sl_image_destroy(s->picture);
    destroy_method(s->method, s->scene);
}

static void expect_damage(const place *p, sample *s, const uint8_t *bytes, size_t size) {
    sl_error error = {SL_OK, ""};
    write_file(p->path, bytes, size);
    assert_int_equal(sl_method_load(s->method, p->path, &error), SL_ERROR_INPUT);
    assert_non_null(strstr(error.message, p->path));
    assert_null(strchr(error.message, '\n'));
}

static void expect_unchanged(sample *s) {
    sl_image *now = finished_picture(s->method);
    assert_true(same_picture(now, s->picture));
    sl_image_destroy(now);
}

static void files_cut_short_are_refused_at_every_length(void **state) {
    const place *p = *state;
    sample s = sample_new(p);
    size_t step = s.size / 3000 + 1; /* every length near the ends, many between */
    for (size_t size = 0; size < s.size; size += size < 400 || size + 400 > s.size ? 1 : step)
        expect_damage(p, &s, s.bytes, size);
    uint8_t *longer = calloc(s.size + 1, 1);
    assert_non_null(longer);
    memcpy(longer, s.bytes, s.size);
    expect_damage(p, &s, longer, s.size + 1);
    free(longer);
    expect_unchanged(&s);
    sample_free(&s);
}

static void any_bit_that_differs_is_noticed(void **state) {
    const place *p = *state;
    sample s = sample_new(p);
    for (uint64_t n = 0; n < 3000; n++) {
        size_t at = n < 300 ? (size_t)n : (size_t)(sl_hash64(n) % s.size);
        uint8_t bit = (uint8_t)(1u << (sl_hash64(n + 77) & 7u));
        s.bytes[at] ^= bit;
        expect_damage(p, &s, s.bytes, s.size);
        s.bytes[at] ^= bit;
    }
    expect_unchanged(&s);
    sample_free(&s);
}

/* Nonsense with a checksum that fits: it is read or refused, but nothing is ever read or written where it
 * must not be. */
static void seal(uint8_t *bytes, size_t size) {
    uint64_t hash = size - 8;
    for (size_t i = 0; i < size - 8; i += 8) {
        uint64_t word = 0;
        for (size_t k = 0; k < 8 && i + k < size - 8; k++) word |= (uint64_t)bytes[i + k] << (8 * k);
        hash = sl_hash64(hash ^ word);
    }
    for (size_t k = 0; k < 8; k++) bytes[size - 8 + k] = (uint8_t)(hash >> (8 * k));
}

static void nonsense_that_is_sealed_does_no_harm(void **state) {
    const place *p = *state;
    sample s = sample_new(p);
    uint8_t *bytes = malloc(s.size);
    assert_non_null(bytes);
    int read = 0, refused = 0;
    for (uint64_t n = 0; n < 1500; n++) {
        memcpy(bytes, s.bytes, s.size);
        for (uint64_t k = 0; k <= n % 3; k++) {
            uint64_t hash = sl_hash64(n * 8 + k);
            size_t at = n % 2 ? 40 + (size_t)(hash % 400) : 40 + (size_t)(hash % (s.size - 48));
            bytes[at] = (uint8_t)(sl_hash64(hash) >> (n % 5 ? 0 : 8) | (n % 7 ? 0u : 0xffu));
        }
        seal(bytes, s.size);
        write_file(p->path, bytes, s.size);
        sl_error error;
        sl_method *method = created_method(s.scene, &s.settings);
        sl_status status = sl_method_load(method, p->path, &error);
        if (status == SL_OK) {
            read++;
            if (read % 16 == 0) sl_image_destroy(finished_picture(method));
        } else {
            refused++;
            assert_non_null(strstr(error.message, p->path));
        }
        sl_method_destroy(method);
    }
    print_message("%d sealed files read, %d refused\n", read, refused);
    assert_true(read > 100 && refused > 100);
    free(bytes);
    sample_free(&s);
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup_teardown(name, make_place, clear_place)
    const struct CMUnitTest tests[] = {
        TEST(a_second_run_makes_no_records_and_the_same_picture),
        TEST(so_it_does_with_radiance_records),
        TEST(so_it_does_with_more_bounces),
        TEST(records_from_a_file_end_where_those_that_were_made_did),
        TEST(another_view_starts_with_what_it_sees_again),
        TEST(caches_of_other_scenes_and_settings_are_refused),
        TEST(files_cut_short_are_refused_at_every_length),
        TEST(any_bit_that_differs_is_noticed),
        TEST(nonsense_that_is_sealed_does_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
