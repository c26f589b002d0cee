/* The update loop (section on the system's components): U1 to U10.
 *
 *   id map ── priorities ── normalised ── selected pixels ── split, or asked for ── samples ── committed ── aged ── display arrays ── swap
 *                                                                                   │
 *                                                  changes found, coarser patches ──┘
 */
#include "cache/shading_cache/shading_cache.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/announce.h"
#include "cache/picture_value.h"
#include "cache/shading_cache/change.h"
#include "cache/shading_cache/display.h"
#include "cache/shading_cache/plan.h"
#include "cache/shading_cache/renderers.h"
#include "cache/shading_cache/work.h"
#include "scene/ambient.h"
#include "scene/object_places.h"

#include <string.h>

enum { RENDERERS_MAX = 3, LEVELS_AN_UPDATE = 3, CROWD = 4, CHOICES_A_PATCH = 16, LEAVES_A_TASK = 1024, NUDGES = 3 };

/* A patch is split above 1.2 stop sizes, and dropped by ageing below 0.8: in between nothing swings to and fro. */
static const float split_slack = 1.2f, drop_slack = 0.8f;

typedef struct shading_state {
    const sl_scene *scene;
    sl_settings settings;
    sl_shading_plan plan;
    sl_display_curve curve;

    const sl_tracer *tracer;       /* the renderers hold the address of this */
    sl_tracer *own_tracer;
    sl_primitives *primitives;
    sl_patches *patches;
    sl_sample_renderer renderer[RENDERERS_MAX];
    int renderer_count;
    sl_display *display;
    sl_changes *changes;
    sl_object_places *places;

    sl_display_ids ids;            /* U1 */
    float *id_memory;
    uint32_t *leaf_of_pixel;       /* index into leaves */
    uint32_t *leaf_of_patch;
    size_t leaf_of_patch_room;
    sl_leaf_priority *leaf;        /* U2, U3: visible leaves, in the order of their first pixels */
    size_t leaf_count, leaf_room;
    sl_choice *choice;             /* U4 */
    sl_work_settings work;         /* U5, U6 */
    sl_chosen_place *place;
    uint32_t *vertex;              /* U6: to be shaded */
    size_t vertex_room;
    sl_sample_request *request;    /* U7 */
    sl_sample *sample, *part;
    bool *stale, *changing;        /* by object */
    uint32_t *stale_before;

    uint32_t now;                  /* the update under way: 1, 2, ... */
    uint64_t last_update;          /* after which a picture is done: an edit allows as many again */
    uint32_t edits;                /* ... of a series: frames */
    bool shows_only;               /* the next frame of a series waits for no update */
    bool drawn;                    /* the display knows the view */
    bool done;
    sl_counters counters;
    sl_announcer announcer;
} shading_state;

static size_t pixels_of(const shading_state *s) { return (size_t)s->settings.width * (size_t)s->settings.height; }

/* ---- life ---- */

static void shading_destroy(void *state) {
    shading_state *s = state;
    if (!s) return;
    for (int i = 0; i < s->renderer_count; i++) s->renderer[i].destroy(s->renderer[i].state);
    sl_display_destroy(s->display);
    sl_changes_destroy(s->changes);
    sl_object_places_destroy(s->places);
    sl_patches_destroy(s->patches);
    sl_primitives_destroy(s->primitives);
    sl_tracer_destroy(s->own_tracer);
    sl_free(s->ids.patch);
    sl_free(s->id_memory);
    sl_free(s->leaf_of_pixel);
    sl_free(s->leaf_of_patch);
    sl_free(s->leaf);
    sl_free(s->choice);
    sl_free(s->place);
    sl_free(s->vertex);
    sl_free(s->request);
    sl_free(s->sample);
    sl_free(s->part);
    sl_free(s->stale);
    sl_free(s->changing);
    sl_free(s->stale_before);
    sl_free(s);
}

