/* Radiance cache splatting where it is known to fail: section by section the cases that break careless
 * caches, each with what must come out, by closed forms where there are some. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "unit_test.h"
#include "matched.h"
#include "rendering.h"

static const double pi = 3.14159265358979323846;

static const float *channel_of(const sl_image *image, const char *name) {
    const float *plane = sl_image_channel(image, name);
    if (!plane) fail_msg("no channel %s", name);
    return plane;
}

/* ---- a lit wall over a dark floor: corner, gradients, borders -------------------------------- */

/* The wall x = 0, 3 high and 6 wide, lit squarely and evenly; the floor y = 0, that light only grazes, sees
 * nothing else. So its irradiance is that of a rectangle of even radiance, down to the corner, where R
 * vanishes and the gradient is infinite. */
static const char wall_obj[] =
    "v 0 0 -3\nv 0 0 3\nv 0 3 3\nv 0 3 -3\nv 6 0 -3\nv 6 0 3\nf 1 4 3 2\nf 1 2 6 5\n";
static const char wall_json[] =
    "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"m\"}], \"materials\": {\"m\": "
    "{\"diffuse\": 0.6}},\n"
    " \"lights\": [{\"type\": \"directional\", \"direction\": [-1, 0, 0], \"irradiance\": 3.14159265}],\n"
    " \"camera\": {\"eye\": [%g, %g, %g], \"target\": [%g, %g, %g], \"fov_deg\": 40}}";

typedef struct {
    double x, y, z;
} point;

