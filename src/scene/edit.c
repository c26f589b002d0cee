/* Edits of a scene in memory. They are collected beside the scene, checked by the rules for scenes that are
 * built (scene/parts.h), and take place together, or not at all. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "scene/animation.h"
#include "scene/derive.h"
#include "scene/parts.h"
#include "scene/reshape.h"

struct sl_scene_edit {
    sl_scene *scene;
    uint64_t version;       /* of the scene, when the edit began */
    sl_material *materials; /* all of them, as they are to be; names are the scene's */
    sl_light *lights;       /* likewise, and behind them those that come */
    size_t light_count, light_room;
    bool has_sky, looks;
    sl_environment sky;
    sl_camera camera;
    sl_placement *placement;
    size_t placements, placement_room;
    sl_reshaping shape;
};

/* ---- parts that there are --------------------------------------------------------------------------- */

size_t sl_scene_light_count(const sl_scene *scene) { return scene->light_count; }

uint32_t sl_scene_find_object(const sl_scene *scene, const char *name) {
    for (size_t i = 0; i < scene->object_count; i++) {
        if (strcmp(scene->object_names[i], name) == 0) return (uint32_t)i + 1;
    }
    return 0;
}

/* ---- collecting ------------------------------------------------------------------------------ */

void sl_scene_edit_destroy(sl_scene_edit *edit) {
    if (!edit) return;
    sl_environment_release(&edit->sky);
    SL_FREE_ALL(edit->materials, edit->lights, edit->placement);
    sl_reshaping_release(&edit->shape);
    sl_free(edit);
}

sl_status sl_scene_edit_begin(sl_scene *scene, sl_scene_edit **edit, sl_error *error) {
    if (edit) *edit = NULL;
    if (!scene || !edit) return sl_fail_null(error, "a scene and a place for an edit");
    sl_scene_edit *e = sl_allocate(1, sizeof *e);
    if (e) {
        e->scene = scene;
        e->version = scene->version;
        e->materials = sl_copy_of(scene->materials, scene->material_count, sizeof *e->materials);
        e->lights = sl_copy_of(scene->lights, scene->light_count, sizeof *e->lights);
        e->light_count = e->light_room = scene->light_count;
    }
    if (!e || !e->materials || !e->lights) {
        sl_scene_edit_destroy(e);
        return sl_fail_memory(error, "an edit");
    }
    *edit = e;
    return SL_OK;
}

static sl_status check_number(const char *what, uint32_t number, size_t count, sl_error *error) {
    if (number > 0 && number <= count) return SL_OK;
    return sl_fail(error, SL_ERROR_USAGE, "%s %u: expected a number from 1 to %zu", what, number, count);
}

sl_status sl_edit_material(sl_scene_edit *edit, uint32_t material, const sl_material_data *data,
                           sl_error *error) {
    sl_material made;
    if (!edit || !data) return sl_fail_null(error, "an edit and a material");
    sl_status status = check_number("material", material, edit->scene->material_count, error);
    if (status != SL_OK) return status;
    sl_material *to = &edit->materials[material - 1];
    status = sl_material_take(edit->scene, data, to->name, &made, error);
    if (status == SL_OK) status = sl_material_check(edit->scene, &made, error);
    if (status == SL_OK) *to = made;
    return status;
}

sl_status sl_edit_light(sl_scene_edit *edit, uint32_t light, const float strength[3],
                        const double position[3], const double direction[3], sl_error *error) {
    char name[32], text[SL_RULE_TEXT];
    if (!edit) return sl_fail_null(error, "an edit");
    sl_status status = check_number("light", light, edit->light_count, error);
    if (status != SL_OK) return status;
    sl_light made = edit->lights[light - 1];
    /* its cones, which are not given here, are none that a light could have a fault in */
    sl_light_data given = {.type = made.type, .outer_rad = 1.0, .direction = {0.0, 0.0, 1.0}};
    if (strength) memcpy(given.strength, strength, sizeof given.strength);
    if (position) memcpy(given.position, position, sizeof given.position);
    if (direction) memcpy(given.direction, direction, sizeof given.direction);
    snprintf(name, sizeof name, "light %u", light);
    if (sl_light_fault(&given, text)) return sl_fail(error, SL_ERROR_INPUT, "%s: %s", name, text);
    const sl_affine as_given = sl_affine_identity();
    const sl_light from = sl_light_from(&given, &as_given);
    if (strength) made.intensity = from.intensity;
    if (position && made.type != SL_LIGHT_DIRECTIONAL) made.position = from.position;
    if (direction && made.type != SL_LIGHT_POINT) made.direction = from.direction;
    edit->lights[light - 1] = made;
    return SL_OK;
}

