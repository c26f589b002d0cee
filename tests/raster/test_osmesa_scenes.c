/* Every scene, from its own camera and from others, on the faces of a cube and above a surface point: the
 * triangle seen at each pixel is OSMesa's. Depth from the corner planes is OSMesa's in every bit. Our own,
 * more accurate depth picks another triangle in a few pixels; where the two triangles are further apart than
 * float depth and snapped corners can tell, long double says which is right. */
#define _XOPEN_SOURCE 700
#include "osmesa_soup.h"

#include <glob.h>
#include <math.h>
#include <unistd.h>

#include "rendering.h"
#include "scene/scene.h"

typedef long double real;

typedef struct tally {
    char name[32];
    size_t triangles;
    uint64_t pixels, id, depth, changed, ours_right, theirs_right, coincident;
} tally;
enum { MOST_SCENES = 40 };
static tally tallies[MOST_SCENES];
static int scenes;

typedef struct judged_scene {
    const sl_scene *scene;
    sl_raster *raster;
    osmesa_mesh mesh;
    unsigned program;
    tally *sum;
} judged_scene;

/* ---- the truth ------------------------------------------------------------------------------- */

/* Window depth, z/w mapped to [0,1], at a pixel's centre on the plane of a triangle: the ratio of two 3x3
 * determinants of clip coordinates. These are the vertex shader's, which OSMesa's rasterizer and ours have in
 * common. */
static real exact_depth(const sl_scene *s, const sl_view *view, uint32_t t, real px, real py) {
    real clip[3][4], z = 0, w = 0;
    for (int k = 0; k < 3; k++) {
        sl_vec3 q = sl_sub(sl_scene_position(s, s->vertex[k][t]), view->origin);
        for (int i = 0; i < 4; i++) {
            const float *m = view->clip[i];
            clip[k][i] = (real)(((m[0] * q.x + m[1] * q.y) + m[2] * q.z) + m[3]);
        }
        clip[k][0] -= px * clip[k][3];
        clip[k][1] -= py * clip[k][3];
    }
    for (int k = 0; k < 3; k++) {
        const real *a = clip[(k + 1) % 3], *b = clip[(k + 2) % 3];
        real e = a[0] * b[1] - a[1] * b[0];
        z += e * clip[k][2];
        w += e * clip[k][3];
    }
    return 0.5L * (z / w) + 0.5L;
}

typedef struct depth_range {
    real least, most;
} depth_range;

/* Corners are snapped to a 256th of a pixel before either rasterizer sees them: the depths within half of
 * that around the pixel's centre. */
static depth_range depths_around(const sl_scene *s, const sl_view *view, uint32_t t, real px, real py) {
    real x = 0x1p-8L / view->width, y = 0x1p-8L / view->height, d = exact_depth(s, view, t, px, py);
    real slope =
        fabsl(exact_depth(s, view, t, px + x, py) - d) + fabsl(exact_depth(s, view, t, px, py + y) - d);
    return (depth_range){d - slope, d + slope};
}

/* Of two triangles that both cover the pixel the nearer is right. Float depths below 1 are 2^-24 apart, and
 * each of two correctly rounded ones may be off by half of that, as may their corners': what is closer
 * together than two steps (coincident surfaces, a fold's edge) cannot be told apart by either rasterizer, and
 * comes in runs of pixels of one pair of triangles. */
static void judge_pixel(tally *sum, const sl_scene *scene, const sl_view *view, size_t i, uint32_t ours,
                        uint32_t theirs) {
    real px = (real)(2 * (i % (size_t)view->width) + 1) / view->width - 1,
         py = (real)(2 * (i / (size_t)view->width) + 1) / view->height - 1;
    sum->changed++;
    if (ours == SL_NO_INDEX || theirs == SL_NO_INDEX) {
        sum->theirs_right++; /* coverage is not a matter of precision */
        return;
    }
    depth_range our_depth = depths_around(scene, view, ours, px, py),
                their_depth = depths_around(scene, view, theirs, px, py);
    if (their_depth.least - our_depth.most > 0x1p-23L) sum->ours_right++;
    else if (our_depth.least - their_depth.most > 0x1p-23L) sum->theirs_right++;
    else sum->coincident++;
}

/* ---- views ----------------------------------------------------------------------------------- */

