/* Preprocessing time of the light octree, part by part: over depth and triangles (Fig. 13), over neighbours
 * and photons (Fig. 14), over lights a voxel with the spread of their clusters (Fig. 17), and what two
 * threads do. Scenes are the generated ones; the paper's Boxes, Bunny and Dragon stand beside those of about
 * as many triangles. Trends are to be compared, not seconds: its machine had four 2 GHz cores. */
#include <math.h>
#include <stdlib.h>

#include "octree_bench.h"

enum { EMBREE, PHOTONS, TREE, VOXELS, LIGHTS, PACK, PARTS };
static const double degrees = 57.29577951308232;

typedef struct world {
    char name[64];
    sl_scene *scene;
    sl_tracer *tracer;
    size_t triangles;
} world;

static bool open_world(bench_report *r, const bench_options *o, const char *path, world *w) {
    sl_error error;
    bench_scene_name(path, w->name);
    if (!bench_wants(o, w->name) || !bench_open_scene(r, path, &w->scene)) return false;
    if (sl_tracer_create(w->scene, 2, NULL, &w->tracer, &error) != SL_OK) bench_fail("tracer", &error);
    w->triangles = sl_scene_triangle_count(w->scene);
    return true;
}

static void close_world(world *w) {
    sl_tracer_destroy(w->tracer);
    sl_scene_destroy(w->scene);
}

/* All parts, once. */
static void prepare(const world *w, const sl_light_octree_settings *settings, unsigned threads,
                    double seconds[PARTS], size_t *leaves) {
    sl_tracer *tracer;
    sl_error error;
    sl_counters counters = {{0}};
    octree_light light;
    double from = octree_seconds(threads);
    if (sl_tracer_create(w->scene, threads, NULL, &tracer, &error) != SL_OK) bench_fail("tracer", &error);
    seconds[EMBREE] = octree_seconds(threads) - from;
    sl_photon_tree *tree =
        octree_photons(w->scene, tracer, settings, 0, threads, &seconds[PHOTONS], &counters);
    sl_octree *octree = octree_voxels(w->scene, settings->depth, threads, &seconds[VOXELS]);
    octree_light_voxels(w->scene, octree, tree, settings, threads, &light);
    seconds[LIGHTS] = light.seconds[0];
    seconds[PACK] = light.seconds[1];
    *leaves = octree->leaf_count;
    octree_light_free(&light);
    sl_octree_destroy(octree);
    sl_photon_tree_destroy(tree);
    sl_tracer_destroy(tracer);
}

static double sum(const double *values, int count) {
    double all = 0.0;
    for (int i = 0; i < count; i++) all += values[i];
    return all;
}