static sl_status make_buffers(shading_state *s, sl_error *error) {
    size_t pixels = pixels_of(s), choices = 2 * (size_t)s->settings.shading_cache.points;
    s->ids.patch = sl_allocate(pixels, sizeof *s->ids.patch);
    s->id_memory = sl_allocate(2 * pixels, sizeof *s->id_memory);
    s->leaf_of_pixel = sl_allocate(pixels, sizeof *s->leaf_of_pixel);
    s->choice = sl_allocate(choices, sizeof *s->choice);
    s->place = sl_allocate(choices, sizeof *s->place);
    s->vertex_room = 4 * choices + 64;
    s->vertex = sl_allocate(s->vertex_room, sizeof *s->vertex);
    s->request = sl_allocate(s->vertex_room, sizeof *s->request);
    s->sample = sl_allocate(s->vertex_room, sizeof *s->sample);
    s->part = sl_allocate(s->vertex_room, sizeof *s->part);
    s->stale = sl_allocate(s->scene->object_count, sizeof *s->stale);
    s->changing = sl_allocate(s->scene->object_count, sizeof *s->changing);
    s->stale_before = sl_allocate(s->scene->object_count, sizeof *s->stale_before);
    if (!s->ids.patch || !s->id_memory || !s->leaf_of_pixel || !s->choice || !s->place || !s->vertex || !s->request || !s->sample ||
        !s->part || !s->stale || !s->changing || !s->stale_before)
        return sl_fail_memory(error, "the shading cache");
    s->ids.u = s->id_memory;
    s->ids.v = s->id_memory + pixels;
    return SL_OK;
}

typedef sl_status renderer_maker(const sl_renderer_settings *settings, sl_sample_renderer *renderer, sl_error *error);

static sl_status make_renderers(shading_state *s, sl_error *error) {
    const struct {
        bool runs;
        renderer_maker *make;
    } makers[RENDERERS_MAX] = {{s->plan.direct, sl_area_renderer}, {s->plan.indirect, sl_bidirectional_renderer}, {s->plan.caustics, sl_caustic_renderer}};
    sl_renderer_settings settings = {.scene = s->scene, .tracer = &s->tracer, .cache = s->settings.shading_cache, .seed = s->settings.seed,
                                     .threads = s->settings.threads};
    sl_status status = SL_OK;
    for (int i = 0; i < RENDERERS_MAX && status == SL_OK; i++) {
        if (!makers[i].runs) continue;
        status = makers[i].make(&settings, &s->renderer[s->renderer_count], error);
        if (status == SL_OK) s->renderer_count++;
    }
    return status;
}

static sl_status make_tracer(shading_state *s, sl_error *error) {
    sl_tracer_destroy(s->own_tracer);
    s->own_tracer = NULL;
    s->tracer = NULL;
    sl_status status = sl_tracer_create(s->scene, s->settings.threads, NULL, &s->own_tracer, error);
    s->tracer = s->own_tracer;
    return status;
}

/* Y_ref: what the scene's light makes of its surfaces, on the average. */
static float middle_radiance(const shading_state *s) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    float guess = sl_rgb_mean(sl_ambient_irradiance_of_all_bounces(s->scene)) * (float)(1.0 / SL_PI);
    return c->mean_level_radiance > 0.0 ? (float)c->mean_level_radiance : guess > 0.0f ? guess : 1.0f;
}

static sl_status make_cache(shading_state *s, sl_error *error) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    sl_display_settings display = {s->settings.width, s->settings.height, sl_ambient_irradiance_of_all_bounces(s->scene), s->settings.threads};
    sl_status status = make_buffers(s, error);
    if (status == SL_OK) status = make_tracer(s, error);
    if (status == SL_OK) status = sl_primitives_find(s->scene, &s->primitives, error);
    if (status == SL_OK) status = sl_patches_create(s->primitives, s->plan.radiance, &s->patches, error);
    if (status == SL_OK) status = make_renderers(s, error);
    if (status == SL_OK) status = sl_display_create(s->scene, s->primitives, &display, &s->display, error);
    if (status == SL_OK) status = sl_changes_create(s->scene, (float)c->change_threshold, c->change_window, &s->changes, error);
    if (status == SL_OK) status = sl_object_places_take(s->scene, &s->places, error);
    return status;
}

static sl_status shading_create(const sl_scene *scene, const sl_settings *settings, const sl_transport *transport, void **state, sl_error *error) {
    (void)transport; /* its own: sl_shading_transport() */
    shading_state *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "the shading cache");
    s->scene = scene;
    s->settings = *settings;
    s->plan = sl_shading_plan_make(scene, settings);
    s->announcer = (sl_announcer){.observer = settings->observer, .method = "shading-cache", .counters = &s->counters};
    s->curve = (sl_display_curve){middle_radiance(s)};
    s->last_update = settings->shading_cache.updates;
    sl_status status = make_cache(s, error);
    if (status != SL_OK) {
        shading_destroy(s);
        return status;
    }
    *state = s;
    return SL_OK;
}

