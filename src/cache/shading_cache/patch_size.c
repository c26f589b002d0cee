/* How large a patch is in the picture: its corners as the camera sees them, cut at the picture's sides before the division by the distance (Sutherland
 * and Hodgman 1974), so that a floor that runs on behind the eye has a size, too. */
#include <math.h>

#include "base/math.h"
#include "cache/shading_cache/work.h"

/* Homogeneous: x/w and y/w are -1 and 1 at the picture's sides. */
typedef struct seen_point {
    double x, y, w;
} seen_point;

typedef struct seen_view {
    sl_vec3d eye, right, up, forward; /* right and up scaled by the field of view */
    double half_width, half_height;   /* pixels */
    double near;
} seen_view;

enum { SIDES = 4, POINTS_MAX = 4 + SIDES };

static seen_view view_of(const sl_scene *scene, const sl_camera *camera, int width, int height) {
    double up = sl_tan(0.5 * (double)camera->vertical_fov), right = up * (double)width / (double)height;
    return (seen_view){.eye = sl_to_double(camera->eye),
                       .right = sl_scaled(sl_to_double(camera->right), 1.0 / right),
                       .up = sl_scaled(sl_to_double(camera->up), 1.0 / up),
                       .forward = sl_scaled(sl_to_double(camera->back), -1.0),
                       .half_width = 0.5 * (double)width,
                       .half_height = 0.5 * (double)height,
                       .near = 1e-5 * (double)scene->scale};
}

static double inside(const seen_point *p, int side) {
    switch (side) {
    case 0: return p->w - p->x;
    case 1: return p->w + p->x;
    case 2: return p->w - p->y;
    default: return p->w + p->y;
    }
}

static int cut(const seen_point *in, int count, int side, seen_point *out) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        const seen_point *a = &in[i], *b = &in[i + 1 < count ? i + 1 : 0];
        double da = inside(a, side), db = inside(b, side);
        if (da >= 0.0) out[kept++] = *a;
        if ((da >= 0.0) == (db >= 0.0)) continue;
        double t = da / (da - db);
        out[kept++] = (seen_point){a->x + t * (b->x - a->x), a->y + t * (b->y - a->y), a->w + t * (b->w - a->w)};
    }
    return kept;
}

/* Adds a convex polygon of three or four corners. What is left of it inside all sides is nowhere behind the eye. */
static void add_polygon(const seen_view *view, int corners, const seen_point *corner, sl_patch_size *size) {
    seen_point a[POINTS_MAX], b[POINTS_MAX];
    int count = corners;
    for (int i = 0; i < count; i++) a[i] = corner[i];
    for (int side = 0; side < SIDES; side += 2) {
        count = cut(a, count, side, b);
        count = cut(b, count, side + 1, a);
    }
    double twice = 0.0, longest = 0.0, x[POINTS_MAX], y[POINTS_MAX];
    for (int i = 0; i < count; i++) {
        if (!(a[i].w >= view->near)) {
            *size = (sl_patch_size){HUGE_VALF, HUGE_VALF};
            return;
        }
        x[i] = a[i].x / a[i].w * view->half_width;
        y[i] = a[i].y / a[i].w * view->half_height;
    }
    for (int i = 0; i < count; i++) {
        int j = i + 1 < count ? i + 1 : 0;
        double dx = x[j] - x[i], dy = y[j] - y[i];
        twice += (x[i] - x[0]) * (y[j] - y[0]) - (x[j] - x[0]) * (y[i] - y[0]);
        longest = fmax(longest, dx * dx + dy * dy);
    }
    size->area += (float)(0.5 * fabs(twice));
    size->edge = fmaxf(size->edge, (float)sqrt(longest));
}

static seen_point seen_at(const sl_patches *p, const seen_view *view, uint32_t root, uint32_t u, uint32_t v) {
    sl_vec3d q = sl_subd(sl_to_double(sl_root_position(p->primitives, root, u, v)), view->eye);
    return (seen_point){sl_dotd(view->right, q), sl_dotd(view->up, q), sl_dotd(view->forward, q)};
}

/* A curved patch may bulge out of what its corners span, or come back to where it began: four by four cells of it, two triangles each. */
static void add_curved(const sl_patches *p, const seen_view *view, const sl_patch_place *place, sl_patch_size *size) {
    enum { CELLS = 4 };
    seen_point grid[CELLS + 1][CELLS + 1];
    uint32_t side_u = (uint32_t)(place->u[2] - place->u[0]), side_v = (uint32_t)(place->v[2] - place->v[0]);
    for (uint32_t j = 0; j <= CELLS; j++) {
        for (uint32_t i = 0; i <= CELLS; i++) {
            grid[j][i] = seen_at(p, view, place->root, place->u[0] + side_u * i / CELLS, place->v[0] + side_v * j / CELLS);
        }
    }
    for (int j = 0; j < CELLS; j++) {
        for (int i = 0; i < CELLS; i++) {
            seen_point first[3] = {grid[j][i], grid[j][i + 1], grid[j + 1][i + 1]}, second[3] = {grid[j][i], grid[j + 1][i + 1], grid[j + 1][i]};
            add_polygon(view, 3, first, size);
            add_polygon(view, 3, second, size);
        }
    }
    size->edge *= (float)CELLS; /* the patch's: its cells' sides are a quarter of that */
}

sl_patch_size sl_patch_projected(const sl_patches *p, const sl_patch_place *place, const sl_camera *camera, int width, int height) {
    seen_view view = view_of(p->primitives->scene, camera, width, height);
    sl_patch_size size = {0.0f, 0.0f};
    if (p->primitives->kind[place->root / 2] == SL_PRIMITIVE_BICUBIC) {
        add_curved(p, &view, place, &size);
        return size;
    }
    seen_point corner[4];
    for (int c = 0; c < place->corners; c++) corner[c] = seen_at(p, &view, place->root, place->u[c], place->v[c]);
    add_polygon(&view, place->corners, corner, &size);
    return size;
}