sl_status sl_edit_add_light(sl_scene_edit *edit, const sl_light_data *data, uint32_t *light,
                            sl_error *error) {
    const sl_affine as_given = sl_affine_identity();
    sl_light_data d;
    char text[SL_RULE_TEXT];
    if (!edit || !data || !light) return sl_fail_null(error, "an edit, a light and a place for its number");
    sl_status status = SL_TAKE(sl_light_data, &d, data, error);
    if (status != SL_OK) return status;
    if (sl_light_fault(&d, text)) return sl_fail(error, SL_ERROR_INPUT, "light: %s", text);
    if (d.type == SL_LIGHT_QUAD)
        return sl_fail(error, SL_ERROR_USAGE, "light: a quad is an object: sl_edit_add_object()");
    if (!sl_make_room(&edit->lights, edit->light_count, &edit->light_room, sizeof *edit->lights))
        return sl_fail_memory(error, "an edit");
    edit->lights[edit->light_count++] = sl_light_from(&d, &as_given);
    *light = (uint32_t)edit->light_count;
    return SL_OK;
}

sl_status sl_edit_environment(sl_scene_edit *edit, int width, int height, const float *radiance,
                              sl_error *error) {
    sl_environment sky;
    size_t repaired;
    if (!edit || !radiance) return sl_fail_null(error, "an edit and the radiance of its sky");
    sl_status status = sl_sky_take(width, height, radiance, &sky, error);
    if (status != SL_OK) return status;
    status = sl_environment_complete(&sky, &repaired, error);
    if (status != SL_OK) {
        sl_environment_release(&sky);
        return status;
    }
    sl_environment_release(&edit->sky);
    edit->sky = sky;
    edit->has_sky = true;
    return SL_OK;
}

sl_status sl_edit_camera(sl_scene_edit *edit, const float eye[3], const float target[3], const float up[3],
                         float vertical_fov_rad, sl_error *error) {
    sl_camera camera;
    if (!edit || !eye || !target || !up) return sl_fail_null(error, "an edit and three vectors");
    sl_status status = sl_view_take(eye, target, up, vertical_fov_rad, &camera, error);
    if (status != SL_OK) return status;
    edit->camera = camera;
    edit->looks = true;
    return SL_OK;
}

/* ---- objects --------------------------------------------------------------------------------- */

static sl_status check_object(const sl_scene_edit *e, uint32_t object, sl_error *error) {
    return check_number("object", object, e->scene->object_count + e->shape.more.scene.object_count, error);
}

static const char *name_of_object(const sl_scene_edit *e, uint32_t object) {
    const size_t there = e->scene->object_count;
    return object < there ? e->scene->object_names[object] : e->shape.more.scene.object_names[object - there];
}

static sl_status fail_object(const sl_scene_edit *e, uint32_t number, const char *fault, sl_error *error) {
    return sl_fail(error, SL_ERROR_INPUT, "object '%s': %s", name_of_object(e, number - 1), fault);
}

static sl_status place(sl_scene_edit *e, sl_placement placed, sl_error *error) {
    size_t i = 0;
    while (i < e->placements && e->placement[i].object != placed.object) i++;
    if (i == e->placements) {
        if (!sl_make_room(&e->placement, i, &e->placement_room, sizeof placed))
            return sl_fail_memory(error, "an edit");
        e->placements++;
    }
    e->placement[i] = placed;
    return SL_OK;
}

