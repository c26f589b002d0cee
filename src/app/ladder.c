/* draft, normal and high are steps of every ladder; others stand between them, and above. Each trades time
 * for error along the settings that bound it: records and the samples of their gathers, photons and the
 * voxels that hold them, the size of mesh triangles; and always enough light samples that direct light is not
 * what is left. Costs: what these settings take in the Cornell box and in the atrium (splatting's draft,
 * normal and high are 1, 3.6 and 18 there), and their counts where nothing was measured. */
#include "app/ladder.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DRAFT SL_QUALITY_DRAFT
#define NORMAL SL_QUALITY_NORMAL
#define HIGH SL_QUALITY_HIGH

static const sl_ladder_step steps[] = {
    {"splatting", DRAFT, true, 1.0, "accuracy=0.5 glossy-accuracy=0.3 gather-size=20 spp=8"},
    {"splatting", DRAFT, false, 2.0, "accuracy=0.35 glossy-accuracy=0.25 gather-size=26 spp=12"},
    {"splatting", NORMAL, true, 4.0, "accuracy=0.25 glossy-accuracy=0.2 gather-size=32 spp=16"},
    {"splatting", HIGH, false, 9.0, "accuracy=0.17 glossy-accuracy=0.15 gather-size=42 spp=32"},
    {"splatting", HIGH, true, 20.0, "accuracy=0.12 glossy-accuracy=0.12 gather-size=52 spp=64"},
    {"splatting", HIGH, false, 60.0, "accuracy=0.085 glossy-accuracy=0.1 gather-size=72 spp=128"},
    {"splatting", HIGH, false, 180.0, "accuracy=0.06 glossy-accuracy=0.085 gather-size=100 spp=256"},
    {"splatting", HIGH, false, 600.0, "accuracy=0.04 glossy-accuracy=0.07 gather-size=144 spp=512"},
    {"light-octree", DRAFT, true, 1.0, "depth=5 stored-photons=150000 neighbours=150 spp=8"},
    {"light-octree", DRAFT, false, 2.0, "depth=5 stored-photons=300000 neighbours=200 spp=12"},
    {"light-octree", NORMAL, true, 3.0, "depth=5 stored-photons=600000 neighbours=300 spp=16"},
    {"light-octree", HIGH, true, 11.0, "depth=6 stored-photons=1200000 neighbours=500 spp=64"},
    {"light-octree", HIGH, false, 30.0, "depth=7 stored-photons=3000000 neighbours=700 spp=128"},
    {"light-octree", HIGH, false, 80.0, "depth=7 stored-photons=8000000 neighbours=1000 spp=256"},
    {"light-octree", HIGH, false, 220.0, "depth=7 stored-photons=20000000 neighbours=1600 spp=512"},
    {"direct-radiance", DRAFT, true, 1.0, "photons=3 emitter-samples=1 shadow-size=512"},
    {"direct-radiance", NORMAL, true, 2.0, "photons=6 emitter-samples=2 shadow-size=512"},
    {"direct-radiance", HIGH, true, 10.0, "photons=8 emitter-samples=2 shadow-size=512"},
    {"direct-radiance", HIGH, false, 40.0, "photons=8 emitter-samples=4 shadow-size=1024"},
    {"direct-radiance", HIGH, false, 200.0, "photons=12 emitter-samples=6 shadow-size=1024"},
    {"direct-radiance", HIGH, false, 1000.0, "photons=16 emitter-samples=10 shadow-size=1024"},
    {"multi-mesh", DRAFT, true, 1.0,
     "threshold=2 leaf-area=256 leaf-edge=32 gather-size=64 coarse-depth=3 light-size=64"},
    {"multi-mesh", NORMAL, false, 2.0,
     "threshold=1.4 leaf-area=128 leaf-edge=22 gather-size=64 coarse-depth=4 light-size=64"},
    {"multi-mesh", NORMAL, true, 3.0,
     "threshold=1 leaf-area=64 leaf-edge=16 gather-size=64 coarse-depth=4 light-size=64"},
    {"multi-mesh", NORMAL, false, 6.0,
     "threshold=0.7 leaf-area=32 leaf-edge=11 gather-size=64 coarse-depth=4 light-size=64"},
    {"multi-mesh", HIGH, true, 16.0,
     "threshold=0.5 leaf-area=16 leaf-edge=8 gather-size=128 coarse-depth=5 light-size=64"},
    {"multi-mesh", HIGH, false, 40.0,
     "threshold=0.25 leaf-area=8 leaf-edge=6 gather-size=128 coarse-depth=5 light-size=128"},
    {"multi-mesh", HIGH, false, 200.0,
     "threshold=0.1 leaf-area=2 leaf-edge=2 gather-size=256 coarse-depth=6 light-size=256"},
    {"shading-cache", DRAFT, true, 1.0, "indirect-samples=100 area-samples=64 points-a-pixel=0.03"},
    {"shading-cache", NORMAL, false, 4.0, "indirect-samples=200 area-samples=64 points-a-pixel=0.06"},
    {"shading-cache", NORMAL, true, 16.0, "indirect-samples=400 area-samples=64 points-a-pixel=0.12"},
    {"shading-cache", HIGH, false, 60.0, "indirect-samples=700 area-samples=128 points-a-pixel=0.25"},
    {"shading-cache", HIGH, true, 200.0, "indirect-samples=1200 area-samples=256 points-a-pixel=0.5"},
    {"shading-cache", HIGH, false, 1300.0, "indirect-samples=4000 area-samples=512 points-a-pixel=1"},
};
enum { STEPS = sizeof steps / sizeof steps[0] };

