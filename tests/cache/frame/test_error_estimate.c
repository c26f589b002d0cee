/* The error of a picture that is estimated without a reference, held against references and against errors
 * that were planted. */
#include "unit_test.h"
#include "cache/audit/audit.h"
#include "rendering.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SIZE = 32 };

static sl_error_probe *probe_of(const sl_scene *scene, const sl_settings *settings) {
    sl_error error;
    sl_error_probe *probe = NULL;
    good(sl_error_probe_create(scene, settings, &probe, &error), &error);
    return probe;
}

static sl_error_estimate estimate_with(sl_error_probe *probe, const sl_image *image, uint64_t probes,
                                       uint32_t samples) {
    sl_error error;
    sl_error_estimate estimate = {0};
    good(sl_error_probe_estimate(probe, image, probes, samples, &estimate, &error), &error);
    return estimate;
}

/* A path traced picture of the same paths as a method's. */
static sl_image *reference_of(const sl_scene *scene, const char *transport, uint32_t spp) {
    sl_settings settings = small_settings("path", SIZE, SIZE);
    settings.transport = transport;
    settings.spp = spp;
    settings.seed = 77;
    return render(scene, &settings, NULL);
}

/* Relative error against a noisy reference, less what its noise adds, over the pixels that a probe judges, or
 * all. */
static double measured_error(const sl_image *image, const sl_image *reference, const sl_error_probe *probe) {
    const sl_image *surfaces = probe ? sl_error_probe_surfaces(probe) : NULL;
    const sl_compare_options options = {.mask = surfaces};
    sl_comparison c;
    sl_error_estimate noise;
    assert_int_equal(sl_image_compare(image, reference, &options, &c, NULL, NULL), SL_OK);
    assert_int_equal(sl_error_estimate_from_halves(reference, surfaces, &noise, NULL), SL_OK);
    double square = c.rmse * c.rmse - noise.rmse * noise.rmse;
    return sqrt(square > 0.0 ? square : 0.0) / fabs(c.mean_reference);
}

static void add_to_picture(sl_image *image, float offset) {
    for (size_t i = 0; i < (size_t)(3 * image->width * image->height); i++) image->planes[i] += offset;
}

static void estimates_agree_with_a_converged_reference_for_every_method(void **state) {
    static const char *const methods[] = {"splatting", "direct-radiance", "light-octree", "multi-mesh",
                                          "shading-cache"};
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    for (size_t i = 0; i < sizeof methods / sizeof methods[0]; i++) {
        char transport[64];
        snprintf(transport, sizeof transport, "matched:%s", methods[i]);
        sl_settings settings = small_settings(methods[i], SIZE, SIZE);
        sl_image *image = render(scene, &settings, NULL), *reference = reference_of(scene, transport, 24);
        sl_error_probe *probe = probe_of(scene, &settings);
        sl_error_estimate e = estimate_with(probe, image, 512, 32);
        double truth = measured_error(image, reference, probe);
        print_message("%s: %.4f, estimated %.4f, %.4f to %.4f\n", methods[i], truth, e.rel_rmse, e.least,
                      e.bound);
        assert_true(truth <= e.bound);
        assert_true(truth >= e.least);
        /* or no better than the probes can tell */
        assert_true(e.bound < 2.0 * truth || e.bound < 1.3 * e.resolution);
        sl_error_probe_destroy(probe);
        destroy_pictures(image, reference);
    }
    sl_scene_destroy(scene);
}

/* A floor, a wall and a mirror that shows the sky, which takes no part of what lights the others. */
static sl_scene *room_under_a_sky(void) {
    static const char obj[] =
        "mtllib none.mtl\n"
        "v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nv 2 2 -2\nv -2 2 -2\nv 0.4 0 0.2\nv 1.4 0 -0.3\nv 1.4 0.9 "
        "-0.6\nv 0.4 0.9 -0.1\n"
        "usemtl white\nf 4 3 2\nf 4 2 1\nf 1 2 5\nf 1 5 6\nusemtl mirror\nf 7 8 9\nf 7 9 10\n";
    return scene_from_text(
        "{\"softlux\":1,\"meshes\":[{\"file\":\"mesh.obj\"}],\"environment\":{\"radiance\":[1,1.5,2]},"
        "\"materials\":{\"white\":{\"diffuse\":0.7},\"mirror\":{\"mirror\":0.8}},"
        "\"lights\":[{\"type\":\"point\",\"position\":[-0.5,1.5,0.5],\"intensity\":6}],"
        "\"camera\":{\"eye\":[0,2,4],\"target\":[0,0.3,0],\"fov_deg\":40}}",
        obj);
}

