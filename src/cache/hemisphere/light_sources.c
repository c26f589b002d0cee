#include "cache/hemisphere/light_sources.h"

#include <stdlib.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

/* Emitters within twice their extent are sampled by solid angle. */
#define NEAR_EXTENTS 2.0f

enum { COLUMNS = 24 };

static bool allocate_columns(sl_light_sources *s) {
    float **const columns[COLUMNS] = {
        &s->x,            &s->y,            &s->z,            &s->normal_x,     &s->normal_y,
        &s->normal_z,     &s->extent,       &s->near,         &s->two_sided,    &s->strength,
        &s->radiance,     &s->area,         &s->red,          &s->green,        &s->blue,
        &s->corner[0][0], &s->corner[0][1], &s->corner[0][2], &s->corner[1][0], &s->corner[1][1],
        &s->corner[1][2], &s->corner[2][0], &s->corner[2][1], &s->corner[2][2]};
    s->block = sl_allocate_planes(s->count, COLUMNS, columns);
    s->index = sl_allocate(s->count, sizeof *s->index);
    return s->block && s->index;
}

static double mean(sl_rgb c) { return ((double)c.r + (double)c.g + (double)c.b) / 3.0; }

static float finite_part(double x) { return x > 0.0 && x < 1e30 ? (float)x : 0.0f; }

/* ---- order ---- */

typedef struct placed {
    uint64_t code;
    uint32_t index;
} placed;

static int by_code(const void *a, const void *b) {
    const placed *p = a, *q = b;
    if (p->code != q->code) return p->code < q->code ? -1 : 1;
    return (p->index > q->index) - (p->index < q->index);
}

/* Bits of three coordinates interleaved, eight of each. */
static uint64_t morton_code(const sl_scene *scene, sl_vec3 p) {
    const float d[3] = {p.x - scene->central_min.x, p.y - scene->central_min.y, p.z - scene->central_min.z};
    uint64_t code = 0;
    for (int a = 0; a < 3; a++) {
        float c = d[a] / sl_scene_central_diagonal(scene) * 255.0f;
        uint64_t cell = c > 0.0f ? (uint64_t)(c < 255.0f ? c : 255.0f) : 0;
        for (int bit = 0; bit < 8; bit++) code |= (cell >> bit & 1) << (3 * bit + a);
    }
    return code;
}

static sl_vec3 middle_of(const sl_scene *scene, const sl_emitter *e) {
    sl_vec3 a = sl_scene_position(scene, scene->vertex[0][e->triangle]),
            b = sl_scene_position(scene, scene->vertex[1][e->triangle]);
    sl_vec3 c = sl_scene_position(scene, scene->vertex[2][e->triangle]);
    return sl_add(a, sl_scale(sl_add(sl_sub(b, a), sl_sub(c, a)), 1.0f / 3.0f));
}

static void place_emitters(sl_light_sources *s, placed *p) {
    const sl_scene *scene = s->scene;
    for (size_t i = 0; i < s->count; i++) s->index[i] = SL_NO_INDEX;
    for (uint32_t i = 0; i < scene->emitter_count; i++)
        p[i] = (placed){morton_code(scene, middle_of(scene, &scene->emitters[i])), i};
    qsort(p, scene->emitter_count, sizeof *p, by_code);
    for (size_t i = 0; i < scene->emitter_count; i++) s->index[i] = p[i].index;
}

/* ---- sources; strengths are absolute at first ---- */

static void fill_emitter(sl_light_sources *s, size_t i) {
    const sl_scene *scene = s->scene;
    const sl_emitter *e = &scene->emitters[s->index[i]];
    sl_vec3 corner[3], n = sl_scene_geometric_normal(scene, e->triangle), middle = middle_of(scene, e);
    for (int c = 0; c < 3; c++) {
        corner[c] = sl_scene_position(scene, scene->vertex[c][e->triangle]);
        s->corner[c][0][i] = corner[c].x, s->corner[c][1][i] = corner[c].y, s->corner[c][2][i] = corner[c].z;
    }
    s->x[i] = middle.x, s->y[i] = middle.y, s->z[i] = middle.z;
    s->normal_x[i] = n.x, s->normal_y[i] = n.y, s->normal_z[i] = n.z;
    s->extent[i] = 1e-12f;
    for (int c = 0; c < 3; c++)
        s->extent[i] = fmaxf(s->extent[i], sl_length(sl_scale(sl_sub(corner[c], middle), s->unit)));
    bool masked = sl_scene_has_alpha(scene, e->triangle); /* solid angles know no masks */
    s->near[i] = masked ? 0.0f : NEAR_EXTENTS * NEAR_EXTENTS * s->extent[i] * s->extent[i];
    s->two_sided[i] = e->two_sided ? 1.0f : 0.0f;
    s->area[i] = finite_part((double)e->area * (double)s->unit * (double)s->unit);
    s->radiance[i] = finite_part(mean(e->radiance));
    s->red[i] = e->radiance.r, s->green[i] = e->radiance.g, s->blue[i] = e->radiance.b;
}

