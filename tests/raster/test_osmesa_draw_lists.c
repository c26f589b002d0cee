/* OSMesa judges the passes that draw: those that every method asks for while it renders the Cornell box, a
 * room and a cave are handed to OSMesa as they come, all large ones and every fiftieth small view, and whole
 * frames are compared. Triangle numbers agree in every bit, and so do depths of large views, told OpenGL's
 * way (the methods' own is 1/w, which OpenGL does not store); in small views depths may be 256 steps of a
 * float (1.5e-5) apart and are counted by themselves; Gouraud's values agree within the roundings of OSMesa's
 * planes, which begin at the target's corner. */
#define _XOPEN_SOURCE 700
#include "osmesa_soup.h"

#include <math.h>
#include <unistd.h>

#include "raster/clusters.h"
#include "rendering.h"
#include "scene/scene.h"

enum { EVERY = 50, DEPTH_STEPS = 256 };

typedef struct tally {
    uint64_t draws, judged, pixels, id, depth, near;
} tally;
static const char *const view_names[SL_VIEW_KINDS] = {"camera", "pyramid", "hemicube face",
                                                      "light's window"};
static tally tallies[2][SL_VIEW_KINDS]; /* large, small */
static struct {
    uint64_t passes, pixels, differing, other_triangle;
    double worst; /* difference in units of the bound */
} gouraud_tally;
static bool judging; /* our own passes are not told */

/* ---- one view -------------------------------------------------------------------------------- */

/* Row 2 of a view of depth 1/w is the height f above a plane that cuts, mostly the near one: z = 2 f - w has
 * the same plane for OpenGL, z >= -w, and keeps what is in view before the far one. A light's window has its
 * far plane there; it gets a near one, a thousandth as far. */
static sl_view with_window_depth(const sl_view *view) {
    sl_view v = *view;
    v.corner_planes = true;
    if (v.depth == SL_DEPTH_WINDOW) return v;
    float along = 0.0f;
    for (int k = 0; k < 3; k++) along += v.clip[2][k] * v.clip[3][k];
    for (int k = 0; k < 3; k++)
        v.clip[2][k] = along < 0.0f ? v.clip[3][k] : 2.0f * v.clip[2][k] - v.clip[3][k];
    v.clip[2][3] = along < 0.0f ? -2e-3f * v.clip[2][3] : 2.0f * v.clip[2][3] - v.clip[3][3];
    v.depth = SL_DEPTH_WINDOW;
    return v;
}

/* The triangles that a view draws, in order. */
typedef struct draw_list {
    size_t count;
    uint32_t *triangle, *index;
} draw_list;

static draw_list list_of(const sl_raster_mesh *m, const sl_view *view) {
    draw_list list = {0, checked_calloc(m->triangle_count, 4), checked_calloc(3 * m->triangle_count, 4)};
    for (uint32_t t = 0; t < m->triangle_count; t++) {
        if (t == view->skip_triangle || (view->left_out && view->left_out[t])) continue;
        for (size_t k = 0; k < 3; k++) list.index[3 * list.count + k] = m->vertex[k][t];
        list.triangle[list.count++] = t;
    }
    return list;
}

static void draw_theirs(const sl_raster_mesh *m, const sl_view *view, int width, int height, uint32_t *id,
                        float *depth) {
    const osmesa_format format = PLANE_R32UI;
    draw_list list = list_of(m, view);
    float *const position[3] = {(float *)(uintptr_t)m->x, (float *)(uintptr_t)m->y, (float *)(uintptr_t)m->z};
    osmesa_mesh mesh = mesh_of(position, m->vertex_count, NULL, 0, 3 * list.count, list.index);
    osmesa_target target = osmesa_target_create(width, height, 1, &format, true);
    unsigned program = program_in_view("", "", "out uint id; void main() { id = uint(gl_PrimitiveID); }");
    judge_draw(program, &target, &mesh, view, true, false);
    osmesa_read(&target, 0, id);
    osmesa_read_depth(&target, depth);
    for (size_t i = 0; i < (size_t)width * (size_t)height; i++) {
        if (id[i] != SL_NO_INDEX) id[i] = list.triangle[id[i]];
    }
    osmesa_program_destroy(program);
    osmesa_target_destroy(&target);
    osmesa_mesh_destroy(&mesh);
    free(list.triangle), free(list.index);
}