static double mean_of(const sl_image *image) {
    size_t values = 3 * (size_t)image->width * (size_t)image->height;
    double sum = 0.0;
    for (size_t i = 0; i < values; i++) sum += (double)image->planes[i];
    return sum / (double)values;
}

static void a_sky_that_lights_nothing_is_no_light_to_the_paths_matched_either(void **state) {
    static const char *const tracers[] = {"path", "bidirectional"};
    /* of boxes light subpaths are joined to the camera */
    static const sl_pixel_filter filters[] = {SL_FILTER_CENTRE, SL_FILTER_BOX};
    sl_scene *scene = room_under_a_sky();
    sl_settings settings = small_settings("direct-radiance", SIZE, SIZE);
    settings.quality = SL_QUALITY_HIGH;
    sl_image *image = render(scene, &settings, NULL);
    for (int i = 0; i < 4; i++) {
        sl_settings traced = small_settings(tracers[i / 2], SIZE, SIZE);
        traced.transport = "matched:direct-radiance";
        traced.filter = filters[i % 2];
        traced.spp = 32;
        sl_image *reference = render(scene, &traced, NULL);
        double ours = mean_of(image), theirs = mean_of(reference);
        print_message("%s, filter %d: %.4f, %.4f\n", tracers[i / 2], i % 2, ours, theirs);
        assert_true(fabs(ours - theirs) < 0.05 * theirs);
        /* the mirror's sky is there, and in its place */
        if (filters[i % 2] == SL_FILTER_CENTRE) assert_true(measured_error(image, reference, NULL) < 0.1);
        sl_image_destroy(reference);
    }
    sl_error_probe *probe = probe_of(scene, &settings);
    sl_error_estimate e = estimate_with(probe, image, 512, 16);
    assert_true(e.bound < 0.15);
    sl_error_probe_destroy(probe);
    destroy_picture(image, scene);
}

static void a_planted_error_is_what_is_estimated(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-point.json");
    sl_settings settings = small_settings("path", SIZE, SIZE);
    settings.transport = "direct";
    sl_image *image = reference_of(scene, "direct", 64);
    sl_error_probe *probe = probe_of(scene, &settings);
    sl_error_estimate clean = estimate_with(probe, image, 512, 64);
    float offset = 0.2f * (float)clean.mean;
    add_to_picture(image, offset);
    sl_error_estimate e = estimate_with(probe, image, 512, 64);
    assert_true(clean.rel_rmse < 0.05);
    assert_true(fabs(e.rel_rmse - 0.2) < 0.01);
    assert_true(e.bound >= 0.2 && e.bound < 0.25);
    assert_true(e.least <= 0.2 && e.least > 0.15);
    assert_true(fabs(e.mean - clean.mean) < 0.02 * clean.mean); /* a picture's own bias is seen through */
    sl_error_probe_destroy(probe);
    destroy_picture(image, scene);
}

static void the_bound_holds_for_at_least_nine_of_ten_seeds(void **state) {
    enum { SEEDS = 40 };
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = small_settings("splatting", SIZE, SIZE);
    sl_image *image = render(scene, &settings, NULL),
             *reference = reference_of(scene, "matched:splatting", 48);
    sl_error_probe *viewer = probe_of(scene, &settings);
    double truth = measured_error(image, reference, viewer);
    sl_error_probe_destroy(viewer);
    unsigned above = 0, below = 0;
    for (unsigned seed = 0; seed < SEEDS; seed++) {
        settings.seed = seed;
        sl_error_probe *probe = probe_of(scene, &settings);
        sl_error_estimate e = estimate_with(probe, image, 96, 4);
        above += e.bound >= truth;
        below += e.least <= truth;
        sl_error_probe_destroy(probe);
    }
    print_message("truth %.4f; %u of %u bounds hold, %u of those from below\n", truth, above, SEEDS, below);
    assert_true(10 * above >= 9 * SEEDS);
    assert_true(10 * below >= 9 * SEEDS);
    destroy_pictures(image, reference);
    sl_scene_destroy(scene);
}

