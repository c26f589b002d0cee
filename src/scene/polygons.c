#include "scene/polygons.h"

#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"

/* ---- lists ------------------------------------------------------------------------------------------ */

bool sl_polygons_add_value(sl_polygons *p, sl_corner_part part, const float value[3]) {
    if (!sl_make_room(&p->value[part], p->count[part], &p->room[part], 3 * sizeof(float))) return false;
    memcpy(p->value[part][p->count[part]++], value, 3 * sizeof(float));
    return true;
}

bool sl_polygons_add_corner(sl_polygons *p, sl_corner corner) {
    if (!sl_make_room(&p->corner, p->corner_count, &p->corner_room, sizeof corner)) return false;
    p->corner[p->corner_count++] = corner;
    return true;
}

void sl_polygons_release(sl_polygons *p) {
    for (int part = 0; part < SL_CORNER_PARTS; part++) sl_free(p->value[part]);
    SL_FREE_ALL(p->corner, p->gathered, p->cut);
    *p = (sl_polygons){0};
}

/* ---- cutting ---------------------------------------------------------------------------------------- */

enum { MOST_CORNERS = 256 /* of a polygon that is cut along its diagonals: others are cut from the first */ };

/* The corners that are left, and a normal by Newell's method. */
typedef struct ring {
    const float *positions;
    uint32_t corner[MOST_CORNERS], left;
    sl_vec3d normal;
} ring;

static sl_vec3d position_of(const ring *r, uint32_t i) {
    const float *p = r->positions + 3 * r->corner[i % r->left];
    return sl_v3d((double)p[0], (double)p[1], (double)p[2]);
}

static void find_normal(ring *r) {
    for (uint32_t i = 1; i + 1 < r->left; i++) {
        sl_vec3d first = position_of(r, 0);
        r->normal = sl_addd(r->normal, sl_crossd(sl_subd(position_of(r, i), first),
                                                 sl_subd(position_of(r, i + 1), first)));
    }
}

/* Returns on which side of an edge a point is, seen against the normal: positive, to the left. */
static double side_of(const ring *r, sl_vec3d a, sl_vec3d b, sl_vec3d p) {
    return sl_dotd(r->normal, sl_crossd(sl_subd(b, a), sl_subd(p, a)));
}

/* Returns whether a corner sticks out, and no other lies in the triangle of it and its neighbours. */
static bool is_ear(const ring *r, uint32_t i) {
    const sl_vec3d a = position_of(r, i + r->left - 1), b = position_of(r, i), c = position_of(r, i + 1);
    if (!(side_of(r, a, b, c) >= 0.0)) return false;
    for (uint32_t k = 2; k + 1 < r->left; k++) {
        const sl_vec3d p = position_of(r, i + k);
        if (side_of(r, a, b, p) > 0.0 && side_of(r, b, c, p) > 0.0 && side_of(r, c, a, p) > 0.0) return false;
    }
    return true;
}

static void cut_at(ring *r, uint32_t i, uint32_t *triangle) {
    const uint32_t corners[3] = {r->corner[(i + r->left - 1) % r->left], r->corner[i],
                                 r->corner[(i + 1) % r->left]};
    memcpy(triangle, corners, sizeof corners);
    r->left--;
    for (; i < r->left; i++) r->corner[i] = r->corner[i + 1];
}

/* Cuts a polygon into count - 2 triangles, along its diagonals where it does not cross itself and has at most
 * 256 corners: a convex one from its first corner. positions: 3 numbers a corner; triangles: 3 numbers of
 * corners each. */
static void cut_polygon(const float *positions, uint32_t count, uint32_t *triangles) {
    ring r = {.positions = positions, .left = count};
    if (count == 3 || count > MOST_CORNERS) {
        for (uint32_t i = 0; i + 2 < count; i++)
            memcpy(triangles + 3 * (size_t)i, (uint32_t[3]){0, i + 1, i + 2}, 3 * sizeof *triangles);
        return;
    }
    for (uint32_t i = 0; i < count; i++) r.corner[i] = i;
    find_normal(&r);
    for (uint32_t at = 1; r.left >= 3; triangles += 3) {
        uint32_t tried = 0;
        while (tried++ < r.left && !is_ear(&r, at)) at = (at + 1) % r.left;
        cut_at(&r, at, triangles);
        at %= r.left;
    }
}

/* ---- into the model --------------------------------------------------------------------------------- */

static bool make_room(sl_polygons *p) {
    if (p->corner_count <= p->gathered_room) return true;
    sl_free(p->gathered);
    sl_free(p->cut);
    p->gathered_room = 2 * p->corner_count;
    p->gathered = sl_allocate_unset(8 * p->gathered_room, sizeof *p->gathered);
    p->cut = sl_allocate_unset(3 * p->gathered_room, sizeof *p->cut);
    return p->gathered && p->cut;
}

/* Returns where `numbers` numbers of each corner stand together; NULL where corners have none. */
static const float *gather(const sl_polygons *p, sl_corner_part part, size_t numbers, float *to) {
    if (p->corner[0].at[part] == SL_NO_INDEX) return NULL;
    for (size_t i = 0; i < p->corner_count; i++)
        memcpy(to + numbers * i, p->value[part][p->corner[i].at[part]], numbers * sizeof *to);
    return to;
}

sl_status sl_polygons_place(sl_polygons *p, const char *path, uint32_t material, uint32_t object,
                            const sl_affine *placement, sl_model *model, sl_error *error) {
    const size_t count = p->corner_count;
    if (!make_room(p)) return sl_fail_memory(error, path);
    const sl_mesh mesh = {"",
                          count,
                          count - 2,
                          gather(p, SL_CORNER_POSITION, 3, p->gathered),
                          gather(p, SL_CORNER_NORMAL, 3, p->gathered + 3 * count),
                          gather(p, SL_CORNER_UV, 2, p->gathered + 6 * count),
                          p->cut,
                          material,
                          object};
    cut_polygon(mesh.positions, (uint32_t)count, p->cut);
    p->corner_count = 0;
    return sl_model_add_mesh(model, path, &mesh, placement, error);
}
