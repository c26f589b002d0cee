/* The atlas of a scene: charts, each flattened, all packed; and what is done with what a step refuses. A
 * chart of which a face is flipped or overlaps another is cut in two and both parts are flattened anew; where
 * it is only slivers, they leave the chart as charts of one triangle. The last word is spoken on the
 * coordinates as they are stored, whole multiples of 2^-24: what rounding has flipped goes the same way, and
 * all are packed again. */
#include "cache/light_octree/atlas/refine.h"

#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"

/* What charts are expected to fill of the texture, before that is known. */
#define EXPECTED 0.65
/* A map that shrinks or grows a chart by more than this is none. */
#define ASTRAY 16.0
/* Charts that stretch more than this on the mean are cut: corners of boxes, mostly, whose three sides have no
 * conformal map but a bad one. */
#define STRETCH 1.1

typedef struct making {
    const sl_atlas_settings *settings;
    unsigned threads;
    sl_atlas_faces faces;
    sl_atlas_charts charts;
    sl_atlas_place *place;
    double density;         /* texels a unit */
    uint32_t *local;        /* scratch of sl_atlas_flatten() */
    uint8_t *bad;           /* of each face: flipped or overlapping */
    uint32_t *list;         /* charts to be flattened */
    size_t listed;
    bool *failed;           /* of each chart: no memory */
    float *coordinates;
} making;

/* ---- flattening ---- */

/* Largest over smallest singular value of the map from a face's own plane to the atlas. */
static double face_stretch(const sl_atlas_faces *f, size_t face, const double *s) {
    sl_vec3d p = sl_atlas_corner(f, 3 * face), a = sl_subd(sl_atlas_corner(f, 3 * face + 1), p),
             b = sl_subd(sl_atlas_corner(f, 3 * face + 2), p);
    double length = sl_lengthd(a), twice = sl_lengthd(sl_crossd(a, b));
    if (!(length > 0.0) || !(twice > 0.0)) return 1.0;
    double x = sl_dotd(a, b) / length, y = twice / length; /* corners (0,0), (length,0), (x,y) */
    double du = (s[2] - s[0]) / length, dv = (s[3] - s[1]) / length;
    double eu = (s[4] - s[0] - du * x) / y, ev = (s[5] - s[1] - dv * x) / y;
    double square = du * du + dv * dv + eu * eu + ev * ev, twice_determinant = 2.0 * fabs(du * ev - dv * eu);
    double sum = sqrt(square + twice_determinant), difference = sqrt(fmax(square - twice_determinant, 0.0));
    double smallest = sum - difference;
    return smallest > 1e-6 * sum ? (sum + difference) / smallest : 1e6;
}

/* The mean over a chart's area, slivers aside. */
static double chart_stretch(const making *m, const sl_atlas_chart *c) {
    double sum = 0.0, area = 0.0;
    for (size_t i = c->first; i < c->first + c->count; i++) {
        uint32_t f = m->charts.face[i];
        if (sl_dotd(m->faces.normal[f], m->faces.normal[f]) == 0.0) continue;
        sum += m->faces.area[f] * face_stretch(&m->faces, f, m->charts.corner + 6 * (size_t)f);
        area += m->faces.area[f];
    }
    return area > 0.0 ? sum / area : 1.0;
}

/* A chart's coordinates in whole grid units, at the density of the moment. They do not depend on where the
 * chart will lie. */
static void snap(const making *m, const sl_atlas_chart *c, int64_t *corner) {
    double scale = m->density / m->settings->size * SL_ATLAS_GRID, larger = fmax(c->width, c->height);
    /* far too large for the atlas: only to see what overlaps */
    if (larger * scale > 0x1p28) scale = 0x1p28 / larger;
    for (size_t i = 0; i < 6 * c->count; i++)
        corner[i] = (int64_t)floor(
            m->charts.corner[6 * (size_t)m->charts.face[c->first + i / 6] + i % 6] * scale + 0.5);
}

