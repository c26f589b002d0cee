#include "render_cache.h"

#include <math.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "common.h"

/* ages end there: a pixel that shows something never comes before one that shows nothing */
enum { OLD = 127,
       /* time alone makes nothing older than that: gaps are worth more than pixels that are most likely
        * right */
       OLD_BY_TIME = 16,
       AGED_BY_CHANGE = 80, /* what a sample that found another colour adds to the ages around it */
       YOUNG = 8,           /* what is younger than that has most likely seen the change itself */
       CHANGE_RADIUS = 3,    /* pixels */
       GROUP = 8 };         /* slots looked at for the oldest point */

static const float near_share = 0.95f;    /* a neighbour is nearer where its depth is below this share */
static const float color_change = 0.05f;  /* share of the larger colour */

typedef struct cached_point {
    uint32_t triangle;      /* SL_NO_INDEX: the background, at infinity */
    float place[3];         /* weights of its corners 1 and 2; or a direction */
    float color[3];         /* radiance towards the eye it was sampled from */
    uint8_t age;            /* frames, and more where colours were found to change */
    bool used, exact;       /* exact: sampled since things last moved, so certainly seen */
} cached_point;

struct render_cache {
    render_cache_settings s;
    size_t pixels, capacity, next;
    cached_point *point;
    uint32_t *shown;        /* by pixel: point, or SL_NO_INDEX */
    float *depth;           /* along the view; infinite: background, or none */
    uint32_t *kept;         /* shown, after the depth cull */
    float *picture;         /* three planes */
    float *pyramid;         /* wide fill: weighted colours and weights, all levels */
    uint8_t *priority;
    float *error[2];        /* of two rows */
    uint32_t *chosen;
    sl_sample_request *request;
    sl_sample *sample, *part;
    cached_point *fresh;
    uint64_t frames, samples;
};

static size_t most_samples(const render_cache_settings *s) {
    return (size_t)s->samples + (size_t)s->samples / 4 + 16;
}

/* ---- life ---- */

void render_cache_destroy(render_cache *c) {
    if (!c) return;
    void *const all[] = {c->point,    c->shown,    c->depth,  c->kept,    c->picture, c->pyramid, c->priority,
                         c->error[0], c->error[1], c->chosen, c->request, c->sample,  c->part,    c->fresh};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) sl_free(all[i]);
    sl_free(c);
}

render_cache *render_cache_create(const render_cache_settings *settings) {
    render_cache *c = bench_allocate(1, sizeof *c);
    c->s = *settings;
    c->pixels = (size_t)settings->width * (size_t)settings->height;
    c->capacity = c->pixels + c->pixels / 2 + GROUP; /* one and a half points a pixel */
    size_t samples = most_samples(settings);
    c->point = bench_allocate(c->capacity, sizeof *c->point);
    c->shown = bench_allocate(c->pixels, sizeof *c->shown);
    c->depth = bench_allocate(c->pixels, sizeof *c->depth);
    c->kept = bench_allocate(c->pixels, sizeof *c->kept);
    c->picture = bench_allocate(3 * c->pixels, sizeof *c->picture);
    c->pyramid = bench_allocate(8 * c->pixels + 64 * (size_t)(settings->width + settings->height),
                                sizeof *c->pyramid);
    c->priority = bench_allocate(c->pixels, sizeof *c->priority);
    for (int i = 0; i < 2; i++) c->error[i] = bench_allocate((size_t)settings->width, sizeof **c->error);
    c->chosen = bench_allocate(samples, sizeof *c->chosen);
    c->request = bench_allocate(samples, sizeof *c->request);
    c->sample = bench_allocate(samples, sizeof *c->sample);
    c->part = bench_allocate(samples, sizeof *c->part);
    c->fresh = bench_allocate(samples, sizeof *c->fresh);
    return c;
}