static void probes_are_the_same_however_they_were_asked_for(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = small_settings("splatting", SIZE, SIZE);
    sl_image *image = render(scene, &settings, NULL);
    sl_error_probe *probe = probe_of(scene, &settings);
    sl_error_estimate at_once = estimate_with(probe, image, 96, 6),
                      again = estimate_with(probe, image, 96, 6);
    assert_memory_equal(&at_once, &again, sizeof again); /* nothing is lost or traced anew */
    for (unsigned threads = 1; threads <= 7; threads += 3) {
        settings.threads = threads;
        sl_error_probe *other = probe_of(scene, &settings);
        estimate_with(other, image, 32, 4);
        estimate_with(other, image, 96, 5);
        estimate_with(other, image, 10, 2);
        sl_error_estimate step_by_step = estimate_with(other, image, 96, 6);
        assert_memory_equal(&at_once, &step_by_step, sizeof step_by_step);
        sl_error_probe_destroy(other);
    }
    sl_error_probe_destroy(probe);
    destroy_picture(image, scene);
}

/* One pixel in a thousand holds nearly all of the error, and the probes are a tenth of the pixels: they have
 * to find it. */
static void an_error_in_a_single_pixel_is_found(void **state) {
    enum { SEEDS = 20 };
    sl_scene *scene = load_scene("scenes/cornell-point.json");
    sl_settings settings = small_settings("path", SIZE, SIZE);
    settings.transport = "direct";
    sl_image *image = reference_of(scene, "direct", 64);
    size_t at = 17 * SIZE + 11;
    float mean = 0.0f, outlier;
    for (size_t i = 0; i < 3 * SIZE * SIZE; i++) mean += image->planes[i] / (3 * SIZE * SIZE);
    outlier = 32.0f * mean; /* relative RMSE: 32 sqrt(1/1024) = 1 */
    for (size_t c = 0; c < 3; c++) image->planes[c * SIZE * SIZE + at] += outlier;
    for (unsigned seed = 0; seed < SEEDS; seed++) {
        settings.seed = seed;
        sl_error_probe *probe = probe_of(scene, &settings);
        sl_error_estimate e = estimate_with(probe, image, 100, 8);
        assert_true(fabs(e.rel_rmse - 1.0) < 0.05 && e.bound > 0.99 && e.bound < 1.2 && e.least < 1.01);
        sl_error_probe_destroy(probe);
    }
    destroy_picture(image, scene);
}

static void a_judgement_traces_until_the_answer_is_clear(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-point.json");
    sl_settings settings = small_settings("path", SIZE, SIZE);
    settings.transport = "direct";
    sl_image *image = reference_of(scene, "direct", 32);
    sl_error_probe *probe = probe_of(scene, &settings);
    sl_error_estimate few = estimate_with(probe, image, 256, 16), e;
    assert_int_equal(sl_error_probe_judge(probe, image, 1.1 * few.bound, 0, &e, NULL), SL_OK);
    /* clearly within: no more had to be traced */
    assert_true(e.bound == few.bound && e.samples == few.samples);
    assert_int_equal(sl_error_probe_judge(probe, image, 0.9 * few.bound, 0, &e, NULL), SL_OK);
    assert_true(e.samples > few.samples);
    assert_true(e.bound <= 0.9 * few.bound);
    uint64_t before = e.samples;
    add_to_picture(image, 0.2f * (float)few.mean);
    assert_int_equal(sl_error_probe_judge(probe, image, 0.1, 0, &e, NULL), SL_OK);
    /* clearly worse: a probe or two that this picture chooses */
    assert_true(e.least > 0.1 && e.samples < before + before / 2);
    sl_error_probe_destroy(probe);
    destroy_picture(image, scene);
}

/* A third too bright wherever no lamp is seen, and the lamp by `wrong`. *planted: of the surfaces, and of all
 * pixels. */
