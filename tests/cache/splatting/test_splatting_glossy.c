/* Radiance records: what a record's coefficients send to the eye from a pixel, against quadrature; and whole
 * pictures of glossy receivers. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "unit_test.h"
#include "cache/splatting/glossy.h"
#include "matched.h"
#include "rendering.h"
#include "harmonics_support.h"

enum { ORDER = 10 };
static const double pi = 3.14159265358979323846;

/* ---- one record and one pixel ---- */

typedef struct {
    float px, py, pz, nx, ny, nz;
    uint32_t receives, material;
    sl_splat_receivers receivers;
    sl_material surface;
    sl_scene scene;
    sl_glossy *glossy;
    sl_glossy_view view;
    float coefficients[9 * 160];
    sl_glossy_record record;
} stage;

/* A smooth environment, seen from everywhere alike. */
static double environment(int channel, sl_vec3d w) {
    const double tint[3] = {1.0, 0.4, 2.0};
    return tint[channel] *
           (1.5 + 0.7 * w.x - 0.5 * w.y + 0.6 * w.z + 0.8 * w.x * w.y - 0.4 * w.y * w.z * w.z);
}

static sl_vec3d direction_at(const sl_frame *f, double cosine, double phi) {
    double sine = sqrt(fmax(0.0, 1.0 - cosine * cosine)), x = sine * cos(phi), y = sine * sin(phi);
    return sl_v3d(x * (double)f->x.x + y * (double)f->y.x + cosine * (double)f->z.x,
                  x * (double)f->x.y + y * (double)f->y.y + cosine * (double)f->z.y,
                  x * (double)f->x.z + y * (double)f->y.z + cosine * (double)f->z.z);
}

enum { RINGS = 128, SECTORS = 256 };

static void project_environment(stage *s) {
    size_t stride = sl_hsh_stride(ORDER);
    memset(s->coefficients, 0, sizeof s->coefficients);
    for (int j = 0; j < RINGS; j++) {
        for (int k = 0; k < SECTORS; k++) {
            double c = (j + 0.5) / RINGS, phi = 2.0 * pi * (k + 0.5) / SECTORS, sine = sqrt(1.0 - c * c),
                   values[160];
            sl_vec3d world = direction_at(&s->record.frame, c, phi);
            hsh_evaluate(ORDER, sl_v3d(sine * cos(phi), sine * sin(phi), c), values);
            for (int channel = 0; channel < 3; channel++) {
                double share = environment(channel, world) * 2.0 * pi / (RINGS * SECTORS);
                for (size_t i = 0; i < stride; i++)
                    s->coefficients[(size_t)channel * stride + i] += (float)(share * values[i]);
            }
        }
    }
}

/* The lobe (s+2)/(2 pi) cos^s alpha against the environment, by quadrature over the pixel's hemisphere. */
static double reflected(const stage *s, int channel, sl_vec3d to_viewer) {
    sl_vec3 n = sl_v3(s->nx, s->ny, s->nz);
    sl_frame f = sl_frame_from_normal(n);
    double n_v = (double)n.x * to_viewer.x + (double)n.y * to_viewer.y + (double)n.z * to_viewer.z, sum = 0.0;
    sl_vec3d mirrored = sl_v3d(2.0 * n_v * (double)n.x - to_viewer.x, 2.0 * n_v * (double)n.y - to_viewer.y,
                               2.0 * n_v * (double)n.z - to_viewer.z);
    for (int j = 0; j < RINGS; j++) {
        for (int k = 0; k < SECTORS; k++) {
            double c = (j + 0.5) / RINGS;
            sl_vec3d w = direction_at(&f, c, 2.0 * pi * (k + 0.5) / SECTORS);
            double cos_alpha = w.x * mirrored.x + w.y * mirrored.y + w.z * mirrored.z;
            if (cos_alpha > 0.0)
                sum += pow(cos_alpha, (double)s->surface.exponent) * c * environment(channel, w);
        }
    }
    return sum * ((double)s->surface.exponent + 2.0) / (2.0 * pi) * 2.0 * pi / (RINGS * SECTORS);
}

static sl_vec3 unit(float x, float y, float z) { return sl_normalize_or(sl_v3(x, y, z), sl_v3(0, 0, 1)); }

static void stage_open(stage *s, sl_vec3 record_normal, sl_vec3 pixel_normal) {
    *s = (stage){.receives = 1, .nx = pixel_normal.x, .ny = pixel_normal.y, .nz = pixel_normal.z};
    s->receivers = (sl_splat_receivers){1, 1, &s->px, &s->py, &s->pz, &s->nx, &s->ny, &s->nz, &s->receives};
    s->surface = (sl_material){.specular = {1, 1, 1}, .exponent = 20.0f};
    s->scene = (sl_scene){.material_count = 1, .materials = &s->surface};
    assert_int_equal(sl_glossy_create(&s->scene, ORDER, &s->glossy, NULL), SL_OK);
    s->view = (sl_glossy_view){s->glossy, &s->receivers, &s->material, {0, 0, 0}, NULL};
    s->record = (sl_glossy_record){{0, 0, 0}, sl_frame_from_normal(record_normal), s->coefficients};
    project_environment(s);
}