void render_cache_edit(render_cache *c, unsigned changes) {
    if (!(changes & (SL_CHANGED_CAMERA | SL_CHANGED_OBJECTS))) return;
    for (size_t i = 0; i < c->capacity; i++) c->point[i].exact = false;
}

/* ---- projection ---- */

typedef struct view {
    sl_vec3 eye, right, up, forward;
    float across, upwards; /* pixels per tangent */
    int width, height;
} view;

static view view_of(const render_cache *c) {
    const sl_camera *camera = &c->s.scene->camera;
    float scale = 0.5f * (float)c->s.height / (float)sl_tan(0.5 * (double)camera->vertical_fov);
    return (view){camera->eye, camera->right, camera->up, sl_neg(camera->back),
                  scale,       scale,         c->s.width, c->s.height};
}

static sl_vec3 on_triangle(const sl_scene *scene, uint32_t triangle, const float weight[3]) {
    sl_vec3 a = sl_scene_position(scene, scene->vertex[0][triangle]),
            b = sl_scene_position(scene, scene->vertex[1][triangle]);
    return sl_mad(sl_mad(a, weight[0], sl_sub(b, a)), weight[1],
                  sl_sub(sl_scene_position(scene, scene->vertex[2][triangle]), a));
}

/* The pixel that a direction goes through, and its length along the view; SL_NO_INDEX: none. */
static uint32_t pixel_of(const view *v, sl_vec3 direction, float *depth) {
    float z = sl_dot(direction, v->forward);
    if (!(z > 0.0f)) return SL_NO_INDEX;
    float x = floorf(0.5f * (float)v->width + v->across * (sl_dot(direction, v->right) / z));
    float y = floorf(0.5f * (float)v->height - v->upwards * (sl_dot(direction, v->up) / z));
    if (!(x >= 0.0f && y >= 0.0f && x < (float)v->width && y < (float)v->height)) return SL_NO_INDEX;
    *depth = z;
    return (uint32_t)y * (uint32_t)v->width + (uint32_t)x;
}

/* Nearest wins; at equal depth the one sampled last for certain, then the lower index. */
static void project_points(render_cache *c) {
    view v = view_of(c);
    for (size_t i = 0; i < c->pixels; i++) c->shown[i] = SL_NO_INDEX, c->depth[i] = INFINITY;
    for (size_t i = 0; i < c->capacity; i++) {
        const cached_point *p = &c->point[i];
        if (!p->used) continue;
        bool background = p->triangle == SL_NO_INDEX;
        sl_vec3 direction = background ? sl_v3(p->place[0], p->place[1], p->place[2])
                                       : sl_sub(on_triangle(c->s.scene, p->triangle, p->place), v.eye);
        float depth;
        uint32_t pixel = pixel_of(&v, direction, &depth);
        if (pixel == SL_NO_INDEX) continue;
        if (background) depth = INFINITY;
        const cached_point *rival = c->shown[pixel] == SL_NO_INDEX ? NULL : &c->point[c->shown[pixel]];
        if (rival && !(p->exact && !rival->exact) && (!(depth < c->depth[pixel]) || rival->exact)) continue;
        c->shown[pixel] = (uint32_t)i;
        c->depth[pixel] = depth;
    }
}

/* ---- neighbours ---- */

typedef struct window {
    int x0, y0, x1, y1;
} window;

static window window_around(const render_cache *c, size_t pixel, int radius) {
    int x = (int)(pixel % (size_t)c->s.width), y = (int)(pixel / (size_t)c->s.width);
    return (window){x > radius ? x - radius : 0, y > radius ? y - radius : 0,
                    x + radius < c->s.width ? x + radius : c->s.width - 1,
                    y + radius < c->s.height ? y + radius : c->s.height - 1};
}

/* Points of hidden surfaces come through where nearer ones leave gaps: a point goes where hardly any
 * neighbour is as far, and most that show something are nearer. Those sampled since things moved stay, they
 * are known to be seen. */