static sl_error_estimate estimate_beside_a_lamp(double wrong, double planted[2]) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = small_settings("splatting", SIZE, SIZE);
    sl_image *truth = reference_of(scene, "matched:splatting", 64),
             *image = reference_of(scene, "matched:splatting", 64);
    sl_error_probe *probe = probe_of(scene, &settings);
    const float *surface = sl_error_probe_surfaces(probe)->planes;
    size_t pixels = SIZE * SIZE;
    double count[2] = {0.0, 0.0}, squares[2] = {0.0, 0.0}, sum[2] = {0.0, 0.0};
    for (size_t i = 0; i < 3 * pixels; i++) {
        bool is_surface = surface[i % pixels] > 0.5f;
        double off = (double)truth->planes[i] * (is_surface ? 1.0 / 3.0 : wrong);
        image->planes[i] = truth->planes[i] + (float)off;
        for (int all = !is_surface; all < 2; all++) {
            count[all] += 1.0;
            squares[all] += off * off;
            sum[all] += (double)truth->planes[i];
        }
    }
    assert_true(count[0] > 0.0 && count[0] < count[1]);
    for (int all = 0; all < 2; all++)
        planted[all] = sqrt(squares[all] / count[all]) / (sum[all] / count[all]);
    sl_error_estimate e = estimate_with(probe, image, 1024, 64);
    print_message("planted %.4f of surfaces, %.4f of all, estimated %.4f, %.4f to %.4f\n", planted[0],
                  planted[1], e.rel_rmse, e.least, e.bound);
    assert_int_equal(e.probes, pixels);
    sl_error_probe_destroy(probe);
    destroy_pictures(truth, image);
    sl_scene_destroy(scene);
    return e;
}

static void all_pixels_are_judged_and_surfaces_beside_a_lamp_by_themselves(void **state) {
    double planted[2];
    sl_error_estimate e = estimate_beside_a_lamp(0.0, planted);
    assert_true(planted[1] < 0.6 * planted[0]);
    assert_true(fabs(e.rel_rmse - planted[0]) < 0.05 * planted[0]);
    assert_true(e.bound > planted[0] && e.bound < 1.1 * planted[0]);
    e = estimate_beside_a_lamp(1.0 / 3.0, planted);
    assert_true(planted[1] > planted[0]);
    assert_true(fabs(e.rel_rmse - planted[1]) < 0.05 * planted[1]);
    assert_true(e.bound > planted[1] && e.bound < 1.1 * planted[1]);
}

static unsigned surfaces_in(const sl_scene *scene, sl_pixel_filter filter, const float *within) {
    sl_settings settings = small_settings("path", SIZE, SIZE);
    settings.filter = filter;
    sl_error_probe *probe = probe_of(scene, &settings);
    const float *surface = sl_error_probe_surfaces(probe)->planes;
    unsigned count = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        count += surface[i] > 0.5f;
        if (within && surface[i] > 0.5f) assert_true(within[i] > 0.5f);
    }
    sl_error_probe_destroy(probe);
    return count;
}

static void pixels_at_the_rim_of_a_lamp_are_no_surfaces_where_pixels_are_boxes(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = small_settings("splatting", SIZE, SIZE);
    sl_error_probe *centres = probe_of(scene, &settings);
    unsigned all = SIZE * SIZE, by_centre = surfaces_in(scene, SL_FILTER_CENTRE, NULL);
    unsigned by_box = surfaces_in(scene, SL_FILTER_BOX, sl_error_probe_surfaces(centres)->planes);
    assert_true(by_centre < all && by_box < by_centre && by_box > all - 5 * (all - by_centre));
    sl_error_probe_destroy(centres);
    sl_scene_destroy(scene);
}

static void nothing_is_promised_for_a_picture_with_a_value_that_is_no_number(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-point.json");
    sl_settings settings = small_settings("path", SIZE, SIZE);
    sl_image *image = reference_of(scene, "full", 16);
    sl_error_probe *probe = probe_of(scene, &settings);
    sl_error_estimate before = estimate_with(probe, image, 1024, 8);
    for (int x = 0; x < SIZE; x++) image->planes[5 * SIZE + x] = x % 2 ? NAN : INFINITY;
    sl_error_estimate e = estimate_with(probe, image, 1024, 8);
    assert_int_equal(e.nonfinite, SIZE);
    assert_true(isinf(e.bound));
    assert_true(isfinite(e.rel_rmse) && fabs(e.mean - before.mean) < 0.1 * before.mean);
    sl_error_probe_destroy(probe);
    destroy_picture(image, scene);
}

