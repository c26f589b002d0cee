#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/file.h"
#include "scene/lines.h"
#include "scene/mesh_file.h"
#include "scene/polygons.h"

enum { MOST = 4000000000u };

typedef struct reader {
    sl_lines lines;
    sl_polygons polygons;
    uint32_t material, object;
} reader;

static char none[] = "";

static sl_status read_vertex(reader *r, uint32_t dimension) {
    static const char expected[] = "the numbers of a vertex";
    sl_lines *l = &r->lines;
    float value[3] = {0};
    if (!sl_lines_more(l)) return sl_lines_fail(l, expected, NULL);
    for (uint32_t i = 0; i < dimension; i++) {
        char *end = sl_is_line_end(l->rest) ? NULL : sl_read_number(l->rest, &value[i]);
        if (!end) return sl_lines_fail(l, expected, l->rest);
        l->rest = end;
    }
    l->rest = none; /* what else it has is not used */
    return sl_polygons_add_value(&r->polygons, SL_CORNER_POSITION, value) ? SL_OK
                                                                          : sl_fail_memory(l->error, l->path);
}

/* Reads a face; what is drawn has three corners at least. */
static sl_status read_face(reader *r, const sl_affine *placement, sl_model *model) {
    static const char expected[] =
        "a face: a number of corners, and so many vertices of those that there are";
    sl_lines *l = &r->lines;
    const double last = (double)r->polygons.count[SL_CORNER_POSITION] - 1.0;
    sl_corner corner = {{SL_NO_INDEX, SL_NO_INDEX, SL_NO_INDEX}};
    uint32_t count = 0;
    sl_status status = sl_lines_whole(l, expected, 1, MOST, &count);
    for (uint32_t i = 0; i < count && status == SL_OK; i++) {
        status = sl_is_line_end(l->rest) ? sl_lines_fail(l, expected, l->rest)
                                         : sl_lines_whole(l, expected, 0, last, &corner.at[0]);
        if (status == SL_OK && !sl_polygons_add_corner(&r->polygons, corner))
            status = sl_fail_memory(l->error, l->path);
    }
    if (status != SL_OK) return status;
    l->rest = none; /* a colour */
    return sl_polygons_place(&r->polygons, l->path, r->material, r->object, placement, model, l->error);
}

/* Reads "OFF", letters before it that say what else a vertex has, and how many vertices, faces and edges
 * there are, in one line or several; some writers have no blank between. n: of as many dimensions as stand
 * first. */
static sl_status read_header(sl_lines *l, uint32_t *dimension, uint32_t *vertices, uint32_t *faces) {
    static const char magic[] = "an OFF file, which begins with 'OFF'",
                      expected[] = "how many vertices, faces and edges there are";
    uint32_t *const numbers[] = {dimension, vertices, faces, &(uint32_t){0}};
    *dimension = 3;
    if (!sl_lines_more(l)) return sl_lines_fail(l, magic, NULL);
    char *off = l->rest + strspn(l->rest, "STCNn");
    if (strncmp(off, "OFF", 3) != 0) return sl_lines_fail(l, magic, l->rest);
    const bool has_dimension = off > l->rest && off[-1] == 'n';
    l->rest = off + 3 + strspn(off + 3, " \t");
    sl_status status = SL_OK;
    for (int i = has_dimension ? 0 : 1; i < 4 && status == SL_OK; i++)
        status = sl_lines_whole(l, expected, 0, i ? MOST : 3, numbers[i]);
    return status;
}

static sl_status read_file(reader *r, const sl_affine *placement, sl_model *model) {
    uint32_t dimension, vertices, faces;
    const char *name = sl_file_name(r->lines.path);
    const sl_material grey = sl_grey_material(name, 0.6f);
    sl_status status = read_header(&r->lines, &dimension, &vertices, &faces);
    if (status == SL_OK) status = sl_model_add_material(model, &grey, &r->material, r->lines.error);
    if (status == SL_OK) status = sl_model_add_object(model, name, &r->object, r->lines.error);
    for (uint32_t i = 0; status == SL_OK && i < vertices; i++) status = read_vertex(r, dimension);
    for (uint32_t i = 0; status == SL_OK && i < faces; i++) status = read_face(r, placement, model);
    return status;
}

sl_status sl_off_file_load(const char *path, const sl_affine *placement, sl_model *model, sl_error *error) {
    reader r = {0};
    char *text;
    sl_status status = sl_lines_open(path, &text, &r.lines, error);
    if (status == SL_OK) status = read_file(&r, placement, model);
    sl_polygons_release(&r.polygons);
    sl_free(text);
    return status;
}