static void cull_by_depth(render_cache *c) {
    for (size_t i = 0; i < c->pixels; i++) {
        c->kept[i] = c->shown[i];
        if (c->shown[i] == SL_NO_INDEX || c->point[c->shown[i]].exact) continue;
        window w = window_around(c, i, 1);
        int nearer = 0, others = -1;
        for (int y = w.y0; y <= w.y1; y++) {
            for (int x = w.x0; x <= w.x1; x++) {
                size_t at = (size_t)y * (size_t)c->s.width + (size_t)x;
                if (c->shown[at] == SL_NO_INDEX) continue;
                others++;
                nearer += c->depth[at] < near_share * c->depth[i];
            }
        }
        if (nearer < 3 || others - nearer > 2) continue;
        c->kept[i] = SL_NO_INDEX;
    }
}

static float weight_of(const render_cache *c, size_t pixel, int x, int y) {
    int dx = x - (int)(pixel % (size_t)c->s.width), dy = y - (int)(pixel / (size_t)c->s.width);
    return dx && dy ? 1.0f : 2.0f;
}

/* Weights 2 beside, 1 at the corners. Returns how many of the neighbours show nothing. */
static int fill_from_neighbours(const render_cache *c, size_t pixel, float color[3], float *weight) {
    window w = window_around(c, pixel, 1);
    int missing = 0;
    *weight = color[0] = color[1] = color[2] = 0.0f;
    for (int y = w.y0; y <= w.y1; y++) {
        for (int x = w.x0; x <= w.x1; x++) {
            size_t at = (size_t)y * (size_t)c->s.width + (size_t)x;
            if (at == pixel) continue;
            if (c->kept[at] == SL_NO_INDEX) {
                missing++;
                continue;
            }
            float share = weight_of(c, pixel, x, y);
            for (int k = 0; k < 3; k++) color[k] += share * c->point[c->kept[at]].color[k];
            *weight += share;
        }
    }
    return missing;
}

/* ---- wide gaps: averages over 2x2, 4x4, ... pixels, of what is there ---- */

static void reduce_level(const float *fine, int width, int height, float *coarse) {
    int w = (width + 1) / 2;
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++)
            for (size_t k = 0; k < 4; k++)
                coarse[4 * ((size_t)(y / 2) * (size_t)w + (size_t)(x / 2)) + k] +=
                    fine[4 * ((size_t)y * (size_t)width + (size_t)x) + k];
    }
}

/* From the top down: what is empty takes its parent's average. Bilinear would be smoother; gaps are then
 * filled by the 3x3 rule from these. */
static void expand_level(const float *coarse, int width, int height, float *fine) {
    int w = (width + 1) / 2;
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            float *to = &fine[4 * ((size_t)y * (size_t)width + (size_t)x)];
            const float *from = &coarse[4 * ((size_t)(y / 2) * (size_t)w + (size_t)(x / 2))];
            if (to[3] > 0.0f || !(from[3] > 0.0f)) continue;
            for (int k = 0; k < 3; k++) to[k] = from[k] / from[3];
            to[3] = 1.0f;
        }
    }
}

static const float *fill_wide_gaps(render_cache *c) {
    float *level[32];
    int widths[32], heights[32], levels = 0;
    size_t used = 0;
    for (int w = c->s.width, h = c->s.height;; w = (w + 1) / 2, h = (h + 1) / 2) {
        level[levels] = c->pyramid + used, widths[levels] = w, heights[levels] = h;
        used += 4 * (size_t)w * (size_t)h;
        levels++;
        if (w == 1 && h == 1) break;
    }
    memset(c->pyramid, 0, used * sizeof *c->pyramid);
    for (size_t i = 0; i < c->pixels; i++) {
        if (c->kept[i] == SL_NO_INDEX) continue;
        for (size_t k = 0; k < 3; k++) level[0][4 * i + k] = c->point[c->kept[i]].color[k];
        level[0][4 * i + 3] = 1.0f;
    }
    for (int l = 1; l < levels; l++) reduce_level(level[l - 1], widths[l - 1], heights[l - 1], level[l]);
    for (int l = levels - 1; l > 0; l--) expand_level(level[l], widths[l - 1], heights[l - 1], level[l - 1]);
    return level[0];
}

