#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/direct_radiance/lights.h"

#include <math.h>

enum { EDGES_TRIED = 192, CORNERS_MAX = 8 };

/* The light's plane, and the rectangle that holds it. */
typedef struct {
    sl_vec3d origin, x, y;
    double left, right, bottom, top;
} rectangle;

typedef struct {
    double x, y;
} plane_point;

static plane_point place_of(const rectangle *r, sl_vec3 p) {
    sl_vec3d d = sl_subd(sl_to_double(p), r->origin);
    return (plane_point){sl_dotd(d, r->x), sl_dotd(d, r->y)};
}

static sl_vec3 corner_of(const sl_scene *s, uint32_t emitter, int k) {
    return sl_scene_position(s, s->vertex[k][s->emitters[emitter].triangle]);
}

/* ---- the rectangle ---- */

static void bound(const sl_scene *s, const sl_map_light *light, const uint32_t *emitter, rectangle *r) {
    r->left = r->bottom = INFINITY;
    r->right = r->top = -INFINITY;
    for (size_t i = 0; i < light->count; i++) {
        for (int k = 0; k < 3; k++) {
            plane_point p = place_of(r, corner_of(s, emitter[i], k));
            r->left = p.x < r->left ? p.x : r->left;
            r->right = p.x > r->right ? p.x : r->right;
            r->bottom = p.y < r->bottom ? p.y : r->bottom;
            r->top = p.y > r->top ? p.y : r->top;
        }
    }
}

static bool axes_along(const sl_map_light *light, sl_vec3 edge, rectangle *r) {
    sl_vec3d n = sl_to_double(light->direction), e = sl_to_double(edge);
    sl_vec3d x = sl_subd(e, sl_scaled(n, sl_dotd(e, n)));
    double length = sl_lengthd(x);
    r->origin = sl_to_double(light->position);
    if (!(length > 1e-30)) return false;
    r->x = sl_scaled(x, 1.0 / length);
    r->y = sl_crossd(n, r->x);
    return true;
}

static double area_of(const rectangle *r) { return (r->right - r->left) * (r->top - r->bottom); }

/* The least rectangle around a convex shape has a side along one of the shape's edges. */
static bool least_rectangle(const sl_scene *s, const sl_map_light *light, const uint32_t *emitter,
                            rectangle *least) {
    bool found = false;
    for (size_t i = 0; i < light->count && 3 * i < EDGES_TRIED; i++) {
        for (int k = 0; k < 3; k++) {
            rectangle r = {0};
            if (!axes_along(light, sl_sub(corner_of(s, emitter[i], (k + 1) % 3), corner_of(s, emitter[i], k)),
                            &r))
                continue;
            bound(s, light, emitter, &r);
            if (!isfinite(area_of(&r)) || (found && !(area_of(&r) < area_of(least) * (1.0 - 1e-6)))) continue;
            *least = r;
            found = true;
        }
    }
    return found && least->right > least->left && least->top > least->bottom;
}

/* ---- its cells ---- */

/* Cuts a convex polygon by sign * (x or y) <= sign * limit. */
static int cut(const plane_point *in, int count, bool vertical, double sign, double limit, plane_point *out) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        plane_point a = in[i], b = in[(i + 1) % count];
        double da = sign * (limit - (vertical ? a.y : a.x)), db = sign * (limit - (vertical ? b.y : b.x));
        if (da >= 0.0) out[kept++] = a;
        if ((da >= 0.0) != (db >= 0.0)) {
            double t = da / (da - db);
            out[kept++] = (plane_point){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)};
        }
    }
    return kept;
}

typedef struct {
    double flux, x, y; /* x, y: sums of places by flux */
} cell_share;

static void add_polygon(const plane_point *p, int count, double radiance, cell_share *sum) {
    for (int i = 1; i + 1 < count; i++) {
        double area =
            0.5 * fabs((p[i].x - p[0].x) * (p[i + 1].y - p[0].y) - (p[i + 1].x - p[0].x) * (p[i].y - p[0].y));
        sum->flux += radiance * area;
        sum->x += radiance * area * (p[0].x + p[i].x + p[i + 1].x) / 3.0;
        sum->y += radiance * area * (p[0].y + p[i].y + p[i + 1].y) / 3.0;
    }
}

