/* A small room, open in front, that is edited at random: what there is to edit, as it stands, from which the
 * same room can be built afresh. */
#pragma once

#include "base/math.h"
#include "base/random.h"
#include "softlux.h"

#include <string.h>

enum { ROOM_MATERIALS = 4, ROOM_LIGHTS = 3, ROOM_MOST_LIGHTS = 5, ROOM_OBJECTS = 3 };
enum { MATERIAL_WALL = 1, MATERIAL_SIDE, MATERIAL_BOX, MATERIAL_LAMP };
enum { OBJECT_ROOM = 1, OBJECT_BOX, OBJECT_LAMP };

typedef enum room_edit {
    EDIT_COLOUR,
    EDIT_KIND,
    EDIT_LAMP,
    EDIT_POWER,
    EDIT_PLACE,
    EDIT_SKY,
    EDIT_CAMERA,
    EDIT_TRANSFORM,
    ROOM_EDITS,
    EDIT_SHAPE = ROOM_EDITS, /* the box is higher, or lower */
    EDIT_CHAIR,              /* it comes, or goes */
    EDIT_NEW_LIGHT,
    EDIT_TEXTURE,
    EDIT_GLOW,               /* of the box */
    ALL_ROOM_EDITS
} room_edit;

/* All that edits change. */
typedef struct edited_room {
    sl_material_data material[ROOM_MATERIALS];
    int lights;
    float strength[ROOM_MOST_LIGHTS][3];
    double place[ROOM_MOST_LIGHTS][3], direction[ROOM_MOST_LIGHTS][3];
    float height; /* of the box */
    uint32_t chair; /* its object, or 0 */
    bool shaped, furnished; /* in this edit */
    float sky[4 * 2 * 3];
    int sky_width; /* 0: one colour, the first */
    float eye[3];
    double transform[ROOM_OBJECTS][16];
    uint64_t random;
} edited_room;

static inline double room_random(edited_room *r) {
    return (double)sl_random_bits(sl_random_key(1, 2), r->random++) * 0x1p-32;
}

static inline void identity_of(double columns[16]) {
    for (int i = 0; i < 16; i++) columns[i] = i % 5 == 0;
}

static inline edited_room room_at_first(uint64_t seed) {
    edited_room r = {
        .eye = {0.1f, 1.0f, 2.6f}, .random = seed << 32, .lights = ROOM_LIGHTS, .height = 1.0f};
    const float diffuse[ROOM_MATERIALS] = {0.7f, 0.5f, 0.6f, 0.3f};
    for (int i = 0; i < ROOM_MATERIALS; i++) {
        r.material[i].size = sizeof r.material[i];
        for (int c = 0; c < 3; c++) r.material[i].diffuse[c] = diffuse[i];
    }
    r.material[MATERIAL_LAMP - 1].emission[0] = r.material[MATERIAL_LAMP - 1].emission[1] = 6.0f;
    r.material[MATERIAL_LAMP - 1].emission[2] = 5.0f;
    for (int i = 0; i < ROOM_MOST_LIGHTS; i++) {
        for (int c = 0; c < 3; c++) r.strength[i][c] = 0.5f;
        r.place[i][0] = 0.4 - 0.4 * i;
        r.place[i][1] = 1.5;
        r.direction[i][1] = -1.0;
        r.direction[i][2] = -0.2;
    }
    for (int i = 0; i < ROOM_OBJECTS; i++) identity_of(r.transform[i]);
    return r;
}

/* ---- built ---- */

enum { ROOM_QUADS = 8 };
typedef struct quads {
    float positions[3 * 4 * ROOM_QUADS], uv[2 * 4 * ROOM_QUADS];
    uint32_t indices[6 * ROOM_QUADS], materials[2 * ROOM_QUADS];
} quads;