/* Marks what is flipped or overlaps in a chart. */
static bool find_bad(making *m, const sl_atlas_chart *c) {
    int64_t *corner = sl_allocate(c->count, 6 * sizeof *corner);
    uint8_t *bad = sl_allocate(c->count, sizeof *bad);
    bool good = corner && bad;
    if (good) snap(m, c, corner);
    good = good && sl_atlas_overlap(corner, c->count, bad) != SIZE_MAX;
    for (size_t i = 0; good && i < c->count; i++) m->bad[m->charts.face[c->first + i]] = bad[i];
    sl_free(corner);
    sl_free(bad);
    return good;
}

/* Charts that are flat already are looked at again, since the density has changed. */
static void flatten_task(void *context, size_t index, unsigned worker) {
    making *m = context;
    (void)worker;
    uint32_t id = m->list[index];
    const sl_atlas_chart *chart = &m->charts.chart[id];
    bool fresh = !chart->flat;
    double scale = 1.0;
    m->failed[index] = (fresh && !sl_atlas_flatten(&m->charts, &m->faces, id, m->local, &scale)) ||
                       (chart->count > 1 && !find_bad(m, chart));
    if (m->failed[index] || chart->count == 1 || !fresh) return;
    if (!(scale * ASTRAY > 1.0 && scale < ASTRAY) || chart_stretch(m, chart) > STRETCH)
        for (size_t i = 0; i < chart->count; i++) m->bad[m->charts.face[chart->first + i]] = 1;
}

/* Few bad faces, all of them thin, may leave; else the chart is to be cut. */
static bool may_leave(const making *m, const sl_atlas_chart *c, size_t bad) {
    if (c->count <= 2) return true;
    for (size_t i = c->first; i < c->first + c->count; i++) {
        sl_vec3d n = m->faces.normal[m->charts.face[i]];
        if (m->bad[m->charts.face[i]] && sl_dotd(n, n) > 0.0 && 50 * bad > c->count) return false;
    }
    return true;
}

/* Takes bad faces out of their charts, or cuts the charts, as the case may be. */
static sl_status mend(making *m, sl_error *error) {
    size_t cuts = 0;
    for (uint32_t id = 0; id < m->charts.count; id++) {
        const sl_atlas_chart *c = &m->charts.chart[id];
        size_t bad = 0;
        for (size_t i = c->first; i < c->first + c->count; i++) bad += m->bad[m->charts.face[i]];
        if (!bad || may_leave(m, c, bad)) continue;
        m->list[cuts++] = id;
        for (size_t i = c->first; i < c->first + c->count; i++) m->bad[m->charts.face[i]] = 0;
    }
    sl_status status = sl_atlas_charts_set_apart(&m->charts, &m->faces, m->bad, error);
    memset(m->bad, 0, m->faces.count);
    if (status == SL_OK && cuts)
        status = sl_atlas_charts_split(&m->charts, &m->faces, m->list, cuts, m->threads, error);
    return status == SL_OK
               ? sl_atlas_charts_unbend(&m->charts, &m->faces, sl_cos(m->settings->bend), m->threads, error)
               : status;
}

/* Until every chart is flat and without a bad face at the density of the moment. */
static sl_status flatten_all(making *m, bool *changed, sl_error *error) {
    *changed = false;
    for (int round = 0;; round++) {
        m->listed = 0;
        for (uint32_t id = 0; id < m->charts.count; id++)
            if (!round || !m->charts.chart[id].flat) m->list[m->listed++] = id;
        if (!m->listed) return SL_OK;
        *changed = *changed || round;
        sl_parallel_for(m->threads, m->listed, flatten_task, m);
        for (size_t i = 0; i < m->listed; i++)
            if (m->failed[i]) return sl_fail_memory(error, "flattening an atlas's charts");
        sl_status status = mend(m, error);
        if (status != SL_OK) return status;
    }
}

/* ---- coordinates ---- */

/* A triangle alone may be too thin for the grid: it gets at least one unit of height along its longest edge,
 * which lies along an axis. */