static point sub(point a, point b) { return (point){a.x - b.x, a.y - b.y, a.z - b.z}; }
static double dot(point a, point b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static point cross(point a, point b) {
    return (point){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static point scaled(point a, double s) { return (point){a.x * s, a.y * s, a.z * s}; }
static point unit(point a) { return scaled(a, 1.0 / sqrt(dot(a, a))); }

/* Lambert: E / L = 1/2 sum of angle times (edge's unit normal . n), for a polygon above the floor. */
static double irradiance_of_wall(point p) {
    const point corner[4] = {{0, 0, -3}, {0, 0, 3}, {0, 3, 3}, {0, 3, -3}};
    double sum = 0.0;
    for (int i = 0; i < 4; i++) {
        point a = unit(sub(corner[i], p)), b = unit(sub(corner[(i + 1) % 4], p)), c = cross(a, b);
        double length = sqrt(dot(c, c));
        if (length > 0.0) sum += atan2(length, dot(a, b)) * c.y / length;
    }
    return 0.5 * fabs(sum);
}

enum { WALL_SIZE = 64 };

typedef struct {
    point eye, target;
} camera;

/* Where the floor is seen at a pixel; false: it is not. */
static int floor_at(const camera *view, int x, int y, point *p) {
    const point eye = view->eye;
    point forward = unit(sub(view->target, eye)), right = unit(cross(forward, (point){0, 1, 0})),
          up = cross(right, forward);
    double t = tan(20.0 * pi / 180.0), u = (2.0 * (x + 0.5) / WALL_SIZE - 1.0) * t,
           v = (1.0 - 2.0 * (y + 0.5) / WALL_SIZE) * t;
    point d = {forward.x + u * right.x + v * up.x, forward.y + u * right.y + v * up.y,
               forward.z + u * right.z + v * up.z};
    if (!(d.y < 0.0)) return 0;
    double s = -eye.y / d.y;
    *p = (point){eye.x + s * d.x, 0.0, eye.z + s * d.z};
    return p->x > 0.0 && p->x < 6.0 && fabs(p->z) < 3.0;
}

typedef struct {
    double mean, worst; /* relative errors */
    /* largest change of the error from a pixel to the next, a third of the wall's height from it or more */
    double jump;
    double records;
} floor_error;

static floor_error error_of_floor(const sl_image *image, const camera *view) {
    static double error[WALL_SIZE][WALL_SIZE];
    const float *indirect = channel_of(image, "indirect.G");
    floor_error e = {0};
    int count = 0;
    for (int y = 0; y < WALL_SIZE; y++) {
        for (int x = 0; x < WALL_SIZE; x++) {
            point p;
            error[y][x] = NAN;
            if (!floor_at(view, x, y, &p)) continue;
            double truth = 0.6 * 0.6 / pi * irradiance_of_wall(p);
            error[y][x] = (double)indirect[y * WALL_SIZE + x] / truth - 1.0;
            e.mean += fabs(error[y][x]);
            e.worst = fmax(e.worst, fabs(error[y][x]));
            count++;
            if (p.x < 1.0) continue;
            if (x > 0 && isfinite(error[y][x - 1]))
                e.jump = fmax(e.jump, fabs(error[y][x] - error[y][x - 1]));
            if (y > 0 && isfinite(error[y - 1][x]))
                e.jump = fmax(e.jump, fabs(error[y][x] - error[y - 1][x]));
        }
    }
    assert_true(count > WALL_SIZE * WALL_SIZE / 4);
    e.mean /= count;
    return e;
}

static sl_scene *wall_scene(const camera *view) {
    char json[1024];
    snprintf(json, sizeof json, wall_json, view->eye.x, view->eye.y, view->eye.z, view->target.x,
             view->target.y, view->target.z);
    return scene_from_text(json, wall_obj);
}

static floor_error measure_floor(const sl_settings *settings, const camera *view) {
    sl_scene *scene = wall_scene(view);
    sl_counters counters;
    sl_image *image = render(scene, settings, &counters);
    assert_sound_picture(image, "wall and floor");
    floor_error e = error_of_floor(image, view);
    e.records = (double)counters.value[SL_COUNT_RECORDS];
    destroy_picture(image, scene);
    return e;
}

static const camera from_above = {{4, 3, 0.5}, {0.9, 0, 0.1}};

static sl_settings floor_settings(sl_quality quality) {
    sl_settings settings = small_settings("splatting", WALL_SIZE, WALL_SIZE);
    settings.quality = quality;
    settings.gather = SL_GATHER_RAYS;
    settings.gather_size = 40;
    return settings;
}

static void expect_floor(const char *what, const sl_settings *settings, const camera *view, double mean,
                         double worst, double records) {
    floor_error e = measure_floor(settings, view);
    print_message("%s: mean error %.4f, worst %.3f, jump %.4f, %g records\n", what, e.mean, e.worst, e.jump,
                  e.records);
    if (!(e.mean < mean && e.worst < worst && e.records < records)) fail_msg("%s", what);
}

static void a_floor_before_a_lit_wall_is_lamberts_into_the_corner(void **state) {
    const sl_gather_kind gathers[] = {SL_GATHER_PLANE, SL_GATHER_HEMICUBE, SL_GATHER_RAYS};
    /* the plane does not see down to the corner */
    const double mean[] = {0.045, 0.02, 0.012}, worst[] = {0.2, 0.15, 0.15};
    for (int i = 0; i < 3; i++) {
        sl_settings settings = floor_settings(SL_QUALITY_NORMAL);
        settings.gather = gathers[i];
        expect_floor("gathers", &settings, &from_above, mean[i], worst[i], 150);
    }
}

/* R vanishes in the corner, and with it 1/R. Few pixels of 4096 get records of their own all the same, and a
 * smaller a costs no more than R_min lets it. */
static void accuracies_from_a_thousandth_to_two_light_the_floor(void **state) {
    const double accuracies[] = {0.001, 0.0011, 0.02, 1.0, 2.0}, worst[] = {0.15, 0.15, 0.15, 0.4, 0.8};
    for (int i = 0; i < 5; i++) {
        sl_settings settings = floor_settings(SL_QUALITY_NORMAL);
        settings.accuracy = accuracies[i];
        expect_floor("accuracies", &settings, &from_above, 0.025, worst[i], 420);
    }
}

/* On the lit floor every border of a record would show: weights that do not vanish there jump by up to the
 * records' disagreement. Gathers so fine that their noise does not. */
static void no_border_of_a_record_shows(void **state) {
    sl_settings settings = floor_settings(SL_QUALITY_HIGH);
    settings.gather_size = 160;
    floor_error e = measure_floor(&settings, &from_above);
    print_message("largest jump %.4f\n", e.jump);
    assert_true(e.jump < 0.01);
}

/* The eye two hundredths above the floor: splats lie across the near plane and contain the camera. */
static void an_eye_amid_the_records_sees_the_floor_as_it_is(void **state) {
    static const camera low = {{1.5, 0.02, 0.1}, {1.0, -0.08, 0}};
    sl_settings settings = floor_settings(SL_QUALITY_NORMAL);
    expect_floor("an eye close to the floor", &settings, &low, 0.02, 0.06, 300);
}

/* ---- what rays hardly find, and normals that say nothing ---- */

static const char lit_json[] =
    "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"m\"}], \"materials\": {\"m\": "
    "{%s}},\n"
    " \"lights\": [{\"type\": \"point\", \"position\": [0.3, 2.6, 0.8], \"intensity\": 10}],\n"
    " \"camera\": {\"eye\": [0.5, 1.7, 1.8], \"target\": [0, 0.6, 0], \"fov_deg\": 60}}";
static const char dull[] = "\"diffuse\": 0.7",
                  shiny[] = "\"diffuse\": 0.3, \"specular\": 0.6, \"exponent\": 8";

/* Quads of a box, its eight corners numbered from `first`. */
static int append_box(char *out, size_t size, int first, point low, point high) {
    int n = 0;
    for (int i = 0; i < 8; i++) {
        n += snprintf(out + n, size - (size_t)n, "v %g %g %g\n", i % 2 ? high.x : low.x,
                      i / 2 % 2 ? high.y : low.y, i / 4 ? high.z : low.z);
    }
    static const int face[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                   {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (int f = 0; f < 6; f++)
        n += snprintf(out + n, size - (size_t)n, "f %d %d %d %d\n", first + face[f][0], first + face[f][1],
                      first + face[f][2], first + face[f][3]);
    return n;
}

/* A spot of 4 degrees on the ceiling of an empty room is all that shines on the floor: a patch of 0.0035 m^2,
 * E = Phi albedo / pi cos cos / d^2. Of a gather's rays few find it, so pixels scatter, but their mean is
 * right. */
static void a_small_bright_patch_is_right_in_the_mean(void **state) {
    static const char json[] =
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"m\"}], \"materials\": "
        "{\"m\": {\"diffuse\": 0.5}},\n"
        " \"lights\": [{\"type\": \"spot\", \"position\": [0, 1, 0], \"direction\": [0, 1, 0], "
        "\"intensity\": 1000,\n"
        "   \"inner_deg\": 1.9, \"outer_deg\": 1.9}],\n"
        " \"camera\": {\"eye\": [0, 1.9, 0], \"target\": [0, 0, 0], \"up\": [0, 0, -1], \"fov_deg\": 60}}";
    char obj[1024];
    append_box(obj, sizeof obj, 1, (point){-2, 0, -2}, (point){2, 2, 2});
    sl_scene *scene = scene_from_text(json, obj);
    for (int g = SL_GATHER_HEMICUBE; g <= SL_GATHER_RAYS; g++) {
        sl_settings settings = small_settings("splatting", 32, 32);
        settings.quality = SL_QUALITY_HIGH;
        settings.gather_size = 64;
        settings.gather = (sl_gather_kind)g;
        sl_image *image = render(scene, &settings, NULL);
        assert_sound_picture(image, "a small bright patch");
        const float *indirect = channel_of(image, "indirect.G");
        double power = 1000.0 * 2.0 * pi * (1.0 - cos(1.9 * pi / 180.0)), sum = 0.0, truth = 0.0, worst = 0.0;
        for (int i = 0; i < 32 * 32; i++) {
            double t = tan(30.0 * pi / 180.0) * 1.9, x = t * (2.0 * (i % 32 + 0.5) / 32 - 1.0),
                   z = t * (2.0 * (i / 32 + 0.5) / 32 - 1.0);
            double d2 = x * x + z * z + 4.0, wanted = 0.5 / pi * (0.5 * power / pi) * (4.0 / d2) / d2;
            sum += (double)indirect[i];
            truth += wanted;
            worst = fmax(worst, (double)indirect[i] / wanted);
        }
        print_message("a small bright patch: mean %.3f of the truth, brightest pixel %.2f\n", sum / truth,
                      worst);
        assert_true(fabs(sum / truth - 1.0) < 0.12 && worst < 6.0);
        sl_image_destroy(image);
    }
    sl_scene_destroy(scene);
}

/* Vertex normals that are opposite, zero, or no numbers: where they cancel there is no shading normal to be
 * had. */
static void shading_normals_that_cancel_or_are_none_give_light_all_the_same(void **state) {
    static const char normals[][100] = {"vn 0 1 0\nvn 0 -1 0\nvn 0 1 0\nvn 0 -1 0\n",
                                        "vn 0 0 0\nvn 0 0 0\nvn 0 0 0\nvn 0 0 0\n",
                                        "vn 1 0 0\nvn -1 0 0\nvn 1 0 0\nvn -1 0 0\n",
                                        "vn nan 0 0\nvn inf 1 0\nvn 1e38 1e38 0\nvn 1e-40 1e-40 0\n"};
    char obj[2048], json[1024];
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 2; k++) {
            int n = append_box(obj, sizeof obj, 1, (point){-2, 0, -2}, (point){2, 3, 2});
            snprintf(obj + n, sizeof obj - (size_t)n,
                     "v -1 0.5 -1\nv -1 0.5 1\nv 1 0.5 1\nv 1 0.5 -1\n%sf 9//1 10//2 11//3 12//4\n",
                     normals[i]);
            snprintf(json, sizeof json, lit_json, k ? shiny : dull);
            sl_scene *scene = scene_from_text(json, obj);
            sl_settings settings = small_settings("splatting", 24, 24);
            sl_counters counters;
            sl_image *image = render(scene, &settings, &counters);
            assert_sound_picture(image, "normals that cancel");
            double sum = 0.0;
            for (int p = 0; p < 24 * 24; p++) sum += (double)channel_of(image, "G")[p];
            assert_true(sum > 24 * 24 * 0.1);
            assert_true(counters.value[SL_COUNT_RECORDS] < 24 * 24 / 2);
            destroy_picture(image, scene);
        }
    }
}

/* ---- thin walls ---- */

/* Two rooms of 2 x 2 x 2, open to the camera, share a wall that is 1/1000 thick, and the light hangs in the
 * right one. What the left room sees of the world is black; so it must stay black, though records of the
 * right room lie a thousandth away. */
static const char rooms_obj[] =
    "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\nv 2 2 2\nv 0 2 2\n"
    "v 2.001 0 0\nv 4 0 0\nv 4 2 0\nv 2.001 2 0\nv 2.001 0 2\nv 4 0 2\nv 4 2 2\nv 2.001 2 2\n"
    "f 1 2 3 4\nf 1 4 8 5\nf 2 6 7 3\nf 1 5 6 2\nf 4 3 7 8\n"
    "f 9 10 11 12\nf 9 12 16 13\nf 10 14 15 11\nf 9 13 14 10\nf 12 11 15 16\n";
/* One floor and one back wall, which the dividing wall stands on and leans against; open above. Behind the
 * wall it is dark. */
static const char divided_obj[] =
    "v 0 0 0\nv 4 0 0\nv 4 2 0\nv 0 2 0\nv 0 0 2\nv 4 0 2\n"
    "v 2 -0.2 -0.2\nv 2.001 -0.2 -0.2\nv 2.001 2 -0.2\nv 2 2 -0.2\nv 2 -0.2 2\nv 2.001 -0.2 2\nv 2.001 2 "
    "2\nv 2 2 2\n"
    "f 1 2 3 4\nf 1 5 6 2\nf 7 11 14 10\nf 8 9 13 12\nf 10 14 13 9\nf 11 12 13 14\nf 7 10 9 8\n";
static const char rooms_json[] =
    "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"m\"}], \"materials\": {\"m\": "
    "{%s}},\n"
    " \"lights\": [{\"type\": \"point\", \"position\": [%s], \"intensity\": 10}],\n"
    " \"camera\": {\"eye\": [2, 1, 5.5], \"target\": [2, 1, 0], \"fov_deg\": 40}}";

enum { ROOMS_WIDTH = 32, ROOMS_HEIGHT = 16 };

static void assert_left_is_dark(const sl_scene *scene, const sl_settings *settings, const char *what) {
    sl_image *image = render(scene, settings, NULL);
    assert_sound_picture(image, what);
    const float *picture = channel_of(image, "G");
    double left = 0.0, right = 0.0;
    for (int i = 0; i < ROOMS_WIDTH * ROOMS_HEIGHT; i++)
        *(i % ROOMS_WIDTH < ROOMS_WIDTH / 2 ? &left : &right) += (double)picture[i];
    /* Not quite so where shadow maps light what a gather sees: the dividing wall ends, and its end is no
     * sharper than a texel. */
    double most = settings->direct == SL_DIRECT_SHADOW_MAPS ? 1e-5 * right : 0.0;
    if (left > most || !(right > 10.0)) fail_msg("%s: %g on the left, %g on the right", what, left, right);
    sl_image_destroy(image);
}

static void assert_walls_hold(const char *where, const char *light, const char *obj) {
    char json[1024], what[200];
    for (int run = 0; run < 10; run++) { /* every instrument, metric, surface and way of lighting, in turn */
        snprintf(json, sizeof json, rooms_json, run / 3 % 2 ? shiny : dull, light);
        sl_scene *scene = scene_from_text(json, obj);
        sl_settings settings = small_settings("splatting", ROOMS_WIDTH, ROOMS_HEIGHT);
        settings.accuracy = settings.glossy_accuracy = run < 8 ? 0.5 : 1.0;
        settings.gather = (sl_gather_kind)(SL_GATHER_PLANE + run % 3);
        settings.metric = (sl_radius_metric)(SL_METRIC_HARMONIC + run % 2);
        settings.records_per_frame = run % 5 < 2 ? 50 : 0;
        settings.direct = run % 7 < 2 ? SL_DIRECT_SHADOW_MAPS : SL_DIRECT_RAYS;
        snprintf(what, sizeof what, "%s, run %d", where, run);
        assert_left_is_dark(scene, &settings, what);
        sl_scene_destroy(scene);
    }
}

static void no_light_leaks_through_a_wall_of_a_thousandth(void **state) {
    assert_walls_hold("two rooms", "3, 1, 1", rooms_obj);
}

static void no_light_leaks_under_a_wall_that_stands_on_the_floor(void **state) {
    assert_walls_hold("a divided floor", "2.5, 1, 1", divided_obj);
}

static void assert_all_is_dark(const char *obj, const char *light, const char *const from[2],
                               sl_quality quality) {
    static const char view[] =
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"m\"}],\n"
        " \"materials\": {\"m\": {\"diffuse\": 0.7}},\n"
        " \"lights\": [{\"type\": \"point\", \"position\": [%s], \"intensity\": 3}],\n"
        " \"camera\": {\"eye\": [%s], \"target\": [%s, 0.9, 0], \"fov_deg\": 75}}";
    char json[1024];
    snprintf(json, sizeof json, view, light, from[0], from[1]);
    sl_scene *scene = scene_from_text(json, obj);
    sl_settings settings = small_settings("splatting", 64, 48);
    settings.quality = quality;
    sl_image *image = render(scene, &settings, NULL);
    const float *direct = channel_of(image, "direct.G"), *indirect = channel_of(image, "indirect.G");
    for (int p = 0; p < 64 * 48; p++) {
        if (direct[p] > 0.0f || indirect[p] > 1e-3f)
            fail_msg("from %s: pixel (%d, %d) has %g direct, %g indirect light", from[0], p % 64, p / 64,
                     (double)direct[p], (double)indirect[p]);
    }
    destroy_picture(image, scene);
}

/* A folding screen without thickness parts a room from wall to wall; the light is behind it. Records touch
 * it, and at its outlines the rasterizer, whose vertices are snapped, shows pixels of what is behind it. */
static void no_light_comes_through_a_folding_screen_without_thickness(void **state) {
    static const char *const cameras[][2] = {{"0.8498448, 1.11755972, 1.72571254", "-0.354102"},
                                             {"-0.4170288, 1.14097268, 1.89332926", "0.173762"},
                                             {"-0.2517072, 1.89315692, 1.78283794", "0.104878"}};
    enum { PANELS = 6 };
    char obj[4096];
    int n = append_box(obj, sizeof obj, 1, (point){-2, 0, -2}, (point){2, 2.5, 2});
    for (int i = 0; i <= PANELS; i++) {
        double x = -2.0 + 4.0 * i / PANELS, z = i % 2 ? 0.35 : -0.2;
        n += snprintf(obj + n, sizeof obj - (size_t)n, "v %g 0 %g\nv %g 2.5 %g\n", x, z, x, z);
    }
    for (int a = 9; a < 9 + 2 * PANELS; a += 2)
        n += snprintf(obj + n, sizeof obj - (size_t)n, "f %d %d %d %d\n", a, a + 2, a + 3, a + 1);
    for (int i = 0; i < 6; i++)
        assert_all_is_dark(obj, "0.3, 2, -1", cameras[i / 2], i % 2 ? SL_QUALITY_NORMAL : SL_QUALITY_DRAFT);
}

/* A closed cylinder of 24 facets on a floor, a lamp inside: at its outline facets turn their insides to the
 * eye. */
static void no_facet_of_a_cylinder_around_a_lamp_shows_its_inside(void **state) {
    enum { FACETS = 24, TOP = 2 * FACETS + 1 };
    static const char *const cameras[][2] = {{"-0.41796, 3.23511944, 5.190418", "0.083592"},
                                             {"1.94272, 3.24682592, 1.587224", "-0.388544"}};
    char obj[8192];
    int n = 0;
    for (int i = 0; i < FACETS; i++) {
        double x = cos(2.0 * pi * i / FACETS), z = sin(2.0 * pi * i / FACETS);
        n += snprintf(obj + n, sizeof obj - (size_t)n, "v %.9g 0 %.9g\nv %.9g 2 %.9g\n", x, z, x, z);
    }
    n += snprintf(obj + n, sizeof obj - (size_t)n,
                  "v 0 2 0\nv -3 0 -3\nv 3 0 -3\nv 3 0 3\nv -3 0 3\nf -1 -2 -3 -4\n");
    for (int i = 0; i < FACETS; i++) {
        int a = 2 * i + 1, b = 2 * ((i + 1) % FACETS) + 1;
        n += snprintf(obj + n, sizeof obj - (size_t)n, "f %d %d %d %d\nf %d %d %d\n", a, b, b + 1, a + 1,
                      a + 1, b + 1, TOP);
    }
    for (int i = 0; i < 2; i++) assert_all_is_dark(obj, "0.1, 0.6, 0.05", cameras[i], SL_QUALITY_DRAFT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_floor_before_a_lit_wall_is_lamberts_into_the_corner),
        cmocka_unit_test(accuracies_from_a_thousandth_to_two_light_the_floor),
        cmocka_unit_test(no_border_of_a_record_shows),
        cmocka_unit_test(an_eye_amid_the_records_sees_the_floor_as_it_is),
        cmocka_unit_test(a_small_bright_patch_is_right_in_the_mean),
        cmocka_unit_test(shading_normals_that_cancel_or_are_none_give_light_all_the_same),
        cmocka_unit_test(no_light_leaks_through_a_wall_of_a_thousandth),
        cmocka_unit_test(no_light_leaks_under_a_wall_that_stands_on_the_floor),
        cmocka_unit_test(no_light_comes_through_a_folding_screen_without_thickness),
        cmocka_unit_test(no_facet_of_a_cylinder_around_a_lamp_shows_its_inside),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