/* Each a corner and two edges. */
static inline sl_mesh_data mesh_of_quads(quads *to, const char *name, size_t count, const float *quad,
                                         const uint32_t *materials) {
    for (size_t q = 0; q < count; q++) {
        const uint32_t first = (uint32_t)(4 * q), corner[6] = {0, 1, 2, 0, 2, 3};
        for (int c = 0; c < 4; c++) {
            const float *f = quad + 9 * q;
            const int right = c == 1 || c == 2, up = c >= 2;
            for (int k = 0; k < 3; k++)
                to->positions[12 * q + 3 * (size_t)c + (size_t)k] =
                    f[k] + (right ? f[3 + k] : 0.0f) + (up ? f[6 + k] : 0.0f);
            to->uv[8 * q + 2 * (size_t)c] = (float)right;
            to->uv[8 * q + 2 * (size_t)c + 1] = (float)up;
        }
        for (int k = 0; k < 6; k++) to->indices[6 * q + (size_t)k] = first + corner[k];
        to->materials[2 * q] = to->materials[2 * q + 1] = materials[q];
    }
    return (sl_mesh_data){.size = sizeof(sl_mesh_data), .name = name, .vertex_count = 4 * count,
                          .positions = to->positions, .texture_coordinates = to->uv,
                          .triangle_count = 2 * count, .indices = to->indices, .materials = to->materials};
}

static inline sl_mesh_data mesh_of_chair(quads *to) {
    static const float seat[] = {0.4f, 0.3f, 0.5f, 0.3f, 0, 0, 0, 0, -0.3f,
                                 0.4f, 0.3f, 0.2f, 0.3f, 0, 0, 0, 0.4f, 0};
    static const uint32_t of_side[] = {MATERIAL_SIDE, MATERIAL_SIDE};
    return mesh_of_quads(to, "chair", 2, seat, of_side);
}

static inline sl_status give_mesh(sl_scene_builder *b, const sl_mesh_data *m, sl_error *error) {
    uint32_t mesh;
    sl_status status = sl_scene_builder_mesh(b, m, &mesh, error);
    const sl_instance_data i = {.size = sizeof i, .mesh = mesh};
    return status == SL_OK ? sl_scene_builder_instance(b, &i, error) : status;
}

static inline sl_status give_meshes(const edited_room *r, sl_scene_builder *b, sl_error *error) {
    static const float room[] = {-1, 0, 1,  2, 0, 0, 0, 0, -2, /* floor, ceiling, back, left, right */
                                 -1, 2, -1, 2, 0, 0, 0, 0, 2,  -1, 0, -1, 2, 0, 0, 0, 2, 0,
                                 -1, 0, 1,  0, 0, -2, 0, 2, 0, 1,  0, -1, 0, 0, 2, 0, 2, 0};
    static const float box[] = {-0.3f, 0.6f, 0.1f,  0.6f, 0, 0, 0, 0, -0.6f, /* of five sides */
                                -0.3f, 0,    0.1f,  0.6f, 0, 0, 0, 0.6f, 0,
                                -0.3f, 0,    -0.5f, 0, 0, 0.6f, 0, 0.6f, 0,
                                0.3f,  0,    0.1f,  0, 0, -0.6f, 0, 0.6f, 0,
                                0.3f,  0,    -0.5f, -0.6f, 0, 0, 0, 0.6f, 0};
    static const float lamp[] = {-0.25f, 1.9f, -0.25f, 0.5f, 0, 0, 0, 0, 0.5f};
    static const uint32_t of_room[] = {1, 1, 1, 2, 2}, of_box[] = {3, 3, 3, 3, 3}, of_lamp[] = {4};
    quads to[4];
    sl_mesh_data mesh[] = {mesh_of_quads(&to[0], "room", 5, room, of_room),
                           mesh_of_quads(&to[1], "box", 5, box, of_box),
                           mesh_of_quads(&to[2], "lamp", 1, lamp, of_lamp), mesh_of_chair(&to[3])};
    sl_status status = SL_OK;
    for (size_t i = 1; i < 3 * mesh[1].vertex_count; i += 3) to[1].positions[i] *= r->height;
    for (int i = 0; i < (r->chair ? 4 : 3) && status == SL_OK; i++) status = give_mesh(b, &mesh[i], error);
    return status;
}

static const float room_target[3] = {0, 0.8f, 0}, room_up[3] = {0, 1, 0};

