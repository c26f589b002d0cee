/* How far the light octree's indirect light is from the path tracer's on the same paths: over depth, lights,
 * photons and neighbours; with each remedy and without; and where the error comes from, by taking one
 * approximation after the other away, down to the photon map itself.
 *
 * Every picture is made from photons of two seeds, x and y: with A and B halves of the reference, mean
 * (x-A)(y-B) is what no number of such maps would average out (systematic), mean (x-y)^2 / 2 what would
 * (random). */
#include <math.h>
#include <string.h>

#include "base/math.h"
#include "octree_bench.h"

typedef struct trial {
    size_t leaves;
    double mib, systematic, random;
    bench_error error; /* of the first seed */
} trial;

/* ---- a trial ---- */

static void judge(const octree_world *w, trial *t) {
    const float *a = w->reference.half[0], *b = w->reference.half[1], *x = w->values[0], *y = w->values[1];
    size_t count = 3 * w->pixels.count;
    double both = 0.0, apart = 0.0, mean = 0.0;
    for (size_t i = 0; i < count; i++) {
        double xa = (double)x[i] - (double)a[i], xb = (double)x[i] - (double)b[i],
               ya = (double)y[i] - (double)a[i], yb = (double)y[i] - (double)b[i];
        both += 0.5 * (xa * yb + xb * ya);
        apart += 0.5 * (xa - ya) * (xa - ya);
        mean += 0.5 * ((double)a[i] + (double)b[i]);
    }
    t->error = bench_compare(x, &w->reference, NULL);
    t->systematic = mean > 0.0 ? sqrt(fmax(0.0, both) * (double)count) / mean : 0.0;
    t->random = mean > 0.0 ? sqrt(apart * (double)count) / mean : 0.0;
}

static trial try(const bench_report *r, octree_world *w, const sl_light_octree_settings *settings,
                 const char *picture) {
    trial t = {0};
    sl_octree *octree = octree_world_octree(w, settings->depth);
    for (int seed = 0; seed < OCTREE_SEEDS; seed++) {
        const sl_photon_tree *tree = octree_world_photons(w, settings, seed);
        t.mib = octree_world_picture(w, octree, tree, settings, 2, w->values[seed]).mib;
        if (picture && seed == 0) octree_view_write(&w->view, r, w->name, picture);
    }
    t.leaves = octree->leaf_count;
    judge(w, &t);
    return t;
}

static trial try_direct(octree_world *w, const sl_light_octree_settings *settings, octree_place place) {
    trial t = {0};
    for (int seed = 0; seed < OCTREE_SEEDS; seed++)
        octree_direct(&w->view, &w->pixels, octree_world_octree(w, settings->depth),
                      octree_world_photons(w, settings, seed), settings, place, w->values[seed]);
    judge(w, &t);
    return t;
}

static const char header[] = "scene|what|leaves|MiB|relRMSE %|systematic %|random %|bias %|relMSE|trimmed";

static void row(bench_report *r, const octree_world *w, const char *what, const trial *t) {
    char size[64] = "|", text[32];
    if (t->leaves) snprintf(size, sizeof size, "%zu|%.2f", t->leaves, t->mib);
    bench_row(r, "%s|%s|%s|%.2f|%.2f|%.2f|%+.2f|%s|%.2e", w->name, what, size, 100.0 * t->error.rel_rmse,
              100.0 * t->systematic, 100.0 * t->random, 100.0 * t->error.bias,
              bench_mse_text(&t->error, text), t->error.trimmed);
}

static sl_light_octree_settings base(const bench_options *o) {
    sl_light_octree_settings s = octree_settings();
    if (o->brief) s.photons = 150000, s.depth = 5;
    return s;
}

/* ---- over depth, lights, photons and neighbours ---- */

