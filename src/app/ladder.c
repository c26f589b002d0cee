/* draft, normal and high are steps of every ladder; others stand between them, and above. Each trades time
 * for error along the settings that bound it: records and the samples of their gathers, photons and the
 * voxels that hold them, the size of mesh triangles; and always enough light samples that direct light is not
 * what is left. Costs: what these settings take in the Cornell box and in the atrium (splatting's draft,
 * normal and high are 1, 3.6 and 18 there), and their counts where nothing was measured. */
#include "app/ladder.h"

#include <string.h>

typedef struct splatting_step {
    sl_quality quality;
    double accuracy, glossy_accuracy;
    int gather_size;
    uint32_t light_samples;
    double cost;
} splatting_step;

static const splatting_step splatting[] = {
    {SL_QUALITY_DRAFT, 0.5, 0.3, 20, 8, 1.0},       {SL_QUALITY_DRAFT, 0.35, 0.25, 26, 12, 2.0},
    {SL_QUALITY_NORMAL, 0.25, 0.2, 32, 16, 4.0},    {SL_QUALITY_HIGH, 0.17, 0.15, 42, 32, 9.0},
    {SL_QUALITY_HIGH, 0.12, 0.12, 52, 64, 20.0},    {SL_QUALITY_HIGH, 0.085, 0.1, 72, 128, 60.0},
    {SL_QUALITY_HIGH, 0.06, 0.085, 100, 256, 180.0}, {SL_QUALITY_HIGH, 0.04, 0.07, 144, 512, 600.0},
};

typedef struct octree_step {
    sl_quality quality;
    int depth;
    uint64_t photons;
    int neighbours;
    uint32_t light_samples;
    double cost;
} octree_step;

static const octree_step octree[] = {
    {SL_QUALITY_DRAFT, 5, 150000, 150, 8, 1.0},     {SL_QUALITY_DRAFT, 5, 300000, 200, 12, 2.0},
    {SL_QUALITY_NORMAL, 5, 600000, 300, 16, 3.0},   {SL_QUALITY_HIGH, 6, 1200000, 500, 64, 11.0},
    {SL_QUALITY_HIGH, 7, 3000000, 700, 128, 30.0},  {SL_QUALITY_HIGH, 7, 8000000, 1000, 256, 80.0},
    {SL_QUALITY_HIGH, 7, 20000000, 1600, 512, 220.0},
};

typedef struct map_step {
    sl_quality quality;
    int samples, emitter_samples, shadow_size;
    double cost;
} map_step;

static const map_step map[] = {
    {SL_QUALITY_DRAFT, 3, 1, 512, 1.0},    {SL_QUALITY_NORMAL, 6, 2, 512, 2.0},
    {SL_QUALITY_HIGH, 8, 2, 512, 10.0},    {SL_QUALITY_HIGH, 8, 4, 1024, 40.0},
    {SL_QUALITY_HIGH, 12, 6, 1024, 200.0}, {SL_QUALITY_HIGH, 16, 10, 1024, 1000.0},
};

typedef struct mesh_step {
    sl_quality quality;
    double threshold_scale, leaf_area, leaf_edge;
    int gather_size, coarse_depth, light_size;
    double cost;
} mesh_step;

static const mesh_step mesh[] = {
    {SL_QUALITY_DRAFT, 2.0, 256.0, 32.0, 64, 3, 64, 1.0},
    {SL_QUALITY_NORMAL, 1.4, 128.0, 22.0, 64, 4, 64, 2.0},
    {SL_QUALITY_NORMAL, 1.0, 64.0, 16.0, 64, 4, 64, 3.0},
    {SL_QUALITY_NORMAL, 0.7, 32.0, 11.0, 64, 4, 64, 6.0},
    {SL_QUALITY_HIGH, 0.5, 16.0, 8.0, 128, 5, 64, 16.0},
    {SL_QUALITY_HIGH, 0.25, 8.0, 6.0, 128, 5, 128, 40.0},
    {SL_QUALITY_HIGH, 0.1, 2.0, 2.0, 256, 6, 256, 200.0},
};

typedef struct shading_step {
    sl_quality quality;
    double points_a_pixel;
    int indirect_samples, area_samples;
    double cost;
} shading_step;

static const shading_step shading[] = {
    {SL_QUALITY_DRAFT, 0.03, 100, 64, 1.0},   {SL_QUALITY_NORMAL, 0.06, 200, 64, 4.0},
    {SL_QUALITY_NORMAL, 0.12, 400, 64, 16.0}, {SL_QUALITY_HIGH, 0.25, 700, 128, 60.0},
    {SL_QUALITY_HIGH, 0.5, 1200, 256, 200.0}, {SL_QUALITY_HIGH, 1.0, 4000, 512, 1300.0},
};

