#include "cache/light_octree/atlas/parts.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

enum { GUTTER = 2 }; /* texels between charts */
/* Radians between a chart's plane and its triangles at most. */
static const double BEND = 60.0 / 180.0 * SL_PI;

typedef struct making {
    sl_atlas_faces faces;
    sl_atlas_charts charts;
} making;

/* Takes the plane of a chart to its place in the atlas. */
static sl_atlas_chart chart_at(const making *m, size_t id, double size, double density) {
    const sl_atlas_plane *p = &m->charts.plane[id];
    sl_vec3d centre = sl_atlas_corner(&m->faces, 3 * (size_t)m->charts.face[p->first]),
             from = sl_subd(centre, p->origin);
    return (sl_atlas_chart){.centre = sl_to_float(centre),
                            .along = {sl_to_float(sl_scaled(p->right, density / size)),
                                      sl_to_float(sl_scaled(p->up, density / size))},
                            .at = {(float)((p->x + density * sl_dotd(from, p->right)) / size),
                                   (float)((p->y + density * sl_dotd(from, p->up)) / size)}};
}

/* ---- the atlas ---- */

static sl_status make(making *m, const sl_scene *scene, sl_atlas *a, sl_error *error) {
    int needed = 0;
    sl_status status = sl_atlas_faces_create(scene, &m->faces, error);
    if (status == SL_OK) status = sl_atlas_charts_create(&m->faces, BEND, &m->charts, error);
    if (status != SL_OK) return status;
    a->chart = sl_allocate(m->charts.count, sizeof *a->chart);
    if (!a->chart) return sl_fail_memory(error, "an atlas");
    status = sl_atlas_pack(&m->charts, &m->faces, a->size, GUTTER, &a->texels_per_unit, &needed, error);
    if (status == SL_OK && !(a->texels_per_unit > 0.0))
        status = sl_fail(error, SL_ERROR_RESOURCES,
                         "an atlas of %d x %d texels is too small for %zu charts: a size of %d would do",
                         a->size, a->size, m->charts.count, needed);
    if (status != SL_OK) return status;
    a->chart_count = m->charts.count;
    for (size_t c = 0; c < a->chart_count; c++)
        a->chart[c] = chart_at(m, c, a->size, a->texels_per_unit);
    a->chart_of = m->charts.of_face;
    m->charts.of_face = NULL;
    return SL_OK;
}

sl_status sl_atlas_create(const sl_scene *scene, int size, sl_atlas **atlas, sl_error *error) {
    *atlas = NULL;
    if (!scene->triangle_count)
        return sl_fail(error, SL_ERROR_INPUT, "a scene without triangles has no atlas");
    making m = {.charts = {0}};
    sl_atlas *a = sl_allocate(1, sizeof *a);
    if (!a) return sl_fail_memory(error, "an atlas");
    *a = (sl_atlas){.size = size, .triangle_count = scene->triangle_count};
    sl_status status = make(&m, scene, a, error);
    sl_atlas_faces_release(&m.faces);
    sl_atlas_charts_release(&m.charts);
    if (status == SL_OK) *atlas = a;
    else sl_atlas_destroy(a);
    return status;
}

void sl_atlas_destroy(sl_atlas *a) {
    if (!a) return;
    SL_FREE_ALL(a->chart_of, a->chart, a);
}

size_t sl_atlas_bytes(const sl_atlas *a) {
    return sizeof *a + a->triangle_count * sizeof *a->chart_of + a->chart_count * sizeof *a->chart;
}