bool sl_map_light_mask_point(const sl_scene *scene, uint32_t triangle, int index, sl_vec3d *at) {
    float w1, w2;
    if (!sl_scene_mask_point(scene, triangle, index, &w1, &w2)) return false;
    const double w[3] = {1.0 - (double)w1 - (double)w2, (double)w1, (double)w2};
    *at = (sl_vec3d){0};
    for (int k = 0; k < 3; k++)
        *at =
            sl_addd(*at, sl_scaled(sl_to_double(sl_scene_position(scene, scene->vertex[k][triangle])), w[k]));
    return true;
}

/* Point by point: what a mask leaves is no polygon. */
static void add_masked(const sl_scene *s, const sl_emitter *e, const rectangle *r, const rectangle *cell,
                       cell_share *sum) {
    const int count = sl_scene_mask_points(s, e->triangle);
    const double flux = (double)sl_rgb_mean(e->radiance) * (double)e->area / count;
    for (int i = 0; i < count; i++) {
        sl_vec3d at;
        if (!sl_map_light_mask_point(s, e->triangle, i, &at)) continue;
        const plane_point p = place_of(r, sl_to_float(at));
        if (p.x < cell->left || p.x >= cell->right || p.y < cell->bottom || p.y >= cell->top) continue;
        sum->flux += flux;
        sum->x += flux * p.x;
        sum->y += flux * p.y;
    }
}

static cell_share share_of_cell(const sl_scene *s, const sl_map_light *light, const uint32_t *emitter,
                                const rectangle *r, const rectangle *cell) {
    cell_share sum = {0};
    for (size_t i = 0; i < light->count; i++) {
        const sl_emitter *e = &s->emitters[emitter[i]];
        plane_point a[CORNERS_MAX], b[CORNERS_MAX];
        if (sl_scene_has_alpha(s, e->triangle)) {
            add_masked(s, e, r, cell, &sum);
            continue;
        }
        for (int k = 0; k < 3; k++) a[k] = place_of(r, corner_of(s, emitter[i], k));
        int count = cut(a, 3, false, 1.0, cell->right, b);
        count = cut(b, count, false, -1.0, cell->left, a);
        count = cut(a, count, true, 1.0, cell->top, b);
        count = cut(b, count, true, -1.0, cell->bottom, a);
        add_polygon(a, count, (double)sl_rgb_mean(e->radiance), &sum);
    }
    return sum;
}

static rectangle cell_of(const rectangle *r, int n, int column, int row) {
    rectangle cell = *r;
    double wide = (r->right - r->left) / (double)n, high = (r->top - r->bottom) / (double)n;
    cell.left = column ? r->left + wide * (double)column : -INFINITY;
    cell.right = column + 1 < n ? r->left + wide * (double)(column + 1) : INFINITY;
    cell.bottom = row ? r->bottom + high * (double)row : -INFINITY;
    cell.top = row + 1 < n ? r->bottom + high * (double)(row + 1) : INFINITY;
    return cell;
}

size_t sl_map_light_divide(const sl_scene *scene, const sl_map_light *light, const uint32_t *emitter, int n,
                           sl_map_light_point *point) {
    rectangle r = {0};
    double total = 0.0;
    size_t count = 0;
    point[0] = (sl_map_light_point){.position = light->position, .intensity = light->intensity};
    if (n <= 1 || !least_rectangle(scene, light, emitter, &r)) return 1;
    for (int i = 0; i < n * n; i++) {
        rectangle cell = cell_of(&r, n, i % n, i / n);
        cell_share part = share_of_cell(scene, light, emitter, &r, &cell);
        if (!(part.flux > 0.0)) continue;
        sl_vec3d middle = sl_addd(sl_scaled(r.x, part.x / part.flux), sl_scaled(r.y, part.y / part.flux));
        point[count++] = (sl_map_light_point){.position = sl_to_float(sl_addd(r.origin, middle)),
                                              .intensity = sl_grey((float)part.flux)};
        total += (double)(float)part.flux;
    }
    for (size_t i = 0; i < count; i++)
        point[i].intensity = sl_rgb_scale(light->intensity, (float)((double)point[i].intensity.r / total));
    return count > 0 ? count : 1;
}

enum {
    SIZE = 16,
    TEXELS = SIZE * SIZE,
    PLACES = 4 /* each way in a cell */,
    FINEST = 8 /* lights of more points a side have them everywhere */
};

