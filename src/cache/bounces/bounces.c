/* The second-level cache: where its records lie, what they answer, and how it follows the camera. */
#include "cache/bounces/second_level.h"

#include "base/batch.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

enum { ORIGINS = 1600, CHECKS = 64, QUICK_CHECKS = CHECKS / 2, CHECK_GENERATION = 100 };
/* Few look-ups of visible gathers shall miss the records; those of second-level gathers matter less, and
 * deeper generations of probes mostly look from corners into the same corners. */
enum { GENERATIONS = 2 };
static const double few_uncovered[GENERATIONS] = {0.015, 0.04};
/* Nor more records than that, of a place full of small things. */
static const size_t most_records[GENERATIONS] = {4000, 5000};
/* Of a fine picture far fewer look-ups may miss: nearly all light may come through a gap of a door. And where
 * light bounces often it does so between small things, and what records are off by comes back with every
 * bounce: there they lie nearer to each other, are found from so many times more origins, and may be so many
 * times more. */
enum { MANY_BOUNCES = 10, FINE_ORIGINS = 4, FINE_TIMES = 16 };
static const double finest_accuracy = 0.3, fine_radius = 0.4, fine_uncovered = 0.02;
/* So many more points out of all records' reach than where the cache was made: the camera sees more than it
 * did; or it has gone elsewhere. */
#define MANY_MISSED 0.01f
#define MOST_MISSED 0.1f
/* Where a view sees a little more: origins, and records that it may add and have gather again; few enough for
 * a frame, and fewer for one that somebody waits for. */
enum { MORE = 256, AGAIN = 32, QUICK_ORIGINS = ORIGINS / 8, QUICK_MORE = MORE / 4, QUICK_AGAIN = AGAIN / 4 };

sl_second_settings sl_second_settings_for(const sl_gather_settings *visible, double accuracy,
                                          uint32_t bounces) {
    sl_second_settings s = {.bounces = bounces,
                            .gather = *visible,
                            .aspect = 1.0f,
                            .seed = visible->seed,
                            .threads = 1,
                            .minimum_radius = 0.014};
    /* Twice as coarse, with a sixth of the rays: a visible gather takes the mean of thousands of look-ups. */
    double coarser = 2.0 * accuracy;
    s.accuracy = coarser < finest_accuracy ? finest_accuracy : coarser > 0.6 ? 0.6 : coarser;
    s.gather.kind = SL_GATHER_RAYS;
    s.gather.background = NULL; /* the sky lights what a gather sees by samples, as lamps do */
    s.gather.harmonics_order = 0;
    /* Each bounce brings the noise of the gathers back once more. */
    s.gather.size = visible->size / 5 * (bounces > MANY_BOUNCES ? 3 : 2);
    if (s.gather.size < 12) s.gather.size = 12;
    return s;
}

static void add_irradiance(const void *context, const sl_second_points *points, float *r, float *g, float *b,
                           bool *missed, sl_counters *counters) {
    const sl_second_cache *cache = context;
    uint64_t asked = 0;
    if (!cache->shines) return;
    for (size_t i = 0; i < points->count; i++) asked += points->triangle[i] != SL_NO_INDEX;
    sl_count(counters, SL_COUNT_SECOND_LEVEL_LOOK_UPS, asked);
    sl_count(counters, SL_COUNT_SECOND_LEVEL_MISSES,
             SL_KERNEL_OF(cache->isa, sl_look_up)(cache, points, (float *[3]){r, g, b}, NULL, missed));
}

/* ---- places ---- */

static sl_radius_rules radii_of(const sl_second_settings *s, const sl_scene *scene) {
    return (sl_radius_rules){.accuracy = s->accuracy,
                             .minimum_reach = s->minimum_radius * (double)sl_scene_central_diagonal(scene),
                             .maximum_radius = 0.1 * (double)scene->diagonal,
                             .guard = true,
                             .gather = SL_GATHER_RAYS,
                             .metric = SL_METRIC_HARMONIC};
}

static bool is_picture_fine(const sl_second_settings *s) {
    return s->accuracy <= finest_accuracy && !s->quick;
}

/* Covers what gathers at visible points (about so many origins) see, and what gathers there see, by about
 * `most` records. */