static void compare_view(const judged_scene *j, sl_view view) {
    size_t pixels = (size_t)view.width * (size_t)view.height, where = 0;
    uint32_t *ours = checked_calloc(pixels, 4), *theirs = checked_calloc(pixels, 4);
    float *our_depth = checked_calloc(pixels, 4), *their_depth = checked_calloc(pixels, 4);
    const osmesa_format format = PLANE_R32UI;
    osmesa_target target = osmesa_target_create(view.width, view.height, 1, &format, true);
    judge_draw(j->program, &target, &j->mesh, &view, true, false);
    osmesa_read(&target, 0, theirs);
    osmesa_read_depth(&target, their_depth);
    osmesa_target_destroy(&target);

    sl_target planes = {.width = view.width, .height = view.height, .id = ours, .depth = our_depth};
    sl_counters counters = {{0}};
    view.corner_planes = true;
    assert_int_equal(sl_raster_id(j->raster, &view, 1, &planes, &counters, NULL), SL_OK);
    size_t differing = differing_words(ours, theirs, pixels, &where);
    if (differing) {
        print_message("%s: %zu ids differ, first at (%zu, %zu) of %dx%d: %u at %.9g, theirs %u at %.9g\n",
                      j->sum->name, differing, where % (size_t)view.width, where / (size_t)view.width,
                      view.width, view.height, ours[where], (double)our_depth[where], theirs[where],
                      (double)their_depth[where]);
    }
    j->sum->pixels += pixels;
    j->sum->id += differing;
    j->sum->depth += differing_words(our_depth, their_depth, pixels, NULL);

    view.corner_planes = false;
    assert_int_equal(sl_raster_id(j->raster, &view, 1, &planes, &counters, NULL), SL_OK);
    for (size_t i = 0; i < pixels; i++) {
        if (ours[i] != theirs[i]) judge_pixel(j->sum, j->scene, &view, i, ours[i], theirs[i]);
    }
    free(ours), free(theirs), free(our_depth), free(their_depth);
}

/* A pyramid has depth 1/w, which OpenGL does not know; its third row gives way to that of near and far
 * planes. */
static sl_view with_window_depth(sl_view pyramid, float near, float far) {
    double n = (double)near, f = (double)far;
    for (int k = 0; k < 3; k++) pyramid.clip[2][k] = (float)((f + n) / (f - n) * (double)pyramid.clip[3][k]);
    pyramid.clip[2][3] = (float)(-2.0 * f * n / (f - n));
    pyramid.depth = SL_DEPTH_WINDOW;
    return pyramid;
}

static void compare_cameras(const judged_scene *j, float near, float far) {
    const sl_scene *s = j->scene;
    sl_vec3 box = sl_sub(s->box_max, s->box_min);
    int width = 640, height = 640 * s->film_height / s->film_width;
    compare_view(j, sl_view_camera(&s->camera, width, height < 1 ? 1 : height, near, far));
    uint64_t key = sl_random_key(8, s->triangle_count);
    for (uint64_t n = 0; n < 2; n++) {
        sl_camera camera;
        sl_vec3 eye = sl_v3(s->box_min.x + box.x * (0.3f + 0.4f * sl_random_unit(key, 8 * n)),
                            s->box_min.y + box.y * (0.3f + 0.4f * sl_random_unit(key, 8 * n + 1)),
                            s->box_min.z + box.z * (0.3f + 0.4f * sl_random_unit(key, 8 * n + 2)));
        sl_vec3 away = sl_v3(sl_random_unit(key, 8 * n + 3) - 0.5f,
                             0.4f * (sl_random_unit(key, 8 * n + 4) - 0.5f), 0.6f);
        assert_true(sl_camera_look_at(&camera, eye, sl_add(eye, away), sl_v3(0, 1, 0), n ? 0.9f : 1.6f));
        compare_view(j, sl_view_camera(&camera, n ? 511 : 800, n ? 383 : 450, near, far));
    }
}

/* Six faces around a point, and a pyramid of 140 degrees above it. */
static void compare_pyramids(const judged_scene *j, float near, float far) {
    const sl_scene *s = j->scene;
    sl_vec3 middle = sl_scale(sl_add(s->box_min, s->box_max), 0.5f),
            eye = sl_mad(middle, 0.07f * s->diagonal, sl_v3(0.3f, -0.2f, 0.1f));
    for (int face = 0; face < 6; face++)
        compare_view(j, with_window_depth(sl_view_cube_face(eye, face, 256, near), near, far));
    sl_frame frame = sl_frame_from_normal(sl_normalize_or(sl_v3(0.2f, 0.9f, -0.3f), sl_v3(0, 1, 0)));
    const float tangent = 2.7474774f;
    const int sizes[] = {64, 256};
    for (int n = 0; n < 2; n++) {
        sl_view view =
            sl_view_pyramid(&frame, eye, -tangent, tangent, -tangent, tangent, sizes[n], sizes[n], near);
        compare_view(j, with_window_depth(view, near, far));
    }
}

/* ---- scenes ---------------------------------------------------------------------------------- */