sl_status sl_edit_transform(sl_scene_edit *edit, uint32_t object, const double columns[16],
                            sl_error *error) {
    sl_placement placed = {.object = object - 1, .placement = sl_affine_identity(), .released = !columns};
    if (!edit) return sl_fail_null(error, "an edit");
    sl_status status = check_object(edit, object, error);
    if (status != SL_OK) return status;
    const char *fault = columns ? sl_matrix_fault(columns, &placed.placement) : NULL;
    if (!fault && !(sl_affine_determinant(&placed.placement) > 0.0))
        fault = "expected 'transform' not to mirror";
    return fault ? fail_object(edit, object, fault, error) : place(edit, placed, error);
}

sl_status sl_edit_add_object(sl_scene_edit *edit, const sl_mesh_data *mesh, uint32_t *object,
                             sl_error *error) {
    const sl_affine as_given = sl_affine_identity();
    const char *name = "added";
    uint32_t index;
    if (!edit || !mesh || !object)
        return sl_fail_null(error, "an edit, a mesh and a place for its object's number");
    sl_model *more = &edit->shape.more;
    const size_t number = edit->scene->object_count + more->scene.object_count;
    if (mesh->size >= offsetof(sl_mesh_data, name) + sizeof name && mesh->name && *mesh->name)
        name = mesh->name;
    const size_t vertices = more->vertex_count, triangles = more->triangle_count;
    sl_status status = sl_mesh_take(edit->scene, more, mesh, name, (uint32_t)number, &as_given, error);
    if (status == SL_OK) status = sl_model_add_object(more, name, &index, error);
    if (status == SL_OK) {
        *object = (uint32_t)number + 1;
    } else {
        more->vertex_count = vertices;
        more->triangle_count = triangles;
    }
    return status;
}

/* Fails where an object's surfaces are not triangles that were there before the edit. */
static sl_status check_shape(const sl_scene_edit *e, uint32_t object, sl_error *error) {
    const sl_scene *s = e->scene;
    sl_status status = check_number("object", object, s->object_count, error);
    for (size_t i = 0; i < s->bicubic_count && status == SL_OK; i++)
        if (s->object_index[s->bicubics[i].first_triangle] == object - 1)
            status = fail_object(e, object, "expected triangles, not a bicubic surface", error);
    return status;
}

sl_status sl_edit_remove_object(sl_scene_edit *edit, uint32_t object, sl_error *error) {
    if (!edit) return sl_fail_null(error, "an edit");
    sl_status status = check_shape(edit, object, error);
    if (status != SL_OK) return status;
    sl_reshaping *r = &edit->shape;
    if (!r->gone) r->gone = sl_allocate(edit->scene->object_count, sizeof *r->gone);
    if (!r->gone) return sl_fail_memory(error, "an edit");
    r->gone[object - 1] = true;
    return SL_OK;
}

static bool all_finite(const float *values, size_t count) {
    bool finite = true;
    for (size_t i = 0; i < count && values; i++) finite &= isfinite(values[i]) != 0;
    return finite;
}

sl_status sl_edit_vertices(sl_scene_edit *edit, uint32_t object, size_t count, const float *positions,
                           const float *normals, sl_error *error) {
    if (!edit || !positions) return sl_fail_null(error, "an edit and positions");
    sl_status status = check_shape(edit, object, error);
    if (status != SL_OK) return status;
    sl_reshaping *r = &edit->shape;
    const size_t there = sl_scene_vertices(edit->scene, object, NULL, NULL);
    if (count != there)
        return sl_fail(error, SL_ERROR_USAGE, "object '%s': expected %zu vertices, got %zu",
                       name_of_object(edit, object - 1), there, count);
    if (!all_finite(positions, 3 * count) || !all_finite(normals, 3 * count))
        return fail_object(edit, object, "expected finite vertices", error);
    sl_moulding m = {object - 1, count, sl_copy_of(positions, 3 * count, sizeof *positions),
                     normals ? sl_copy_of(normals, 3 * count, sizeof *normals) : NULL};
    if (m.positions && (m.normals || !normals) &&
        sl_make_room(&r->moulding, r->mouldings, &r->moulding_room, sizeof m)) {
        r->moulding[r->mouldings++] = m;
        return SL_OK;
    }
    sl_free(m.positions);
    sl_free(m.normals);
    return sl_fail_memory(error, "an edit");
}