/* Irradiance on the six planes, each texel by its middle. */
static void fill_sky(const sl_environment *e, double irradiance[6]) {
    for (int d = 0; d < 6; d++) irradiance[d] = e->width > 0 ? 0.0 : SL_PI * mean(e->constant);
    for (int row = 0; row < e->height; row++) {
        double top = sl_cos(SL_PI * row / e->height), bottom = sl_cos(SL_PI * (row + 1) / e->height),
               y = 0.5 * (top + bottom);
        double across = sqrt(fmax(0.0, 1.0 - y * y)), solid = 2.0 * SL_PI / e->width * (top - bottom);
        for (int column = 0; column < e->width; column++) {
            const float *t = e->texels + 3 * ((size_t)row * (size_t)e->width + (size_t)column);
            double phi = 2.0 * SL_PI * ((column + 0.5) / e->width - 0.5),
                   light = mean((sl_rgb){t[0], t[1], t[2]}) * solid;
            double d[3] = {across * sl_sin(phi), y, -across * sl_cos(phi)};
            for (int axis = 0; axis < 3; axis++)
                irradiance[2 * axis + (d[axis] < 0.0 ? 1 : 0)] += light * fabs(d[axis]);
        }
    }
}

/* ---- powers ---- */

/* As a surface about the scene's size away would be lit. */
static double power_of(const sl_light_sources *s, size_t i, const double sky[6]) {
    double most = 0.0;
    for (int d = 0; d < 6; d++) most = fmax(most, sky[d]);
    if (i == s->sky) return most;
    return s->index[i] == SL_NO_INDEX ? 0.0 : (double)s->radiance[i] * (double)s->area[i];
}

static double sound(double power) { return power > 0.0 && isfinite(power) ? power : 0.0; }

/* Makes strengths and radiances relative to the strongest source. */
static void scale_strengths(sl_light_sources *s, const double sky[6]) {
    double most = 0.0;
    for (size_t i = 0; i < s->count; i++) most = fmax(most, sound(power_of(s, i, sky)));
    s->absolute = finite_part(most);
    for (size_t i = 0; i < s->count && most > 0.0; i++) {
        s->strength[i] = i == s->sky ? 0.0f : (float)(sound(power_of(s, i, sky)) / most);
        s->radiance[i] = (float)((double)s->radiance[i] / most);
    }
    for (int d = 0; d < 6; d++) s->sky_irradiance[d] = most > 0.0 ? (float)(sky[d] / most) : 0.0f;
}

/* ---- all of it ---- */

static void count_blocks(sl_light_sources *s) {
    size_t emitters = (s->scene->emitter_count + SL_SOURCE_LANES - 1) / SL_SOURCE_LANES;
    bool sky = s->scene->environment.present;
    s->blocks = emitters + (sky ? 1 : 0);
    s->count = s->blocks * SL_SOURCE_LANES;
    s->sky = sky ? emitters * SL_SOURCE_LANES : s->count;
}

static void fill(sl_light_sources *s, placed *p) {
    double sky[6] = {0};
    place_emitters(s, p);
    for (size_t i = 0; i < s->count; i++) {
        s->extent[i] = 1.0f;
        if (s->index[i] != SL_NO_INDEX) fill_emitter(s, i);
    }
    if (s->sky < s->count) fill_sky(&s->scene->environment, sky);
    scale_strengths(s, sky);
}

sl_status sl_light_sources_create(const sl_scene *scene, sl_light_sources **out, sl_error *error) {
    *out = NULL;
    sl_light_sources *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "the light sources");
    int exponent;
    frexpf(scene->diagonal, &exponent);
    s->unit = ldexpf(1.0f, -exponent);
    s->scene = scene;
    count_blocks(s);
    placed *p = sl_allocate(s->count, sizeof *p);
    if (!allocate_columns(s) || !p) {
        sl_free(p);
        sl_light_sources_destroy(s);
        return sl_fail_memory(error, "the light sources");
    }
    fill(s, p);
    sl_free(p);
    *out = s;
    return SL_OK;
}

void sl_light_sources_destroy(sl_light_sources *s) {
    if (!s) return;
    sl_free(s->block);
    sl_free(s->index);
    sl_free(s);
}

size_t sl_light_sources_bytes(const sl_light_sources *s) {
    return sizeof *s + s->count * (COLUMNS * sizeof(float) + sizeof *s->index);
}