/* ---- the view: every primitive has a root on the side that the eye may see ---- */

static bool faces_the_eye(const shading_state *s, uint32_t primitive) {
    uint32_t triangle = s->primitives->first_triangle[primitive];
    sl_vec3 corner = sl_scene_position(s->scene, s->scene->vertex[0][triangle]);
    return sl_dot(sl_scene_geometric_normal(s->scene, triangle), sl_sub(s->scene->camera.eye, corner)) > 0.0f;
}

static sl_status want_roots(shading_state *s, sl_error *error) {
    sl_status status = SL_OK;
    for (uint32_t p = 0; p < s->primitives->count; p++) {
        bool curved = s->primitives->kind[p] == SL_PRIMITIVE_BICUBIC, front = curved || faces_the_eye(s, p);
        if (front && sl_patches_root(s->patches, 2 * p, &status, error) == SL_NO_INDEX) return status;
        if ((curved || !front) && sl_patches_root(s->patches, 2 * p + 1, &status, error) == SL_NO_INDEX) return status;
    }
    return SL_OK;
}

static sl_status take_view(shading_state *s, sl_error *error) {
    if (s->drawn) return SL_OK;
    sl_status status = want_roots(s, error);
    if (status == SL_OK) status = sl_display_build(s->display, s->patches, &s->counters, error);
    s->drawn = status == SL_OK;
    return status;
}

/* ---- U1, U2: the id map, and what of its patches wants samples ---- */

static sl_status room_for_leaves(shading_state *s, sl_error *error) {
    size_t patches = s->patches->patch_capacity;
    if (patches > s->leaf_of_patch_room) {
        sl_free(s->leaf_of_patch);
        s->leaf_of_patch_room = 0;
        s->leaf_of_patch = sl_allocate(patches, sizeof *s->leaf_of_patch);
        if (!s->leaf_of_patch) return sl_fail_memory(error, "visible patches");
        s->leaf_of_patch_room = patches;
    }
    size_t leaves = s->patches->patches_alive < pixels_of(s) ? s->patches->patches_alive : pixels_of(s);
    if (leaves > s->leaf_room) {
        sl_free(s->leaf);
        s->leaf_room = 0;
        s->leaf = sl_allocate(leaves, sizeof *s->leaf);
        if (!s->leaf) return sl_fail_memory(error, "visible patches");
        s->leaf_room = leaves;
    }
    return SL_OK;
}

/* Counts each leaf's pixels; the leaf and what is above it have been seen. */
static void count_pixels(shading_state *s) {
    for (size_t i = 0; i < s->leaf_of_patch_room; i++) s->leaf_of_patch[i] = SL_NO_INDEX;
    s->leaf_count = 0;
    for (size_t i = 0; i < pixels_of(s); i++) {
        uint32_t patch = s->ids.patch[i];
        s->leaf_of_pixel[i] = SL_NO_INDEX;
        if (patch == SL_NO_INDEX) continue;
        uint32_t *leaf = &s->leaf_of_patch[patch];
        if (*leaf == SL_NO_INDEX) {
            *leaf = (uint32_t)s->leaf_count;
            s->leaf[s->leaf_count++] = (sl_leaf_priority){.patch = patch};
        }
        s->leaf[*leaf].pixels++;
        s->leaf_of_pixel[i] = *leaf;
    }
    for (size_t i = 0; i < s->leaf_count; i++) {
        for (uint32_t p = s->leaf[i].patch; p != SL_NO_INDEX; p = sl_patch_parent(s->patches, p)) {
            sl_patch *patch = &s->patches->patch[p];
            if (patch->seen != s->now) patch->pixels = 0;
            patch->seen = s->now;
            patch->pixels += s->leaf[i].pixels;
        }
    }
}

/* Corners of one colour do not say that nothing lies between them; the larger a leaf, the more may. One of 1/1024 of the picture or more counts as
 * if it were wrong by some levels, so that it does not wait for a random pixel. */
static float least_priority(const shading_state *s, const sl_leaf_priority *leaf) {
    static const float levels_when_large = 16.0f;
    float share = 1024.0f * (float)leaf->pixels / (float)pixels_of(s);
    return levels_when_large * (share < 1.0f ? share : 1.0f);
}

