/* Parts of a scene as people give them, in scene files and in calls: one set of bounds, one set of words for
 * what breaks them, and one way into the model. */
#pragma once

#include "scene/model.h"

enum { SL_LARGEST_FILM = 65536, SL_RULE_TEXT = 200 /* room for what was expected */ };
#define SL_LEAST_FOV_DEG 0.01
#define SL_MOST_FOV_DEG 179.0
#define SL_EXPECTED_VIEW "expected the camera's 'eye' apart from its 'target', and 'up' not along the view"
#define SL_EXPECTED_ONE_REFLECTION "expected either 'mirror', or 'diffuse' and 'specular'"

double sl_radians(double degrees);

/* Tells whether a number is within its bounds; if not, text says what was expected. */
bool sl_is_within(const char *key, double value, double low, double high, char text[SL_RULE_TEXT]);

/* Copies a struct whose caller may know fewer of its fields. */
sl_status sl_take_struct(void *ours, size_t known, const void *given, const char *type, sl_error *error);
#define SL_TAKE(type, ours, given, error) sl_take_struct(ours, sizeof(type), given, #type, error)

/* A number of a material, or the three of a colour, each from 0 to `most`: its key in scene files, and where
 * sl_material and sl_material_data have it. */
typedef struct sl_material_number {
    const char *key;
    size_t field, given;
    int floats;
    double most;
} sl_material_number;
enum { SL_MATERIAL_NUMBERS = 6, SL_MATERIAL_TEXTURES = 3 };
extern const sl_material_number sl_material_numbers[SL_MATERIAL_NUMBERS];
bool sl_material_number_fits(const sl_material_number *number, const sl_material *material,
                             char text[SL_RULE_TEXT]);
/* A texture likewise: an index, SL_NO_INDEX for none; or a number from 1, 0 for none. */
typedef struct sl_material_texture {
    const char *key;
    size_t field, given;
} sl_material_texture;
extern const sl_material_texture sl_material_textures[SL_MATERIAL_TEXTURES];

/* Returns the key of what is wrong with a light ("" for the whole), with what was expected in text; NULL:
 * nothing. */
const char *sl_light_fault(const sl_light_data *light, char text[SL_RULE_TEXT]);
/* Makes a light without fault, turned into our world: one without extent, or a quad as an object of two
 * triangles. */
sl_light sl_light_from(const sl_light_data *light, const sl_affine *turn);
sl_status sl_model_add_quad(sl_model *model, const char *path, const char *name, const sl_light_data *light,
                            const sl_affine *turn, uint32_t *object, sl_error *error);

/* ---- what calls give, checked and made into the scene's ---- */

/* name: of messages, and of the material, which does not own it. */
sl_status sl_material_take(const sl_scene *scene, const sl_material_data *data, const char *name,
                           sl_material *material, sl_error *error);
/* A mesh whose triangles all name materials of the scene, into the triangles of an object of a model. */
sl_status sl_mesh_take(const sl_scene *scene, sl_model *model, const sl_mesh_data *data, const char *name,
                       uint32_t object, const sl_affine *placement, sl_error *error);
/* The texels are copied; sl_environment_complete() makes the sums. */
sl_status sl_sky_take(int width, int height, const float *radiance, sl_environment *sky, sl_error *error);
sl_status sl_view_take(const float eye[3], const float target[3], const float up[3], float vertical_fov_rad,
                       sl_camera *camera, sl_error *error);

/* Makes a transform of 16 numbers by columns. Returns what was expected, or NULL where they are one. */
const char *sl_matrix_fault(const double columns[16], sl_affine *transform);