static inline sl_light_data light_of(const edited_room *r, int i) {
    sl_light_data light = {.size = sizeof light, .type = i == 1 ? SL_LIGHT_SPOT : SL_LIGHT_POINT,
                           .outer_rad = 1.0, .inner_rad = 0.7};
    memcpy(light.strength, r->strength[i], sizeof light.strength);
    memcpy(light.position, r->place[i], sizeof light.position);
    memcpy(light.direction, r->direction[i], sizeof light.direction);
    return light;
}

static inline sl_status give_room(const edited_room *r, sl_scene_builder *b, sl_error *error) {
    static const uint8_t texels[] = {200, 90, 250, 160};
    const sl_texture_data stripes = {.size = sizeof stripes, .width = 2, .height = 2, .channels = 1,
                                     .srgb = texels};
    uint32_t number;
    sl_status status = sl_scene_builder_texture(b, &stripes, &number, error);
    for (int i = 0; i < ROOM_MATERIALS && status == SL_OK; i++)
        status = sl_scene_builder_material(b, &r->material[i], &number, error);
    if (status == SL_OK) status = give_meshes(r, b, error);
    for (int i = 0; i < r->lights && status == SL_OK; i++) {
        const sl_light_data light = light_of(r, i);
        status = sl_scene_builder_light(b, &light, error);
    }
    if (status == SL_OK)
        status = sl_scene_builder_environment(b, r->sky_width, r->sky_width ? 2 : 0, r->sky, error);
    if (status == SL_OK) status = sl_scene_builder_camera(b, r->eye, room_target, room_up, 0.8f, error);
    return status == SL_OK ? sl_scene_builder_film(b, 24, 24, error) : status;
}

/* The room as it stands; objects are moved by one edit. */
static inline sl_status build_room(const edited_room *r, sl_scene **scene, sl_error *error) {
    sl_scene_builder *b;
    sl_scene_edit *e;
    *scene = NULL;
    sl_status status = sl_scene_builder_create(&b, error);
    if (status == SL_OK) status = give_room(r, b, error);
    if (status == SL_OK) status = sl_scene_builder_build(b, scene, error);
    sl_scene_builder_destroy(b);
    if (status == SL_OK) status = sl_scene_edit_begin(*scene, &e, error);
    if (status != SL_OK) return status;
    for (uint32_t i = 0; i < ROOM_OBJECTS && status == SL_OK; i++)
        status = sl_edit_transform(e, i + 1, r->transform[i], error);
    if (status == SL_OK) return sl_scene_edit_commit(e, NULL, error);
    sl_scene_edit_destroy(e);
    return status;
}

/* ---- edited ---- */

static inline void choose_colour(edited_room *r, float c[3], double most) {
    for (int k = 0; k < 3; k++) c[k] = (float)(most * (0.1 + 0.9 * room_random(r)));
}

static inline void choose_transform(edited_room *r, double m[16]) {
    const double angle = 1.5 * room_random(r), scale = 0.7 + 0.5 * room_random(r);
    identity_of(m);
    m[0] = m[10] = scale * sl_cos(angle);
    m[2] = -scale * sl_sin(angle);
    m[8] = scale * sl_sin(angle);
    m[5] = scale;
    m[12] = 0.6 * room_random(r) - 0.3;
    m[14] = 0.4 * room_random(r) - 0.2;
    m[5] = 0.6 + 0.6 * room_random(r);
}

static inline sl_status change_chair(edited_room *r, sl_scene_edit *e, sl_error *error) {
    quads to;
    const sl_mesh_data chair = mesh_of_chair(&to);
    const uint32_t there = r->chair;
    if (r->furnished) return SL_OK;
    r->furnished = true;
    r->chair = 0;
    return there ? sl_edit_remove_object(e, there, error) : sl_edit_add_object(e, &chair, &r->chair, error);
}