/* Path tracing with few samples is off most at the rims of lamps: the two halves know. */
static void a_picture_of_two_halves_knows_its_own_error(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_image *reference = reference_of(scene, "full", 64);
    sl_settings settings = small_settings("path", SIZE, SIZE);
    settings.spp = 8;
    sl_image *image = render(scene, &settings, NULL);
    sl_error_estimate e;
    assert_int_equal(sl_error_estimate_from_halves(image, NULL, &e, NULL), SL_OK);
    double truth = measured_error(image, reference, NULL);
    print_message("path: %.4f, estimated %.4f, %.4f to %.4f\n", truth, e.rel_rmse, e.least, e.bound);
    assert_true(e.least <= truth && truth <= e.bound && e.bound < 2.5 * truth);
    sl_image_destroy(image);
    settings.spp = 1; /* one half is black: nothing to go by */
    image = render(scene, &settings, NULL);
    assert_int_equal(sl_error_estimate_from_halves(image, NULL, &e, NULL), SL_OK);
    assert_true(isinf(e.bound));
    destroy_pictures(image, reference);
    sl_scene_destroy(scene);
}

/* Two planted errors, of which the second is so many times the first. */
static void how_much_of_an_error_is_left_is_told_by_differences_at_the_same_probes(void **state) {
    enum { SEEDS = 10 };
    const double shares[] = {1.0, 0.96, 0.3};
    sl_scene *scene = load_scene("scenes/cornell-point.json");
    sl_settings settings = small_settings("path", SIZE, SIZE);
    settings.transport = "direct";
    sl_image *first = reference_of(scene, "direct", 64), *second = reference_of(scene, "direct", 64);
    double error = 0.2 * mean_of(first), planted = 0.0;
    add_to_picture(first, (float)error);
    for (size_t i = 0; i < sizeof shares / sizeof shares[0]; i++) {
        unsigned held = 0, near = 0, overlap = 0;
        add_to_picture(second, (float)(shares[i] * error - planted));
        planted = shares[i] * error;
        for (settings.seed = 0; settings.seed < SEEDS; settings.seed++) {
            double left;
            sl_error_probe *probe = probe_of(scene, &settings);
            sl_error_estimate before = estimate_with(probe, first, 128, 16),
                              after = estimate_with(probe, second, 128, 16);
            assert_int_equal(sl_error_probe_left(probe, first, second, &left, NULL), SL_OK);
            held += left <= shares[i];
            near += left > shares[i] - 0.1;
            overlap += after.bound > before.least;
            sl_error_probe_destroy(probe);
        }
        print_message("%.2f: %u not above, %u near, %u of the bounds overlap\n", shares[i], held, near,
                      overlap);
        assert_true(10 * held >= 9 * SEEDS);
        if (shares[i] > 0.9) assert_true(10 * near >= 9 * SEEDS && 10 * overlap >= 9 * SEEDS);
    }
    destroy_pictures(second, first);
    sl_scene_destroy(scene);
}

static void what_no_path_from_the_eye_finds_is_owned_up_to(void **state) {
    sl_scene *scene = load_scene("scenes/mirror-balls.json");
    const struct {
        const char *method;
        bool blind;
    } cases[] = {{"light-octree", true}, {"splatting", false}, {"path", true}};
    for (size_t i = 0; i < 3; i++) {
        sl_settings settings = small_settings(cases[i].method, SIZE, SIZE);
        sl_error_probe *probe = probe_of(scene, &settings);
        sl_image *image = blank_image(SIZE, SIZE, 3);
        assert_int_equal(estimate_with(probe, image, 16, 1).blind, cases[i].blind);
        sl_image_destroy(image);
        sl_error_probe_destroy(probe);
    }
    sl_scene_destroy(scene);
}