static void thicken(int64_t *p) {
    int64_t low[2] = {p[0], p[1]}, high[2] = {p[0], p[1]};
    for (size_t k = 2; k < 6; k++) {
        if (p[k] < low[k % 2]) low[k % 2] = p[k];
        if (p[k] > high[k % 2]) high[k % 2] = p[k];
    }
    if ((p[2] - p[0]) * (p[5] - p[1]) - (p[3] - p[1]) * (p[4] - p[0]) > 0) return;
    int64_t x = high[0] > low[0] ? high[0] : low[0] + 1, y = high[1] > low[1] ? high[1] : low[1] + 1;
    int64_t right[6] = {low[0], low[1], x, low[1], low[0], y};
    memcpy(p, right, sizeof right);
}

static void place_task(void *context, size_t id, unsigned worker) {
    making *m = context;
    (void)worker;
    const sl_atlas_chart *c = &m->charts.chart[id];
    const sl_atlas_place *at = &m->place[id];
    int64_t *corner = sl_allocate(c->count, 6 * sizeof *corner), low[2] = {INT64_MAX, INT64_MAX};
    m->failed[id] = corner == NULL;
    if (!corner) return;
    snap(m, c, corner);
    if (c->count == 1) thicken(corner);
    for (size_t i = 0; i < 6 * c->count; i += 2) { /* quarter turns about the origin, exactly */
        int64_t x = corner[i], y = corner[i + 1];
        corner[i] = at->turns == 0 ? x : at->turns == 1 ? -y : at->turns == 2 ? -x : y;
        corner[i + 1] = at->turns == 0 ? y : at->turns == 1 ? x : at->turns == 2 ? -y : -x;
        for (size_t k = 0; k < 2; k++) low[k] = corner[i + k] < low[k] ? corner[i + k] : low[k];
    }
    double unit = SL_ATLAS_GRID / m->settings->size;
    int64_t origin[2] = {(int64_t)floor(at->x * unit + 0.5) - low[0],
                         (int64_t)floor(at->y * unit + 0.5) - low[1]};
    for (size_t i = 0; i < 6 * c->count; i++)
        m->coordinates[6 * (size_t)m->charts.face[c->first + i / 6] + i % 6] =
            (float)((double)(corner[i] + origin[i % 2]) / SL_ATLAS_GRID);
    sl_free(corner);
}

/* Packs, and looks again at all charts at the density that came out, until nothing is left to mend. */
static sl_status pack_all(making *m, sl_error *error) {
    int needed = 0;
    bool changed = true;
    for (double hint = 0.0; changed; hint = m->density) {
        sl_status status = sl_atlas_pack(&m->charts, &m->faces, m->settings->size, m->settings->gutter, hint,
                                         m->place, &m->density, &needed, error);
        if (status != SL_OK) return status;
        if (!(m->density > 0.0))
            return sl_fail(error, SL_ERROR_RESOURCES,
                           "an atlas of %d x %d texels is too small for %zu charts: a size of %d would do",
                           m->settings->size, m->settings->size, m->charts.count, needed);
        status = flatten_all(m, &changed, error);
        if (status != SL_OK) return status;
    }
    sl_parallel_for(m->threads, m->charts.count, place_task, m);
    for (size_t i = 0; i < m->charts.count; i++)
        if (m->failed[i]) return sl_fail_memory(error, "an atlas's coordinates");
    return SL_OK;
}

/* ---- measures ---- */

static bool measure(const making *m, sl_atlas *a) {
    size_t texels = (size_t)a->size * (size_t)a->size, covered = 0;
    uint32_t *triangle = sl_allocate(texels, sizeof *triangle);
    bool good = triangle && sl_atlas_cover(a, m->faces.count, m->threads, triangle, &covered);
    double sum = 0.0, area = 0.0;
    for (size_t f = 0; f < m->faces.count; f++) {
        double corner[6];
        for (size_t k = 0; k < 6; k++) corner[k] = (double)a->coordinates[6 * f + k];
        sum += m->faces.area[f] * face_stretch(&m->faces, f, corner);
        area += m->faces.area[f];
    }
    for (size_t c = 0; c < m->charts.count; c++) a->single += m->charts.chart[c].count == 1;
    a->texels_per_unit = m->density;
    a->stretch = area > 0.0 ? sum / area : 1.0;
    a->coverage = (double)covered / (double)texels;
    sl_free(triangle);
    return good;
}