static void draw_ours(const sl_raster *raster, const sl_view *view, bool small, const sl_target *target) {
    sl_counters counters = {{0}};
    if (!small) {
        assert_int_equal(sl_raster_id(raster, view, 1, target, &counters, NULL), SL_OK);
        return;
    }
    sl_raster_scratch *scratch;
    assert_int_equal(sl_raster_scratch_create(raster, target->width, target->height, &scratch, NULL), SL_OK);
    sl_raster_id_small(raster, view, target, scratch, &counters);
    sl_raster_scratch_destroy(scratch);
}

/* Depths in [0, 1] that differ; those that are at most DEPTH_STEPS of a float apart are counted in `near`,
 * where that is given. */
static size_t differing_depths(const float *a, const float *b, size_t count, uint64_t *near, size_t *where) {
    size_t differing = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t p, q;
        memcpy(&p, a + i, 4);
        memcpy(&q, b + i, 4);
        if (p == q) continue;
        if (near && p - q + DEPTH_STEPS <= 2 * DEPTH_STEPS) ++*near;
        else if (!differing++) *where = i;
    }
    return differing;
}

static void judge_view(const sl_raster *raster, const sl_view *as_drawn, bool small) {
    tally *sum = &tallies[small][as_drawn->kind];
    if (judging || (sum->draws++ % EVERY != 0 && small) || raster->masked) return;
    judging = true;
    sl_view view = with_window_depth(as_drawn);
    view.scissor = (sl_scissor){0, 0, 0, 0};
    int width = view.x + view.width, height = view.y + view.height;
    size_t pixels = (size_t)width * (size_t)height, where = 0;
    uint32_t *ours = checked_calloc(pixels, 4), *theirs = checked_calloc(pixels, 4);
    float *our_depth = checked_calloc(pixels, 4), *their_depth = checked_calloc(pixels, 4);
    for (size_t i = 0; i < pixels; i++) {
        ours[i] = SL_NO_INDEX;
        our_depth[i] = 1.0f;
    }
    draw_ours(raster, &view, small, &(sl_target){width, height, ours, our_depth});
    draw_theirs(&raster->mesh, &view, width, height, theirs, their_depth);
    size_t ids = differing_words(ours, theirs, pixels, &where);
    if (ids)
        print_message("%s: %zu ids of %dx%d differ, first %u, theirs %u\n", view_names[view.kind], ids, width,
                      height, ours[where], theirs[where]);
    size_t depths = differing_depths(our_depth, their_depth, pixels,
                                     small || view.kind == SL_VIEW_LIGHT ? &sum->near : NULL, &where);
    if (depths)
        print_message("%s: %zu depths of %dx%d differ, first %.9g, theirs %.9g\n", view_names[view.kind],
                      depths, width, height, (double)our_depth[where], (double)their_depth[where]);
    sum->judged++;
    sum->pixels += pixels;
    sum->id += ids;
    sum->depth += depths;
    free(ours), free(theirs), free(our_depth), free(their_depth);
    judging = false;
}

/* ---- Gouraud --------------------------------------------------------------------------------- */

/* In double, of a value a: a / w and 1 / w are planes on the screen; x and y in pixels. */
typedef struct screen_triangle {
    double x[3], y[3], w[3];
    bool cut; /* OSMesa cuts it, and interpolates in what is left */
} screen_triangle;

static screen_triangle on_screen(const sl_raster_mesh *m, const sl_view *view, uint32_t t) {
    screen_triangle s = {.cut = false};
    for (int k = 0; k < 3; k++) {
        uint32_t v = m->vertex[k][t];
        double q[4] = {(double)m->x[v] - (double)view->origin.x, (double)m->y[v] - (double)view->origin.y,
                       (double)m->z[v] - (double)view->origin.z, 1},
               c[4] = {0};
        for (int i = 0; i < 4; i++) {
            for (int j = 0; j < 4; j++) c[i] += (double)view->clip[i][j] * q[j];
        }
        s.x[k] = (c[0] / c[3] * 0.5 + 0.5) * view->width;
        s.y[k] = (c[1] / c[3] * 0.5 + 0.5) * view->height;
        s.w[k] = c[3];
        s.cut |= fabs(c[0]) > c[3] || fabs(c[1]) > c[3] || fabs(c[2]) > c[3];
    }
    return s;
}

