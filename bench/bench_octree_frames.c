/* What the light octree takes in memory, and how fast it and its atlas make frames: at two sizes of picture,
 * with either filter, over lights a voxel, with the texture fetches that each pixel takes. The paper's
 * graphics card made 40 frames a second at 800 x 600, 10 at 1280 x 1024, and 25 to 10 for 1 to 8 lights; from
 * the atlas 700 to 200. */
#include <stdlib.h>
#include <string.h>

#include "cache/light_octree/atlas/bake.h"
#include "octree_bench.h"

static const double mebi = 1.0 / 1048576.0;

typedef struct size2 {
    int width, height;
} size2;
static const size2 sizes[2] = {{800, 600}, {1280, 1024}};

/* ---- memory ---- */

static void memory_row(bench_report *r, const bench_options *o, const char *path, int depth) {
    sl_light_octree_settings settings = octree_settings();
    sl_counters counters = {{0}};
    double seconds[2], unused;
    octree_light light;
    sl_scene *scene;
    sl_tracer *tracer;
    sl_error error;
    char name[64];
    bench_scene_name(path, name);
    if (!bench_wants(o, name) || !bench_open_scene(r, path, &scene)) return;
    if (sl_tracer_create(scene, 2, NULL, &tracer, &error) != SL_OK) bench_fail("tracer", &error);
    settings.photons = 150000; /* memory does not depend on them, but for leaves that get none */
    settings.neighbours = 50;
    sl_photon_tree *tree = octree_photons(scene, tracer, &settings, 0, 2, seconds, &counters);
    sl_octree *octree = octree_voxels(scene, depth, 2, &unused);
    octree_light_voxels(scene, octree, tree, &settings, 2, &light);
    double leaves = (double)octree->leaf_count, bricks = 32.0 * (double)light.texture->brick_count;
    double lights = 16.0 * (double)light.texture->width * (double)light.texture->height,
           dense = 256.0 * (double)(1ull << 3 * depth);
    double derived = (32.0 / 3.0 + 64.0) * leaves; /* a brick for 3 leaves, 4 lights of 16 bytes */
    bench_row(r, "%s|%d|%zu|%zu|%.2f|%.3f|%.3f|%.3f|%.3f|%.0f|%.1f|%.1f", name, depth, octree->leaf_count,
              light.texture->brick_count, leaves / (double)light.texture->brick_count, mebi * bricks,
              mebi * lights, mebi * (bricks + lights), mebi * derived, mebi * dense,
              mebi * (double)(sl_octree_bytes(octree) + sl_voxel_lights_bytes(light.lights)),
              mebi * (double)sl_photon_tree_bytes(tree));
    octree_light_free(&light);
    sl_octree_destroy(octree);
    sl_photon_tree_destroy(tree);
    sl_tracer_destroy(tracer);
    sl_scene_destroy(scene);
}

static void memory(bench_report *r, const bench_options *o) {
    bench_say(r, "\nMemory in MiB with 4 lights a voxel. *derived*: 1.0 + 6.1 MiB for 100,000 leaves, in "
                 "proportion; *dense*: 256 bytes for every cell. The last\n"
                 "two are what preprocessing has beside it: leaves and sets of lights, and 150,000 photons "
                 "in their tree.\n");
    bench_table(
        r, "memory",
        "scene|depth|leaves|bricks|leaves a brick|octree|lights|both|derived|dense|leaves and sets|photons");
    memory_row(r, o, "scenes/cornell.json", 6);
    memory_row(r, o, "scenes/generated/figure.json", 6);
    memory_row(r, o, "scenes/cornell.json", 7);
    if (!o->brief) memory_row(r, o, "scenes/generated/room.json", 7);
    memory_row(r, o, "scenes/generated/atrium.json", 7);
    memory_row(r, o, "scenes/generated/cathedral.json", 7);
}

/* ---- frames ---- */

typedef struct frames {
    octree_view *view;
    sl_octree_shading shading;
    const sl_atlas_canvas *canvas; /* NULL: from the octree */
} frames;

static double frame(const frames *f, unsigned threads) {
    octree_view *v = f->view;
    sl_error error;
    if (!f->canvas) return octree_shade_view(v, &f->shading, threads);
    v->counters = (sl_counters){{0}};
    double from = octree_seconds(threads);
    if (sl_atlas_apply(f->canvas, v->gbuffer, v->scene, threads, v->planes[0], v->planes[1], v->planes[2],
                       &v->counters, &error) != SL_OK)
        bench_fail("atlas", &error);
    return octree_seconds(threads) - from;
}