/* Ten pixels, each for ten, all with the square 4 but one with 400. */
static void the_bound_is_that_of_student_and_the_rule_of_three(void **state) {
    sl_audit_pixel pixels[10];
    const double x[3] = {5.0, 5.0, 5.0}, off[3] = {3.0, 3.0, 3.0}, far_off[3] = {-15.0, -15.0, -15.0};
    for (int i = 0; i < 10; i++) pixels[i] = sl_audit_pixel_of(x, off, off, 10.0);
    sl_error_estimate e = {0};
    sl_audit_conclude(pixels, 10, 100.0, 12.0, &e);
    assert_true(fabs(e.mean - 10.0) < 1e-12 && fabs(e.rel_rmse - 0.2) < 1e-12 && fabs(e.least - 0.2) < 1e-12);
    assert_true(fabs(e.bound - sqrt(4.0 + 3.0 * 9.0 * 4.0 / 100.0) / 10.0) < 1e-12);
    pixels[3] = sl_audit_pixel_of(x, far_off, far_off, 10.0);
    e = (sl_error_estimate){0};
    sl_audit_conclude(pixels, 10, 100.0, 12.0, &e);
    double mean = 43.6, shares = 90.0 * (9.0 * 39.6 * 39.6 + 356.4 * 356.4);
    assert_true(fabs(e.rmse * e.rmse - mean) < 1e-9);
    assert_true(e.least == 0.0);
    /* One pixel has nine tenths of the variance: 1.23 degrees of freedom, between t = 6.314 of one and 2.920
     * of two. */
    const double t = 2.920 + 2.0 * (0.9 * 0.9 + 0.1 * 0.1 / 9.0 - 0.5) * (6.314 - 2.920),
                 most = mean + t * sqrt(shares) / 100.0 + 3.0 * 9.0 * 400.0 / 100.0,
                 spread = t * sqrt(90.0 * (9.0 * 1.8 * 1.8 + 16.2 * 16.2)) / 100.0;
    assert_true(fabs(e.bound * (e.mean - spread) / sqrt(most) - 1.0) < 1e-9);
    assert_true(e.resolution == 0.0 || isinf(e.resolution)); /* p and q agree */
    /* If all pixels were looked at, only their noise is left: here none. */
    for (int i = 0; i < 10; i++) pixels[i] = sl_audit_pixel_of(x, i ? off : far_off, i ? off : far_off, 1.0);
    e = (sl_error_estimate){0};
    sl_audit_conclude(pixels, 10, 10.0, 12.0, &e);
    assert_true(fabs(e.bound - e.rel_rmse) < 1e-12 && fabs(e.least - e.rel_rmse) < 1e-12);
}

static void noise_of_the_probes_themselves_widens_the_bounds(void **state) {
    const double x[3] = {5.0, 5.0, 5.0}, p[3] = {4.0, 4.0, 4.0}, q[3] = {2.0, 2.0, 2.0};
    sl_audit_pixel a = sl_audit_pixel_of(x, p, q, 1.0);
    assert_true(fabs(a.square - 3.0) < 1e-12 && fabs(a.difference - 2.0) < 1e-12 &&
                fabs(a.noise - 2.0) < 1e-12);
    assert_true(fabs(a.square_variance - (2.0 * 4.0 * 2.0 + 4.0)) < 1e-12 &&
                fabs(a.difference_variance - 1.0) < 1e-12);
    /* Ten of a hundred: a picture without error would be off by p's and q's variance, 2, in each, and by
     * three times nine in what is not seen. */
    sl_audit_pixel pixels[10];
    for (int i = 0; i < 10; i++) pixels[i] = sl_audit_pixel_of(x, p, q, 10.0);
    sl_error_estimate e = {0};
    sl_audit_conclude(pixels, 10, 100.0, 32.0, &e);
    double noise = 1.812 * sqrt(10.0 * 20.0 * 20.0) + 3.0 * 9.0 * 2.0,
           difference = 1.812 * sqrt(10.0 * 10.0) / 100.0;
    assert_true(fabs(e.resolution - sqrt(noise / 100.0) / (30.0 - difference)) < 1e-9);
    assert_true(e.bound > e.resolution && e.bound < 2.0 * e.resolution);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_bound_is_that_of_student_and_the_rule_of_three),
        cmocka_unit_test(noise_of_the_probes_themselves_widens_the_bounds),
        cmocka_unit_test(a_planted_error_is_what_is_estimated),
        cmocka_unit_test(an_error_in_a_single_pixel_is_found),
        cmocka_unit_test(estimates_agree_with_a_converged_reference_for_every_method),
        cmocka_unit_test(a_sky_that_lights_nothing_is_no_light_to_the_paths_matched_either),
        cmocka_unit_test(the_bound_holds_for_at_least_nine_of_ten_seeds),
        cmocka_unit_test(probes_are_the_same_however_they_were_asked_for),
        cmocka_unit_test(a_judgement_traces_until_the_answer_is_clear),
        cmocka_unit_test(all_pixels_are_judged_and_surfaces_beside_a_lamp_by_themselves),
        cmocka_unit_test(pixels_at_the_rim_of_a_lamp_are_no_surfaces_where_pixels_are_boxes),
        cmocka_unit_test(nothing_is_promised_for_a_picture_with_a_value_that_is_no_number),
        cmocka_unit_test(a_picture_of_two_halves_knows_its_own_error),
        cmocka_unit_test(how_much_of_an_error_is_left_is_told_by_differences_at_the_same_probes),
        cmocka_unit_test(what_no_path_from_the_eye_finds_is_owned_up_to),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