/* A picture's tangent: 127 degrees, and 4/5 of a Lambertian emitter's flux. */
static const double REACH = 2.0;
/* Views that differ less are alike; a cell is shut where less of its light gets out. */
static const double ALIKE = 0.75, SHUT = 0.02;

typedef struct {
    const sl_scene *scene;
    const sl_raster *raster;
    const sl_map_lights *lights;
    unsigned threads;
    sl_counters *counters;
    float *depth; /* of one picture */
} looking;

/* Share of what shines ahead of a place, or back, that gets farther than `near`. Flux by texel is cos^4 of
 * the angle off the axis. */
static sl_status look(const looking *l, const sl_map_light_point *place, bool back, double near, double *open,
                      sl_error *error) {
    const sl_map_light *light = &l->lights->light[place->light];
    const sl_frame frame = sl_light_frame(light);
    const sl_light_picture picture = {
        place->position,
        sl_light_side(&frame, back ? SL_LIGHT_BACK : SL_LIGHT_AHEAD),
        -REACH,
        REACH,
        -REACH,
        REACH,
        SIZE,
        SIZE,
        back,
        sl_map_light_clearance(l->scene, l->lights, place->light, place->position, back)};
    const sl_view view = sl_light_picture_view(l->scene, light, &picture);
    const sl_target target = {SIZE, SIZE, NULL, l->depth};
    double sum = 0.0, all = 0.0;
    sl_status status = sl_raster_id(l->raster, &view, l->threads, &target, l->counters, error);
    for (int i = 0; i < TEXELS; i++) {
        const double x = REACH * ((2.0 * (i % SIZE) + 1.0) / SIZE - 1.0),
                     y = REACH * ((2.0 * (i / SIZE) + 1.0) / SIZE - 1.0);
        const double squared = 1.0 + x * x + y * y, weight = 1.0 / (squared * squared),
                     inverse = (double)l->depth[i];
        all += weight;
        /* reciprocal depth: 0 where nothing is */
        if (squared > near * near * inverse * inverse) sum += weight;
    }
    *open = sum / all;
    return status;
}

/* Of both sides where both shine. */
static sl_status openness(const looking *l, const sl_map_light_point *place, double near, double *open,
                          sl_error *error) {
    double behind = 0.0;
    sl_status status = look(l, place, false, near, open, error);
    if (status != SL_OK || !l->lights->light[place->light].two_sided) return status;
    status = look(l, place, true, near, &behind, error);
    *open = 0.5 * (*open + behind);
    return status;
}

static double squared_distance(sl_vec3 a, sl_vec3 b) { return (double)sl_dot(sl_sub(a, b), sl_sub(a, b)); }

/* The point of the light, points [first, end), that is nearest. */
static size_t owner_of(const sl_map_lights *lights, size_t first, size_t end, sl_vec3 position) {
    size_t best = first;
    for (size_t i = first + 1; i < end; i++) {
        if (squared_distance(lights->point[i].position, position) <
            squared_distance(lights->point[best].position, position))
            best = i;
    }
    return best;
}

typedef struct {
    sl_map_light_point at;
    size_t owner;
    double open;
} candidate;

/* The place whose view is most like the cell's, the one nearer to its middle of two; moves the point there.
 */
static void settle(sl_map_light_point *point, double side, const candidate *places, size_t count,
                   size_t owner, double own, sl_light_openings *found) {
    double flux = 0.0, open = 0.0, least = INFINITY;
    const candidate *best = NULL;
    for (size_t i = 0; i < count; i++) {
        if (places[i].owner != owner) continue;
        const double share = (double)sl_rgb_mean(places[i].at.intensity);
        flux += share;
        open += share * places[i].open;
    }
    if (!(flux > 0.0)) return;
    open /= flux;
    found->shut += open < SHUT;
    if (open < SHUT || (own >= ALIKE * open && own * ALIKE <= open)) return;
    for (size_t i = 0; i < count; i++) {
        if (places[i].owner != owner || places[i].open < 0.5 * open) continue;
        const double ratio = places[i].open / open,
                     cost = fabs(ratio > 1.0 ? ratio - 1.0 : 1.0 / ratio - 1.0) +
                            0.25 * squared_distance(places[i].at.position, point->position) / (side * side);
        if (cost < least) best = &places[i];
        least = cost < least ? cost : least;
    }
    if (!best) return;
    point->position = best->at.position;
    point->intensity = sl_rgb_scale(point->intensity, (float)fmin(open / best->open, 2.0));
    found->moved++;
}