/* Objects that change, and what is seen from elsewhere and is not diffuse, grow old. */
static void prioritise_some(void *context, size_t task, unsigned worker) {
    (void)worker;
    shading_state *s = context;
    bool ages = !s->settings.shading_cache.no_ageing;
    size_t end = (task + 1) * LEAVES_A_TASK < s->leaf_count ? (task + 1) * LEAVES_A_TASK : s->leaf_count;
    for (size_t i = task * LEAVES_A_TASK; i < end; i++) {
        uint32_t patch = s->leaf[i].patch, object = sl_root_object(s->primitives, sl_patch_root(s->patches, patch));
        float priority = sl_patch_priority(s->patches, &s->curve, patch, s->now, ages ? s->changes->eye_moved : 0,
                                           ages ? sl_changes_since(s->changes, object) : 0);
        float least = least_priority(s, &s->leaf[i]);
        s->leaf[i].priority = priority < 0.0f || priority > least ? priority : least;
    }
}

static void announce_priorities(shading_state *s) {
    float *plane = s->announcer.observer ? sl_allocate(pixels_of(s), sizeof *plane) : NULL;
    for (size_t i = 0; plane && i < pixels_of(s); i++)
        plane[i] = s->leaf_of_pixel[i] == SL_NO_INDEX ? 0.0f : s->leaf[s->leaf_of_pixel[i]].normal;
    sl_announce(&s->announcer, "priorities", "section 4.2", s->settings.width, s->settings.height, 1, plane, true);
    sl_free(plane);
}

static sl_status see_priorities(shading_state *s, sl_error *error) {
    sl_status status = sl_display_id_map(s->display, s->settings.threads, &s->ids, &s->counters, error);
    if (status == SL_OK) status = room_for_leaves(s, error);
    if (status != SL_OK) return status;
    sl_announce_pass(&s->announcer, "id map", "section 4.1");
    count_pixels(s);
    sl_parallel_for(s->settings.threads, (s->leaf_count + LEAVES_A_TASK - 1) / LEAVES_A_TASK, prioritise_some, s);
    sl_priorities_normalise(s->leaf_count, s->leaf, s->settings.shading_cache.plain_normalisation);
    announce_priorities(s);
    return SL_OK;
}

/* ---- U4 to U6: which pixels, and what work that makes ---- */

static sl_status select_pixels(shading_state *s, size_t *choices, sl_error *error) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    sl_selection_settings selection = {.how = c->selection, .points = c->points, .random_share = c->no_random ? 0.0f : (float)c->random_share,
                                       .flood_threshold = c->no_flood ? 2.0f : (float)c->flood_threshold, .per_patch = CHOICES_A_PATCH,
                                       .seed = s->settings.seed, .update = s->now};
    return sl_select_pixels(&selection, s->settings.width, s->settings.height, s->leaf_of_pixel, s->leaf_count, s->leaf, s->choice, choices,
                            &s->counters, error);
}

/* What changes is shown with patches as coarse as leaves time to shade them all anew. */
static float coarsest_patch(const shading_state *s, bool triangles) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    double visible = 0.0;
    if (c->no_resolution_drop) return 0.0f;
    for (size_t i = 0; i < s->leaf_count; i++) {
        uint32_t object = sl_root_object(s->primitives, sl_patch_root(s->patches, s->leaf[i].patch));
        if (s->changes->object[object].changing) visible += s->leaf[i].pixels;
    }
    return visible > 0.0 ? sl_changes_coarsest(visible, c->nominal_rate, c->clean_up_seconds, triangles) : 0.0f;
}

static sl_status work_out(shading_state *s, size_t choices, size_t *vertices, sl_error *error) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    for (size_t i = 0; i < choices; i++) {
        uint32_t pixel = s->choice[i].pixel;
        s->place[i] = (sl_chosen_place){s->ids.patch[pixel], s->ids.u[pixel], s->ids.v[pixel]};
    }
    for (size_t i = 0; i < s->scene->object_count; i++) {
        s->stale_before[i] = s->changes->object[i].stale_before;
        s->changing[i] = s->changes->object[i].changing;
    }
    s->work = (sl_work_settings){.split_above = split_slack * (float)c->stop_size, .levels = LEVELS_AN_UPDATE, .crowd = CROWD,
                                 .variance_aware = c->variance_aware, .now = s->now, .stale_before = c->no_ageing ? NULL : s->stale_before,
                                 .eye_moved = c->no_ageing ? 0 : s->changes->eye_moved, .changing = s->changing, .coarsest = coarsest_patch(s, false)};
    return sl_work_out(s->patches, &s->curve, &s->work, &s->scene->camera, s->settings.width, s->settings.height, choices, s->place, s->vertex,
                       vertices, &s->counters, error);
}

