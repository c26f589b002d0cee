#include "base/error.h"
#include "base/memory.h"
#include "scene/bicubic.h"
#include "scene/file.h"
#include "scene/lines.h"
#include "scene/mesh_file.h"

enum { MOST_SURFACES = 1000000 };

static sl_status read_point(sl_lines *l, const sl_affine *placement, sl_vec3 *point) {
    double xyz[3];
    const char *word = sl_lines_more(l) ? l->rest : NULL;
    for (int i = 0; i < 3; i++) {
        sl_status status = sl_lines_decimal(l, "16 control points of three numbers each", &xyz[i]);
        if (status != SL_OK) return status;
    }
    *point = sl_to_float(sl_affine_point(placement, sl_v3d(xyz[0], xyz[1], xyz[2])));
    return sl_is_finite(*point) ? SL_OK
                                : sl_lines_fail(l, "a control point within what floats can say", word);
}

/* A placement that mirrors would turn fronts into backs: then the points of each row change places. */
static sl_status read_surface(sl_lines *l, const sl_affine *placement, sl_bicubic *surface) {
    static const char degrees[] = "the degrees '3 3' of a bicubic surface";
    const bool mirrored = sl_affine_determinant(placement) < 0.0;
    uint32_t degree;
    sl_status status = sl_lines_whole(l, degrees, 3, 3, &degree);
    const unsigned long line = l->line;
    if (status == SL_OK) status = sl_lines_whole(l, degrees, 3, 3, &degree);
    *surface = (sl_bicubic){.steps = SL_BICUBIC_STEPS};
    for (int k = 0; k < 16 && status == SL_OK; k++)
        status = read_point(l, placement, &surface->point[k / 4][mirrored ? 3 - k % 4 : k % 4]);
    if (status != SL_OK || sl_bicubic_has_area(surface)) return status;
    return sl_fail(l->error, SL_ERROR_INPUT, "%s:%lu: expected a surface that has an area", l->path, line);
}

static sl_status read_file(sl_lines *l, const sl_affine *placement, sl_model *model) {
    uint32_t count, material, object;
    const char *name = sl_file_name(l->path);
    const sl_material grey = sl_grey_material(name, 0.5f);
    sl_status status = sl_lines_whole(l, "the number of surfaces", 1, MOST_SURFACES, &count);
    if (status == SL_OK) status = sl_model_add_material(model, &grey, &material, l->error);
    if (status == SL_OK) status = sl_model_add_object(model, name, &object, l->error);
    for (size_t i = 0; status == SL_OK && i < count; i++) {
        sl_bicubic surface;
        status = read_surface(l, placement, &surface);
        if (status == SL_OK) status = sl_model_add_bicubic(model, &surface, material, object, l->error);
    }
    if (status != SL_OK || !sl_lines_more(l)) return status;
    return sl_lines_fail(l, "the end of the file after the last surface", l->rest);
}

sl_status sl_bicubic_file_load(const char *path, const sl_affine *placement, sl_model *model,
                               sl_error *error) {
    char *text;
    sl_lines lines;
    sl_status status = sl_lines_open(path, &text, &lines, error);
    if (status == SL_OK) status = read_file(&lines, placement, model);
    sl_free(text);
    return status;
}