/* Doubles or halves: in that no bit is lost. */
static inline sl_status change_height(edited_room *r, const sl_scene *scene, sl_scene_edit *e,
                                      sl_error *error) {
    enum { MOST = 64 };
    const float height = r->height > 0.75f ? 0.5f : 1.0f;
    float positions[3 * MOST];
    const size_t count = sl_scene_vertices(scene, OBJECT_BOX, NULL, NULL);
    if (r->shaped || count > MOST) return r->shaped ? SL_OK : SL_ERROR_INPUT;
    r->shaped = true;
    sl_scene_vertices(scene, OBJECT_BOX, positions, NULL);
    for (size_t i = 0; i < count; i++) positions[3 * i + 1] *= height / r->height;
    r->height = height;
    return sl_edit_vertices(e, OBJECT_BOX, count, positions, NULL, error);
}

static inline sl_status begin_room_edit(edited_room *r, sl_scene *scene, sl_scene_edit **e,
                                        sl_error *error) {
    r->shaped = r->furnished = false;
    return sl_scene_edit_begin(scene, e, error);
}

/* Changes something of one kind in the room, and tells the edit of it. */
static inline sl_status edit_room(edited_room *r, const sl_scene *scene, room_edit kind, sl_scene_edit *e,
                                  sl_error *error) {
    const double chance = room_random(r);
    uint32_t any = 1 + (uint32_t)(3.0 * room_random(r));
    sl_material_data *m = &r->material[any - 1];
    switch (kind) {
    case EDIT_SHAPE: return change_height(r, scene, e, error);
    case EDIT_CHAIR: return change_chair(r, e, error);
    case EDIT_NEW_LIGHT: {
        const sl_light_data light = light_of(r, r->lights);
        if (r->lights == ROOM_MOST_LIGHTS) return SL_OK;
        r->lights++;
        return sl_edit_add_light(e, &light, &any, error);
    }
    case EDIT_TEXTURE:
        m->texture = !m->texture;
        return sl_edit_material(e, any, m, error);
    case EDIT_GLOW:
        m = &r->material[MATERIAL_BOX - 1];
        m->emission[0] = m->emission[0] > 0.0f ? 0.0f : 1.0f;
        return sl_edit_material(e, MATERIAL_BOX, m, error);
    case EDIT_COLOUR:
        choose_colour(r, m->diffuse, 0.7);
        if (m->specular[0] > 0.0f) choose_colour(r, m->specular, 0.3);
        return sl_edit_material(e, any, m, error);
    case EDIT_KIND:
        memset(m->specular, 0, sizeof m->specular);
        if (chance < 0.6) choose_colour(r, m->specular, 0.3);
        m->exponent = 10.0f;
        return sl_edit_material(e, any, m, error);
    case EDIT_LAMP:
        m = &r->material[MATERIAL_LAMP - 1];
        memset(m->emission, 0, sizeof m->emission);
        if (chance < 0.8) choose_colour(r, m->emission, 8.0);
        return sl_edit_material(e, MATERIAL_LAMP, m, error);
    case EDIT_POWER:
        memset(r->strength[any - 1], 0, sizeof r->strength[0]);
        if (chance < 0.8) choose_colour(r, r->strength[any - 1], 1.0);
        return sl_edit_light(e, any, r->strength[any - 1], NULL, NULL, error);
    case EDIT_PLACE:
        r->place[any - 1][0] = 1.6 * room_random(r) - 0.8;
        r->place[any - 1][1] = 1.0 + 0.8 * room_random(r);
        r->direction[any - 1][0] = room_random(r) - 0.5;
        return sl_edit_light(e, any, NULL, r->place[any - 1], r->direction[any - 1], error);
    case EDIT_SKY:
        r->sky_width = chance < 0.5 ? 0 : 4;
        for (int i = 0; i < 24; i++) r->sky[i] = chance < 0.3 ? 0.0f : (float)(0.5 * room_random(r));
        return sl_edit_environment(e, r->sky_width, r->sky_width ? 2 : 0, r->sky, error);
    case EDIT_CAMERA:
        r->eye[0] = (float)(1.2 * room_random(r) - 0.6);
        r->eye[1] = (float)(0.6 + room_random(r));
        return sl_edit_camera(e, r->eye, room_target, room_up, 0.8f, error);
    default:
        choose_transform(r, r->transform[OBJECT_BOX - 1]);
        return sl_edit_transform(e, OBJECT_BOX, r->transform[OBJECT_BOX - 1], error);
    }
}