sl_ladder sl_ladder_of(const char *method) {
    sl_ladder ladder = {steps, 0};
    while (ladder.step < steps + STEPS && strcmp(ladder.step->method, method) != 0) ladder.step++;
    const sl_ladder_step *end = ladder.step;
    while (end < steps + STEPS && strcmp(end->method, method) == 0) end++;
    ladder.count = (unsigned)(end - ladder.step);
    return ladder;
}

/* Takes so many updates that points come to that share of the pixels. */
static void take_updates(sl_settings *s, double points_a_pixel) {
    enum { POINTS = 64 }; /* of an update, where nothing else was asked for */
    sl_shading_cache_settings *c = &s->shading_cache;
    double points = points_a_pixel * (double)s->width * (double)s->height;
    if (s->width > 0 && !c->updates) c->updates = 1u + (uint32_t)(points / (c->points ? c->points : POINTS));
}

/* Takes NAME=VALUE, where the settings leave it open. */
static void take(sl_settings *s, char *word) {
    char *value = strchr(word, '='), asked[64];
    *value++ = '\0';
    if (strcmp(word, "points-a-pixel") == 0) take_updates(s, strtod(value, NULL));
    else if (sl_settings_get(s, word, asked, sizeof asked, NULL) == SL_OK && strcmp(asked, "0") == 0)
        (void)sl_settings_set(s, word, value, NULL);
}

sl_settings sl_ladder_settings(const sl_settings *asked, const sl_ladder_step *of) {
    sl_settings s = *asked;
    char text[128], *rest = NULL;
    s.quality = of->quality;
    snprintf(text, sizeof text, "%s", of->settings);
    for (char *w = strtok_r(text, " ", &rest); w; w = strtok_r(NULL, " ", &rest)) take(&s, w);
    return s;
}

unsigned sl_ladder_refines_all_from(const char *method) {
    return method && strcmp(method, "multi-mesh") == 0 ? 5 : 3;
}

/* Weights: seconds that the methods take at draft, normal and high quality in the Cornell box, two rooms and
 * a room with a window, against the half microsecond of a ray of the path tracer. Right within a factor of
 * two. */
double sl_effort_in_rays(const sl_counters *c) {
    static const struct { sl_counter counter; double rays; } weights[] = {
        {SL_COUNT_RAYS, 0.5},           {SL_COUNT_SHADOW_RAYS, 0.4},      {SL_COUNT_PHOTONS_STORED, 2.5},
        {SL_COUNT_PHOTONS_GATHERED, 0.3}, {SL_COUNT_PHOTON_LOOK_UPS, 0.02}, {SL_COUNT_FRAGMENTS_SHADED, 0.02},
    };
    double rays = 0.0;
    for (size_t i = 0; i < sizeof weights / sizeof weights[0]; i++)
        rays += weights[i].rays * (double)c->value[weights[i].counter];
    return rays;
}