static sl_status find_places(sl_second_cache *cache, unsigned origins_wanted, size_t most,
                             sl_counters *counters, sl_error *error) {
    const sl_second_settings *s = &cache->settings;
    sl_probed origins;
    sl_status status =
        sl_probe_camera(cache->scene, cache->tracer, s, origins_wanted, &origins, counters, error);
    size_t start = cache->list.count, first = start; /* records of the last generation start here */
    for (size_t generation = 0; status == SL_OK && generation < GENERATIONS; generation++) {
        sl_probed seen;
        size_t before = cache->list.count;
        const size_t room = sl_fewer(most, most_records[generation] * (cache->fine ? FINE_TIMES : 1));
        const double few = few_uncovered[generation] * (is_picture_fine(s) ? fine_uncovered : 1.0);
        const sl_gather_point *from = generation == 0 ? origins.points : cache->list.points + first;
        size_t count = generation == 0 ? origins.count : cache->list.count - first;
        if (count == 0 || cache->list.count - start >= most) break;
        status = sl_probe_from(cache->scene, cache->tracer, s, from, count, origins_wanted, generation,
                               &seen, counters, error);
        if (status == SL_OK)
            status = sl_cover_points(cache, &seen, few, start + room, counters, error);
        sl_probed_free(&seen);
        first = before;
    }
    sl_probed_free(&origins);
    return status;
}

/* ---- the camera ---- */

typedef struct {
    const sl_second_cache *cache;
    const sl_gather_point *points;
} check;

/* Of the points that one origin sees. */
typedef struct {
    uint32_t asked, out_of_reach;
} checked;

static void check_origin(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    (void)worker, (void)counters;
    const check *c = context;
    const sl_gather_point *p = c->points + index * SL_PROBE_RAYS;
    checked of = {0, 0};
    for (size_t i = 0; i < SL_PROBE_RAYS; i++) {
        if (p[i].triangle == SL_NO_INDEX) continue;
        of.asked++;
        if (!(sl_second_weight(c->cache, &p[i]) > 0.0f)) of.out_of_reach++;
    }
    *(checked *)result = of;
}

/* A few points that gathers of this view will see, always the same ones: how many of them does no record
 * reach? */
static sl_status check_points(const sl_second_cache *cache, float *missed, sl_counters *counters,
                               sl_error *error) {
    const sl_second_settings *s = &cache->settings;
    const unsigned checks = s->quick ? QUICK_CHECKS : CHECKS;
    sl_probed origins, seen = {0};
    checked of[CHECKS], all = {0, 0};
    sl_status status = sl_probe_camera(cache->scene, cache->tracer, s, checks, &origins, counters, error);
    if (status == SL_OK)
        status = sl_probe_from(cache->scene, cache->tracer, s, origins.points, origins.count, checks,
                               CHECK_GENERATION, &seen, counters, error);
    check context = {cache, seen.points};
    const sl_batch batch = {.count = seen.count / SL_PROBE_RAYS, .work = check_origin, .context = &context,
                            .results = of, .result_bytes = sizeof *of};
    if (status == SL_OK) sl_batch_run(&batch, s->threads, counters);
    for (size_t i = 0; status == SL_OK && i < batch.count; i++)
        all.asked += of[i].asked, all.out_of_reach += of[i].out_of_reach;
    if (status == SL_OK) *missed = all.asked ? (float)all.out_of_reach / (float)all.asked : 0.0f;
    sl_probed_free(&origins);
    sl_probed_free(&seen);
    return status;
}

/* ---- its life ---- */

/* Tells whether light bounces between so many small things that records of a fine picture are to be finer. */
static bool is_too_coarse(const sl_second_cache *cache) {
    const sl_second_settings *s = &cache->settings;
    return is_picture_fine(s) && s->bounces > MANY_BOUNCES && cache->list.count >= most_records[0];
}

static sl_status find_finer_places(sl_second_cache *cache, sl_counters *counters, sl_error *error) {
    sl_second_list_free(&cache->list);
    sl_record_octree_free(&cache->octree);
    cache->fine = true;
    cache->radii.minimum_reach *= fine_radius;
    return find_places(cache, FINE_ORIGINS * ORIGINS, SIZE_MAX, counters, error);
}

/* Gathers live as long as light bounces. */
static sl_status make_records(sl_second_cache *cache, sl_counters *counters, sl_error *error) {
    sl_status status = sl_second_open_gathers(cache, error);
    if (status == SL_OK) status = find_places(cache, ORIGINS, SIZE_MAX, counters, error);
    if (status == SL_OK && is_too_coarse(cache)) status = find_finer_places(cache, counters, error);
    if (status == SL_OK) status = sl_let_light_bounce(cache, counters, error);
    if (status == SL_OK) status = check_points(cache, &cache->report.missed, counters, error);
    sl_gathers_destroy(&cache->gathers);
    return status;
}

/* Tells whether so much is new that what it sends to the others counts. */
static bool is_grown(const sl_second_cache *cache) {
    return 8 * (cache->list.count - cache->bounced) > cache->bounced;
}