/* ---- U7: samples ---- */

static bool on_the_border(const sl_primitives *primitives, const sl_patch_vertex *v) {
    bool triangle = primitives->kind[v->root / 2] == SL_PRIMITIVE_TRIANGLE;
    if (v->u == 0 || v->v == 0) return true;
    return triangle ? v->u + v->v >= SL_PATCH_DYADIC : v->u >= SL_PATCH_DYADIC || v->v >= SL_PATCH_DYADIC;
}

/* Where a vertex is shaded. On its root's border it is moved inwards by 1/256 of the way to the middle: in the crease between two walls it would see
 * half of what is behind the other. Inside other geometry it is asked for further and further inside. */
static void place_request(const shading_state *s, uint32_t vertex, int nudge, sl_root_point *point) {
    static const int32_t ways[NUDGES + 1] = {256, 100, 20, 5};
    const sl_patch_vertex *v = &s->patches->vertex[vertex];
    bool triangle = s->primitives->kind[v->root / 2] == SL_PRIMITIVE_TRIANGLE;
    int32_t centre = triangle ? SL_PATCH_DYADIC / 3 : SL_PATCH_DYADIC / 2, u = v->u, w = v->v;
    if (nudge || on_the_border(s->primitives, v)) {
        u += (centre - u) / ways[nudge];
        w += (centre - w) / ways[nudge];
    }
    sl_root_point_at(s->primitives, v->root, (uint32_t)u, (uint32_t)w, point);
}

static void make_request(const shading_state *s, uint32_t vertex, int nudge, sl_sample_request *request) {
    const sl_patch_vertex *v = &s->patches->vertex[vertex];
    const sl_material *material = sl_root_material(s->primitives, v->root);
    bool more = v->evaluated != SL_VERTEX_NEVER && s->settings.shading_cache.variance_aware && !sl_vertex_is_stale(s->patches, &s->work, vertex);
    *request = (sl_sample_request){.material = material, .eye = s->scene->camera.eye, .radiance = sl_looks_otherwise_from_elsewhere(material), .set = more ? v->samples : 0};
    place_request(s, vertex, nudge, &request->point);
}

static void add_sample(sl_sample *sum, const sl_sample *part) {
    sum->irradiance = sl_rgb_add(sum->irradiance, part->irradiance);
    sum->radiance = sl_rgb_add(sum->radiance, part->radiance);
    sum->variance += part->variance;
    sum->valid = sum->valid && part->valid;
}

/* The next run of requests from `first` that are worth asking for: what one renderer calls invalid no other one is asked about. */
static size_t next_run(const sl_sample *samples, size_t count, size_t *first) {
    while (*first < count && !samples[*first].valid) ++*first;
    size_t end = *first;
    while (end < count && samples[end].valid) end++;
    return end - *first;
}

static void render_samples(shading_state *s, size_t count, const sl_sample_request *requests, sl_sample *samples) {
    for (size_t i = 0; i < count; i++) samples[i] = (sl_sample){.valid = true};
    for (int r = 0; r < s->renderer_count; r++) {
        size_t first = 0, run;
        while ((run = next_run(samples, count, &first)) > 0) {
            s->renderer[r].render(s->renderer[r].state, run, requests + first, s->settings.threads, s->part, &s->counters);
            for (size_t i = 0; i < run; i++) add_sample(&samples[first + i], &s->part[i]);
            first += run;
        }
    }
    sl_count(&s->counters, SL_COUNT_POINTS_SHADED, count);
}

static void sample_vertices(shading_state *s, size_t count) {
    for (size_t i = 0; i < count; i++) make_request(s, s->vertex[i], 0, &s->request[i]);
    render_samples(s, count, s->request, s->sample);
    for (int nudge = 1; nudge <= NUDGES; nudge++) {
        for (size_t i = 0; i < count; i++) {
            if (s->sample[i].valid) continue;
            sl_sample again;
            make_request(s, s->vertex[i], nudge, &s->request[i]);
            render_samples(s, 1, &s->request[i], &again);
            s->sample[i] = again;
        }
    }
}

