#include "scene/polygons.h"

#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"

#define NONE SIZE_MAX

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

bool sl_polygons_add(sl_polygons *p, sl_polygon polygon) {
    if (!sl_make_room(&p->polygon, p->polygon_count, &p->polygon_room, sizeof polygon)) return false;
    p->polygon[p->polygon_count++] = polygon;
    return true;
}

void sl_polygons_release(sl_polygons *p) {
    for (int part = 0; part < SL_CORNER_PARTS; part++) sl_free(p->value[part]);
    sl_free(p->corner);
    sl_free(p->polygon);
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

void sl_polygon_cut(const float *positions, uint32_t count, uint32_t *triangles) {
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

typedef struct target {
    const sl_polygons *from;
    const sl_affine *placement;
    sl_affine normal_map;
    bool mirrored; /* the placement turns fronts into backs, unless two corners change places */
    uint32_t first_material;
    sl_model *model;
    sl_error *error;
} target;

static void place_corner(const target *to, const sl_corner *corner, size_t vertex) {
    const sl_polygons *from = to->from;
    const float *p = from->value[SL_CORNER_POSITION][corner->at[SL_CORNER_POSITION]];
    const sl_vec3 at =
        sl_to_float(sl_affine_point(to->placement, sl_v3d((double)p[0], (double)p[1], (double)p[2])));
    memcpy(to->model->positions + 3 * vertex, (float[3]){at.x, at.y, at.z}, 3 * sizeof(float));
    if (corner->at[SL_CORNER_UV] != SL_NO_INDEX)
        memcpy(to->model->uvs + 2 * vertex, from->value[SL_CORNER_UV][corner->at[SL_CORNER_UV]],
               2 * sizeof(float));
    if (corner->at[SL_CORNER_NORMAL] == SL_NO_INDEX) return;
    const float *n = from->value[SL_CORNER_NORMAL][corner->at[SL_CORNER_NORMAL]];
    const sl_vec3 normal = sl_affine_unit(&to->normal_map, sl_v3(n[0], n[1], n[2]));
    memcpy(to->model->normals + 3 * vertex, (float[3]){normal.x, normal.y, normal.z}, 3 * sizeof(float));
}

static sl_status place(const target *to, const sl_polygon *polygon, const sl_corner *corner,
                       uint32_t object) {
    sl_model *m = to->model;
    const uint32_t count = polygon->corner_count;
    size_t vertex, first;
    sl_status status = sl_model_add_vertices(m, count, object, &vertex, to->error);
    if (status == SL_OK) status = sl_model_add_triangles(m, count - 2, &first, to->error);
    if (status != SL_OK) return status;
    for (uint32_t i = 0; i < count; i++) place_corner(to, &corner[i], vertex + i);
    sl_polygon_cut(m->positions + 3 * vertex, count, m->indices + 3 * first);
    for (size_t t = first; t < m->triangle_count; t++) {
        uint32_t *index = m->indices + 3 * t, second = index[to->mirrored ? 2 : 1];
        index[2] = (uint32_t)vertex + index[to->mirrored ? 1 : 2];
        index[1] = (uint32_t)vertex + second;
        index[0] += (uint32_t)vertex;
        m->material_index[t] = to->first_material + polygon->material;
        m->object_index[t] = object;
    }
    return SL_OK;
}

/* Where the corners of a polygon begin, and the next polygon of its object. */
typedef struct link {
    size_t corner, next;
} link;

static sl_status place_object(const target *to, const char *name, const link *links, size_t first) {
    const sl_polygons *from = to->from;
    uint32_t object;
    sl_status status = sl_model_add_object(to->model, name, &object, to->error);
    for (size_t i = first; i < from->polygon_count && status == SL_OK; i = links[i].next)
        status = place(to, &from->polygon[i], &from->corner[links[i].corner], object);
    return status;
}

/* Chains the polygons of each object; first, last: of each, NONE where it has none. */
static void chain(const sl_polygons *p, link *links, size_t *first, size_t *last) {
    size_t corner = 0;
    for (size_t i = 0; i < p->polygon_count; corner += p->polygon[i++].corner_count) {
        const uint32_t object = p->polygon[i].object;
        links[i] = (link){corner, NONE};
        if (first[object] == NONE) first[object] = i;
        else links[last[object]].next = i;
        last[object] = i;
    }
}

sl_status sl_polygons_place(const sl_polygons *from, const sl_names *objects, const sl_affine *placement,
                            uint32_t first_material, sl_model *model, sl_error *error) {
    const target to = {from,
                       placement,
                       sl_affine_normal_map(placement),
                       sl_affine_determinant(placement) < 0.0,
                       first_material,
                       model,
                       error};
    link *links = sl_allocate(from->polygon_count, sizeof *links);
    size_t *ends = sl_allocate(2 * objects->count, sizeof *ends);
    sl_status status = links && ends ? SL_OK : sl_fail_memory(error, "polygons");
    if (status == SL_OK) {
        memset(ends, 0xff, 2 * objects->count * sizeof *ends);
        chain(from, links, ends, ends + objects->count);
    }
    for (size_t i = 0; i < objects->count && status == SL_OK; i++) {
        if (ends[i] != NONE) status = place_object(&to, objects->name[i], links, ends[i]);
    }
    sl_free(links);
    sl_free(ends);
    return status;
}
