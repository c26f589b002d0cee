/* Coplanar triangles that lie over one another (a face modelled twice, decals, both windings of one sheet, a
 * table's legs on the floor) are one surface: its area, where photons fall, counts once. */
#include <stdlib.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/light_octree/octree.h"

/* Each triangle is compared with so many that follow it in its plane. */
enum { CANDIDATES = 64, CORNERS = 6 };

/* ---- planes ---- */

typedef struct plane_entry {
    /* of the plane, rounded: equal for one plane's triangles, but for very few at a bin's edge */
    uint32_t hash, triangle;
} plane_entry;

typedef struct shares_pass {
    const sl_scene *scene;
    sl_vec3d middle;
    double size;
    float *share;
} shares_pass;

static bool comes_before(sl_vec3 a, sl_vec3 b) {
    if (a.x != b.x) return a.x < b.x;
    return a.y != b.y ? a.y < b.y : a.z < b.z;
}

static void swap_corners(sl_vec3 *a, sl_vec3 *b) {
    sl_vec3 c = *a;
    *a = *b;
    *b = c;
}

/* Corners in one order, whatever the triangle's: so that the same three give the same bits. */
static void sorted_corners(const shares_pass *pass, uint32_t t, sl_vec3d corner[3]) {
    sl_vec3 p[3];
    for (int k = 0; k < 3; k++) p[k] = sl_scene_position(pass->scene, pass->scene->vertex[k][t]);
    if (comes_before(p[1], p[0])) swap_corners(&p[0], &p[1]);
    if (comes_before(p[2], p[1])) swap_corners(&p[1], &p[2]);
    if (comes_before(p[1], p[0])) swap_corners(&p[0], &p[1]);
    for (int k = 0; k < 3; k++) corner[k] = sl_subd(sl_to_double(p[k]), pass->middle);
}

/* Unit, one of the two; (0,0,0) without area. */
static sl_vec3d plane_normal(const sl_vec3d corner[3]) {
    sl_vec3d n = sl_crossd(sl_subd(corner[1], corner[0]), sl_subd(corner[2], corner[0]));
    double length = sl_lengthd(n);
    if (!(length > 0.0)) return sl_v3d(0.0, 0.0, 0.0);
    double largest = fabs(n.x) >= fabs(n.y) && fabs(n.x) >= fabs(n.z) ? n.x
                     : fabs(n.y) >= fabs(n.z)                         ? n.y
                                                                      : n.z;
    return sl_scaled(n, (largest < 0.0 ? -1.0 : 1.0) / length);
}

static uint64_t bin(double v) { return (uint64_t)(int64_t)floor(v + 0.5); }

static plane_entry entry_of(const shares_pass *pass, uint32_t t) {
    sl_vec3d corner[3];
    sorted_corners(pass, t, corner);
    sl_vec3d n = plane_normal(corner);
    uint64_t key = sl_hash64(bin(700.0 * n.x) << 32 ^ bin(700.0 * n.y) << 16 ^ bin(700.0 * n.z));
    key = sl_hash64(key ^ bin(30011.0 * sl_dotd(n, corner[0]) / pass->size));
    return (plane_entry){(uint32_t)(key >> 32), t};
}

static int by_plane(const void *a, const void *b) {
    const plane_entry *p = a, *q = b;
    if (p->hash != q->hash) return p->hash < q->hash ? -1 : 1;
    return (p->triangle > q->triangle) - (p->triangle < q->triangle);
}

/* ---- overlaps in one plane ---- */

typedef struct flat_point {
    double x, y;
} flat_point;

typedef struct flat_triangle {
    flat_point corner[3];   /* counter-clockwise */
    double area, left, right;
    sl_vec3d normal;
    double offset;
    uint32_t triangle;
    double covered;
} flat_triangle;