typedef struct plane {
    double dx, dy, at, largest; /* of its terms, from the target's corner */
} plane;

static plane plane_through(const screen_triangle *s, const double value[3], double x, double y) {
    double ax = s->x[1] - s->x[0], ay = s->y[1] - s->y[0], bx = s->x[2] - s->x[0], by = s->y[2] - s->y[0],
           area = ax * by - bx * ay;
    double a = value[1] - value[0], b = value[2] - value[0];
    plane p = {.dx = (a * by - b * ay) / area, .dy = (b * ax - a * bx) / area};
    double condition = (fabs(ax * by) + fabs(bx * ay)) / fabs(area),
           origin = fabs(p.dx * s->x[0]) + fabs(p.dy * s->y[0]) + fabs(value[0]);
    p.at = value[0] + p.dx * (x - s->x[0]) + p.dy * (y - s->y[0]);
    p.largest = condition * (origin + fabs(p.dx) * x + fabs(p.dy) * y);
    return p;
}

/* By how much a value of OSMesa's may be off: sixteen roundings of its planes' terms, and half a step of
 * 1/256 pixel, by which corners are snapped and a pixel beside its triangle is moved. A triangle that is cut
 * has other corners, which are better ones or about as good. */
static double bound_of(const screen_triangle *s, const float value[3], double x, double y) {
    double over[3], inverse[3];
    for (int k = 0; k < 3; k++) {
        inverse[k] = 1.0 / s->w[k];
        over[k] = (double)value[k] / s->w[k];
    }
    plane numerator = plane_through(s, over, x, y), denominator = plane_through(s, inverse, x, y);
    double a = numerator.at / denominator.at,
           slope = (fabs(numerator.dx - a * denominator.dx) + fabs(numerator.dy - a * denominator.dy)) /
                   fabs(denominator.at);
    return 16 * 0x1p-24 * (numerator.largest + fabs(a) * denominator.largest) / fabs(denominator.at) *
               (s->cut ? 16 : 1) +
           slope / 256 + 0x1p-23;
}

static void corners_of(const sl_raster_mesh *m, const sl_gouraud_pass *pass, uint32_t t, float *value) {
    size_t channels = (size_t)pass->channels;
    if (pass->corners) pass->corners(pass->context, t, value);
    for (size_t k = 0; k < 3 && !pass->corners; k++)
        memcpy(value + k * channels, pass->vertex + m->vertex[k][t] * channels, channels * sizeof *value);
}

static void draw_their_values(const sl_raster_mesh *m, const sl_view *view, const sl_gouraud_pass *pass,
                              uint32_t *id, float *rgba) {
    const osmesa_format formats[] = {PLANE_R32UI, PLANE_RGBA32F};
    draw_list list = list_of(m, view);
    const float *from[3] = {m->x, m->y, m->z};
    float *position[3], *value = checked_calloc(12 * list.count, sizeof *value);
    for (int i = 0; i < 3; i++) position[i] = checked_calloc(3 * list.count, sizeof *position[i]);
    for (size_t n = 0; n < list.count; n++) {
        float corner[3 * SL_GOURAUD_CHANNELS] = {0};
        corners_of(m, pass, list.triangle[n], corner);
        for (size_t k = 0; k < 3; k++) {
            for (int i = 0; i < 3; i++) position[i][3 * n + k] = from[i][list.index[3 * n + k]];
            memcpy(value + 4 * (3 * n + k), corner + k * (size_t)pass->channels,
                   (size_t)pass->channels * sizeof *value);
        }
    }
    osmesa_mesh mesh = mesh_of(position, 3 * list.count, value, 4, 0, NULL);
    osmesa_target target = osmesa_target_create(view->width, view->height, 2, formats, true);
    unsigned program = program_in_view(
        "layout(location = 3) in vec4 a; out vec4 value;", "value = a;",
        "in vec4 value; layout(location = 0) out uint id; layout(location = 1) out vec4 colour;"
        "void main() { id = uint(gl_PrimitiveID); colour = value; }");
    judge_draw(program, &target, &mesh, view, true, false);
    osmesa_read(&target, 0, id);
    osmesa_read(&target, 1, rgba);
    for (size_t i = 0; i < (size_t)view->width * (size_t)view->height; i++) {
        if (id[i] != SL_NO_INDEX) id[i] = list.triangle[id[i]];
    }
    osmesa_program_destroy(program);
    osmesa_target_destroy(&target);
    osmesa_mesh_destroy(&mesh);
    for (int i = 0; i < 3; i++) free(position[i]);
    free(value), free(list.triangle), free(list.index);
}

