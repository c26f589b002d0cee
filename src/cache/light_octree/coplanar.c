#include "cache/light_octree/coplanar.h"

#include <stdlib.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/random.h"

enum { CHUNK = 4096, CANDIDATES = 64, CORNERS = 6 };

/* ---- planes ---- */

typedef struct plane_entry {
    /* of the plane, rounded: equal for one plane's triangles, but for very few at a bin's edge */
    uint32_t hash, triangle;
} plane_entry;

typedef struct shares_pass {
    const sl_scene *scene;
    sl_vec3d middle;
    double size;
    plane_entry *entry;
    float *share;
    bool *covered;          /* of each chunk: some triangle is */
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

static void hash_chunk(void *context, size_t index, unsigned worker) {
    (void)worker;
    const shares_pass *pass = context;
    size_t end =
        (index + 1) * CHUNK < pass->scene->triangle_count ? (index + 1) * CHUNK : pass->scene->triangle_count;
    for (size_t t = index * CHUNK; t < end; t++) {
        sl_vec3d corner[3];
        sorted_corners(pass, (uint32_t)t, corner);
        sl_vec3d n = plane_normal(corner);
        uint64_t key = sl_hash64(bin(700.0 * n.x) << 32 ^ bin(700.0 * n.y) << 16 ^ bin(700.0 * n.z));
        key = sl_hash64(key ^ bin(30011.0 * sl_dotd(n, corner[0]) / pass->size));
        pass->entry[t] = (plane_entry){(uint32_t)(key >> 32), (uint32_t)t};
    }
}

/* Stable, by hash: triangles stay in ascending order. */
static void sort_entries(plane_entry **entry, plane_entry **spare, size_t count) {
    for (unsigned shift = 0; shift < 32; shift += 11) {
        size_t start[2048] = {0}, sum = 0;
        for (size_t i = 0; i < count; i++) start[(*entry)[i].hash >> shift & 2047]++;
        for (size_t d = 0; d < 2048; d++) {
            size_t here = start[d];
            start[d] = sum;
            sum += here;
        }
        for (size_t i = 0; i < count; i++) (*spare)[start[(*entry)[i].hash >> shift & 2047]++] = (*entry)[i];
        plane_entry *other = *entry;
        *entry = *spare;
        *spare = other;
    }
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

static bool cover_group(const shares_pass *pass, const plane_entry *entry, size_t count) {
    flat_triangle *flat = malloc(count * sizeof *flat);
    if (!flat) return false; /* then duplicates count twice */
    bool any = false;
    for (size_t i = 0; i < count; i++) flat[i] = flatten(pass, entry[i].triangle);
    qsort(flat, count, sizeof *flat, by_left);
    for (size_t i = 0; i < count; i++) {
        for (size_t k = i + 1; k < count && k <= i + CANDIDATES && flat[k].left < flat[i].right; k++)
            cover(pass, &flat[i], &flat[k]);
    }
    for (size_t i = 0; i < count; i++) {
        if (!(flat[i].covered > 1e-4)) continue;
        pass->share[flat[i].triangle] = flat[i].covered < 1.0 - 1e-4 ? (float)(1.0 - flat[i].covered) : 0.0f;
        any = true;
    }
    free(flat);
    return any;
}

/* The groups that begin in this part of the list. */
static void cover_chunk(void *context, size_t index, unsigned worker) {
    (void)worker;
    const shares_pass *pass = context;
    size_t total = pass->scene->triangle_count,
           end = (index + 1) * CHUNK < total ? (index + 1) * CHUNK : total;
    for (size_t i = index * CHUNK; i < end; i++) {
        if (i > 0 && pass->entry[i].hash == pass->entry[i - 1].hash) continue;
        size_t last = i + 1;
        while (last < total && pass->entry[last].hash == pass->entry[i].hash) last++;
        if (last - i > 1) pass->covered[index] |= cover_group(pass, pass->entry + i, last - i);
    }
}

sl_status sl_coplanar_shares(const sl_scene *scene, unsigned threads, float **share, sl_error *error) {
    *share = NULL;
    size_t count = scene->triangle_count, chunks = (count + CHUNK - 1) / CHUNK;
    shares_pass pass = {
        .scene = scene,
        .size = (double)scene->scale,
        .middle = sl_scaled(sl_addd(sl_to_double(scene->box_min), sl_to_double(scene->box_max)), 0.5),
        .entry = sl_allocate(count, sizeof *pass.entry),
        .share = sl_allocate(count, sizeof *pass.share),
        .covered = sl_allocate(chunks, sizeof *pass.covered)};
    plane_entry *spare = sl_allocate(count, sizeof *spare);
    bool good = pass.entry && pass.share && pass.covered && spare, any = false;
    if (good) {
        for (size_t i = 0; i < count; i++) pass.share[i] = 1.0f;
        sl_parallel_for(threads, chunks, hash_chunk, &pass);
        sort_entries(&pass.entry, &spare, count);
        sl_parallel_for(threads, chunks, cover_chunk, &pass);
        for (size_t i = 0; i < chunks; i++) any |= pass.covered[i];
    }
    sl_free(pass.entry);
    sl_free(spare);
    sl_free(pass.covered);
    if (any) *share = pass.share;
    else sl_free(pass.share);
    return good ? SL_OK : sl_fail_memory(error, "coplanar triangles");
}
