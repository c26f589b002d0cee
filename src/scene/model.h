/* A scene while it is being read: lists that grow. Importers append to it; sl_model_build() welds and builds
 * the scene. */
#ifndef SL_SCENE_MODEL_H
#define SL_SCENE_MODEL_H

#include "scene/affine.h"
#include "scene/scene.h"

typedef struct sl_model {
    size_t vertex_count, vertex_room;
    float *positions, *normals, *uvs; /* 3, 3, 2 a vertex; a missing normal is (0,0,0) */
    uint32_t *vertex_object;
    size_t triangle_count, triangle_room;
    uint32_t *indices, *material_index, *object_index;
    size_t bicubic_count, bicubic_room;
    sl_bicubic *bicubics; /* in triangle order */
    size_t material_count, material_room;
    sl_material *materials;
    size_t texture_count, texture_room;
    sl_texture *textures;
    size_t light_count, light_room;
    sl_light *lights;
    size_t object_count, object_room;
    char **object_names;
    size_t warning_count, warning_room, warnings_left_out;
    char **warnings;
    bool has_camera;
    sl_camera camera;
    const sl_viewpoint *view; /* of the caller, in place of what the camera has; or NULL */
    sl_environment environment; /* texels owned */
    int film_width, film_height;
    size_t file_count, file_room;
    char **files; /* that have been opened, in that order; some more than once */
    char *folder; /* real path of the folder that files must lie below; NULL: they may lie anywhere */
} sl_model;

void sl_model_clear(sl_model *model);

/* Confines the model to the folder of the file that is being loaded. */
sl_status sl_model_confine(sl_model *model, const char *path, sl_error *error);
/* Refuses a file outside of the model's folder: the message says how to allow it. */
sl_status sl_model_may_read(const sl_model *model, const char *path, sl_error *error);

/* Remembers a file that is there, for sl_scene.files; to be called before it is read, whatever comes of that.
 */
sl_status sl_model_note_file(sl_model *model, const char *path, sl_error *error);

/* Room for `count` more; they are zero, and the counts are raised. The first new index in *first. */
sl_status sl_model_add_vertices(sl_model *model, size_t count, uint32_t object, size_t *first,
                                sl_error *error);
sl_status sl_model_add_triangles(sl_model *model, size_t count, size_t *first, sl_error *error);
/* One surface with its vertices and triangles; control points and steps are given, the rest is set. */
sl_status sl_model_add_bicubic(sl_model *model, const sl_bicubic *surface, uint32_t material, uint32_t object,
                               sl_error *error);
/* Copies; the name too. */
sl_status sl_model_add_material(sl_model *model, const sl_material *material, uint32_t *index,
                                sl_error *error);
sl_status sl_model_add_light(sl_model *model, const sl_light *light, sl_error *error);
sl_status sl_model_add_object(sl_model *model, const char *name, uint32_t *index, sl_error *error);
/* Lines that are there already are not told twice; beyond SL_WARNINGS_OF_READING they are counted. */
__attribute__((format(printf, 2, 3))) void sl_model_warn(sl_model *model, const char *format, ...);

/* A texture by file name (decoded once however often it is named), or from `bytes` bytes at `memory` where
 * that is not NULL, `path` then being its name. What cannot be read is a warning, and *index SL_NO_INDEX;
 * failing is for want of memory, or where the file may not be read. */
sl_status sl_model_texture(sl_model *model, const char *path, const void *memory, size_t bytes,
                           uint32_t *index, sl_error *error);
/* The mean colour (linear) and mean bytes/255 of a texture: for material constants that a texture modulates.
 */
sl_rgb sl_texture_mean_color(const sl_texture *texture);
sl_rgb sl_texture_mean_data(const sl_texture *texture);

/* Vertices of one object that agree in every bit of position, normal and texture coordinates become one, but
 * for those of bicubic surfaces. */
sl_status sl_model_weld(sl_model *model, sl_error *error);
/* Welds and builds; the model's warnings come first. */
sl_status sl_model_build(sl_model *model, sl_scene **scene, sl_error *error);

#endif