/* Points [first, end) of a light whose cells are `side` wide. */
static sl_status examine(const looking *l, unsigned subdivision, size_t first, size_t end, double side,
                         const double *own, sl_map_lights *lights, sl_light_openings *found,
                         sl_error *error) {
    const uint32_t index = lights->point[first].light;
    const sl_map_light *light = &lights->light[index];
    const int n = (int)subdivision * PLACES;
    sl_map_light_point *fine = sl_allocate((size_t)(n * n), sizeof *fine);
    candidate *places = sl_allocate((size_t)(n * n), sizeof *places);
    sl_status status = fine && places ? SL_OK : sl_fail_memory(error, "places of an area light");
    size_t count =
        status == SL_OK ? sl_map_light_divide(l->scene, light, lights->emitter + light->first, n, fine) : 0;
    for (size_t i = 0; i < count && status == SL_OK; i++) {
        fine[i].light = index;
        places[i] = (candidate){fine[i], owner_of(lights, first, end, fine[i].position), 0.0};
        status = openness(l, &places[i].at, 0.5 * side, &places[i].open, error);
    }
    /* owners are told by where points stood */
    sl_map_light_point *moved = sl_allocate(end - first, sizeof *moved);
    if (status == SL_OK && !moved) status = sl_fail_memory(error, "points of an area light");
    for (size_t i = first; i < end && status == SL_OK; i++) {
        moved[i - first] = lights->point[i];
        settle(&moved[i - first], side, places, count, i, own[i - first], found);
    }
    for (size_t i = first; i < end && status == SL_OK; i++) lights->point[i] = moved[i - first];
    sl_free(moved);
    sl_free(places);
    sl_free(fine);
    return status;
}

/* A light that is not divided takes its map's pictures from its own place. */
static void follow(sl_map_lights *lights, size_t first, size_t end) {
    if (end - first != 1) return;
    sl_map_light *light = &lights->light[lights->point[first].light];
    light->position = lights->point[first].position;
    light->intensity = lights->point[first].intensity;
}

static sl_status visit(const looking *l, unsigned subdivision, size_t first, size_t end,
                       sl_map_lights *lights, sl_light_openings *found, sl_error *error) {
    const sl_map_light *light = &lights->light[lights->point[first].light];
    const double side = sqrt((double)light->area / (double)(end - first));
    double own[FINEST * FINEST], wide = 0.0;
    bool near = false;
    sl_status status = SL_OK;
    if (light->kind != SL_MAP_LIGHT_AREA || subdivision > FINEST || !(side > 0.0)) return SL_OK;
    found->points += end - first;
    for (size_t i = first; i < end && status == SL_OK; i++) {
        status = openness(l, &lights->point[i], side, &wide, error);
        if (status == SL_OK && wide < ALIKE)
            status = openness(l, &lights->point[i], 0.5 * side, &own[i - first], error);
        else own[i - first] = 1.0;
        near = near || wide < 1.0;
    }
    if (status != SL_OK || !near) return status;
    status = examine(l, subdivision, first, end, side, own, lights, found, error);
    if (status == SL_OK) follow(lights, first, end);
    return status;
}

sl_status sl_map_lights_find_openings(const sl_scene *scene, const sl_raster *raster, unsigned subdivision,
                                      unsigned threads, sl_map_lights *lights, sl_light_openings *found,
                                      sl_counters *counters, sl_error *error) {
    *found = (sl_light_openings){0};
    looking l = {scene, raster, lights, threads, counters, sl_allocate(TEXELS, sizeof *l.depth)};
    sl_status status = l.depth ? SL_OK : sl_fail_memory(error, "a view from a light");
    for (size_t first = 0, end; first < lights->point_count && status == SL_OK; first = end) {
        for (end = first + 1;
             end < lights->point_count && lights->point[end].light == lights->point[first].light;)
            end++;
        status = visit(&l, subdivision, first, end, lights, found, error);
    }
    sl_free(l.depth);
    return status;
}