static void look_from(stage *s, sl_vec3 to_viewer, float radiance[3]) {
    s->view.eye = sl_scale(to_viewer, 3.0f);
    SL_KERNEL_OF(sl_isa_best(), sl_glossy_radiance)(&s->view, &s->record, 0, radiance);
}

static void a_pixel_with_the_records_normal_reflects_what_quadrature_says(void **state) {
    static stage s;
    const sl_vec3 normals[] = {{0, 0, 1}, {0, 0, -1}, unit(1, 2, -0.5f), unit(-0.3f, 0.1f, 0.9f)};
    for (int i = 0; i < 4; i++) {
        stage_open(&s, normals[i], normals[i]);
        for (int k = 0; k < 12; k++) {
            float radiance[3];
            sl_vec3d d = direction_at(&s.record.frame, 0.35 + 0.05 * k, 1.1 * k);
            sl_vec3 to_viewer = sl_to_float(d);
            look_from(&s, to_viewer, radiance);
            for (int c = 0; c < 3; c++) {
                double wanted = reflected(&s, c, d);
                assert_true(fabs((double)radiance[c] - wanted) < 0.01 * wanted);
            }
        }
        sl_glossy_destroy(s.glossy);
    }
}

/* The tilt brings up directions that the record did not see; they take their mirror image's light: the more,
 * the further. */
static void a_tilted_pixel_reflects_what_quadrature_says_but_for_what_the_record_could_not_see(void **state) {
    static stage s;
    double worst = 0.0;
    const sl_vec3 record_normal = unit(0.4f, -0.2f, 0.8f);
    const sl_frame frame = sl_frame_from_normal(record_normal);
    for (int turn = 0; turn < 8; turn++) {
        for (int step = 1; step <= 2; step++) {
            double beta = 0.17 * step;
            sl_vec3 n = sl_to_float(direction_at(&frame, cos(beta), 0.8 * turn));
            stage_open(&s, record_normal, unit(n.x, n.y, n.z));
            sl_frame own = sl_frame_from_normal(sl_v3(s.nx, s.ny, s.nz));
            for (int k = 0; k < 6; k++) {
                float radiance[3];
                sl_vec3d d = direction_at(&own, 0.5 + 0.08 * k, 1.3 * k);
                look_from(&s, sl_to_float(d), radiance);
                for (int c = 0; c < 3; c++) {
                    double wanted = reflected(&s, c, d), error = fabs((double)radiance[c] / wanted - 1.0);
                    worst = error > worst ? error : worst;
                }
            }
            sl_glossy_destroy(s.glossy);
        }
    }
    assert_true(worst < 0.03);
}

static void coefficients_are_translated_along_their_gradients_in_the_records_frame(void **state) {
    static stage s;
    float there[3], moved[3], expected[3];
    stage_open(&s, unit(0.3f, 0.5f, 0.7f), unit(0.3f, 0.5f, 0.7f));
    size_t stride = sl_hsh_stride(ORDER);
    sl_vec3 to_viewer = unit(0.5f, 0.2f, 0.8f);
    look_from(&s, to_viewer, there);
    for (size_t i = 0; i < 3 * stride; i++) {
        s.coefficients[3 * stride + i] = 0.5f * s.coefficients[i];  /* d/dx */
        s.coefficients[6 * stride + i] = -0.2f * s.coefficients[i]; /* d/dy */
    }
    sl_vec3 d = sl_add(sl_scale(s.record.frame.x, 0.4f), sl_scale(s.record.frame.y, 0.3f));
    s.px = d.x, s.py = d.y, s.pz = d.z;
    s.view.eye = sl_add(d, sl_scale(to_viewer, 3.0f));
    SL_KERNEL_OF(sl_isa_best(), sl_glossy_radiance)(&s.view, &s.record, 0, moved);
    for (int c = 0; c < 3; c++) {
        expected[c] = there[c] * (1.0f + 0.5f * 0.4f - 0.2f * 0.3f);
        assert_true(fabsf(moved[c] - expected[c]) < 1e-4f * expected[c]);
    }
    sl_glossy_destroy(s.glossy);
}

/* At a wall that is almost touched, where depth vanishes, gradients are beyond all measure: the lobe must not
 * show them as a blot. */
static void gradients_beyond_measure_change_what_is_reflected_by_half(void **state) {
    static stage s;
    float there[3], moved[3];
    stage_open(&s, unit(0.3f, 0.5f, 0.7f), unit(0.3f, 0.5f, 0.7f));
    size_t stride = sl_hsh_stride(ORDER);
    look_from(&s, unit(0.5f, 0.2f, 0.8f), there);
    const float steep[] = {1e5f, -1e5f, 1e30f, INFINITY, NAN};
    for (int i = 0; i < 5; i++) {
        for (size_t j = 0; j < 3 * stride; j++) s.coefficients[3 * stride + j] = steep[i] * s.coefficients[j];
        s.px = 0.01f * s.record.frame.x.x, s.py = 0.01f * s.record.frame.x.y,
        s.pz = 0.01f * s.record.frame.x.z;
        SL_KERNEL_OF(sl_isa_best(), sl_glossy_radiance)(&s.view, &s.record, 0, moved);
        for (int c = 0; c < 3; c++) assert_true(moved[c] > 0.45f * there[c] && moved[c] < 1.55f * there[c]);
    }
    sl_glossy_destroy(s.glossy);
}

