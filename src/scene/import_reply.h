/* What the importer's process answers: what a mesh file has in it, flat, in words of this machine. It is read
 * as a stranger's file is: the importer may have run astray.
 *
 * A word is 32 bits. A text is its length, its bytes, and 1 to 4 zeros up to a whole word. A list is its
 * length and its elements.
 *
 *     SL_IMPORT_MAGIC, SL_IMPORT_VERSION, bytes of the whole: low word, high word
 *     outcome, a text, the list of the files that were opened (texts)
 *     and where the outcome is SL_IMPORT_READ:
 *     textures:  whether compressed, bytes, these up to a whole word
 *     materials: name, which fields it has (a bit each), SL_IMPORT_FIELDS times 5 numbers,
 *                which texts it has (a bit each), alpha mode, names of textures
 *     meshes:    name, material, flags, vertices, triangles, positions (3 a vertex),
 *                where flags say so normals (3) and sets of texture coordinates (2), corners
 *     nodes:     parent (before it; SL_NO_INDEX: none), name, transform (3 rows of 4), list of meshes
 *     lights:    name, type, position, direction, colour, quadratic attenuation, inner and outer angle
 *     cameras:   name, position, direction, up, horizontal field of view, aspect, orthographic width
 *     SL_IMPORT_MAGIC */
#ifndef SL_SCENE_IMPORT_REPLY_H
#define SL_SCENE_IMPORT_REPLY_H

#include <stddef.h>
#include <stdint.h>

#include "softlux.h"

#define SL_IMPORT_MAGIC 0x4d494c53u
#define SL_IMPORT_VERSION 1u
enum { SL_IMPORT_HEADER_BYTES = 16, SL_IMPORT_FIELD_NUMBERS = 5 };

typedef enum sl_import_outcome {
    SL_IMPORT_READ,
    SL_IMPORT_OUTSIDE, /* it names a file that must not be read: the text */
    SL_IMPORT_STARVED, /* no memory */
    SL_IMPORT_UNKNOWN, /* no format that is known */
    SL_IMPORT_DAMAGED, /* the text says why, or is empty */
    SL_IMPORT_OUTCOMES
} sl_import_outcome;

typedef enum sl_import_field {
    SL_IMPORT_DIFFUSE, /* three numbers */
    SL_IMPORT_SPECULAR,
    SL_IMPORT_EMISSIVE,
    SL_IMPORT_BASE,
    SL_IMPORT_SHININESS, /* one number */
    SL_IMPORT_STRENGTH,
    SL_IMPORT_OPACITY,
    SL_IMPORT_METALLIC,
    SL_IMPORT_ROUGHNESS,
    SL_IMPORT_CUTOFF,
    SL_IMPORT_ILLUM,
    SL_IMPORT_TWO_SIDED,
    SL_IMPORT_GLOSSINESS,
    SL_IMPORT_UV_SET, /* of the diffuse map, as are the next three */
    SL_IMPORT_WRAP_U, /* SL_IMPORT_REPEATED and so on */
    SL_IMPORT_WRAP_V,
    SL_IMPORT_UV_TRANSFORM, /* five: offset, scale, rotation */
    SL_IMPORT_FIELDS
} sl_import_field;

typedef enum sl_import_map {
    SL_IMPORT_MAP_DIFFUSE,
    SL_IMPORT_MAP_OPACITY,
    SL_IMPORT_MAP_HEIGHT,
    SL_IMPORT_MAP_METALNESS,
    SL_IMPORT_MAP_UNKNOWN,
    SL_IMPORT_MAP_EMISSIVE,
    SL_IMPORT_MAP_SPECULAR,
    SL_IMPORT_MAPS
} sl_import_map;

enum {
    SL_IMPORT_NORMALS = 1,
    SL_IMPORT_COLOURS = 2,
    SL_IMPORT_BONES = 4,
    SL_IMPORT_UVS = 8, /* and the bits above it: of each set */
    SL_IMPORT_UV_SETS = 4,
    SL_IMPORT_MESH_FLAGS = 128
};
enum { SL_IMPORT_REPEATED, SL_IMPORT_CLAMPED, SL_IMPORT_MIRRORED };
enum { SL_IMPORT_POINT, SL_IMPORT_SPOT, SL_IMPORT_DIRECTIONAL, SL_IMPORT_OTHER_LIGHT, SL_IMPORT_LIGHT_TYPES };

typedef struct sl_import_texture {
    uint32_t compressed, bytes;
    const void *data;
} sl_import_texture;

typedef struct sl_import_material {
    char *name, *alpha_mode, *map[SL_IMPORT_MAPS]; /* NULL: none, but for the name */
    uint32_t has;                                  /* bit per field */
    float value[SL_IMPORT_FIELDS][SL_IMPORT_FIELD_NUMBERS];
} sl_import_material;

typedef struct sl_import_mesh {
    const char *name;
    uint32_t material, flags, vertex_count, triangle_count;
    const float *positions, *normals, *uvs[SL_IMPORT_UV_SETS]; /* NULL: none */
    const uint32_t *corners;
} sl_import_mesh;

typedef struct sl_import_node {
    const char *name;
    uint32_t parent, mesh_count;
    const float *transform;
    const uint32_t *mesh;
} sl_import_node;

typedef struct sl_import_light {
    const char *name;
    uint32_t type;
    float position[3], direction[3], colour[3], quadratic, inner, outer;
} sl_import_light;

typedef struct sl_import_camera {
    const char *name;
    float position[3], direction[3], up[3], horizontal_fov, aspect, orthographic_width;
} sl_import_camera;

/* Lists are its own; what they point to lies in the reply. */
typedef struct sl_import {
    sl_import_outcome outcome;
    const char *text;
    uint32_t file_count, texture_count, material_count, mesh_count, node_count, light_count, camera_count;
    const char **files;
    sl_import_texture *textures;
    sl_import_material *materials;
    sl_import_mesh *meshes;
    sl_import_node *nodes;
    sl_import_light *lights;
    sl_import_camera *cameras;
} sl_import;

/* The bytes that a reply of which these are the first SL_IMPORT_HEADER_BYTES says it has; 0: they begin none.
 */
uint64_t sl_import_reply_bytes(const void *header);
/* Reads a whole reply, which is aligned to words. Of what it says all holds: texts end, indices are below
 * their lists' lengths, parents come first, and nothing is left over; numbers may be any, and corners beyond
 * their mesh are a fault of the file. Failing names the path. Release it in any case. */
sl_status sl_import_reply_read(const char *path, void *reply, size_t size, sl_import *import,
                               sl_error *error);
void sl_import_release(sl_import *import);

#endif