/* ---- U8: commit, change ---- */

/* A value may tell of change if it replaces one that was made with the same samples. Radiance towards an eye that has moved tells nothing. */
typedef struct compared {
    bool comparable, radiance;
    float before;
} compared;

static float level_of(const shading_state *s, uint32_t vertex, bool with_radiance) {
    const sl_patch_vertex *v = &s->patches->vertex[vertex];
    sl_rgb exitant = sl_rgb_mul(sl_rgb_scale((sl_rgb){v->value[0], v->value[1], v->value[2]}, (float)(1.0 / SL_PI)), sl_root_mean_diffuse(s->primitives, v->root));
    if (with_radiance) {
        const float *radiance = s->patches->radiance[vertex];
        exitant = sl_rgb_add(exitant, (sl_rgb){radiance[0], radiance[1], radiance[2]});
    }
    return sl_curve_level(&s->curve, exitant);
}

static compared compare_before(const shading_state *s, uint32_t vertex, const sl_sample_request *request) {
    const sl_patch_vertex *v = &s->patches->vertex[vertex];
    compared c = {.comparable = v->evaluated != SL_VERTEX_NEVER && request->set == 0 && v->samples == 1,
                  .radiance = s->patches->radiance && v->evaluated >= s->changes->eye_moved};
    c.before = c.comparable ? level_of(s, vertex, c.radiance) : 0.0f;
    return c;
}

static void blend(float value[3], sl_rgb now, float share) {
    const float parts[3] = {now.r, now.g, now.b};
    for (int k = 0; k < 3; k++) value[k] += share * (parts[k] - value[k]);
}

/* The share of a new value: all of it, but where it refines an unchanged one (beta), or joins earlier sets of samples. */
static float share_of(const shading_state *s, uint32_t vertex, uint32_t set, bool changing) {
    if (s->patches->vertex[vertex].evaluated == SL_VERTEX_NEVER || changing) return 1.0f;
    if (set > 0) return 1.0f / (float)(set + 1);
    return sl_vertex_is_stale(s->patches, &s->work, vertex) ? 1.0f : (float)s->settings.shading_cache.blending;
}

static void commit_sample(shading_state *s, uint32_t vertex, const sl_sample_request *request, const sl_sample *sample) {
    sl_patch_vertex *v = &s->patches->vertex[vertex];
    if (!sl_rgb_is_finite(sample->irradiance) || !sl_rgb_is_finite(sample->radiance)) {
        sl_count(&s->counters, SL_COUNT_NONFINITE, 1);
        v->evaluated = v->evaluated == SL_VERTEX_NEVER ? s->now : v->evaluated; /* the old value stays */
        return;
    }
    compared c = compare_before(s, vertex, request);
    uint32_t object = sl_root_object(s->primitives, v->root);
    float share = share_of(s, vertex, request->set, s->changes->object[object].changing);
    blend(v->value, sample->irradiance, share);
    if (s->patches->radiance) blend(s->patches->radiance[vertex], sample->radiance, share);
    v->variance += share * (share * sample->variance - v->variance * (2.0f - share));
    v->variance = v->variance > 0.0f ? v->variance : 0.0f;
    v->samples = (uint16_t)(request->set < UINT16_MAX ? request->set + 1 : UINT16_MAX);
    v->evaluated = s->now;
    sl_patches_touch(s->patches, vertex);
    if (c.comparable && sl_changes_compare(s->changes, object, c.before, level_of(s, vertex, c.radiance), s->now))
        sl_count(&s->counters, SL_COUNT_CHANGES_DETECTED, 1);
}

/* Objects of which visible leaves still show what was before. */
static void find_stale(shading_state *s) {
    memset(s->stale, 0, s->scene->object_count * sizeof *s->stale);
    for (size_t i = 0; i < s->leaf_count; i++) {
        uint32_t patch = s->leaf[i].patch;
        if (!sl_patch_is_alive(s->patches, patch) || !sl_patch_is_leaf(s->patches, patch)) continue;
        uint32_t object = sl_root_object(s->primitives, sl_patch_root(s->patches, patch));
        for (int c = 0; c < sl_patch_corners(s->patches, patch); c++) {
            const sl_patch_vertex *v = &s->patches->vertex[sl_patch_corner(s->patches, patch, c)];
            s->stale[object] |= v->evaluated < s->changes->object[object].stale_before;
        }
    }
}

