#include "scene/parts.h"

#include <float.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/print.h"

static const double a_degree = SL_PI / 180.0;
double sl_radians(double degrees) { return degrees * a_degree; }

bool sl_is_within(const char *key, double value, double low, double high, char text[SL_RULE_TEXT]) {
    char number[32];
    if (value >= low && value <= high) return true;
    sl_print(text, SL_RULE_TEXT, "expected '%.80s' from %g to %g, got %s", key, low, high,
             sl_outside_text(value, low, high, number));
    return false;
}

sl_status sl_take_struct(void *ours, size_t known, const void *given, const char *type, sl_error *error) {
    size_t size;
    memcpy(&size, given, sizeof size);
    memset(ours, 0, known);
    if (size <= sizeof size || size > known)
        return sl_fail(error, SL_ERROR_USAGE, "expected the field 'size' of %s to be its size, %zu, got %zu",
                       type, known, size);
    memcpy(ours, given, size);
    return SL_OK;
}

/* ---- lights ---------------------------------------------------------------------------------- */

static sl_vec3d vector(const double v[3]) { return sl_v3d(v[0], v[1], v[2]); }

static double quad_area(const sl_light_data *l) {
    return sl_lengthd(sl_crossd(vector(l->edge1), vector(l->edge2)));
}

/* A point light of power P has the intensity P / (4 pi) in every direction; a diffuse emitter of power P and
 * area A leaves the radiance P / (pi A) on each side that shines. */
static sl_rgb strength_of(const sl_light_data *l) {
    const sl_rgb given = {l->strength[0], l->strength[1], l->strength[2]};
    if (!l->is_power) return given;
    if (l->type == SL_LIGHT_POINT) return sl_rgb_scale(given, (float)(0.25 / SL_PI));
    return sl_rgb_scale(given, (float)(1.0 / (SL_PI * quad_area(l) * (l->two_sided ? 2.0 : 1.0))));
}

static bool are_within(const char *key, const double v[3], char text[SL_RULE_TEXT]) {
    const double most = (double)FLT_MAX;
    return sl_is_within(key, v[0], -most, most, text) && sl_is_within(key, v[1], -most, most, text) &&
           sl_is_within(key, v[2], -most, most, text);
}

static const char *strength_fault(const sl_light_data *l, char text[SL_RULE_TEXT]) {
    static const char *const keys[] = {"intensity", "intensity", "irradiance", "radiance"};
    const char *key = l->is_power ? "power" : keys[l->type];
    if (l->is_power && l->type != SL_LIGHT_POINT && l->type != SL_LIGHT_QUAD) {
        sl_print(text, SL_RULE_TEXT, "expected '%s': only point and quad lights have 'power'", keys[l->type]);
        return key;
    }
    for (int c = 0; c < 3; c++) {
        if (!sl_is_within(key, (double)l->strength[c], 0.0, (double)FLT_MAX, text)) return key;
    }
    return NULL;
}

static const char *direction_fault(const sl_light_data *l, char text[SL_RULE_TEXT]) {
    const sl_vec3 unit = sl_normalize_or(sl_to_float(vector(l->direction)), sl_v3(0, 0, 0));
    if (!are_within("direction", l->direction, text)) return "direction";
    if (sl_dot(unit, unit) > 0.5f) return NULL;
    sl_print(text, SL_RULE_TEXT, "expected 'direction' to be other than 0");
    return "direction";
}

/* Tells of cones in degrees, as files have them. */
static const char *cone_fault(const sl_light_data *l, char text[SL_RULE_TEXT]) {
    static const char inner[] = "inner_deg", outer[] = "outer_deg";
    const double most = sl_radians(180.0), degrees = l->outer_rad / a_degree;
    if (!(l->outer_rad >= sl_radians(0.01) && l->outer_rad <= most)) {
        sl_print(text, SL_RULE_TEXT, "expected '%s' from 0.01 to 180, got %.10g", outer, degrees);
        return outer;
    }
    if (l->inner_rad >= 0.0 && l->inner_rad <= l->outer_rad) return NULL;
    if (l->inner_rad >= 0.0)
        sl_print(text, SL_RULE_TEXT, "expected '%s' of at most '%s', %g", inner, outer, degrees);
    else
        sl_print(text, SL_RULE_TEXT, "expected '%s' from 0 to 180, got %.10g", inner,
                 l->inner_rad / a_degree);
    return inner;
}

static const char *quad_fault(const sl_light_data *l, char text[SL_RULE_TEXT]) {
    if (!are_within("edge1", l->edge1, text)) return "edge1";
    if (!are_within("edge2", l->edge2, text)) return "edge2";
    const double area = quad_area(l);
    const bool spans = area > 0.0 && isfinite(area);
    if (spans && sl_rgb_is_finite(strength_of(l))) return NULL;
    sl_print(text, SL_RULE_TEXT,
             spans ? "expected a quad light whose area gives a finite radiance"
                   : "expected a quad light with an area: 'edge1' and 'edge2' must span one");
    return "";
}