static void every_instruction_set_reflects_the_same_bits(void **state) {
    static stage s;
    stage_open(&s, unit(0.1f, 0.5f, 0.7f), unit(0.2f, 0.45f, 0.7f));
    s.view.eye = sl_v3(1, 2, 3);
    float first[3], other[3];
    SL_KERNEL_OF(SL_ISA_BASELINE, sl_glossy_radiance)(&s.view, &s.record, 0, first);
    for (int isa = SL_ISA_BASELINE; isa <= (int)sl_isa_best(); isa++) {
        SL_KERNEL_OF((sl_isa)isa, sl_glossy_radiance)(&s.view, &s.record, 0, other);
        assert_memory_equal(first, other, sizeof first);
    }
    sl_glossy_destroy(s.glossy);
}

static void an_eye_on_the_pixel_or_below_it_and_a_normal_that_is_none_give_numbers(void **state) {
    static stage s;
    float radiance[3];
    stage_open(&s, sl_v3(0, 0, 1), sl_v3(0, 0, 1));
    const sl_vec3 eyes[] = {{0, 0, 0}, {0, 0, -1}, {1, 0, 0}, {1e-30f, 0, 0}};
    for (int i = 0; i < 4; i++) {
        s.view.eye = eyes[i];
        SL_KERNEL_OF(sl_isa_best(), sl_glossy_radiance)(&s.view, &s.record, 0, radiance);
        for (int c = 0; c < 3; c++) assert_true(isfinite(radiance[c]));
    }
    sl_glossy_destroy(s.glossy);
}

/* ---- pictures ---- */

/* The back wall of the Cornell box, with any material. */
static sl_scene *box_with_back(const char *back, sl_settings *settings) {
    char json[1024], folder[512];
    assert_non_null(getcwd(folder, sizeof folder));
    snprintf(
        json, sizeof json,
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"%s/scenes/cornell.obj\"}], \"materials\": {\"back\": %s},"
        "\"camera\": {\"eye\": [278, 273, -800], \"target\": [278, 273, 0], \"up\": [0, 1, 0], \"fov_deg\": "
        "39.3}}",
        folder, back);
    *settings = small_settings("splatting", 96, 96);
    return scene_from_text(json, NULL);
}

/* Gathers see diffuse lobes alone, so a glossy lobe more on one wall is nothing to the pixels of the others.
 */
static void a_glossy_wall_leaves_diffuse_pixels_as_they_were(void **state) {
    sl_settings settings;
    sl_scene *diffuse = box_with_back("{\"diffuse\": [0.3, 0.3, 0.3]}", &settings);
    sl_scene *glossy = box_with_back(
        "{\"diffuse\": [0.3, 0.3, 0.3], \"specular\": [0.5, 0.5, 0.5], \"exponent\": 10}", &settings);
    sl_image *a = render(diffuse, &settings, NULL), *b = render(glossy, &settings, NULL);
    const float *reflection = sl_image_channel(b, "glossy.R");
    assert_null(sl_image_channel(a, "glossy.R"));
    assert_non_null(reflection);
    size_t same = 0, wall = 0;
    for (size_t i = 0; i < 96 * 96; i++) {
        bool on_wall = reflection[i] > 0.0f;
        wall += on_wall;
        same += !on_wall && sl_image_channel(a, "indirect.G")[i] == sl_image_channel(b, "indirect.G")[i];
    }
    assert_true(wall > 1000 && wall < 4000);
    assert_true(same > 96 * 96 - wall - 50); /* but for records that the wall's pixels no longer make */
    destroy_pictures(a, b);
    sl_scene_destroy(diffuse);
    sl_scene_destroy(glossy);
}

static void the_glossy_box_agrees_with_the_path_tracer(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    sl_settings settings = small_settings("splatting", 64, 64);
    settings.quality = SL_QUALITY_NORMAL;
    const sl_comparison c = against_path_tracer(scene, &settings, 256, NULL);
    assert_true(fabs(c.bias) < 0.005);
    assert_true(c.rel_mse - c.rel_mse_noise < 0.005);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pixel_with_the_records_normal_reflects_what_quadrature_says),
        cmocka_unit_test(a_tilted_pixel_reflects_what_quadrature_says_but_for_what_the_record_could_not_see),
        cmocka_unit_test(coefficients_are_translated_along_their_gradients_in_the_records_frame),
        cmocka_unit_test(gradients_beyond_measure_change_what_is_reflected_by_half),
        cmocka_unit_test(every_instruction_set_reflects_the_same_bits),
        cmocka_unit_test(an_eye_on_the_pixel_or_below_it_and_a_normal_that_is_none_give_numbers),
        cmocka_unit_test(a_glossy_wall_leaves_diffuse_pixels_as_they_were),
        cmocka_unit_test(the_glossy_box_agrees_with_the_path_tracer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