static int by_value(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* ---- depth and triangles: Fig. 13 ---- */

enum { POINTS = 64 };
typedef struct line {
    int count;
    double x[POINTS], y[POINTS];
} line;

static void fit(const line *l, double *a, double *b, double *r2) {
    double n = l->count, sx = sum(l->x, l->count), sy = sum(l->y, l->count), sxx = 0.0, sxy = 0.0, syy = 0.0;
    for (int i = 0; i < l->count; i++) {
        sxx += (l->x[i] - sx / n) * (l->x[i] - sx / n);
        sxy += (l->x[i] - sx / n) * (l->y[i] - sy / n);
        syy += (l->y[i] - sy / n) * (l->y[i] - sy / n);
    }
    *b = sxx > 0.0 ? sxy / sxx : 0.0;
    *a = (sy - *b * sx) / n;
    *r2 = sxx > 0.0 && syy > 0.0 ? sxy * sxy / (sxx * syy) : 0.0;
}

static const char *const depth_scenes[] = {
    "scenes/cornell.json",          "scenes/generated/room.json",      "scenes/generated/cave.json",
    "scenes/generated/atrium.json", "scenes/generated/cathedral.json", "scenes/generated/figure.json"};
static const char *const paper_scenes[] = {
    "Boxes, 50 triangles: 5 / 37 / 165 s", "",
    "Dragon, 200,000: 6 / 37 / 227 s",     "Bunny, 70,000: 8 / 40 / 161 s",
    "F355, 50,000: 1 / 10 / 80 s",         "Megane, 700,000: 15 / 76 / 337 s"};

static void depth_rows(bench_report *r, const bench_options *o, const world *w, const char *paper,
                       line *all) {
    sl_light_octree_settings settings = octree_settings();
    double seconds[PARTS], once[3];
    line own = {0};
    sl_counters counters = {{0}};
    if (o->brief) settings.photons = 150000;
    sl_photon_tree *tree = octree_photons(w->scene, w->tracer, &settings, 0, 1, &seconds[PHOTONS], &counters);
    for (int depth = 4; depth <= (o->brief ? 6 : 7); depth++) {
        octree_light light;
        sl_octree *octree = octree_voxels(w->scene, depth, 1, &seconds[VOXELS]);
        int runs = o->once || depth > 6 ? 1 : 3;
        for (int i = 0; i < runs; i++) {
            octree_light_voxels(w->scene, octree, tree, &settings, 1, &light);
            once[i] = light.seconds[0];
            seconds[PACK] = light.seconds[1];
            octree_light_free(&light);
        }
        qsort(once, (size_t)runs, sizeof *once, by_value);
        seconds[LIGHTS] = once[runs / 2];
        double leaves = (double)octree->leaf_count;
        bench_row(r, "%s|%zu|%d|%zu|%.2f|%.0f|%.2f|%.3f|%.3f|%.3f|%.1f|%s", w->name, w->triangles, depth,
                  octree->leaf_count, seconds[PHOTONS],
                  1e-3 * (double)counters.value[SL_COUNT_PHOTONS_EMITTED] / seconds[PHOTONS], seconds[TREE],
                  seconds[VOXELS], seconds[LIGHTS], seconds[PACK], 1e6 * seconds[LIGHTS] / leaves,
                  depth == 4 ? paper : "");
        own.x[own.count] = all->x[all->count] = leaves;
        own.y[own.count++] = all->y[all->count++] = seconds[LIGHTS];
        sl_octree_destroy(octree);
    }
    sl_photon_tree_destroy(tree);
}

static void depths(bench_report *r, const bench_options *o) {
    enum { SCENES = sizeof depth_scenes / sizeof *depth_scenes };
    static line all;
    char names[SCENES][64];
    int first[SCENES + 1] = {0}, scenes = 0;
    bench_say(r,
              "\nOver depth (Fig. 13): %s photons stored, k = 300, n = 4; processor seconds of one thread. "
              "*us / leaf* is gathers and clusters alone.\n",
              o->brief ? "150,000" : "600,000");
    bench_table(r, "depth",
                "scene|triangles|depth|leaves|photons s|1000 paths / s|tree s|octree s|lights s|pack s|us / "
                "leaf|paper's (depth 4 / 5 / 6)");
    for (size_t i = 0; i < SCENES; i++) {
        world w;
        if (!open_world(r, o, depth_scenes[i], &w)) continue;
        depth_rows(r, o, &w, paper_scenes[i], &all);
        snprintf(names[scenes], sizeof names[scenes], "%s", w.name);
        first[++scenes] = all.count;
        close_world(&w);
    }
    bench_say(r, "\nSeconds of gathers and clusters as a + b leaves:\n");
    bench_table(r, "fit", "scene|a s|b us|R2");
    for (int i = 0; i <= scenes && all.count > 1; i++) {
        line part = {0};
        double a, b, r2;
        for (int k = i < scenes ? first[i] : 0; k < (i < scenes ? first[i + 1] : all.count); k++) {
            part.x[part.count] = all.x[k];
            part.y[part.count++] = all.y[k];
        }
        fit(&part, &a, &b, &r2);
        bench_row(r, "%s|%.3f|%.1f|%.4f", i < scenes ? names[i] : "all", a, 1e6 * b, r2);
    }
}

/* ---- triangles alone: other scenes are also of other shapes ---- */

/* The same surfaces and photons: nothing but the triangles differs. */
static void triangles(bench_report *r, const bench_options *o, const char *path, int times) {
    sl_light_octree_settings settings = octree_settings();
    sl_counters counters = {{0}};
    double spent[2], first = 0.0, most = 0.0;
    world w;
    if (!open_world(r, o, path, &w)) return;
    sl_photon_tree *tree = octree_photons(w.scene, w.tracer, &settings, 0, 1, spent, &counters);
    bench_say(r,
              "\nOver triangles, %s: each cut into four again and again, the same photons, depth %d; "
              "processor seconds of one thread.\n",
              w.name, settings.depth);
    bench_table(r, "triangles", "scene|triangles|leaves|sets|octree s|lights s|us / leaf|/ first");
    for (int cut = 0; cut <= (o->brief && times > 2 ? 2 : times); cut++) {
        sl_scene *scene = octree_cut_scene(w.scene, cut);
        double octree_s, best = INFINITY;
        sl_octree *octree = octree_voxels(scene, settings.depth, 1, &octree_s);
        octree_light light;
        size_t sets = 0;
        for (int i = 0; i < (o->once ? 1 : 3); i++) {
            octree_light_voxels(scene, octree, tree, &settings, 1, &light);
            best = fmin(best, light.seconds[0]);
            sets = light.lights->set_count;
            octree_light_free(&light);
        }
        double a_leaf = 1e6 * best / (double)octree->leaf_count;
        if (cut == 0) first = a_leaf;
        most = fmax(most, a_leaf / first);
        bench_row(r, "%s|%zu|%zu|%zu|%.3f|%.3f|%.1f|%.2f", w.name, scene->triangle_count, octree->leaf_count,
                  sets, octree_s, best, a_leaf, a_leaf / first);
        sl_octree_destroy(octree);
        sl_scene_destroy(scene);
    }
    bench_say(r, "\n%s: a leaf takes at most %.2f times what it takes with the fewest triangles, %s 1.3.\n",
              w.name, most, most <= 1.3 ? "within" : "ABOVE");
    sl_photon_tree_destroy(tree);
    close_world(&w);
}

/* ---- neighbours and photons: Fig. 14 ---- */

enum { KS = 4, MAPS = 4 };
static const int ks[KS] = {50, 100, 250, 500};
static const uint64_t maps[MAPS] = {150000, 300000, 600000, 1200000};
static const int paper_gather[KS][MAPS] = {{4, 5, 6, 6}, {6, 7, 10, 14}, {16, 21, 20, 29}, {33, 44, 44, 47}};

static void gathers(bench_report *r, const bench_options *o, const char *path) {
    double seconds[KS][MAPS], spent[2], unused;
    int map_count = o->brief ? 2 : MAPS;
    world w;
    if (!open_world(r, o, path, &w)) return;
    sl_octree *octree = octree_voxels(w.scene, 5, 1, &unused);
    for (int m = 0; m < map_count; m++) {
        sl_light_octree_settings settings = octree_settings();
        sl_counters counters = {{0}};
        settings.photons = maps[m];
        sl_photon_tree *tree = octree_photons(w.scene, w.tracer, &settings, 0, 2, spent, &counters);
        for (int k = 0; k < KS; k++) {
            octree_light light;
            settings.neighbours = ks[k];
            settings.lobes = SL_LOBES_NONE; /* nothing is clustered */
            octree_light_voxels(w.scene, octree, tree, &settings, 1, &light);
            seconds[k][m] = light.seconds[0];
            octree_light_free(&light);
        }
        sl_photon_tree_destroy(tree);
    }
    bench_say(r,
              "\nOver neighbours and photons (Fig. 14), %s, depth 5, %zu leaves: gathers alone, processor "
              "seconds of one thread; in brackets the paper's (Dragon).\n",
              w.name, octree->leaf_count);
    bench_table(r, "gather",
                map_count == MAPS ? "k|150,000|300,000|600,000|1,200,000|last / first|paper"
                                  : "k|150,000|300,000|last / first|paper");
    for (int k = 0; k < KS; k++) {
        char text[256];
        int at = snprintf(text, sizeof text, "%d", ks[k]);
        for (int m = 0; m < map_count; m++)
            at += snprintf(text + at, sizeof text - (size_t)at, "|%.3f (%d)", seconds[k][m],
                           paper_gather[k][m]);
        snprintf(text + at, sizeof text - (size_t)at, "|%.2f|%.2f", seconds[k][map_count - 1] / seconds[k][0],
                 (double)paper_gather[k][map_count - 1] / paper_gather[k][0]);
        bench_row(r, "%s", text);
    }
    bench_say(r, "\nTen times the neighbours take %.1f to %.1f times as long (paper: 7.3 to 8.8).\n",
              fmin(seconds[3][0] / seconds[0][0], seconds[3][map_count - 1] / seconds[0][map_count - 1]),
              fmax(seconds[3][0] / seconds[0][0], seconds[3][map_count - 1] / seconds[0][map_count - 1]));
    sl_octree_destroy(octree);
    close_world(&w);
}

/* ---- lights a voxel: Fig. 17 ---- */

enum { NS = 6 };
static const int ns[NS] = {1, 2, 3, 4, 6, 8};
static const int paper_seconds[NS] = {58, 85, 97, 108, 132, 150};
static const double paper_spread[NS] = {30.0, 25.0, 22.5, 20.0, 15.0, 10.0},
                    law_spread[NS] = {47.1, 35.5, 28.9, 25.1, 20.9, 18.0};

static void clusters(bench_report *r, const bench_options *o, const char *path) {
    sl_light_octree_settings settings = octree_settings();
    sl_counters counters = {{0}};
    double spent[2], unused, none, before = INFINITY;
    bool falls = true;
    world w;
    if (!open_world(r, o, path, &w)) return;
    if (o->brief) settings.photons = 150000, settings.depth = 5;
    sl_photon_tree *tree = octree_photons(w.scene, w.tracer, &settings, 0, 2, spent, &counters);
    sl_octree *octree = octree_voxels(w.scene, settings.depth, 1, &unused);
    octree_light light;
    settings.lobes = SL_LOBES_NONE;
    octree_light_voxels(w.scene, octree, tree, &settings, 1, &light);
    none = light.seconds[0];
    octree_light_free(&light);
    settings.lobes = SL_LOBES_PERPENDICULAR;
    bench_say(r,
              "\nOver lights a voxel (Fig. 17), %s, depth %d, %zu leaves, k = 300: processor seconds of one "
              "thread, gathers alone %.3f. Spread: of the photons\n"
              "about their cluster's direction, by their weights, which are larger for grazing light; *w = "
              "1*: with equal weights, as in *law*: that of\n"
              "300 photons after the cosine law, rms.\n",
              w.name, settings.depth, octree->leaf_count, none);
    bench_table(r, w.name,
                "n|s|clusters s|/ gathers|paper s|rms deg|per axis|rms, w = 1|per axis|law|paper deg");
    for (int i = 0; i < NS; i++) {
        sl_voxel_statistics s, u;
        settings.lights = ns[i];
        octree_light_voxels(w.scene, octree, tree, &settings, 1, &light);
        sl_voxel_lights_statistics(light.lights, octree, &s);
        double time = light.seconds[0];
        octree_light_free(&light);
        settings.unit_weights = true;
        octree_light_voxels(w.scene, octree, tree, &settings, 1, &light);
        sl_voxel_lights_statistics(light.lights, octree, &u);
        octree_light_free(&light);
        settings.unit_weights = false;
        bench_row(r, "%d|%.3f|%.3f|%.2f|%d|%.1f|%.1f|%.1f|%.1f|%.1f|%.1f", ns[i], time, time - none,
                  time / none, paper_seconds[i], degrees * s.rms_angle, degrees * s.axis_angle,
                  degrees * u.rms_angle, degrees * u.axis_angle, law_spread[i],
                  paper_spread[i]);
        falls = falls && s.rms_angle < before;
        before = s.rms_angle;
    }
    bench_say(r, "\n%s: the spread %s with every light more.\n", w.name, falls ? "falls" : "DOES NOT FALL");
    sl_octree_destroy(octree);
    sl_photon_tree_destroy(tree);
    close_world(&w);
}

/* ---- threads ---- */

static const char *const part_names[PARTS] = {"Embree's hierarchy",   "photons", "photon tree", "octree",
                                              "gathers and clusters", "textures"};

static void threads(bench_report *r, const bench_options *o, const char *path) {
    sl_light_octree_settings settings = octree_settings();
    double times[2][PARTS + 1][3], one[PARTS], two[PARTS];
    size_t leaves = 0;
    int runs = o->once ? 1 : 3;
    world w;
    if (!open_world(r, o, path, &w)) return;
    if (o->brief) settings.photons = 150000;
    for (int i = 0; i < runs; i++) { /* in turn: whatever else the machine does hits both */
        double cpu = 0.0;
        prepare(&w, &settings, 1, one, &leaves);
        prepare(&w, &settings, 2, two, &leaves);
        for (int p = 0; p < PARTS; p++) {
            times[0][p][i] = one[p];
            times[1][p][i] = two[p];
            cpu += one[p];
        }
        times[0][PARTS][i] = cpu;
        times[1][PARTS][i] = sum(two, PARTS);
    }
    for (int t = 0; t < 2; t++) {
        for (int p = 0; p <= PARTS; p++) qsort(times[t][p], (size_t)runs, sizeof(double), by_value);
    }
    bench_say(r,
              "\n%s, %zu triangles, %llu photons stored, depth %d, %zu leaves: processor seconds of one "
              "thread, seconds by a clock of two (the paper\n"
              "names 161 s on four cores for 70,000 triangles)\n",
              w.name, w.triangles, (unsigned long long)settings.photons, settings.depth, leaves);
    char table[80];
    snprintf(table, sizeof table, "threads-%s", w.name);
    bench_table(r, table, "part|one thread s|two, clock s|ratio");
    for (int p = 0; p <= PARTS; p++) {
        double a = times[0][p][runs / 2], b = times[1][p][runs / 2];
        bench_row(r, "%s|%.3f|%.3f|%.2f", p < PARTS ? part_names[p] : "all", a, b, b > 0.0 ? a / b : 0.0);
    }
    double all = times[1][PARTS][runs / 2], ratio = times[0][PARTS][runs / 2] / all;
    bench_say(r, "\n%s: %.2f s, %s 5 s; two threads %.2f times one, %s 1.7\n", w.name, all,
              all < 5.0 ? "below" : "ABOVE", ratio, ratio >= 1.7 ? "at least" : "BELOW");
    close_world(&w);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/light-octree");
    bench_report r;
    bench_report_open(&r, &o, "octree_time");
    threads(&r, &o, "scenes/generated/atrium.json");
    threads(&r, &o, "scenes/generated/cathedral.json");
    depths(&r, &o);
    triangles(&r, &o, "scenes/cornell.json", 7);
    triangles(&r, &o, "scenes/generated/room.json", 3);
    gathers(&r, &o, "scenes/generated/cave.json");
    clusters(&r, &o, "scenes/generated/room.json");
    clusters(&r, &o, "scenes/generated/atrium.json");
    bench_report_close(&r);
    return 0;
}