/* ---- the atlas ---- */

static sl_status check(const sl_scene *scene, const sl_atlas_settings *s, sl_error *error) {
    if (s->size < 4 || s->size > 16384)
        return sl_fail(error, SL_ERROR_USAGE, "an atlas's size must be 4 to 16384 texels, not %d", s->size);
    if (s->gutter < 0 || s->gutter > s->size / 4)
        return sl_fail(error, SL_ERROR_USAGE, "an atlas's gutter must be 0 to %d texels, not %d", s->size / 4,
                       s->gutter);
    if (!(s->bend > 0.0 && s->bend <= SL_PI))
        return sl_fail(error, SL_ERROR_USAGE,
                       "a chart must be allowed to bend by more than 0 and at most 180 degrees");
    if (!scene->triangle_count)
        return sl_fail(error, SL_ERROR_INPUT, "a scene without triangles has no atlas");
    return SL_OK;
}

static sl_status make(making *m, const sl_scene *scene, sl_atlas *a, sl_error *error) {
    size_t count = scene->triangle_count;
    sl_status status = sl_atlas_faces_create(scene, &m->faces, error);
    if (status == SL_OK)
        status = sl_atlas_charts_create(&m->faces, m->settings->bend, m->threads, &m->charts, error);
    if (status != SL_OK) return status;
    m->place = sl_allocate(count, sizeof *m->place);
    m->local = sl_allocate(count, sizeof *m->local);
    m->bad = sl_allocate(count, sizeof *m->bad);
    m->list = sl_allocate(count, sizeof *m->list);
    m->failed = sl_allocate(count, sizeof *m->failed);
    if (!m->place || !m->local || !m->bad || !m->list || !m->failed) return sl_fail_memory(error, "an atlas");
    double area = 0.0;
    for (size_t f = 0; f < count; f++) area += m->faces.area[f];
    m->density = area > 0.0 ? m->settings->size * sqrt(EXPECTED / area) : 1.0;
    m->coordinates = a->coordinates;
    bool changed;
    status = flatten_all(m, &changed, error);
    if (status == SL_OK) status = pack_all(m, error);
    if (status != SL_OK) return status;
    a->chart_count = m->charts.count;
    memcpy(a->chart, m->charts.of_face, count * sizeof *a->chart);
    return measure(m, a) ? SL_OK : sl_fail_memory(error, "an atlas");
}

sl_status sl_atlas_create(const sl_scene *scene, const sl_atlas_settings *settings, sl_atlas **atlas,
                          sl_error *error) {
    *atlas = NULL;
    sl_status status = check(scene, settings, error);
    if (status != SL_OK) return status;
    making m = {.settings = settings, .threads = sl_thread_count(settings->threads)};
    sl_atlas *a = sl_allocate(1, sizeof *a);
    if (!a) return sl_fail_memory(error, "an atlas");
    a->size = settings->size;
    a->triangle_count = scene->triangle_count;
    a->chart = sl_allocate(scene->triangle_count, sizeof *a->chart);
    a->coordinates = sl_allocate(scene->triangle_count, 6 * sizeof *a->coordinates);
    status = a->chart && a->coordinates ? make(&m, scene, a, error) : sl_fail_memory(error, "an atlas");
    sl_atlas_faces_release(&m.faces);
    sl_atlas_charts_release(&m.charts);
    sl_free(m.place);
    sl_free(m.local);
    sl_free(m.bad);
    sl_free(m.list);
    sl_free(m.failed);
    if (status == SL_OK) *atlas = a;
    else sl_atlas_destroy(a);
    return status;
}

void sl_atlas_destroy(sl_atlas *a) {
    if (!a) return;
    sl_free(a->chart);
    sl_free(a->coordinates);
    sl_free(a);
}

size_t sl_atlas_bytes(const sl_atlas *a) {
    return sizeof *a + a->triangle_count * (sizeof *a->chart + 6 * sizeof *a->coordinates);
}
