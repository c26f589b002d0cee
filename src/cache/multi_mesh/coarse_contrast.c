/* Where the coarse mesh is too coarse for the light on it. Its edges are a share of the whole scene's size: a
 * patch of sun on a floor, a window's jamb or a lamp's shade is smaller than that where there is a garden
 * around the house. As in the meshes that are displayed, light that differs too much between corners is
 * looked at more closely: once, two levels further down, and no more triangles are added than were there,
 * those that matter most first. */
#include <stdlib.h>

#include "base/error.h"
#include "base/memory.h"
#include "cache/multi_mesh/coarse_tables.h"

enum { BUDGET_LEAST = 4096 };

typedef struct candidate {
    double weight;             /* contrast times area */
    uint32_t triangle;         /* of the scene */
    size_t parts;              /* coarse triangles that cutting it adds */
} candidate;

static int by_weight(const void *a, const void *b) {
    const candidate *x = a, *y = b;
    if (x->weight != y->weight) return x->weight > y->weight ? -1 : 1;
    return x->triangle < y->triangle ? -1 : x->triangle > y->triangle;
}

static float mean_of(const float *colour) { return (colour[0] + colour[1] + colour[2]) * (1.0f / 3.0f); }

/* The most that reflected light differs by between corners of a coarse triangle. */
static float contrast_in(const sl_coarse *c, uint32_t face) {
    if (c->level[face] == SL_COARSE_ABSENT) return 0.0f;
    const float *colour = c->colour + (size_t)c->face[face].first * SL_COARSE_FLOATS;
    float most = 0.0f;
    for (int k = 0; k < sl_coarse_triangles(c, face); k++, colour += SL_COARSE_FLOATS) {
        float b = mean_of(colour + 3), d = mean_of(colour + 6);
        most = fmaxf(most, fmaxf(fabsf(b - d), fmaxf(fabsf(b), fabsf(d))));
    }
    return most;
}

/* The area; the longest edge. */
static double measure(const sl_scene *scene, uint32_t triangle, double *longest) {
    sl_vec3d p[3];
    *longest = 0.0;
    for (int k = 0; k < 3; k++) p[k] = sl_to_double(sl_scene_position(scene, scene->vertex[k][triangle]));
    for (int k = 0; k < 3; k++) *longest = fmax(*longest, sl_lengthd(sl_subd(p[(k + 1) % 3], p[k])));
    return 0.5 * sl_lengthd(sl_crossd(sl_subd(p[1], p[0]), sl_subd(p[2], p[0])));
}

static size_t parts_added(const sl_coarse *c, uint32_t face) {
    if (c->level[face] == SL_COARSE_ABSENT) return 0;
    size_t now = (size_t)sl_coarse_triangles(c, face);
    return now * (sl_coarse_is_sliced(c, face) ? 4 : 16) - now; /* at most */
}

static size_t find_candidates(const sl_coarse *c, float noticed, candidate *found) {
    size_t count = 0;
    for (uint32_t t = 0; t < c->topology->face_count / 2; t++) {
        float contrast = fmaxf(contrast_in(c, 2 * t), contrast_in(c, 2 * t + 1));
        double longest, area = measure(c->scene, t, &longest);
        if (!(contrast > noticed) || !(longest > SL_COARSE_FINER * (double)c->edge)) continue;
        found[count++] =
            (candidate){(double)contrast * area, t, parts_added(c, 2 * t) + parts_added(c, 2 * t + 1)};
    }
    return count;
}

sl_status sl_coarse_find_contrasts(const sl_coarse *c, float noticed, uint8_t **finer, sl_error *error) {
    size_t triangles = c->topology->face_count / 2,
           budget = c->triangle_count > BUDGET_LEAST ? c->triangle_count : BUDGET_LEAST;
    candidate *found = sl_allocate(triangles + 1, sizeof *found);
    *finer = found ? sl_allocate(triangles + 1, 1) : NULL;
    if (!*finer) {
        sl_free(found);
        return sl_fail_memory(error, "the coarse mesh");
    }
    size_t count = find_candidates(c, noticed, found), chosen = 0;
    qsort(found, count, sizeof *found, by_weight);
    for (size_t i = 0; i < count; i++) {
        if (found[i].parts > budget) continue;
        budget -= found[i].parts;
        (*finer)[found[i].triangle] = 1;
        chosen++;
    }
    sl_free(found);
    if (chosen) return SL_OK;
    sl_free(*finer);
    *finer = NULL;
    return SL_OK;
}
