/* The JSON scene file (docs/scene-format.md). */
#pragma once

#include "scene/animation.h"
#include "scene/json.h"
#include "scene/parts.h"

sl_status sl_scene_file_load(const char *path, const sl_load_options *options, sl_scene **scene,
                             sl_error *error);

/* ---- between scene_file.c, scene_file_motion.c, scene_file_lights.c and scene_file_materials.c ---- */

typedef struct sl_scene_file {
    sl_json json;
    sl_model model;
    sl_animation *animation; /* always there while reading; empty: nothing moves */
    bool z_up;
    sl_affine turn;          /* from the file's world to ours */
} sl_scene_file;

/* "transform" of a mesh: 16 numbers by columns, or {translate, rotate_deg, scale}. */
sl_affine sl_scene_file_transform(sl_scene_file *file, const cJSON *item);
/* "keyframes" of a mesh or quad light (NULL: none); of a light without extent; of the camera. */
void sl_scene_file_object_keys(sl_scene_file *file, const cJSON *item, uint32_t first_object,
                               uint32_t object_count);
void sl_scene_file_light_keys(sl_scene_file *file, const cJSON *item, uint32_t light);
void sl_scene_file_camera(sl_scene_file *file, const cJSON *item);

void sl_scene_file_lights(sl_scene_file *file, const cJSON *list);
void sl_scene_file_environment(sl_scene_file *file, const cJSON *item);
/* A material that one of the meshes asks for by name need not be in a mesh file. */
void sl_scene_file_materials(sl_scene_file *file, const cJSON *list, const cJSON *meshes);
/* The index of a named material; an input error at `item` where there is none. */
uint32_t sl_scene_file_material_named(sl_scene_file *file, const cJSON *item, const char *name);