static void compare_scene(const char *path) {
    sl_scene *scene = load_scene(path);
    uint32_t *indices = checked_calloc(3 * scene->triangle_count, sizeof *indices);
    bool masked = false;
    for (uint32_t t = 0; t < scene->triangle_count; t++) {
        for (size_t k = 0; k < 3; k++) indices[3 * t + k] = scene->vertex[k][t];
        masked |= sl_scene_has_alpha(scene, t);
    }
    float *const position[3] = {scene->position_x, scene->position_y, scene->position_z};
    judged_scene j = {.scene = scene, .sum = &tallies[scenes]};
    const char *name = strrchr(path, '/') ? strrchr(path, '/') + 1 : path;
    snprintf(j.sum->name, sizeof j.sum->name, "%.*s", (int)strcspn(name, "."), name);
    j.sum->triangles = scene->triangle_count;
    sl_raster_mesh mesh = {scene->vertex_count, scene->triangle_count,
                           scene->position_x,   scene->position_y,
                           scene->position_z,   {scene->vertex[0], scene->vertex[1], scene->vertex[2]}};
    /* Masks are not OSMesa's business. */
    assert_int_equal(masked ? sl_raster_create_mesh(&mesh, 1, &j.raster, NULL)
                            : sl_raster_create(scene, 1, &j.raster, NULL),
                     SL_OK);
    j.mesh = mesh_of(position, scene->vertex_count, NULL, 0, 3 * scene->triangle_count, indices);
    j.program = program_in_view("", "", "out uint id; void main() { id = uint(gl_PrimitiveID); }");
    float far = 1.5f * (scene->diagonal + sl_length(sl_sub(scene->camera.eye, scene->box_min))),
          near = 1e-3f * scene->diagonal;
    compare_cameras(&j, near, far);
    compare_pyramids(&j, near, far);
    osmesa_program_destroy(j.program);
    osmesa_mesh_destroy(&j.mesh);
    sl_raster_destroy(j.raster);
    sl_scene_destroy(scene);
    free(indices);
    scenes++;
}

static void compare_all(const char *pattern, size_t most_bytes) {
    glob_t found;
    if (glob(pattern, 0, NULL, &found) != 0) return;
    for (size_t i = 0; i < found.gl_pathc && scenes < MOST_SCENES; i++) {
        char obj[300];
        snprintf(obj, sizeof obj, "%.*s.obj", (int)strlen(found.gl_pathv[i]) - 5, found.gl_pathv[i]);
        FILE *file = fopen(obj, "rb");
        long bytes = file && fseek(file, 0, SEEK_END) == 0 ? ftell(file) : 0;
        if (file) fclose(file);
        if ((size_t)bytes <= most_bytes) compare_scene(found.gl_pathv[i]);
    }
    globfree(&found);
}

static void assert_agreement(void) {
    for (int n = 0; n < scenes; n++) {
        assert_int_equal(tallies[n].id, 0);
        assert_int_equal(tallies[n].depth, 0);
        assert_true(tallies[n].ours_right >= tallies[n].theirs_right);
    }
}

static void every_pixel_of_the_small_scenes_shows_osmesas_triangle(void **state) {
    (void)state;
    open_or_skip();
    compare_all("scenes/*.json", SIZE_MAX);
    assert_true(scenes >= 6);
    assert_agreement();
}

/* Those in scenes/generated; where `make scenes` has not been run, a few of them in a temporary folder. With
 * sanitizers, the smallest alone. */
static void every_pixel_of_the_generated_scenes_shows_osmesas_triangle(void **state) {
    (void)state;
    open_or_skip();
    int before = scenes;
    size_t most_bytes = soup_share(100) < 100 ? 1000000 : SIZE_MAX;
    compare_all("scenes/generated/*.json", most_bytes);
    if (scenes == before) {
        const char *named = getenv("SOFTLUX_GENERATE"),
                   *generator = named && *named ? named : "build/generate";
        char folder[] = "/tmp/softlux-test-XXXXXX", command[600], pattern[64];
        if (access(generator, X_OK) != 0) {
            print_message("skipped: neither scenes/generated nor %s (make build/generate)\n", generator);
            skip();
        }
        assert_non_null(mkdtemp(folder));
        snprintf(command, sizeof command, "'%s' %s room cave cathedral >/dev/null", generator, folder);
        assert_int_equal(system(command), 0);
        snprintf(pattern, sizeof pattern, "%s/*.json", folder);
        compare_all(pattern, most_bytes);
        snprintf(command, sizeof command, "rm -r %s", folder);
        assert_int_equal(system(command), 0);
    }
    assert_true(scenes > before);
    assert_agreement();
}

static int print_table(void **state) {
    (void)state;
    char a[32], b[32];
    uint64_t differing = 0;
    print_message("%-16s %10s %12s %7s %7s   %s\n", "scene", "triangles", "pixels", "id", "depth",
                  "our own depth: other triangle, ours right, theirs right, too close to tell");
    for (int n = 0; n < scenes; n++) {
        const tally *t = &tallies[n];
        differing += t->id + t->depth;
        print_message("%-16s %10s %12s %7llu %7llu   %llu, %llu, %llu, %llu\n", t->name,
                      with_commas(t->triangles, a), with_commas(t->pixels, b), (unsigned long long)t->id,
                      (unsigned long long)t->depth, (unsigned long long)t->changed,
                      (unsigned long long)t->ours_right, (unsigned long long)t->theirs_right,
                      (unsigned long long)t->coincident);
    }
    print_message("differing pixels: %llu\n", (unsigned long long)differing);
    osmesa_close();
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pixel_of_the_small_scenes_shows_osmesas_triangle),
        cmocka_unit_test(every_pixel_of_the_generated_scenes_shows_osmesas_triangle),
    };
    return cmocka_run_group_tests(tests, NULL, print_table);
}