static int by_seconds(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median_frame(const bench_options *o, const frames *f, unsigned threads) {
    double seconds[7];
    int runs = o->once ? 3 : 7;
    for (int i = 0; i < runs; i++) seconds[i] = frame(f, threads);
    qsort(seconds, (size_t)runs, sizeof *seconds, by_seconds);
    return seconds[runs / 2];
}

static size_t surface_pixels(const octree_view *v) {
    size_t count = 0, pixels = (size_t)v->gbuffer->width * (size_t)v->gbuffer->height;
    for (size_t i = 0; i < pixels; i++) count += v->gbuffer->material[i] != SL_NO_INDEX;
    return count;
}

static void frame_row(bench_report *r, const bench_options *o, const char *scene, const char *what,
                      int lights, const frames *f, const char *paper, double *first) {
    double one = median_frame(o, f, 1), two = o->once ? 0.0 : median_frame(o, f, 2);
    double pixels = (double)surface_pixels(f->view),
           fetches = (double)f->view->counters.value[SL_COUNT_TEXTURE_FETCHES] / pixels;
    char clock[32] = "";
    if (two > 0.0) snprintf(clock, sizeof clock, "%.1f", 1.0 / two);
    if (*first == 0.0) *first = one;
    bench_row(r, "%s|%s|%d|%d x %d|%.2f|%.1f|%s|%.1f|%.1f|%.2f|%s", scene, what, lights,
              f->view->gbuffer->width, f->view->gbuffer->height, 1e3 * one, 1.0 / one, clock,
              1e9 * one / pixels, fetches, one / *first, paper);
}

/* Made once for both sizes; a mesh of a million triangles takes half a minute. */
typedef struct baked {
    sl_atlas *atlas;
    sl_atlas_canvas *canvas;
    char text[256];
} baked;

/* Only sides that are seen need be filled, and looked up. */
static bool is_seen(const octree_view *v, int side) {
    const sl_gbuffer *g = v->gbuffer;
    for (size_t i = 0; i < (size_t)g->width * (size_t)g->height; i++) {
        if (g->material[i] == SL_NO_INDEX) continue;
        float cosine = sl_dot(sl_scene_geometric_normal(v->scene, g->id[i]),
                              sl_v3(g->geometric_x[i], g->geometric_y[i], g->geometric_z[i]));
        if ((cosine < 0.0f) == (side == SL_ATLAS_BACK)) return true;
    }
    return false;
}

static void bake(bench_report *r, const char *scene, const frames *octree, baked *b) {
    sl_atlas_settings settings = {
        .size = octree_settings().atlas_size, .gutter = 2, .bend = 60.0 / 57.29577951308232, .threads = 2};
    const sl_scene *s = octree->view->scene;
    sl_error error;
    sl_counters counters = {{0}};
    int sides = 0;
    double from = octree_seconds(1);
    if (sl_atlas_create(s, &settings, &b->atlas, &error) != SL_OK) {
        bench_say(r, "no atlas: %s\n", error.message);
        return;
    }
    double charts = octree_seconds(1) - from;
    if (sl_atlas_canvas_create(b->atlas, s, 2, &b->canvas, &error) != SL_OK) bench_fail("atlas", &error);
    from = octree_seconds(1);
    for (int side = 0; side < 2; side++) {
        bool seen = is_seen(octree->view, side);
        sides += seen;
        if (seen && sl_atlas_bake_octree(b->canvas, (sl_atlas_side)side, s, &octree->shading, 1, &counters,
                                         &error) != SL_OK)
            bench_fail("atlas", &error);
    }
    snprintf(b->text, sizeof b->text,
             "Atlas of %s: %zu charts over %.0f %% of %d x %d texels, %.2f processor s; %d sides are seen "
             "and filled in %.2f s.",
             scene, b->atlas->chart_count, 100.0 * (double)b->canvas->covered / ((double)settings.size * settings.size),
             settings.size, settings.size, charts,
             sides, octree_seconds(1) - from);
}

static void forget(baked *b) {
    sl_atlas_canvas_destroy(b->canvas);
    sl_atlas_destroy(b->atlas);
    *b = (baked){0};
}

static void atlas_row(bench_report *r, const bench_options *o, const char *scene, const frames *octree,
                      baked *b, double *first) {
    if (!b->atlas) bake(r, scene, octree, b);
    if (!b->canvas) return;
    frames f = {.view = octree->view, .canvas = b->canvas};
    frame_row(r, o, scene, "atlas", 4, &f, "700 to 200 fps", first);
    if (o->pictures && f.view->gbuffer->width == sizes[0].width) octree_view_write(f.view, r, scene, "atlas");
}

static void view_rows(bench_report *r, const bench_options *o, const char *scene, const char *path, int which,
                      baked *b, double *gbuffer) {
    static const int ns[] = {1, 2, 3, 4, 6, 8};
    static const char *const paper[] = {"25 fps", "20 fps", "17 fps", "14 fps", "12 fps", "10 fps"};
    sl_light_octree_settings settings = octree_settings();
    sl_counters counters = {{0}};
    double seconds[2], unused, first = 0.0;
    octree_light light;
    octree_view view;
    *gbuffer = 0.0;
    if (!octree_view_open(r, path, sizes[which].width, sizes[which].height, &view)) return;
    if (o->brief) settings.photons = 150000;
    sl_photon_tree *tree = octree_photons(view.scene, view.tracer, &settings, 0, 2, seconds, &counters);
    sl_octree *octree = octree_voxels(view.scene, settings.depth, 2, &unused);
    for (size_t i = 0; i < 6; i++) {
        bool four = ns[i] == 4;
        if (!four && (which == 1 || o->brief)) continue;
        settings.lights = ns[i];
        octree_light_voxels(view.scene, octree, tree, &settings, 2, &light);
        frames f = {.view = &view, .shading = sl_octree_shading_of(&settings, light.texture)};
        frame_row(r, o, scene, "trilinear", ns[i], &f, four ? which ? "10 fps" : "14 to 40 fps" : paper[i],
                  &first);
        if (o->pictures && four && which == 0) octree_view_write(&view, r, scene, "trilinear");
        if (four) {
            f.shading.filter = SL_VOXEL_NEAREST;
            frame_row(r, o, scene, "nearest", ns[i], &f, "", &first);
            if (o->pictures && which == 0) octree_view_write(&view, r, scene, "nearest");
            f.shading.filter = SL_VOXEL_TRILINEAR;
            if (!o->brief || view.scene->triangle_count < 100000) atlas_row(r, o, scene, &f, b, &first);
        }
        octree_light_free(&light);
    }
    *gbuffer = view.gbuffer_seconds;
    sl_octree_destroy(octree);
    sl_photon_tree_destroy(tree);
    octree_view_close(&view);
}

static void all_frames(bench_report *r, const bench_options *o) {
    static const char *const paths[] = {"scenes/cornell.json", "scenes/generated/room.json",
                                        "scenes/generated/atrium.json", "scenes/generated/cathedral.json",
                                        "scenes/generated/figure.json"};
    enum { SCENES = sizeof paths / sizeof *paths };
    static char notes[SCENES][400];
    bench_say(r, "\nIndirect light of a frame whose G-buffer is there: milliseconds of one processor, frames "
                 "a second with one thread and with two, nanoseconds\n"
                 "and texture fetches a pixel that shows a surface.\n");
    bench_table(r, "frames", "scene|from|n|picture|ms|fps|fps, two|ns a pixel|fetches|/ first|paper");
    for (size_t i = 0; i < SCENES; i++) {
        char name[64];
        baked b = {0};
        double gbuffer[2];
        bench_scene_name(paths[i], name);
        if (!bench_wants(o, name) || (o->brief && i % 2 == 1)) continue;
        for (int which = 0; which < 2; which++) view_rows(r, o, name, paths[i], which, &b, &gbuffer[which]);
        snprintf(notes[i], sizeof notes[i], "%s G-buffer of %s: %.1f and %.1f ms.", b.text, name,
                 1e3 * gbuffer[0], 1e3 * gbuffer[1]);
        forget(&b);
    }
    for (size_t i = 0; i < SCENES; i++) {
        if (notes[i][0]) bench_say(r, "\n%s\n", notes[i]);
    }
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/light-octree");
    bench_report r;
    bench_report_open(&r, &o, "octree_frames");
    memory(&r, &o);
    all_frames(&r, &o);
    bench_report_close(&r);
    return 0;
}
