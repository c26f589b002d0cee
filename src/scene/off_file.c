#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/lines.h"
#include "scene/mesh_file.h"
#include "scene/polygons.h"

typedef struct reader {
    sl_lines lines;
    char *at; /* what is left of the line at hand */
    sl_polygons polygons;
} reader;

static char none[] = "";

/* Goes on to the next line that is not a comment, if nothing is left of the one at hand; false at the end. */
static bool has_more(reader *r) {
    while (r->at && sl_is_line_end(r->at)) r->at = sl_lines_next(&r->lines);
    return r->at;
}

/* Reads a whole number below a limit. */
static sl_status read_whole(reader *r, double limit, const char *expected, uint32_t *whole) {
    float unused;
    double value = 0.0;
    const char *digit = r->at;
    if (!digit || *digit < '0' || *digit > '9') return sl_lines_fail(&r->lines, expected, r->at);
    for (; *digit >= '0' && *digit <= '9'; digit++) value = 10.0 * value + (*digit - '0');
    if (!(value < limit) || *digit == '.') return sl_lines_fail(&r->lines, expected, r->at);
    char *end = sl_read_number(r->at, &unused);
    if (!end) return sl_lines_fail(&r->lines, expected, r->at);
    r->at = end;
    *whole = (uint32_t)value;
    return SL_OK;
}

static sl_status read_vertex(reader *r, uint32_t dimension) {
    float value[3] = {0};
    static const char expected[] = "the numbers of a vertex";
    if (!has_more(r)) return sl_lines_fail(&r->lines, expected, r->at);
    for (uint32_t i = 0; i < dimension; i++) {
        char *end = sl_is_line_end(r->at) ? NULL : sl_read_number(r->at, &value[i]);
        if (!end) return sl_lines_fail(&r->lines, expected, r->at);
        r->at = end;
    }
    r->at = none; /* what else it has is not used */
    return sl_polygons_add_value(&r->polygons, SL_CORNER_POSITION, value)
               ? SL_OK
               : sl_fail_memory(r->lines.error, r->lines.path);
}

/* Reads a face; what is drawn has three corners at least. */
static sl_status read_face(reader *r) {
    static const char expected[] =
        "a face: a number of corners, and so many vertices of those that there are";
    const double vertices = (double)r->polygons.count[SL_CORNER_POSITION];
    const size_t before = r->polygons.corner_count;
    sl_corner corner = {{SL_NO_INDEX, SL_NO_INDEX, SL_NO_INDEX}};
    uint32_t count = 0;
    sl_status status =
        has_more(r) ? read_whole(r, 4e9, expected, &count) : sl_lines_fail(&r->lines, expected, r->at);
    if (status == SL_OK && count == 0) return sl_lines_fail(&r->lines, expected, r->at);
    bool added = true;
    for (uint32_t i = 0; i < count && status == SL_OK && added; i++) {
        status = read_whole(r, vertices, expected, &corner.at[SL_CORNER_POSITION]);
        if (status == SL_OK) added = sl_polygons_add_corner(&r->polygons, corner);
    }
    if (status != SL_OK) return status;
    r->at = none; /* a colour */
    if (count < 3) r->polygons.corner_count = before;
    else added = added && sl_polygons_add(&r->polygons, (sl_polygon){count, 0, 0});
    return added ? SL_OK : sl_fail_memory(r->lines.error, r->lines.path);
}

/* Reads "OFF", letters before it that say what else a vertex has, and how many vertices, faces and edges
 * there are, in one line or several; some writers have no blank between. n: of as many dimensions as stand
 * first. */
static sl_status read_header(reader *r, uint32_t *dimension, uint32_t *vertices, uint32_t *faces) {
    static const char magic[] = "an OFF file, which begins with 'OFF'",
                      expected[] = "how many vertices, faces and edges there are";
    uint32_t *const numbers[] = {dimension, vertices, faces, &(uint32_t){0}};
    *dimension = 3;
    if (!has_more(r)) return sl_lines_fail(&r->lines, magic, r->at);
    char *off = r->at + strspn(r->at, "STCNn");
    if (strncmp(off, "OFF", 3) != 0) return sl_lines_fail(&r->lines, magic, r->at);
    const bool has_dimension = off > r->at && off[-1] == 'n';
    r->at = off + 3 + strspn(off + 3, " \t");
    sl_status status = SL_OK;
    for (int i = has_dimension ? 0 : 1; i < 4 && status == SL_OK; i++)
        status = has_more(r) ? read_whole(r, i ? 4e9 : 4.0, expected, numbers[i])
                             : sl_lines_fail(&r->lines, expected, r->at);
    return status;
}

static sl_status read_file(reader *r, const sl_affine *placement, sl_model *model) {
    uint32_t dimension, vertices, faces, material;
    const char *slash = strrchr(r->lines.path, '/'), *name = slash ? slash + 1 : r->lines.path;
    const sl_material grey = {.name = (char *)(uintptr_t)name,
                              .diffuse = sl_grey(0.6f),
                              .texture = SL_NO_INDEX,
                              .alpha_texture = SL_NO_INDEX,
                              .bump_depth = SL_BUMP_DEPTH};
    sl_status status = read_header(r, &dimension, &vertices, &faces);
    if (status == SL_OK) status = sl_model_add_material(model, &grey, &material, r->lines.error);
    for (uint32_t i = 0; i < vertices && status == SL_OK; i++) status = read_vertex(r, dimension);
    for (uint32_t i = 0; i < faces && status == SL_OK; i++) status = read_face(r);
    if (status != SL_OK) return status;
    const sl_names objects = {.name = (const char *[]){name}, .count = 1};
    return sl_polygons_place(&r->polygons, &objects, placement, material, model, r->lines.error);
}

sl_status sl_off_file_load(const char *path, const sl_affine *placement, sl_model *model, sl_error *error) {
    reader r = {.at = none};
    char *text;
    sl_status status = sl_lines_open(path, &text, &r.lines, error);
    if (status == SL_OK) status = read_file(&r, placement, model);
    sl_polygons_release(&r.polygons);
    sl_free(text);
    return status;
}