/* ---- the picture and what it lacks ---- */

static void show(render_cache *c, bool wide_fill) {
    const float *wide = wide_fill ? fill_wide_gaps(c) : NULL;
    for (size_t i = 0; i < c->pixels; i++) {
        float color[3], weight;
        int missing = fill_from_neighbours(c, i, color, &weight);
        if (c->kept[i] != SL_NO_INDEX) {
            const cached_point *p = &c->point[c->kept[i]];
            for (size_t k = 0; k < 3; k++) c->picture[k * c->pixels + i] = p->color[k];
            c->priority[i] = p->age;
            continue;
        }
        for (size_t k = 0; k < 3 && weight > 0.0f; k++) c->picture[k * c->pixels + i] = color[k] / weight;
        for (size_t k = 0; k < 3 && wide && !(weight > 0.0f); k++)
            c->picture[k * c->pixels + i] = wide[4 * i + k];
        c->priority[i] = (uint8_t)(OLD + 1 + 16 * missing - (missing == 8)); /* at most 255 */
    }
}

static void grow_older(render_cache *c) {
    for (size_t i = 0; i < c->capacity; i++)
        c->point[i].age = (uint8_t)(c->point[i].age + (c->point[i].age < OLD_BY_TIME));
}

/* ---- which pixels: error diffusion (Floyd and Steinberg), rows in turn from the left and from the right
 * ---- */

static void hand_on(float *row, int width, int x, float share) {
    row[x < 0 ? 0 : x >= width ? width - 1 : x] += share;
}

/* Errors left below the last row are the next frame's above its first, so that over frames all that is wanted
 * is chosen. A frame may so have some more or less. The threshold is random: with a fixed one few samples
 * crowd where rows begin. */
static size_t choose_pixels(render_cache *c) {
    int width = c->s.width;
    uint64_t key = sl_random_key(c->s.seed, c->frames), sum = 0;
    size_t count = 0, most = most_samples(&c->s);
    for (size_t i = 0; i < c->pixels; i++) sum += c->priority[i];
    if (sum == 0) return 0;
    float scale = (float)((double)c->s.samples / (double)sum);
    for (int y = 0; y < c->s.height; y++) {
        float *here = c->error[y & 1], *below = c->error[~y & 1];
        int step = y & 1 ? -1 : 1;
        memset(below, 0, (size_t)width * sizeof *below);
        for (int i = 0; i < width; i++) {
            int x = y & 1 ? width - 1 - i : i;
            uint32_t pixel = (uint32_t)(y * width + x);
            float value = here[x] + scale * (float)c->priority[pixel];
            if (value > sl_random_unit(key, pixel) && count < most) {
                c->chosen[count++] = pixel;
                value -= 1.0f;
            }
            if (i + 1 < width) here[x + step] += value * (7.0f / 16.0f);
            else below[x] += value * (7.0f / 16.0f);
            hand_on(below, width, x - step, value * (3.0f / 16.0f));
            hand_on(below, width, x, value * (5.0f / 16.0f));
            hand_on(below, width, x + step, value * (1.0f / 16.0f));
        }
    }
    if (c->s.height & 1) memcpy(c->error[0], c->error[1], (size_t)width * sizeof *c->error[0]);
    return count;
}

/* ---- samples ---- */