/* ---- changes --------------------------------------------------------------------------------- */

static bool same(const void *a, const void *b, size_t bytes) { return memcmp(a, b, bytes) == 0; }

/* The same surface in another colour, or one that methods must plan for anew. */
static bool is_of_another_kind(const sl_material *a, const sl_material *b) {
    return sl_material_is_diffuse(a) != sl_material_is_diffuse(b) ||
           sl_material_is_glossy(a) != sl_material_is_glossy(b) ||
           sl_material_is_mirror(a) != sl_material_is_mirror(b) || a->texture != b->texture ||
           a->alpha_texture != b->alpha_texture || a->height_map != b->height_map ||
           a->bump_depth != b->bump_depth;
}

static unsigned material_changes(const sl_material *a, const sl_material *b) {
    const bool shines = sl_material_is_emitter(a), will_shine = sl_material_is_emitter(b);
    unsigned changes = is_of_another_kind(a, b) ? SL_CHANGED_KINDS : 0u;
    if (!same(&a->diffuse, &b->diffuse, sizeof a->diffuse) ||
        !same(&a->specular, &b->specular, sizeof a->specular) ||
        !same(&a->mirror, &b->mirror, sizeof a->mirror) || a->exponent != b->exponent)
        changes |= SL_CHANGED_MATERIALS;
    if (!same(&a->emission, &b->emission, sizeof a->emission)) changes |= SL_CHANGED_POWER;
    if (shines != will_shine || (shines && a->emission_two_sided != b->emission_two_sided))
        changes |= SL_CHANGED_LIGHTS;
    return changes;
}

static unsigned light_changes(const sl_light *a, const sl_light *b) {
    unsigned changes = 0;
    if (!same(&a->intensity, &b->intensity, sizeof a->intensity)) changes |= SL_CHANGED_POWER;
    if (!same(&a->position, &b->position, sizeof a->position) ||
        !same(&a->direction, &b->direction, sizeof a->direction) ||
        sl_light_is_lit(a) != sl_light_is_lit(b))
        changes |= SL_CHANGED_LIGHTS;
    return changes;
}

static bool same_sky(const sl_environment *a, const sl_environment *b) {
    return a->present == b->present && a->width == b->width && a->height == b->height &&
           same(&a->constant, &b->constant, sizeof a->constant) &&
           (a->width == 0 ||
            same(a->texels, b->texels, 3 * (size_t)a->width * (size_t)a->height * sizeof *a->texels));
}

/* All but what objects will do. */
static unsigned changes_of(const sl_scene_edit *e) {
    const sl_scene *s = e->scene;
    unsigned changes = 0;
    for (size_t i = 0; i < s->material_count; i++)
        changes |= material_changes(&s->materials[i], &e->materials[i]);
    for (size_t i = 0; i < s->light_count; i++) changes |= light_changes(&s->lights[i], &e->lights[i]);
    if (e->light_count > s->light_count) changes |= SL_CHANGED_LIGHTS;
    if (sl_reshapes(&e->shape)) changes |= SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS | SL_CHANGED_KINDS;
    if (e->has_sky && !same_sky(&s->environment, &e->sky)) changes |= SL_CHANGED_SKY;
    if (e->looks && !same(&s->camera, &e->camera, sizeof s->camera)) changes |= SL_CHANGED_CAMERA;
    return changes;
}

/* ---- all or nothing -------------------------------------------------------------------------- */

