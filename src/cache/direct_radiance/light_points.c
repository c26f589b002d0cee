#include "cache/direct_radiance/light_points.h"

#include <math.h>

enum { EDGES_TRIED = 192, CORNERS_MAX = 8 };

/* The light's plane, and the rectangle that holds it. */
typedef struct {
    sl_vec3d origin, x, y;
    double left, right, bottom, top;
} rectangle;

typedef struct {
    double x, y;
} place;

static place place_of(const rectangle *r, sl_vec3 p) {
    sl_vec3d d = sl_subd(sl_to_double(p), r->origin);
    return (place){sl_dotd(d, r->x), sl_dotd(d, r->y)};
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
            place p = place_of(r, corner_of(s, emitter[i], k));
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
static bool least_rectangle(const sl_scene *s, const sl_map_light *light, const uint32_t *emitter, rectangle *least) {
    bool found = false;
    for (size_t i = 0; i < light->count && 3 * i < EDGES_TRIED; i++) {
        for (int k = 0; k < 3; k++) {
            rectangle r = {0};
            if (!axes_along(light, sl_sub(corner_of(s, emitter[i], (k + 1) % 3), corner_of(s, emitter[i], k)), &r)) continue;
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
static int cut(const place *in, int count, bool vertical, double sign, double limit, place *out) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        place a = in[i], b = in[(i + 1) % count];
        double da = sign * (limit - (vertical ? a.y : a.x)), db = sign * (limit - (vertical ? b.y : b.x));
        if (da >= 0.0) out[kept++] = a;
        if ((da >= 0.0) != (db >= 0.0)) {
            double t = da / (da - db);
            out[kept++] = (place){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)};
        }
    }
    return kept;
}

typedef struct {
    double flux, x, y; /* x, y: sums of places by flux */
} share;

static void add_polygon(const place *p, int count, double radiance, share *sum) {
    for (int i = 1; i + 1 < count; i++) {
        double area = 0.5 * fabs((p[i].x - p[0].x) * (p[i + 1].y - p[0].y) - (p[i + 1].x - p[0].x) * (p[i].y - p[0].y));
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
    for (int k = 0; k < 3; k++) *at = sl_addd(*at, sl_scaled(sl_to_double(sl_scene_position(scene, scene->vertex[k][triangle])), w[k]));
    return true;
}

/* Point by point: what a mask leaves is no polygon. */
static void add_masked(const sl_scene *s, const sl_emitter *e, const rectangle *r, const rectangle *cell, share *sum) {
    const int count = sl_scene_mask_points(s, e->triangle);
    const double flux = (double)sl_rgb_mean(e->radiance) * (double)e->area / count;
    for (int i = 0; i < count; i++) {
        sl_vec3d at;
        if (!sl_map_light_mask_point(s, e->triangle, i, &at)) continue;
        const place p = place_of(r, sl_to_float(at));
        if (p.x < cell->left || p.x >= cell->right || p.y < cell->bottom || p.y >= cell->top) continue;
        sum->flux += flux;
        sum->x += flux * p.x;
        sum->y += flux * p.y;
    }
}

static share share_of_cell(const sl_scene *s, const sl_map_light *light, const uint32_t *emitter, const rectangle *r, const rectangle *cell) {
    share sum = {0};
    for (size_t i = 0; i < light->count; i++) {
        const sl_emitter *e = &s->emitters[emitter[i]];
        place a[CORNERS_MAX], b[CORNERS_MAX];
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

size_t sl_map_light_divide(const sl_scene *scene, const sl_map_light *light, const uint32_t *emitter, int n, sl_map_light_point *point) {
    rectangle r = {0};
    double total = 0.0;
    size_t count = 0;
    point[0] = (sl_map_light_point){.position = light->position, .intensity = light->intensity};
    if (n <= 1 || !least_rectangle(scene, light, emitter, &r)) return 1;
    for (int i = 0; i < n * n; i++) {
        rectangle cell = cell_of(&r, n, i % n, i / n);
        share part = share_of_cell(scene, light, emitter, &r, &cell);
        if (!(part.flux > 0.0)) continue;
        sl_vec3d middle = sl_addd(sl_scaled(r.x, part.x / part.flux), sl_scaled(r.y, part.y / part.flux));
        point[count++] = (sl_map_light_point){.position = sl_to_float(sl_addd(r.origin, middle)), .intensity = sl_grey((float)part.flux)};
        total += (double)(float)part.flux;
    }
    for (size_t i = 0; i < count; i++)
        point[i].intensity = sl_rgb_scale(light->intensity, (float)((double)point[i].intensity.r / total));
    return count > 0 ? count : 1;
}