static void sweeps(bench_report *r, const bench_options *o, octree_world *w) {
    static const int lights[] = {1, 2, 3, 4, 6, 8}, neighbours[] = {50, 100, 300, 500};
    static const uint64_t photons[] = {150000, 300000, 600000, 1200000, 2400000};
    sl_light_octree_settings s;
    char what[64];
    int step = o->brief ? 2 : 1;
    for (int depth = 3; depth <= base(o).depth + 1; depth++) {
        s = base(o);
        s.depth = depth;
        trial t = try(r, w, &s, NULL);
        snprintf(what, sizeof what, "depth %d", depth);
        row(r, w, what, &t);
    }
    for (int i = 0; i < 6; i += step) {
        s = base(o);
        s.lights = lights[i];
        trial t = try(r, w, &s, NULL);
        snprintf(what, sizeof what, "n = %d", lights[i]);
        row(r, w, what, &t);
    }
    for (int i = 0; i < (o->brief ? 3 : 5); i += step) {
        s = base(o);
        s.photons = photons[i];
        trial t = try(r, w, &s, NULL);
        snprintf(what, sizeof what, "%u thousand photons", (unsigned)(photons[i] / 1000));
        row(r, w, what, &t);
    }
    for (int i = 0; i < 4; i += step) {
        s = base(o);
        s.neighbours = neighbours[i];
        trial t = try(r, w, &s, NULL);
        snprintf(what, sizeof what, "k = %d", neighbours[i]);
        row(r, w, what, &t);
    }
}

/* ---- remedies and choices, one at a time ---- */

typedef struct choice {
    const char *name, *picture;
    void (*set)(sl_light_octree_settings *s);
} choice;

static void none(sl_light_octree_settings *s) { (void)s; }
static void disc(sl_light_octree_settings *s) { s->area = SL_PHOTON_AREA_DISC; }
static void section(sl_light_octree_settings *s) { s->area = SL_PHOTON_AREA_SECTION; }
static void accept_all(sl_light_octree_settings *s) { s->acceptance = SL_PI; }
static void whole(sl_light_octree_settings *s) { s->whole_voxels = true, s->acceptance = SL_PI / 3.0; }
static void paper(sl_light_octree_settings *s) {
    s->whole_voxels = s->fixed_neighbours = true;
    s->area = SL_PHOTON_AREA_DISC;
    s->acceptance = SL_PI;
    s->unit_weights = true;
}
static void sphere(sl_light_octree_settings *s) { s->flatness = 1.0; }
static void nearest(sl_light_octree_settings *s) { s->filter = SL_VOXEL_NEAREST; }
static void void_dark(sl_light_octree_settings *s) { s->keep_void_dark = true; }
static void unit(sl_light_octree_settings *s) { s->unit_weights = true; }
static void exactly_k(sl_light_octree_settings *s) { s->fixed_neighbours = true; }
static void own(sl_light_octree_settings *s) { s->own_photons = true; }
static void sixty(sl_light_octree_settings *s) { s->acceptance = SL_PI / 3.0; }
static void colour(sl_light_octree_settings *s) { s->lobes = SL_LOBES_NONE; }
static void surface(sl_light_octree_settings *s) { s->lobes = SL_LOBES_SURFACE; }
static void eight(sl_light_octree_settings *s) { s->lights = 8; }

static const choice choices[] = {
    {"default", "octree", none},
    {"the paper's: whole voxels, disc, all photons, equal weights", "paper", paper},
    {"area of a disc", "disc", disc},
    {"area of a section", NULL, section},
    {"photons of all normals", "accept-all", accept_all},
    {"sphere, f = 1", NULL, sphere},
    {"one set of lights a voxel", "whole", whole},
    {"k photons, not k/4 to k", NULL, exactly_k},
    {"photons within 60 degrees", NULL, sixty},
    {"each voxel's own photons", "own", own},
    {"nearest voxel", "nearest", nearest},
    {"void is dark", "void-dark", void_dark},
    {"equal weights", NULL, unit},
    {"one irradiance", "colour", colour},
    {"irradiance on the surface", "surface", surface},
    {"8 lights", NULL, eight},
};