static void set_ray(const render_cache *c, const view *v, uint32_t pixel, sl_ray16 *rays, unsigned lane) {
    float x = ((float)(pixel % (uint32_t)c->s.width) + 0.5f - 0.5f * (float)c->s.width) / v->across;
    float y = (0.5f * (float)c->s.height - (float)(pixel / (uint32_t)c->s.width) - 0.5f) / v->upwards;
    sl_vec3 d = sl_normalize_or(sl_mad(sl_mad(v->forward, x, v->right), y, v->up), v->forward);
    rays->origin_x[lane] = v->eye.x, rays->origin_y[lane] = v->eye.y, rays->origin_z[lane] = v->eye.z;
    rays->direction_x[lane] = d.x, rays->direction_y[lane] = d.y, rays->direction_z[lane] = d.z;
    rays->near[lane] = 0.0f, rays->far[lane] = INFINITY, rays->skip[lane] = SL_NO_INDEX;
}

/* Finds, of a pixel's ray, the point to be shaded, and its colour's parts that need no sample. */
static void meet(const render_cache *c, const sl_ray16 *ray, const sl_hit16 *hit, unsigned lane,
                 cached_point *p, sl_sample_request *q) {
    const sl_scene *scene = c->s.scene;
    sl_vec3 d = sl_v3(ray->direction_x[lane], ray->direction_y[lane], ray->direction_z[lane]);
    *p = (cached_point){
        .triangle = hit->triangle[lane], .place = {d.x, d.y, d.z}, .used = true, .exact = true};
    *q = (sl_sample_request){0};
    if (p->triangle == SL_NO_INDEX) return;
    sl_surface s;
    p->place[0] = hit->w1[lane], p->place[1] = hit->w2[lane], p->place[2] = 0.0f;
    sl_scene_surface(scene, p->triangle, p->place[0], p->place[1], sl_neg(d), &s);
    q->point = (sl_lit_point){s.position, s.normal, s.geometric_normal, p->triangle};
    q->material = s.material;
    q->eye = scene->camera.eye;
    q->radiance = sl_material_is_glossy(s.material) || sl_material_is_mirror(s.material);
}

static void find_points(render_cache *c, size_t count, sl_counters *counters) {
    view v = view_of(c);
    for (size_t first = 0; first < count; first += SL_PACKET) {
        sl_ray16 rays;
        sl_hit16 hits;
        unsigned lanes = (unsigned)(count - first < SL_PACKET ? count - first : SL_PACKET);
        for (unsigned i = 0; i < lanes; i++) set_ray(c, &v, c->chosen[first + i], &rays, i);
        sl_trace(*c->s.tracer, &rays, lanes, false, &hits, counters);
        for (unsigned i = 0; i < lanes; i++)
            meet(c, &rays, &hits, i, &c->fresh[first + i], &c->request[first + i]);
    }
}

/* Points on the background are black requests: renderers see those that lie on surfaces alone. */
static void shade_points(render_cache *c, size_t count, sl_counters *counters) {
    size_t shaded = 0;
    for (size_t i = 0; i < count; i++)
        if (c->fresh[i].triangle != SL_NO_INDEX) c->request[shaded++] = c->request[i];
    for (size_t i = 0; i < shaded; i++) c->sample[i] = (sl_sample){.valid = true};
    for (int r = 0; r < c->s.renderers; r++) {
        sl_render(&c->s.renderer[r], shaded, c->request, c->s.threads, c->part, counters);
        for (size_t i = 0; i < shaded; i++) {
            c->sample[i].irradiance = sl_rgb_add(c->sample[i].irradiance, c->part[i].irradiance);
            c->sample[i].radiance = sl_rgb_add(c->sample[i].radiance, c->part[i].radiance);
        }
    }
    size_t next = 0;
    for (size_t i = 0; i < count; i++) {
        cached_point *p = &c->fresh[i];
        sl_rgb color = {0.0f, 0.0f, 0.0f};
        if (p->triangle == SL_NO_INDEX) {
            color = sl_environment_radiance(&c->s.scene->environment,
                                            sl_v3(p->place[0], p->place[1], p->place[2]));
        } else {
            const sl_sample *s = &c->sample[next];
            sl_rgb kd = sl_scene_diffuse(c->s.scene, p->triangle, p->place[0], p->place[1]);
            color =
                sl_rgb_add(sl_rgb_mul(sl_rgb_scale(s->irradiance, (float)(1.0 / SL_PI)), kd), s->radiance);
            color = sl_rgb_add(
                color, sl_scene_emission(c->s.scene, p->triangle, c->request[next].point.geometric_normal));
            next++;
        }
        p->color[0] = color.r, p->color[1] = color.g, p->color[2] = color.b;
    }
    c->samples += shaded;
}