const char *sl_light_fault(const sl_light_data *l, char text[SL_RULE_TEXT]) {
    const char *place = l->type == SL_LIGHT_QUAD ? "corner" : "position";
    const char *fault = NULL;
    if ((unsigned)l->type > SL_LIGHT_QUAD) {
        sl_print(text, SL_RULE_TEXT,
                 "unknown light type %d; expected 'point', 'spot', 'directional' or 'quad'", (int)l->type);
        return "type";
    }
    if (l->type != SL_LIGHT_DIRECTIONAL && !are_within(place, l->position, text)) return place;
    if (l->type == SL_LIGHT_SPOT || l->type == SL_LIGHT_DIRECTIONAL) fault = direction_fault(l, text);
    if (!fault) fault = strength_fault(l, text);
    if (!fault && l->type == SL_LIGHT_SPOT) fault = cone_fault(l, text);
    return !fault && l->type == SL_LIGHT_QUAD ? quad_fault(l, text) : fault;
}

sl_light sl_light_from(const sl_light_data *l, const sl_affine *turn) {
    sl_light light = {.type = l->type, .intensity = strength_of(l)};
    if (l->type != SL_LIGHT_DIRECTIONAL)
        light.position = sl_to_float(sl_affine_vector(turn, vector(l->position)));
    if (l->type != SL_LIGHT_POINT)
        light.direction =
            sl_unit_or(sl_to_float(sl_affine_vector(turn, vector(l->direction))), sl_v3(0, 0, 0));
    if (l->type == SL_LIGHT_SPOT) {
        light.cos_inner = (float)sl_cos(l->inner_rad);
        light.cos_outer = (float)sl_cos(l->outer_rad);
    }
    return light;
}

sl_status sl_model_add_quad(sl_model *m, const char *path, const char *name, const sl_light_data *l,
                            const sl_affine *turn, uint32_t *object, sl_error *error) {
    static const unsigned along1[4] = {0, 1, 1, 0}, along2[4] = {0, 0, 1, 1};
    static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
    sl_material material = sl_grey_material(name, 0.0f);
    float positions[12];
    sl_mesh mesh = {
        .name = name, .vertex_count = 4, .triangle_count = 2, .positions = positions, .corners = corners};
    material.emission = strength_of(l);
    material.emission_two_sided = l->two_sided;
    for (int i = 0; i < 4; i++) {
        const sl_vec3 p = sl_to_float(
            sl_addd(vector(l->position), sl_addd(sl_scaled(vector(l->edge1), along1[i]),
                                                 sl_scaled(vector(l->edge2), along2[i]))));
        memcpy(positions + 3 * i, (float[3]){p.x, p.y, p.z}, 3 * sizeof(float));
    }
    sl_status status = sl_model_add_material(m, &material, &mesh.material, error);
    if (status == SL_OK) status = sl_model_add_object(m, name, object, error);
    mesh.object = *object;
    return status == SL_OK ? sl_model_add_mesh(m, path, &mesh, turn, error) : status;
}

/* ---- lights of models, whoever has made them ------------------------------------------------- */

static sl_status check_light(sl_light *light, size_t index, sl_error *error) {
    const sl_rgb i = light->intensity;
    const sl_vec3 p = light->position, d = light->direction;
    const sl_light_data given = {.type = light->type, .strength = {i.r, i.g, i.b},
                                 .position = {(double)p.x, (double)p.y, (double)p.z},
                                 .direction = {(double)d.x, (double)d.y, (double)d.z},
                                 .outer_rad = 1.0}; /* its cosines are checked here */
    char text[SL_RULE_TEXT];
    if (sl_light_fault(&given, text))
        return sl_fail(error, SL_ERROR_INPUT, "light %zu: %s", index, text);
    if (light->type == SL_LIGHT_POINT) return SL_OK;
    light->direction = sl_unit_or(d, sl_v3(0, 0, 0));
    bool cone = light->cos_outer >= -1.0f && light->cos_outer <= light->cos_inner && light->cos_inner <= 1.0f;
    if (light->type == SL_LIGHT_SPOT && !cone)
        return sl_fail(error, SL_ERROR_INPUT, "light %zu: expected an inner cone inside the outer cone",
                       index);
    return SL_OK;
}

sl_status sl_lights_check(sl_scene *scene, sl_error *error) {
    sl_status status = SL_OK;
    for (size_t i = 0; i < scene->light_count && status == SL_OK; i++)
        status = check_light(&scene->lights[i], i, error);
    return status;
}

/* ---- transforms ------------------------------------------------------------------------------ */

const char *sl_matrix_fault(const double m[16], sl_affine *a) {
    bool finite = true;
    for (int i = 0; i < 16; i++) finite &= isfinite(m[i]) != 0;
    if (!finite) return "expected 'transform' to be an array of 16 numbers";
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) a->m[i][j] = m[4 * j + i];
    }
    if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0)
        return "expected 'transform' by columns, its bottom row (every fourth number) 0 0 0 1";
    const double volume = fabs(sl_affine_determinant(a));
    return volume > 0.0 && isfinite(volume) ? NULL
                                            : "expected 'transform' to be a matrix that can be inverted";
}