static void compare_values(const sl_raster_mesh *m, const sl_view *view, const sl_gouraud_pass *pass,
                           size_t i, uint32_t t, const float *ours, const float *theirs) {
    float value[3 * SL_GOURAUD_CHANNELS];
    size_t channels = (size_t)pass->channels, pixels = (size_t)view->width * (size_t)view->height;
    screen_triangle s = on_screen(m, view, t);
    double x = (double)(i % (size_t)view->width) + 0.5, y = (double)(i / (size_t)view->width) + 0.5,
           worst = 0;
    corners_of(m, pass, t, value);
    for (size_t c = 0; c < channels; c++) {
        const float at[3] = {value[c], value[channels + c], value[2 * channels + c]};
        worst = fmax(worst,
                     fabs((double)ours[c * pixels + i] - (double)theirs[4 * i + c]) / bound_of(&s, at, x, y));
    }
    gouraud_tally.pixels++;
    gouraud_tally.differing += worst <= 1.0 ? 0u : 1u;
    gouraud_tally.worst = fmax(gouraud_tally.worst, worst);
}

static void judge_gouraud(void *context, const sl_raster *raster, const sl_view *as_drawn, const uint32_t *id,
                          const sl_gouraud_pass *as_asked) {
    if (judging || raster->masked) return;
    judging = true;
    sl_view view = with_window_depth(as_drawn);
    sl_gouraud_pass pass = *as_asked;
    size_t pixels = (size_t)view.width * (size_t)view.height;
    float *ours = checked_calloc((size_t)pass.channels * pixels, sizeof *ours),
          *theirs = checked_calloc(4 * pixels, sizeof *theirs);
    uint32_t *their_id = checked_calloc(pixels, sizeof *their_id);
    sl_counters counters = {{0}};
    pass.out = ours;
    pass.shade = NULL;
    pass.textured = false;
    sl_raster_gouraud(raster, as_drawn, 1, id, &pass, &counters);
    draw_their_values(&raster->mesh, &view, &pass, their_id, theirs);
    gouraud_tally.passes++;
    for (size_t i = 0; i < pixels; i++) {
        if (id[i] == SL_NO_INDEX) continue; /* what another picture hides */
        if (id[i] != their_id[i]) gouraud_tally.other_triangle++;
        else compare_values(&raster->mesh, as_drawn, &pass, i, id[i], ours, theirs);
    }
    free(ours), free(theirs), free(their_id);
    judging = false;
}

/* ---- methods --------------------------------------------------------------------------------- */

static void judge_draw_of(void *context, const sl_raster *raster, const sl_view *view, bool small) {
    judge_view(raster, view, small);
}

static const sl_raster_observer observer = {judge_draw_of, judge_gouraud, NULL};

static void run(sl_scene *scene, const sl_settings *settings) {
    sl_image *image = render(scene, settings, NULL);
    sl_image_destroy(image);
}