#define RUNGS(table) ((unsigned)(sizeof(table) / sizeof(table)[0]))

/* ---- what was left open ---- */

static void take_int(int *asked, int step) { *asked = *asked ? *asked : step; }
static void take_real(double *asked, double step) { *asked = *asked > 0.0 ? *asked : step; }
static void take_count(uint32_t *asked, uint32_t step) { *asked = *asked ? *asked : step; }

static void take_splatting(sl_settings *s, const splatting_step *r) {
    s->quality = r->quality;
    take_real(&s->accuracy, r->accuracy);
    take_real(&s->glossy_accuracy, r->glossy_accuracy);
    take_int(&s->gather_size, r->gather_size);
    take_count(&s->spp, r->light_samples);
}

static void take_octree(sl_settings *s, const octree_step *r) {
    sl_light_octree_settings *o = &s->light_octree;
    s->quality = r->quality;
    take_int(&o->depth, r->depth);
    if (!o->photons) o->photons = r->photons;
    take_int(&o->neighbours, r->neighbours);
    take_count(&s->spp, r->light_samples);
}

static void take_map(sl_settings *s, const map_step *r) {
    sl_radiance_map_settings *m = &s->radiance_map;
    s->quality = r->quality;
    take_int(&m->samples, r->samples);
    take_int(&m->emitter_samples, r->emitter_samples);
    take_int(&m->shadow_size, r->shadow_size);
}

static void take_mesh(sl_settings *s, const mesh_step *r) {
    sl_multi_mesh_settings *m = &s->multi_mesh;
    s->quality = r->quality;
    take_real(&m->threshold_scale, r->threshold_scale);
    take_real(&m->leaf_area, r->leaf_area);
    take_real(&m->leaf_edge, r->leaf_edge);
    take_int(&s->gather_size, r->gather_size);
    take_int(&m->coarse_depth, r->coarse_depth);
    take_int(&m->light_size, r->light_size);
}

static void take_shading(sl_settings *s, const shading_step *r) {
    enum { POINTS = 64 }; /* of an update, where nothing else was asked for */
    sl_shading_cache_settings *c = &s->shading_cache;
    double points = r->points_a_pixel * (double)s->width * (double)s->height;
    s->quality = r->quality;
    take_int(&c->indirect_samples, r->indirect_samples);
    take_int(&c->area_samples, r->area_samples);
    if (s->width > 0) take_count(&c->updates, 1u + (uint32_t)(points / (c->points ? c->points : POINTS)));
}

/* ---- by a method's name ---- */

static bool is(const char *method, const char *name) { return method && strcmp(method, name) == 0; }

unsigned sl_ladder_steps(const char *method) {
    if (is(method, "splatting")) return RUNGS(splatting);
    if (is(method, "light-octree")) return RUNGS(octree);
    if (is(method, "direct-radiance")) return RUNGS(map);
    if (is(method, "multi-mesh")) return RUNGS(mesh);
    if (is(method, "shading-cache")) return RUNGS(shading);
    return 0;
}

unsigned sl_ladder_rung_of(const char *method, sl_quality quality) {
    static const unsigned usual[] = {0, 2, 4};
    if (is(method, "light-octree")) return quality == SL_QUALITY_HIGH ? 3 : usual[quality];
    return is(method, "direct-radiance") ? (unsigned)quality : usual[quality];
}

sl_settings sl_ladder_settings(const sl_settings *asked, unsigned step) {
    sl_settings s = *asked;
    const char *method = asked->method;
    if (step >= sl_ladder_steps(method)) return s;
    if (is(method, "splatting")) take_splatting(&s, &splatting[step]);
    if (is(method, "light-octree")) take_octree(&s, &octree[step]);
    if (is(method, "direct-radiance")) take_map(&s, &map[step]);
    if (is(method, "multi-mesh")) take_mesh(&s, &mesh[step]);
    if (is(method, "shading-cache")) take_shading(&s, &shading[step]);
    return s;
}

unsigned sl_ladder_refines_all_from(const char *method) { return is(method, "multi-mesh") ? 5 : 3; }

double sl_ladder_cost(const char *method, unsigned step) {
    if (step >= sl_ladder_steps(method)) return 1.0;
    if (is(method, "splatting")) return splatting[step].cost;
    if (is(method, "light-octree")) return octree[step].cost;
    if (is(method, "direct-radiance")) return map[step].cost;
    if (is(method, "multi-mesh")) return mesh[step].cost;
    return shading[step].cost;
}