static void projected_areas(const shading_state *s, float *area) {
    for (uint32_t p = 0; p < s->patches->patch_count; p++) {
        if (!sl_patch_is_alive(s->patches, p)) continue;
        uint32_t object = sl_root_object(s->primitives, sl_patch_root(s->patches, p));
        if (!s->changes->object[object].changing || sl_patch_is_leaf(s->patches, p)) continue;
        sl_patch_place place = sl_patch_place_of(s->patches, p);
        area[p] = sl_patch_projected(s->patches, &place, &s->scene->camera, s->settings.width, s->settings.height).area;
    }
}

static sl_status drop_resolution(shading_state *s, sl_error *error) {
    float quads = coarsest_patch(s, false), triangles = coarsest_patch(s, true);
    if (!(quads > 0.0f)) return SL_OK;
    float *area = sl_allocate(s->patches->patch_count, sizeof *area);
    if (!area) return sl_fail_memory(error, "coarser patches");
    projected_areas(s, area);
    sl_changes_drop(s->changes, s->patches, area, quads, triangles);
    sl_free(area);
    return SL_OK;
}

static sl_status commit(shading_state *s, size_t count, sl_error *error) {
    uint64_t before = s->counters.value[SL_COUNT_CHANGES_DETECTED];
    for (size_t i = 0; i < count; i++) commit_sample(s, s->vertex[i], &s->request[i], &s->sample[i]);
    find_stale(s);
    sl_changes_settle(s->changes, s->stale, s->now);
    return s->counters.value[SL_COUNT_CHANGES_DETECTED] > before ? drop_resolution(s, error) : SL_OK;
}

/* ---- U9, U10 ---- */

static sl_status age(shading_state *s, sl_error *error) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    size_t limit = (size_t)(c->cache_limit * (double)pixels_of(s)) + 2 * s->primitives->count;
    uint32_t window = (uint32_t)c->ageing_window, since = s->now > window ? s->now - window : 0;
    return sl_patches_evict(s->patches, limit, since, (double)drop_slack * c->stop_size, &s->counters, error);
}

/* Nothing that is seen wants any more: every leaf is as small as it gets, and as the scene is now. */
static bool nothing_is_left(const shading_state *s) {
    for (size_t i = 0; i < s->leaf_count; i++) {
        uint32_t patch = s->leaf[i].patch;
        if (!sl_patch_is_alive(s->patches, patch) || !sl_patch_is_leaf(s->patches, patch)) return false;
        if (!sl_patch_is_finished(s->patches, &s->work, &s->scene->camera, s->settings.width, s->settings.height, patch)) return false;
    }
    return true;
}

static sl_status one_update(shading_state *s, sl_error *error) {
    size_t choices = 0, vertices = 0;
    s->now++;
    sl_status status = see_priorities(s, error);
    if (status != SL_OK) return status;
    status = select_pixels(s, &choices, error);
    sl_announce_pass(&s->announcer, "selection", "section 4.2");
    if (status == SL_OK) status = work_out(s, choices, &vertices, error);
    if (status != SL_OK) return status;
    sl_announce_pass(&s->announcer, "requests", "section 4.3");
    sample_vertices(s, vertices);
    sl_announce_pass(&s->announcer, "samples", "section 4.3");
    status = commit(s, vertices, error);
    if (status == SL_OK) status = age(s, error);
    sl_announce_pass(&s->announcer, "commit", "sections 4.3 and 4.4");
    if (status == SL_OK) status = sl_display_build(s->display, s->patches, &s->counters, error);
    sl_announce_pass(&s->announcer, "display arrays", "section 3");
    s->done = s->now >= s->last_update || nothing_is_left(s);
    return status;
}

/* ---- the method ---- */

static sl_status shading_update(void *state, sl_progress *progress, sl_error *error) {
    shading_state *s = state;
    if (!s->tracer) return sl_fail(error, SL_ERROR_RESOURCES, "an earlier edit of the scene failed; edit it again");
    sl_status status = take_view(s, error);
    if (status == SL_OK && !s->done && !s->shows_only) status = one_update(s, error);
    s->shows_only = false;
    double left = (double)(s->last_update - s->now) / (double)s->settings.shading_cache.updates;
    progress->fraction = s->done ? 1.0 : 1.0 - left;
    progress->frame_done = true;
    progress->done = s->done;
    return status;
}

