#include "scene/mesh_file.h"

#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/bicubic.h"
#include "scene/file.h"

enum { MOST_SURFACES = 1000000 };

typedef struct reader {
    const char *path, *at;
    unsigned long line;
    sl_error *error;
} reader;

/* ---- words ----------------------------------------------------------------------------------- */

static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

/* To the next word, over line ends and what stands behind a '#'. */
static void skip_space(reader *r) {
    for (; is_space(*r->at) || *r->at == '#'; r->at++) {
        if (*r->at == '#') {
            while (r->at[1] && r->at[1] != '\n') r->at++;
        }
        r->line += *r->at == '\n';
    }
}

static int word_length(const reader *r) {
    int length = 0;
    while (r->at[length] && !is_space(r->at[length]) && r->at[length] != '#' && length < 40) length++;
    return length;
}

static sl_status fail(const reader *r, const char *expected) {
    if (!*r->at)
        return sl_fail(r->error, SL_ERROR_INPUT, "%s:%lu: expected %s, got the end of the file", r->path,
                       r->line, expected);
    return sl_fail(r->error, SL_ERROR_INPUT, "%s:%lu: expected %s, got '%.*s'", r->path, r->line, expected,
                   word_length(r), r->at);
}

static sl_status read_number(reader *r, const char *expected, double *value) {
    skip_space(r);
    char *end;
    size_t length = (size_t)word_length(r);
    *value = strtod(r->at, &end);
    /* neither hexadecimal nor "inf" nor "nan" */
    bool decimal = length && strspn(r->at, "+-.0123456789eE") >= length;
    if (!decimal || end != r->at + length || !isfinite(*value)) return fail(r, expected);
    r->at = end;
    return SL_OK;
}

static sl_status read_whole(reader *r, const char *expected, double low, double high, size_t *value) {
    reader before = *r;
    double number;
    skip_space(&before);
    sl_status status = read_number(r, expected, &number);
    if (status != SL_OK) return status;
    if (!(number >= low && number <= high && number == floor(number))) return fail(&before, expected);
    *value = (size_t)number;
    return SL_OK;
}

/* ---- surfaces -------------------------------------------------------------------------------- */

static sl_status read_point(reader *r, const sl_affine *placement, sl_vec3 *point) {
    double xyz[3];
    reader before = *r;
    skip_space(&before);
    for (int i = 0; i < 3; i++) {
        sl_status status = read_number(r, "16 control points of three numbers each", &xyz[i]);
        if (status != SL_OK) return status;
    }
    *point = sl_to_float(sl_affine_point(placement, sl_v3d(xyz[0], xyz[1], xyz[2])));
    return sl_is_finite(*point) ? SL_OK : fail(&before, "a control point within what floats can say");
}

/* A placement that mirrors would turn fronts into backs: then the points of each row change places. */
static sl_status read_surface(reader *r, const sl_affine *placement, sl_bicubic *surface) {
    static const char degrees[] = "the degrees '3 3' of a bicubic surface";
    bool mirrored = sl_affine_determinant(placement) < 0.0;
    size_t degree;
    skip_space(r);
    reader before = *r;
    sl_status status = read_whole(r, degrees, 3, 3, &degree);
    if (status == SL_OK) status = read_whole(r, degrees, 3, 3, &degree);
    *surface = (sl_bicubic){.steps = SL_BICUBIC_STEPS};
    for (int k = 0; k < 16 && status == SL_OK; k++)
        status = read_point(r, placement, &surface->point[k / 4][mirrored ? 3 - k % 4 : k % 4]);
    if (status == SL_OK && !sl_bicubic_has_area(surface)) {
        status = sl_fail(r->error, SL_ERROR_INPUT, "%s:%lu: expected a surface that has an area", r->path,
                         before.line);
    }
    return status;
}

static sl_status read_file(reader *r, const sl_affine *placement, sl_model *model) {
    size_t count;
    uint32_t material, object;
    const char *slash = strrchr(r->path, '/'), *name = slash ? slash + 1 : r->path;
    sl_material grey = {.name = (char *)(uintptr_t)name,
                        .diffuse = sl_grey(0.5f),
                        .texture = SL_NO_INDEX,
                        .alpha_texture = SL_NO_INDEX};
    sl_status status = read_whole(r, "the number of surfaces", 1, MOST_SURFACES, &count);
    if (status == SL_OK) status = sl_model_add_material(model, &grey, &material, r->error);
    if (status == SL_OK) status = sl_model_add_object(model, name, &object, r->error);
    for (size_t i = 0; i < count && status == SL_OK; i++) {
        sl_bicubic surface;
        status = read_surface(r, placement, &surface);
        if (status == SL_OK) status = sl_model_add_bicubic(model, &surface, material, object, r->error);
    }
    if (status != SL_OK) return status;
    skip_space(r);
    return *r->at ? fail(r, "the end of the file after the last surface") : SL_OK;
}

sl_status sl_bicubic_file_load(const char *path, const sl_affine *placement, sl_model *model,
                               sl_error *error) {
    char *text;
    size_t size;
    sl_status status = sl_file_read(path, &text, &size, error);
    if (status != SL_OK) return status;
    reader r = {path, text, 1, error};
    status = memchr(text, 0, size) ? sl_fail(error, SL_ERROR_INPUT, "%s:1: expected text", path)
                                   : read_file(&r, placement, model);
    sl_free(text);
    return status;
}