/* Pictures over points by planes and by hemicubes, lights by shadow maps and by both kinds of windows. */
static void run_all_on(sl_scene *scene) {
    scene->observer = &observer;
    static const char *const methods[] = {"splatting",  "splatting",     "direct-radiance", "multi-mesh",
                                          "multi-mesh", "shading-cache", "light-octree"};
    for (int n = 0; n < (int)(sizeof methods / sizeof methods[0]); n++) {
        sl_settings settings = small_settings(methods[n], 64, 48);
        settings.threads = 1;
        settings.gather = n == 0 ? SL_GATHER_PLANE : n == 1 ? SL_GATHER_HEMICUBE : SL_GATHER_AUTO;
        settings.direct = n < 2 ? SL_DIRECT_SHADOW_MAPS : SL_DIRECT_AUTO;
        settings.multi_mesh.estimator = n == 4 ? SL_LIGHT_LOOK_AT : SL_LIGHT_RATIO;
        run(scene, &settings);
    }
    sl_scene_destroy(scene);
}

static void run_all(const char *path) { run_all_on(load_scene(path)); }

/* A floor before a mirror on the wall. */
static void every_pass_of_every_method_draws_what_osmesa_draws(void **state) {
    open_or_skip();
    const char *named = getenv("SOFTLUX_GENERATE"), *generator = named && *named ? named : "build/generate";
    char folder[] = "/tmp/softlux-test-XXXXXX", command[600], path[64];
    run_all("scenes/cornell.json");
    run_all("scenes/two-rooms.json");
    if (access(generator, X_OK) == 0) {
        assert_non_null(mkdtemp(folder));
        snprintf(command, sizeof command, "'%s' %s cave >/dev/null", generator, folder);
        assert_int_equal(system(command), 0);
        snprintf(path, sizeof path, "%s/cave.json", folder);
        run_all(path);
        snprintf(command, sizeof command, "rm -r %s", folder);
        assert_int_equal(system(command), 0);
    } else {
        print_message("without the cave: no %s (make build/generate)\n", generator);
    }
    for (int small = 0; small < 2; small++) {
        for (int kind = 0; kind < SL_VIEW_KINDS; kind++) {
            assert_int_equal(tallies[small][kind].id, 0);
            assert_int_equal(tallies[small][kind].depth, 0);
        }
    }
    assert_int_equal(gouraud_tally.differing, 0);
}

/* Each kind of pass that methods have. */
static void no_kind_of_pass_is_missing(void **state) {
    open_or_skip();
    assert_true(tallies[0][SL_VIEW_CAMERA].judged > 0);
    assert_true(tallies[0][SL_VIEW_PYRAMID].judged > 0);
    assert_true(tallies[1][SL_VIEW_PYRAMID].judged > 0);
    assert_true(tallies[1][SL_VIEW_HEMICUBE_FACE].judged > 0);
    assert_true(tallies[1][SL_VIEW_LIGHT].judged > 0);
    assert_true(gouraud_tally.pixels > 0);
}

static int print_table(void **state) {
    uint64_t differing = gouraud_tally.differing;
    print_message("%-24s %10s %10s %12s %10s %10s %10s\n", "pass", "drawn", "judged", "pixels", "id", "depth",
                  "steps");
    for (int small = 0; small < 2; small++) {
        for (int kind = 0; kind < SL_VIEW_KINDS; kind++) {
            const tally *t = &tallies[small][kind];
            if (!t->draws) continue;
            print_message("%s %-18s %10llu %10llu %12llu %10llu %10llu %10llu\n", small ? "small" : "large",
                          view_names[kind], (unsigned long long)t->draws, (unsigned long long)t->judged,
                          (unsigned long long)t->pixels, (unsigned long long)t->id,
                          (unsigned long long)t->depth, (unsigned long long)t->near);
            differing += t->id + t->depth;
        }
    }
    print_message("Gouraud: %llu passes, %llu pixels, %llu differ, at most %.2g of the bound; in %llu "
                  "another triangle by 1/w\n",
                  (unsigned long long)gouraud_tally.passes, (unsigned long long)gouraud_tally.pixels,
                  (unsigned long long)gouraud_tally.differing, gouraud_tally.worst,
                  (unsigned long long)gouraud_tally.other_triangle);
    print_message("differing pixels: %llu\n", (unsigned long long)differing);
    osmesa_close();
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pass_of_every_method_draws_what_osmesa_draws),
        cmocka_unit_test(no_kind_of_pass_is_missing),
    };
    return cmocka_run_group_tests(tests, NULL, print_table);
}