static sl_status shading_resolve(void *state, sl_image **image, sl_error *error) {
    shading_state *s = state;
    size_t pixels = pixels_of(s);
    float *memory = sl_allocate(3 * pixels, sizeof *memory);
    if (!memory) return sl_fail_memory(error, "the picture");
    float *const planes[3] = {memory, memory + pixels, memory + 2 * pixels};
    sl_status status = take_view(s, error);
    if (status == SL_OK) status = sl_display_draw(s->display, s->settings.threads, planes, &s->counters, error);
    if (status == SL_OK) status = sl_image_create(s->settings.width, s->settings.height, 3, NULL, image, error);
    sl_count(&s->counters, SL_COUNT_FRAMES_DISPLAYED, status == SL_OK);
    if (status == SL_OK) sl_announce(&s->announcer, "display", "section 3", s->settings.width, s->settings.height, 3, memory, true);
    for (size_t i = 0; i < 3 * pixels && status == SL_OK; i++) memory[i] = sl_picture_value(memory[i]);
    for (int k = 0; k < 3 && status == SL_OK; k++) sl_raster_flip(planes[k], s->settings.width, s->settings.height, (*image)->planes + (size_t)k * pixels);
    sl_free(memory);
    return status;
}

static sl_status note_motion(shading_state *s, unsigned what, sl_error *error) {
    sl_object_places *places;
    sl_status status = sl_object_places_take(s->scene, &places, error);
    if (status != SL_OK) return status;
    for (size_t i = 0; i < places->count; i++) s->stale[i] = sl_object_has_moved(s->places, places, i);
    sl_changes_edit(s->changes, what, s->stale, s->now + 1);
    sl_object_places_destroy(s->places);
    s->places = places;
    return SL_OK;
}

/* The display follows at once; the shading finds out for itself what has changed. Of a series of frames every frames_per_update-th waits for an
 * update; the others show what there is, from where things are. */
static sl_status shading_edit(void *state, unsigned changes, sl_error *error) {
    shading_state *s = state;
    sl_status status = note_motion(s, changes, error);
    s->done = false;
    s->last_update = (uint64_t)s->now + s->settings.shading_cache.updates;
    s->shows_only = s->edits++ % (uint32_t)s->settings.shading_cache.frames_per_update != 0;
    if (changes & (SL_CHANGED_CAMERA | SL_CHANGED_OBJECTS)) s->drawn = false;
    if (status == SL_OK && (changes & SL_CHANGED_OBJECTS)) status = sl_display_move(s->display, error);
    if (status == SL_OK && (changes & SL_CHANGED_OBJECTS)) status = make_tracer(s, error);
    for (int i = 0; i < s->renderer_count && status == SL_OK; i++) status = s->renderer[i].edit(s->renderer[i].state, changes, error);
    if (status != SL_OK) s->tracer = NULL;
    return status;
}

static const sl_counters *shading_counters(const void *state) { return &((const shading_state *)state)->counters; }

static size_t shading_bytes(const void *state) {
    const shading_state *s = state;
    size_t bytes = sizeof *s + pixels_of(s) * (2 * sizeof *s->ids.patch + 2 * sizeof *s->ids.u) + s->leaf_room * sizeof *s->leaf;
    bytes += s->vertex_room * (sizeof *s->vertex + sizeof *s->request + 2 * sizeof *s->sample);
    if (s->own_tracer) bytes += sl_tracer_memory_bytes(s->own_tracer);
    return bytes + sl_primitives_memory_bytes(s->primitives) + sl_patches_memory_bytes(s->patches) + sl_display_memory_bytes(s->display);
}

const sl_method_class sl_shading_cache_method = {
    .name = "shading-cache",
    .complete = sl_shading_complete,
    .create = shading_create,
    .destroy = shading_destroy,
    .update = shading_update,
    .resolve = shading_resolve,
    .edit = shading_edit,
    .counters = shading_counters,
    .memory_bytes = shading_bytes,
    .transport = sl_shading_transport,
    .plan = sl_shading_plan_write,
};