static double cross(flat_point o, flat_point a, flat_point b) {
    return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

/* On the coordinate plane that the normal leaves largest: all areas shrink alike. */
static flat_triangle flatten(const shares_pass *pass, uint32_t t) {
    sl_vec3d c[3];
    sorted_corners(pass, t, c);
    flat_triangle f = {.normal = plane_normal(c), .triangle = t};
    sl_vec3d n = f.normal;
    f.offset = sl_dotd(n, c[0]);
    for (int k = 0; k < 3; k++) {
        bool x = fabs(n.x) >= fabs(n.y) && fabs(n.x) >= fabs(n.z), y = !x && fabs(n.y) >= fabs(n.z);
        f.corner[k] = x   ? (flat_point){c[k].y, c[k].z}
                      : y ? (flat_point){c[k].z, c[k].x}
                          : (flat_point){c[k].x, c[k].y};
    }
    f.area = 0.5 * cross(f.corner[0], f.corner[1], f.corner[2]);
    if (f.area < 0.0) {
        flat_point p = f.corner[1];
        f.corner[1] = f.corner[2];
        f.corner[2] = p;
        f.area = -f.area;
    }
    f.left = fmin(f.corner[0].x, fmin(f.corner[1].x, f.corner[2].x));
    f.right = fmax(f.corner[0].x, fmax(f.corner[1].x, f.corner[2].x));
    return f;
}

/* Is all of b on the outer side of one of a's edges, but for a sliver? Neighbours in a mesh are. */
static bool separated(const flat_triangle *a, const flat_triangle *b) {
    double least = 1e-5 * (a->area < b->area ? a->area : b->area);
    for (int k = 0; k < 3; k++) {
        flat_point p = a->corner[k], q = a->corner[(k + 1) % 3];
        if (cross(p, q, b->corner[0]) <= least && cross(p, q, b->corner[1]) <= least &&
            cross(p, q, b->corner[2]) <= least)
            return true;
    }
    return false;
}

/* Clips b by a's three edges. */
static double overlap(const flat_triangle *a, const flat_triangle *b) {
    flat_point polygon[CORNERS + 1], kept[CORNERS + 1];
    int count = 3;
    for (int k = 0; k < 3; k++) polygon[k] = b->corner[k];
    for (int k = 0; k < 3; k++) {
        flat_point p = a->corner[k], q = a->corner[(k + 1) % 3];
        int left = 0;
        for (int i = 0; i < count; i++) {
            flat_point u = polygon[i], v = polygon[(i + 1) % count];
            double hu = cross(p, q, u), hv = cross(p, q, v);
            if (hu >= 0.0) kept[left++] = u;
            if ((hu > 0.0 && hv < 0.0) || (hu < 0.0 && hv > 0.0)) {
                double s = hu / (hu - hv);
                kept[left++] = (flat_point){u.x + s * (v.x - u.x), u.y + s * (v.y - u.y)};
            }
        }
        count = left;
        for (int i = 0; i < count; i++) polygon[i] = kept[i];
    }
    double area = 0.0;
    for (int i = 1; i + 1 < count; i++) area += 0.5 * cross(polygon[0], polygon[i], polygon[i + 1]);
    return area;
}

static int by_left(const void *a, const void *b) {
    const flat_triangle *p = a, *q = b;
    if (p->left != q->left) return p->left < q->left ? -1 : 1;
    return p->triangle < q->triangle ? -1 : p->triangle > q->triangle;
}

/* The smaller of two gives way, since what a share tells of a triangle holds all over it: of a wall's face
 * the end of another that meets it takes nothing. Of equal ones the higher number does. */
static bool gives_way(const flat_triangle *a, const flat_triangle *b) {
    if (fabs(a->area - b->area) > 1e-6 * b->area) return a->area < b->area;
    return a->triangle > b->triangle;
}

static void cover(const shares_pass *pass, flat_triangle *a, flat_triangle *b) {
    if (fabs(sl_dotd(a->normal, b->normal)) < 1.0 - 1e-6 || fabs(a->offset - b->offset) > 1e-6 * pass->size)
        return;
    if (!(a->area > 0.0 && b->area > 0.0) || separated(a, b) || separated(b, a)) return;
    flat_triangle *lesser = gives_way(a, b) ? a : b;
    lesser->covered += overlap(a, b) / lesser->area;
}

static void cover_group(const shares_pass *pass, const plane_entry *entry, flat_triangle *flat,
                        size_t count) {
    for (size_t i = 0; i < count; i++) flat[i] = flatten(pass, entry[i].triangle);
    qsort(flat, count, sizeof *flat, by_left);
    for (size_t i = 0; i < count; i++) {
        for (size_t k = i + 1; k < count && k <= i + CANDIDATES && flat[k].left < flat[i].right; k++)
            cover(pass, &flat[i], &flat[k]);
    }
    for (size_t i = 0; i < count; i++) {
        if (flat[i].covered > 1e-4)
            pass->share[flat[i].triangle] =
                flat[i].covered < 1.0 - 1e-4 ? (float)(1.0 - flat[i].covered) : 0.0f;
    }
}

sl_status sl_coplanar_shares(const sl_scene *scene, float *share, sl_error *error) {
    size_t count = scene->triangle_count;
    shares_pass pass = {
        .scene = scene,
        .size = (double)scene->scale,
        .middle = sl_scaled(sl_addd(sl_to_double(scene->box_min), sl_to_double(scene->box_max)), 0.5),
        .share = share};
    plane_entry *entry = sl_allocate(count, sizeof *entry);
    flat_triangle *flat = sl_allocate(count, sizeof *flat);
    bool good = entry && flat;
    for (uint32_t t = 0; good && t < count; t++) {
        entry[t] = entry_of(&pass, t);
        share[t] = 1.0f;
    }
    if (good) qsort(entry, count, sizeof *entry, by_plane);
    for (size_t i = 0, end; good && i < count; i = end) {
        for (end = i + 1; end < count && entry[end].hash == entry[i].hash;) end++;
        if (end - i > 1) cover_group(&pass, entry + i, flat, end - i);
    }
    sl_free(entry);
    sl_free(flat);
    return good ? SL_OK : sl_fail_memory(error, "coplanar triangles");
}