static void swap_materials(sl_scene_edit *e) {
    for (size_t i = 0; i < e->scene->material_count; i++) {
        const sl_material before = e->scene->materials[i];
        e->scene->materials[i] = e->materials[i];
        e->materials[i] = before;
    }
}

/* Lamps come and go, and masks change what is left of them. */
static sl_status change_surfaces(sl_scene_edit *e, unsigned *changes, sl_error *error) {
    sl_scene *s = e->scene;
    const sl_scene before = *s;
    const bool lamps = (*changes & (SL_CHANGED_KINDS | SL_CHANGED_LIGHTS)) != 0;
    swap_materials(e);
    sl_status status = lamps ? sl_scene_make_emitters(s, error) : SL_OK;
    if (status == SL_OK) status = sl_animation_place(s, e->placements, e->placement, changes, error);
    const bool done = status == SL_OK;
    for (size_t i = 0; i < s->emitter_count && done; i++)
        s->emitters[i].radiance = sl_triangle_material(s, s->emitters[i].triangle)->emission;
    if (!done) swap_materials(e);
    if (!lamps) return status;
    sl_free(done ? before.emitters : s->emitters);
    sl_free(done ? before.opaque_share : s->opaque_share);
    if (done) return status;
    s->emitters = before.emitters;
    s->opaque_share = before.opaque_share;
    s->emissive_count = before.emissive_count;
    sl_scene_derive(s);
    return status;
}

/* Objects of other vertices that move are placed as they were last, whatever keyframes say. */
static sl_status place_moulded(sl_scene_edit *e, sl_error *error) {
    sl_status status = SL_OK;
    for (size_t i = 0; i < e->shape.mouldings && e->scene->animation && status == SL_OK; i++) {
        bool placed = false, keyed;
        sl_placement at = {.object = e->shape.moulding[i].object};
        at.placement = sl_animation_placement(e->scene, at.object, &keyed);
        if (keyed) at.placement = sl_affine_identity();
        for (size_t k = 0; k < e->placements; k++) placed |= e->placement[k].object == at.object;
        if (!placed) status = place(e, at, error);
    }
    return status;
}

static sl_status change_shape(sl_scene_edit *e, unsigned *changes, sl_error *error) {
    sl_surfaces before;
    if (!sl_reshapes(&e->shape)) return change_surfaces(e, changes, error);
    sl_status status = place_moulded(e, error);
    if (status == SL_OK) status = sl_reshape(e->scene, &e->shape, &before, error);
    if (status != SL_OK) return status;
    status = change_surfaces(e, changes, error);
    if (status == SL_OK) sl_reshape_settle(&e->shape, &before);
    else sl_reshape_undo(e->scene, &before);
    return status;
}

static void change_lights(sl_scene_edit *e) {
    sl_light *before = e->scene->lights;
    e->scene->lights = e->lights;
    e->scene->light_count = e->light_count;
    e->lights = before;
}

static sl_status commit(sl_scene_edit *e, unsigned *changes, sl_error *error) {
    sl_scene *s = e->scene;
    if (s->version != e->version)
        return sl_fail(error, SL_ERROR_USAGE, "the scene has changed since this edit of it began");
    *changes = changes_of(e);
    sl_status status = change_shape(e, changes, error);
    if (status != SL_OK) {
        *changes = 0;
        return status;
    }
    change_lights(e);
    if (*changes & SL_CHANGED_SKY) {
        const sl_environment before = s->environment;
        s->environment = e->sky;
        e->sky = before;
    }
    if (*changes & SL_CHANGED_CAMERA) {
        s->camera = e->camera;
        sl_scene_measure_from(s, s->camera.eye);
    }
    sl_scene_has_changed(s, *changes);
    return SL_OK;
}

sl_status sl_scene_edit_commit(sl_scene_edit *edit, unsigned *changes, sl_error *error) {
    unsigned changed = 0;
    if (changes) *changes = 0;
    if (!edit) return sl_fail_null(error, "an edit");
    sl_status status = commit(edit, &changed, error);
    if (changes) *changes = changed;
    sl_scene_edit_destroy(edit);
    return status;
}
