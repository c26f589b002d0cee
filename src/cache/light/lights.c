/* Which lights there are (lights.h). Emissive triangles of one object and radiance belong together. Where
 * they lie in one plane they are one planar light, wherever in it they are. Where they do not, what hangs
 * together by common corners is a light of its own (a lamp of four bulbs is four lights, each of which a
 * frustum can hold), planar or solid, or, where it is a hollow of few planes, as many planar ones; but where
 * that would be a swarm, all of it is one solid light. */
#include "cache/light/lights.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

enum { PIECES_MAX = 64 };

/* An emissive triangle, as it is sorted: by what may make it one light with others, then by the piece, then
 * by its number. */
typedef struct {
    uint32_t kind[5];     /* object, radiance (its bits), whether two-sided */
    uint32_t triangle;
    uint32_t piece;       /* the lowest place in the run of what it hangs together with */
    bool two_sided;
} source;

/* A corner's position as bits, and the place in the run of its triangle. */
typedef struct {
    uint32_t bits[3], place;
} corner_place;

static int compare_words(const uint32_t *a, const uint32_t *b, size_t count) {
    for (size_t i = 0; i < count; i++) {
        if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
    }
    return 0;
}

static int by_kind(const void *a, const void *b) {
    const source *s = a, *t = b;
    int order = compare_words(s->kind, t->kind, 5);
    return order ? order : compare_words(&s->triangle, &t->triangle, 1);
}

static int by_piece(const void *a, const void *b) {
    const source *s = a, *t = b;
    int order = compare_words(&s->piece, &t->piece, 1);
    return order ? order : compare_words(&s->triangle, &t->triangle, 1);
}

static int by_position(const void *a, const void *b) {
    const corner_place *s = a, *t = b;
    int order = compare_words(s->bits, t->bits, 3);
    return order ? order : compare_words(&s->place, &t->place, 1);
}

static int by_first_triangle(const void *a, const void *b) {
    const sl_sampled_light *s = a, *t = b;
    return compare_words(s->triangle, t->triangle, 1);
}

/* ---- one plane? ---- */

/* The triangle's corners as it shines; cross: its normal, twice its area long. */
static void corners_of(const sl_scene *scene, uint32_t triangle, sl_vec3 corner[3], sl_vec3d *cross) {
    for (int k = 0; k < 3; k++) corner[k] = sl_scene_position(scene, scene->vertex[k][triangle]);
    sl_vec3d a = sl_to_double(corner[0]);
    *cross = sl_crossd(sl_subd(sl_to_double(corner[1]), a), sl_subd(sl_to_double(corner[2]), a));
}

/* The plane of the largest triangle must hold all corners, but for a hundred-thousandth of the light's size
 * and the roundings of its coordinates, and all must shine to the same side. */
static bool one_plane(const sl_scene *scene, const source *s, size_t count, sl_vec3 *normal) {
    double largest = -1.0, size = 0.0, extent = 0.0;
    sl_vec3 corner[3], origin = {0, 0, 0};
    sl_vec3d cross, n = {0, 0, 0};
    for (size_t i = 0; i < count; i++) {
        corners_of(scene, s[i].triangle, corner, &cross);
        double length = sl_lengthd(cross);
        if (!(length > largest)) continue;
        largest = length;
        origin = corner[0];
        n = length > 0.0 ? sl_scaled(cross, 1.0 / length) : cross;
    }
    double off = 0.0;
    for (size_t i = 0; i < count; i++) {
        corners_of(scene, s[i].triangle, corner, &cross);
        double turned = sl_dotd(cross, n);
        if (s[i].two_sided ? !(fabs(turned) > 0.0) : !(turned > 0.0)) return false;
        for (int k = 0; k < 3; k++) {
            sl_vec3d d = sl_subd(sl_to_double(corner[k]), sl_to_double(origin));
            off = fmax(off, fabs(sl_dotd(d, n)));
            extent = fmax(extent, sl_lengthd(d));
            size =
                fmax(size, (double)fmaxf(fabsf(corner[k].x), fmaxf(fabsf(corner[k].y), fabsf(corner[k].z))));
        }
    }
    *normal = sl_normalize_or(sl_to_float(n), sl_v3(0, 1, 0));
    return off <= 1e-5 * extent + 4e-7 * size;
}