/* The pixel's own point makes room; else the oldest of the next eight slots. */
static size_t slot_for(render_cache *c, uint32_t pixel) {
    if (c->kept[pixel] != SL_NO_INDEX) return c->kept[pixel];
    size_t best = c->next;
    for (size_t i = 0; i < GROUP; i++) {
        size_t at = (c->next + i) % c->capacity;
        if (!c->point[at].used) {
            best = at;
            break;
        }
        if (c->point[at].age > c->point[best].age) best = at;
    }
    c->next = (c->next + GROUP) % c->capacity;
    return best;
}

static bool looks_otherwise(const float a[3], const float b[3]) {
    float apart = 0.0f, largest = 0.0f;
    for (int k = 0; k < 3; k++)
        apart = fmaxf(apart, fabsf(a[k] - b[k])), largest = fmaxf(largest, fmaxf(fabsf(a[k]), fabsf(b[k])));
    return apart > color_change * largest;
}

static void age_around(render_cache *c, uint32_t pixel) {
    window w = window_around(c, pixel, CHANGE_RADIUS);
    for (int y = w.y0; y <= w.y1; y++) {
        for (int x = w.x0; x <= w.x1; x++) {
            uint32_t at = c->kept[(size_t)y * (size_t)c->s.width + (size_t)x];
            if (at == SL_NO_INDEX || c->point[at].age < YOUNG) continue;
            c->point[at].age =
                (uint8_t)(c->point[at].age + AGED_BY_CHANGE < OLD ? c->point[at].age + AGED_BY_CHANGE : OLD);
        }
    }
}

static void store_points(render_cache *c, size_t count) {
    for (size_t i = 0; i < count; i++) {
        uint32_t pixel = c->chosen[i];
        size_t slot = slot_for(c, pixel);
        cached_point *p = &c->point[slot];
        bool again = c->kept[pixel] == slot;
        if (again && looks_otherwise(p->color, c->fresh[i].color)) age_around(c, pixel);
        *p = c->fresh[i];
    }
}

/* ---- a frame ---- */

void render_cache_show(render_cache *c, bool wide_fill) {
    project_points(c);
    cull_by_depth(c);
    show(c, wide_fill);
}

void render_cache_frame(render_cache *c, sl_counters *counters) {
    render_cache_show(c, false);
    grow_older(c);
    size_t count = choose_pixels(c);
    find_points(c, count, counters);
    shade_points(c, count, counters);
    store_points(c, count);
    c->frames++;
}

void render_cache_reference(const render_cache_settings *settings, size_t count, const uint32_t *pixels,
                            float *values) {
    render_cache_settings s = *settings;
    sl_counters counters = {{0}};
    s.samples = (int)count;
    render_cache *c = render_cache_create(&s);
    memcpy(c->chosen, pixels, count * sizeof *pixels);
    find_points(c, count, &counters);
    shade_points(c, count, &counters);
    for (size_t i = 0; i < count; i++) memcpy(values + 3 * i, c->fresh[i].color, sizeof c->fresh[i].color);
    render_cache_destroy(c);
}

const float *render_cache_picture(const render_cache *c) { return c->picture; }
uint64_t render_cache_samples(const render_cache *c) { return c->samples; }