static void remedies(bench_report *r, const bench_options *o, octree_world *w) {
    for (size_t i = 0; i < sizeof choices / sizeof *choices; i++) {
        sl_light_octree_settings s = base(o);
        choices[i].set(&s);
        trial t = try(r, w, &s, o->pictures ? choices[i].picture : NULL);
        row(r, w, choices[i].name, &t);
    }
}

/* ---- where it comes from ---- */

static void ladder(bench_report *r, const bench_options *o, octree_world *w) {
    sl_light_octree_settings s = base(o);
    s.photons *= 4;
    trial t = try_direct(w, &s, OCTREE_AT_PIXEL);
    row(r, w, "photons at pixels, 4 times as many", &t);
    s = base(o);
    whole(&s);
    s.fixed_neighbours = true;
    t = try_direct(w, &s, OCTREE_AT_PIXEL);
    row(r, w, "photons at pixels: density", &t);
    t = try_direct(w, &s, OCTREE_AT_VOXEL);
    row(r, w, "+ gathered at voxels", &t);
    s.filter = SL_VOXEL_NEAREST;
    t = try(r, w, &s, NULL);
    row(r, w, "+ 4 clusters of 8 + 8 bits", &t);
    s.filter = SL_VOXEL_TRILINEAR;
    t = try(r, w, &s, NULL);
    row(r, w, "+ trilinear: one set of lights a voxel", &t);
    s = base(o);
    t = try(r, w, &s, NULL);
    row(r, w, "- split by normals, k/4 to k photons: the default", &t);
    s.whole_voxels = s.fixed_neighbours = true;
    s.area = SL_PHOTON_AREA_DISC;
    s.acceptance = SL_PI;
    t = try(r, w, &s, NULL);
    row(r, w, "one set of lights, disc, photons of all normals", &t);
    t = try_direct(w, &s, OCTREE_AT_PIXEL);
    row(r, w, "that bleeding alone, at pixels", &t);
}

/* ---- the experiment ---- */

static void experiment(bench_report *r, const bench_options *o, const char *path) {
    static octree_world w;
    char table[80];
    if (!octree_world_open(r, o, path, &w)) return;
    sl_light_octree_settings s = base(o);
    bench_say(r,
              "\n%s, %d x %d, %zu pixels, %u reference samples; where nothing else is said depth %d, %u "
              "thousand photons, k = %d, n = %d\n",
              w.name, w.pixels.width, w.pixels.height, w.pixels.count, w.reference.samples, s.depth,
              (unsigned)(s.photons / 1000), s.neighbours, s.lights);
    snprintf(table, sizeof table, "%s-remedies", w.name);
    bench_table(r, table, header);
    remedies(r, o, &w);
    bench_say(r, "\nwhere it comes from, with one approximation after the other:\n");
    snprintf(table, sizeof table, "%s-parts", w.name);
    bench_table(r, table, header);
    ladder(r, o, &w);
    if (!o->once || o->brief || strcmp(w.name, "cornell") == 0) {
        bench_say(r, "\nover depth, lights, photons, neighbours:\n");
        snprintf(table, sizeof table, "%s-sweeps", w.name);
        bench_table(r, table, header);
        sweeps(r, o, &w);
    }
    octree_world_close(&w);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/light-octree");
    bench_report r;
    bench_report_open(&r, &o, "octree_error");
    experiment(&r, &o, "scenes/cornell.json");
    experiment(&r, &o, "scenes/generated/room.json");
    if (!o.brief || o.only) {
        experiment(&r, &o, "scenes/generated/atrium.json");
        experiment(&r, &o, "scenes/generated/cathedral.json");
        experiment(&r, &o, "scenes/generated/figure.json");
        experiment(&r, &o, "scenes/mirror-balls.json");
    }
    bench_report_close(&r);
    return 0;
}