/* Lets light bounce again, from direct light on. */
static sl_status bounce_anew(sl_second_cache *cache, sl_counters *counters, sl_error *error) {
    cache->shines = false;
    sl_status status = sl_second_gather(cache, cache->list.count, counters, error);
    return status == SL_OK ? sl_let_light_bounce(cache, counters, error) : status;
}

/* Has those from `first` on gather the light of all bounces, each other's included: as they were made, each
 * had that of those before. */
static sl_status settle(sl_second_cache *cache, size_t first, sl_counters *counters, sl_error *error) {
    enum { TIMES = 2 };
    const size_t next = cache->next;
    sl_status status = SL_OK;
    for (int i = 0; status == SL_OK && i < TIMES; i++) {
        cache->next = first;
        status = sl_second_cache_renew(cache, cache->list.count - first, counters, error);
    }
    cache->next = next;
    return status;
}

/* Has some more of those that wait for it gather again. */
static sl_status take_turns(sl_second_cache *cache, sl_counters *counters, sl_error *error) {
    const size_t count = sl_fewer(cache->waiting, cache->settings.quick ? QUICK_AGAIN : AGAIN);
    cache->waiting -= count;
    return sl_second_cache_renew(cache, count, counters, error);
}

/* Makes records where there are none. Once those of before lack the light of many they gather again, at once
 * or with the views that follow. */
static sl_status add_places(sl_second_cache *cache, float missed, sl_counters *counters, sl_error *error) {
    const bool elsewhere = missed > MOST_MISSED, quick = !elsewhere && cache->settings.quick;
    const size_t most = elsewhere ? SIZE_MAX : quick ? QUICK_MORE : MORE;
    const size_t first = cache->list.count;
    sl_status status = sl_second_open_gathers(cache, error);
    if (status == SL_OK) status = find_places(cache, quick ? QUICK_ORIGINS : ORIGINS, most, counters, error);
    if (cache->list.count == first) cache->report.missed = missed; /* as few as can be */
    if (status != SL_OK || cache->moved) return status;
    if (elsewhere && is_grown(cache)) return bounce_anew(cache, counters, error);
    if (is_grown(cache)) cache->waiting = cache->bounced = cache->list.count;
    return elsewhere ? settle(cache, first, counters, error) : SL_OK;
}

sl_status sl_second_cache_create(const sl_scene *scene, const sl_tracer *tracer,
                                 const sl_second_settings *settings, sl_second_cache **out,
                                 sl_counters *counters, sl_error *error) {
    const float a = (float)settings->accuracy;
    sl_second_cache *cache = sl_allocate(1, sizeof *cache);
    *out = NULL;
    if (!cache) return sl_fail_memory(error, "second-level records");
    cache->scene = scene;
    cache->tracer = tracer;
    cache->settings = *settings;
    cache->isa = sl_isa_best();
    cache->light = (sl_second_light){cache, add_irradiance};
    cache->rules = (sl_weight_rules){a, 1.0f / a, 1e-5f * scene->scale};
    cache->settings.gather.second = &cache->light;
    cache->radii = radii_of(settings, scene);
    sl_status status = make_records(cache, counters, error);
    if (status == SL_OK) *out = cache;
    else sl_second_cache_destroy(cache);
    return status;
}

sl_status sl_second_cache_follow(sl_second_cache *cache, sl_counters *counters, sl_error *error) {
    float missed = 0.0f;
    sl_status status = check_points(cache, &missed, counters, error);
    if (status == SL_OK && missed > cache->report.missed + MANY_MISSED)
        status = add_places(cache, missed, counters, error);
    if (status == SL_OK) status = take_turns(cache, counters, error);
    if (!cache->moved) sl_gathers_destroy(&cache->gathers);
    cache->report.records = cache->list.count;
    return status;
}

void sl_second_cache_destroy(sl_second_cache *cache) {
    if (!cache) return;
    sl_gathers_destroy(&cache->gathers);
    sl_second_list_free(&cache->list);
    sl_record_octree_free(&cache->octree);
    sl_free(cache);
}

const sl_second_light *sl_second_cache_light(const sl_second_cache *cache) { return &cache->light; }
sl_second_report sl_second_cache_report(const sl_second_cache *cache) { return cache->report; }

float sl_second_cache_reach(const sl_second_cache *cache) { return (float)cache->radii.minimum_reach; }

size_t sl_second_cache_bytes(const sl_second_cache *cache) {
    const sl_second_list *list = &cache->list;
    const sl_record_octree *octree = &cache->octree;
    return sizeof *cache +
           list->capacity * (sizeof *list->records + sizeof *list->points + sizeof *list->terms) +
           octree->node_capacity * sizeof *octree->nodes + octree->block_capacity * sizeof *octree->blocks;
}