/* ---- pieces that hang together ---- */

static uint32_t root_of(uint32_t *parent, uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

static uint32_t position_bits(float x) { return sl_float_bits(x == 0.0f ? 0.0f : x); }

/* Sorts the run by pieces; returns how many there are. */
static sl_status find_pieces(const sl_scene *scene, source *s, size_t count, size_t *pieces,
                             sl_error *error) {
    uint32_t *parent = sl_allocate(count, sizeof *parent);
    corner_place *corners = sl_allocate(3 * count, sizeof *corners);
    if (!parent || !corners) {
        sl_free(parent);
        sl_free(corners);
        return sl_fail_memory(error, "the scene's lamps");
    }
    for (size_t i = 0; i < count; i++) {
        parent[i] = (uint32_t)i;
        for (size_t k = 0; k < 3; k++) {
            sl_vec3 p = sl_scene_position(scene, scene->vertex[k][s[i].triangle]);
            corners[3 * i + k] =
                (corner_place){{position_bits(p.x), position_bits(p.y), position_bits(p.z)}, (uint32_t)i};
        }
    }
    qsort(corners, 3 * count, sizeof *corners, by_position);
    for (size_t i = 1; i < 3 * count; i++) {
        if (memcmp(corners[i].bits, corners[i - 1].bits, sizeof corners[i].bits) != 0) continue;
        uint32_t a = root_of(parent, corners[i - 1].place), b = root_of(parent, corners[i].place);
        if (a != b) parent[a > b ? a : b] = a < b ? a : b; /* the lowest is the root */
    }
    *pieces = 0;
    for (size_t i = 0; i < count; i++) {
        s[i].piece = root_of(parent, (uint32_t)i);
        *pieces += s[i].piece == (uint32_t)i;
    }
    if (*pieces <= PIECES_MAX) qsort(s, count, sizeof *s, by_piece);
    sl_free(parent);
    sl_free(corners);
    return SL_OK;
}

/* ---- lights ---- */

typedef struct {
    const sl_scene *scene;
    sl_sampled_lights *lights;
    size_t triangles;           /* stored so far */
} collection;

/* The sources are in ascending order of triangles. */
static void add_area_light(collection *c, const source *s, size_t count, bool planar, sl_vec3 normal) {
    const sl_emitter *emitter = &c->scene->emitters[c->scene->emitter_of_triangle[s->triangle]];
    sl_vec3 *corners = c->lights->corners + 3 * c->triangles;
    uint32_t *triangles = c->lights->triangles + c->triangles;
    sl_vec3d centre = {0, 0, 0};
    double area = 0.0, opaque = 0.0;
    for (size_t i = 0; i < count; i++) {
        sl_vec3 *corner = corners + 3 * i;
        sl_vec3d cross;
        corners_of(c->scene, s[i].triangle, corner, &cross);
        /* of two-sided ones: all the same way round */
        if (planar && sl_dotd(cross, sl_to_double(normal)) < 0.0) {
            sl_vec3 first = corner[1];
            corner[1] = corner[2];
            corner[2] = first;
        }
        double weight = sl_lengthd(cross);
        sl_vec3d sum =
            sl_addd(sl_addd(sl_to_double(corner[0]), sl_to_double(corner[1])), sl_to_double(corner[2]));
        centre = sl_addd(centre, sl_scaled(sum, weight / 3.0));
        area += weight;
        opaque += weight * (double)c->scene->emitters[c->scene->emitter_of_triangle[s[i].triangle]].opaque;
        triangles[i] = s[i].triangle;
    }
    const float left = area > 0.0 ? (float)(opaque / area) : 1.0f;
    sl_sampled_light *light = &c->lights->light[c->lights->count++];
    *light =
        (sl_sampled_light){.kind = planar ? SL_SOURCE_AREA : SL_SOURCE_SOLID,
                           .colour = sl_rgb_scale(sl_rgb_scale(emitter->radiance, (float)SL_PI), left),
                           .radiance = emitter->radiance,
                           .opaque = left,
                           .two_sided = emitter->two_sided,
                           .triangles = count,
                           .corner = corners,
                           .triangle = triangles,
                           .normal = planar ? normal : sl_v3(0, 0, 0),
                           .position = area > 0.0 ? sl_to_float(sl_scaled(centre, 1.0 / area)) : corners[0],
                           .object = s->kind[0]};
    for (size_t k = 0; k < 3 * count; k++)
        light->extent = fmaxf(light->extent, sl_length(sl_sub(corners[k], light->position)));
    c->triangles += count;
}

/* Returns whether a triangle has a corner before another's plane, by more than a ten-thousandth of the two
 * and roundings: it shines on it. */
static bool is_before(const sl_scene *scene, uint32_t plane, uint32_t triangle) {
    sl_vec3 a[3], b[3];
    sl_vec3d cross, other;
    corners_of(scene, plane, a, &cross);
    corners_of(scene, triangle, b, &other);
    for (int k = 0; k < 3; k++) {
        sl_vec3d d = sl_subd(sl_to_double(b[k]), sl_to_double(a[0]));
        double size = (double)fmaxf(fabsf(b[k].x), fmaxf(fabsf(b[k].y), fabsf(b[k].z)));
        if (sl_dotd(cross, d) >
            sl_lengthd(cross) * (1e-4 * (sl_lengthd(d) + sqrt(sl_lengthd(cross))) + 4e-7 * size))
            return true;
    }
    return false;
}

/* A hollow of few planes, such as a room whose walls shine: no picture holds it, seen from within. Each of
 * its planes is a light then. Marks them as pieces; false: it is convex, or has too many. */
static bool find_planes_of_hollow(const sl_scene *scene, source *s, size_t count) {
    enum { PLANES_MAX = 16 };
    uint32_t first[PLANES_MAX];
    size_t planes = 0;
    bool hollow = false;
    if (s->two_sided) return false;
    for (size_t i = 0; i < count; i++) {
        size_t k = 0;
        sl_vec3 normal;
        for (; k < planes; k++) {
            const source pair[2] = {s[first[k]], s[i]};
            if (one_plane(scene, pair, 2, &normal)) break;
        }
        if (k == PLANES_MAX) return false;
        if (k == planes) first[planes++] = (uint32_t)i;
        s[i].piece = first[k];
    }
    for (size_t i = 0; i < count && !hollow; i++) {
        for (size_t k = 0; k < planes && !hollow; k++)
            hollow = s[i].piece != first[k] && is_before(scene, s[first[k]].triangle, s[i].triangle);
    }
    return hollow;
}

/* Adds what hangs together. */
static void add_piece(collection *c, source *s, size_t count) {
    sl_vec3 normal;
    bool planar = one_plane(c->scene, s, count, &normal);
    if (planar || !find_planes_of_hollow(c->scene, s, count)) {
        add_area_light(c, s, count, planar, normal);
        return;
    }
    qsort(s, count, sizeof *s, by_piece);
    for (size_t first = 0, end; first < count; first = end) {
        for (end = first + 1; end < count && s[end].piece == s[first].piece;) end++;
        planar = one_plane(c->scene, s + first, end - first, &normal);
        add_area_light(c, s + first, end - first, planar, normal);
    }
}

/* A run of one object and radiance. */
static sl_status add_run(collection *c, source *s, size_t count, sl_error *error) {
    sl_vec3 normal;
    size_t pieces = 1;
    if (one_plane(c->scene, s, count, &normal)) {
        add_area_light(c, s, count, true, normal);
        return SL_OK;
    }
    sl_status status = find_pieces(c->scene, s, count, &pieces, error);
    if (status != SL_OK) return status;
    if (pieces > PIECES_MAX) {
        add_area_light(c, s, count, false, normal);
        return SL_OK;
    }
    for (size_t first = 0, end; first < count; first = end) {
        for (end = first + 1; end < count && s[end].piece == s[first].piece;) end++;
        add_piece(c, s + first, end - first);
    }
    return SL_OK;
}

static sl_status add_emitters(collection *c, sl_error *error) {
    const sl_scene *scene = c->scene;
    size_t count = scene->emitter_count;
    source *s = sl_allocate(count, sizeof *s);
    if (!s) return sl_fail_memory(error, "the scene's lamps");
    for (size_t i = 0; i < count; i++) {
        const sl_emitter *e = &scene->emitters[i];
        s[i] = (source){.kind = {scene->object_index[e->triangle], sl_float_bits(e->radiance.r),
                                 sl_float_bits(e->radiance.g), sl_float_bits(e->radiance.b), e->two_sided},
                        .triangle = e->triangle,
                        .two_sided = e->two_sided};
    }
    qsort(s, count, sizeof *s, by_kind);
    sl_status status = SL_OK;
    for (size_t first = 0, end; first < count && status == SL_OK; first = end) {
        for (end = first + 1; end < count && compare_words(s[first].kind, s[end].kind, 5) == 0;) end++;
        status = add_run(c, s + first, end - first, error);
    }
    sl_free(s);
    return status;
}

static void add_scene_light(sl_sampled_lights *lights, const sl_light *light) {
    if (!sl_light_is_lit(light)) return;
    lights->light[lights->count++] = (sl_sampled_light){.kind = (sl_source_kind)light->type,
                                                        .colour = light->intensity,
                                                        .position = light->position,
                                                        .direction = light->direction,
                                                        .cos_inner = light->cos_inner,
                                                        .cos_outer = light->cos_outer,
                                                        .object = SL_NO_INDEX};
}

sl_status sl_sampled_lights_find(const sl_scene *scene, sl_sampled_lights **lights, sl_error *error) {
    *lights = NULL;
    sl_sampled_lights *l = sl_allocate(1, sizeof *l);
    if (l) {
        l->light = sl_allocate(scene->emitter_count + scene->light_count, sizeof *l->light);
        l->light_of_triangle = sl_allocate(scene->triangle_count, sizeof *l->light_of_triangle);
        l->corners = sl_allocate(3 * scene->emitter_count, sizeof *l->corners);
        l->triangles = sl_allocate(scene->emitter_count, sizeof *l->triangles);
    }
    sl_status status = l && l->light && l->light_of_triangle && l->corners && l->triangles
                           ? SL_OK : sl_fail_memory(error, "the scene's lights");
    collection c = {scene, l, 0};
    if (status == SL_OK) status = add_emitters(&c, error);
    if (status != SL_OK) {
        sl_sampled_lights_destroy(l);
        return status;
    }
    qsort(l->light, l->count, sizeof *l->light, by_first_triangle);
    for (size_t t = 0; t < scene->triangle_count; t++) l->light_of_triangle[t] = SL_NO_INDEX;
    for (size_t i = 0; i < l->count; i++) {
        for (size_t k = 0; k < l->light[i].triangles; k++)
            l->light_of_triangle[l->light[i].triangle[k]] = (uint32_t)i;
    }
    for (size_t i = 0; i < scene->light_count; i++) add_scene_light(l, &scene->lights[i]);
    *lights = l;
    return SL_OK;
}

void sl_sampled_lights_destroy(sl_sampled_lights *l) {
    if (!l) return;
    sl_free(l->light);
    sl_free(l->light_of_triangle);
    sl_free(l->corners);
    sl_free(l->triangles);
    sl_free(l);
}
