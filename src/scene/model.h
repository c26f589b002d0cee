/* A scene while it is being made: whatever it comes from (files, the importer's process, arrays) is added
 * here, and sl_model_build() checks it and makes the scene. */
#pragma once

#include "scene/affine.h"
#include "scene/scene.h"

typedef struct sl_model {
    /* The scene's as it stands: materials, textures, lights, environment, objects, film, files, warnings. */
    sl_scene scene;
    size_t material_room, texture_room, light_room, object_room, file_room;
    size_t vertex_count, vertex_room;
    float *positions, *normals, *uvs; /* 3, 3, 2 a vertex; a missing normal is (0,0,0) */
    size_t triangle_count, triangle_room;
    uint32_t *indices, *material_index, *object_index;
    size_t bicubic_count, bicubic_room;
    sl_bicubic *bicubics; /* in triangle order */
    /* Vertices of one object that agree in position, normal and texture coordinates become one, unless this
     * says no. */
    bool keeps_vertices;
    bool keeps_dark_lights; /* edits may turn them on */
    size_t dark_lights;     /* that were left out */
    bool stays_dark;    /* without any light: no default light is added */
    bool has_camera;
    sl_camera camera;
    const sl_viewpoint *view; /* of the caller, in place of what the camera has; or NULL */
    char *folder; /* real path of the folder that files must lie below; NULL: they may lie anywhere */
} sl_model;

void sl_model_clear(sl_model *model);
/* Frees vertices, triangles and surfaces: what is added is numbered from 0 again. */
void sl_model_drop_geometry(sl_model *model);
/* Makes the scene of the model, which is as good as cleared then. */
sl_status sl_model_build(sl_model *model, sl_scene **scene, sl_error *error);

/* Moves the model's triangles into a scene that has none: at no time are there two of all. What follows from
 * triangles has room there. */
sl_status sl_model_add_geometry(sl_model *model, sl_scene *scene, sl_error *error);

/* ---- what a model is made of ---- */

/* Triangles of one material and one object, in whatever arrays they come. */
typedef struct sl_mesh {
    const char *name; /* of messages */
    size_t vertex_count, triangle_count;
    const float *positions, *normals, *uvs; /* 3, 3, 2 a vertex; the last two may be NULL */
    const uint32_t *corners;                /* 3 a triangle */
    uint32_t material, object;
} sl_mesh;

/* Fails where a corner names no vertex, with a message that names the mesh and the corner. `path`: where it
 * comes from; "": from no file. */
sl_status sl_mesh_check(const char *path, const sl_mesh *mesh, sl_error *error);
/* Adds a mesh that passes this check where the placement puts it. */
sl_status sl_model_add_mesh(sl_model *model, const char *path, const sl_mesh *mesh,
                            const sl_affine *placement, sl_error *error);
/* Room for `count` more; they are zero, and the counts are raised. The first new index in *first. */
sl_status sl_model_add_vertices(sl_model *model, size_t count, size_t *first, sl_error *error);
sl_status sl_model_add_triangles(sl_model *model, size_t count, size_t *first, sl_error *error);
/* One surface with its vertices and triangles; control points and steps are given, the rest is set. */
sl_status sl_model_add_bicubic(sl_model *model, const sl_bicubic *surface, uint32_t material, uint32_t object,
                               sl_error *error);
/* Copies; the name too. */
sl_status sl_model_add_material(sl_model *model, const sl_material *material, uint32_t *index,
                                sl_error *error);
/* A light that gives none is counted and left out, unless such are kept: *index is SL_NO_INDEX then. */
sl_status sl_model_add_light(sl_model *model, const sl_light *light, uint32_t *index, sl_error *error);
sl_status sl_model_add_object(sl_model *model, const char *name, uint32_t *index, sl_error *error);
/* The texels become the model's, whatever comes of it; a texture of that name that is there already stays in
 * their place. */
sl_status sl_model_add_texture(sl_model *model, const char *name, const sl_texture *texture, uint32_t *index,
                               sl_error *error);
/* A diffuse grey, as files have that say nothing of materials. */
sl_material sl_grey_material(const char *name, float diffuse);

/* ---- files that it names ---- */

/* Confines the model to the folder of the file that is being loaded. */
sl_status sl_model_confine(sl_model *model, const char *path, sl_error *error);
/* Refuses a file outside of the model's folder: the message says how to allow it. */
sl_status sl_model_may_read(const sl_model *model, const char *path, sl_error *error);
/* Remembers a file that is there, for sl_scene.files; to be called before it is read, whatever comes of that.
 */
sl_status sl_model_note_file(sl_model *model, const char *path, sl_error *error);
/* A texture by file name (decoded once however often it is named), or from `bytes` bytes at `memory` where
 * that is not NULL, `path` then being its name. What cannot be read is a warning, and *index SL_NO_INDEX;
 * failing is for want of memory, or where the file may not be read. */
sl_status sl_model_texture(sl_model *model, const char *path, const void *memory, size_t bytes,
                           uint32_t *index, sl_error *error);
/* The same by a name as exporters write it into mesh files: with back slashes, %20 and folders of the machine
 * that they ran on. Of what can be meant, the first file that is there and may be read. `name` is changed. */
sl_status sl_model_texture_beside(sl_model *model, const char *mesh_file, char *name, uint32_t *index,
                                  sl_error *error);
