/* The direct radiance map, passes 2a to 2c: pictures taken from the lights, of what they light directly. They
 * tell, texel by texel, where light is reflected (positions), how much (radiance, or where materials are not
 * Lambertian their true colour) and in which directions (normals).
 *
 * A face is w x w texels (w x ceil(w/2) for the sides of a hemicube), cut into m x m blocks: each block's
 * middle is a sample, which stands for the block's solid angle. Psi = rho I dOmega / pi is finite wherever y
 * lies and however the surface is tilted there.
 *
 * Where a picture shows a mirror, rays find what the mirror lights: y is real, and b is the whole way. */
#pragma once

#include "cache/direct_radiance/lights.h"
#include "cache/frame/settings.h"
#include "raster/raster.h"

typedef struct sl_map_face {
    uint32_t light;
    sl_vec3 eye;                     /* the light */
    sl_view view;
    sl_frame frame;                  /* x right, y up, z the way it looks */
    /* of the picture plane: at distance 1 along z; directional: in world units around eye */
    double left, right, bottom, top;
    int width, height;               /* texels */
    int columns, rows;               /* blocks: width / columns = height / rows = w / m texels each way */
    size_t first;                    /* its first texel in the planes, row 0 at the bottom */
    bool back;                       /* of an area light */
} sl_map_face;

typedef struct sl_radiance_map {
    const sl_map_lights *lights;
    size_t face_count;
    sl_map_face *face;               /* light by light */
    size_t texels;                   /* of all faces together; the planes hold so many values */
    uint32_t *triangle;              /* SL_NO_INDEX: nothing there (coverage 0) */
    float *position[3];
    float *color[3]; /* Lambertian scenes: L_o, W/(m^2 sr), as it leaves: mirrors on the light's way have had
                        their share; others: true colour, kd with its texture, and nothing else */
    /* shading normals turned to the light; NULL where no weight or material asks for them */
    float *normal[3];
    float *geometric[3];             /* geometric ones, likewise turned; always there, as they decide sides */
    /* per texel: b, the way from the light; by way of mirrors the unfolded one */
    float *path;
    /* NULL, or of light by way of mirrors: unit, at y towards where it comes from; 0 where it came straight
     */
    float *arrival[3];
    float *carried[3];               /* beside that: the reflectances of the mirrors on the way, multiplied */
    bool lambertian;                 /* color holds L_o */
    /* of all lights together, by their flux (directional ones, of unknown flux, aside): the share that leaves
     * inside the faces, hit or not: 1 for cubes around points; 0.554 for 90 degree frustums of area lights */
    double captured;
} sl_radiance_map;

typedef struct sl_radiance_map_options {
    bool lambertian;                 /* no surface is glossy: radiance instead of true colour */
    bool normals;                    /* pass 2c */
    const struct sl_tracer *tracer;  /* follows mirrors in a light's view; NULL: they stay dark */
    unsigned threads;
} sl_radiance_map_options;

/* Takes the pictures. settings are complete. Faces that are dark, faces that meet no geometry, and all of
 * lights without flux are skipped and counted as such. What lies lower than an area light's own triangles
 * reach is not in its pictures. Lights that shine into one hemisphere have hemicubes where cubes are asked
 * for; directional lights one parallel picture, whatever is asked for. */
sl_status sl_radiance_map_render(const sl_scene *scene, const sl_raster *raster, const sl_map_lights *lights,
                                 const sl_radiance_map_settings *settings,
                                 const sl_radiance_map_options *options, sl_radiance_map **map,
                                 sl_counters *counters, sl_error *error);
void sl_radiance_map_destroy(sl_radiance_map *map);
size_t sl_radiance_map_bytes(const sl_radiance_map *map);
/* The part of space, and of a surface, for which one sample of a light's picture stands: (12), (13), and what
 * they should be. */

/* Exact solid angle of the rectangle [x0,x1] x [y0,y1] of a picture plane at distance 1: atan(x y / sqrt(1 +
 * x^2 + y^2)) at its corners, with alternating signs. Those of a picture's parts add up to 4
 * asin(sin^2(fov/2)), those of a cube's six faces to 4 pi. */
double sl_rectangle_solid_angle(double x0, double y0, double x1, double y1);
/* (12) as printed but with the number m of samples a side where the paper has its texels: (2 b tan(fov /
 * 2m))^2. */
double sl_printed_footprint(double b, double fov, int m);
/* (13): A' / cos alpha; infinite at grazing incidence, 0 below. */
double sl_printed_tilted_footprint(double footprint, double cos_alpha);

/* Texels a side of a block in a directional light's picture, of `texels` in others': it holds the whole
 * scene, and the sun that falls through a window is a small part of it. 8 times as many, up to 512 a side of
 * the picture. */
int sl_parallel_texels(int samples, int texels);

typedef struct sl_map_drawing {
    const sl_scene *scene;
    const sl_raster *raster;
    const sl_radiance_map_settings *settings;
    const sl_radiance_map_options *options;
    sl_radiance_map *map;
    sl_counters *counters;
} sl_map_drawing;

/* Chooses the faces of all lights, and what they hold of their flux (map_faces.c). */
sl_status sl_map_faces_choose(const sl_map_drawing *drawing, sl_error *error);
/* Draws all faces, and writes what they show. No shadows are looked up: what the light sees is lit. */
sl_status sl_map_pictures_draw(const sl_map_drawing *drawing, sl_error *error);

/* Texels of the direct radiance map, read as what photons are made of: their flux Psi = rho I dOmega / pi, in
 * which neither distance nor angle is left, and where, whence and onto what it falls. */

/* Part of a face in texel coordinates, half-open: what a photon stands for. */
typedef struct sl_texel_rectangle {
    double left, bottom, right, top;
} sl_texel_rectangle;

/* A texel, or several of one surface. All in double: y - L cancels where the scene lies far from the origin.
 */
typedef struct sl_map_texel {
    sl_vec3d position;   /* y */
    sl_vec3d normal;     /* unit, geometric, on the lit side */
    sl_vec3d shading;    /* unit; the geometric one where the map has no pictures of it */
    sl_vec3d to_light;   /* unit, at y towards where its light comes from */
    double way;          /* b */
    double size;         /* dOmega, sr; directional: area, m^2 */
    double cos_alpha;    /* of the geometric normal; >= SL_TEXEL_COS_MIN */
    double footprint;    /* A' = b^2 dOmega of the texel */
    /* Psi = L_o A of the texel, W/sr. Maps of true colour: W, still to be reflected by the material */
    double flux[3];
    /* of Psi, in maps of true colour of what the material reflects in all directions: weight of means; > 0 */
    double luminance;
    double color[3];     /* the map's: L_o, or kd */
    double radiance[3];  /* of printed weights: L_o; maps of true colour, which need to know who looks: E */
    const sl_material *material;
    uint32_t object;
    bool mirrored;       /* its light came by way of mirrors */
    bool bent;           /* of several texels whose normals differ */
    sl_texel_rectangle rectangle; /* empty where the light came by mirrors */
} sl_map_texel;

/* Psi never has cos alpha in a denominator (L_o has the same cosine): so this guards 0/0 alone, and turns
 * nothing that could be seen. */
#define SL_TEXEL_COS_MIN 1e-6
/* A group's area is the sum of A' / max(cos alpha, that): not larger than its texels' would be at that angle.
 */
#define SL_GROUP_COS_MIN 0.02
/* Photons nearer to their light than that share of the diagonal of the scene's central region are dropped. */
#define SL_PHOTON_NEAREST_LIGHT 1e-4

/* False where there is nothing to reflect light (coverage 0), no light, or the light is too near; then *texel
 * is not written whole. color: instead of the texel's own in the map; or NULL. */
bool sl_map_texel_read(const sl_scene *scene, const sl_radiance_map *map, const sl_map_face *face, int column,
                       int row, const double *color, sl_map_texel *texel);
/* Its index in the planes. */
static inline size_t sl_map_texel_index(const sl_map_face *face, int column, int row) {
    return face->first + (size_t)row * (size_t)face->width + (size_t)column;
}
/* Returns the unit direction in which the light of a face's texel leaves the light. */
sl_vec3 sl_map_face_departure(const sl_map_face *face, size_t texel);
/* A ray of the picture: towards texel coordinates (column, row), where texel (0, 0) is the square from 0
 * to 1. Not of unit length. */
void sl_map_face_ray(const sl_map_face *face, bool directional, double column, double row, sl_vec3d *origin,
                     sl_vec3d *direction);

static inline double sl_luminance_of(const double c[3]) {
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

/* Sample photons: what pass 3 takes from the direct radiance map. A photon is a piece of directly lit
 * surface; a receiver (the paper's importon) adds up what all of them send. */

/* 64 bytes: what a fragment program would hold in four registers. */
typedef struct sl_map_photon {
    sl_vec3 position;     /* y */
    /* A' = b^2 dOmega, m^2 perpendicular to the light: (12) corrected. Of a flux group: A cos alpha */
    float footprint;
    /* Psi = rho I dOmega / pi = L_o A, W/sr. With lobes: I dOmega, the material is the lobe's */
    sl_rgb flux;
    float cos_alpha;      /* at y, towards the light; > 0 */
    sl_vec3 normal;       /* n_y, unit, on the lit side: the geometric one, which decides sides */
    /* (13) with (12), for the printed weights: A of (14); its A' is printed_area * cos_alpha */
    float printed_area;
    sl_rgb radiance; /* for the printed weights: L_o, or with lobes the irradiance that is reflected; of a
                        group, the share that it has in its sample's mean */
    /* M, of all its light's faces: a sample may have no photon, or a few groups of them; 0: each has one */
    uint32_t samples;
} sl_map_photon;

/* Reflection of photon i on a surface that is not Lambertian. */
typedef struct sl_photon_lobe {
    sl_rgb diffuse, specular; /* kd, ks */
    float exponent;
    sl_vec3 to_light;         /* unit */
    sl_vec3 normal;           /* unit, shading */
} sl_photon_lobe;

/* A photon's footprint, the polygon between its corners on its tangent plane, as two triangles seen from its
 * lit side. None where the corners do not all meet the plane in front of the light, or a ray to one is longer
 * than 4 b: then the flux weight stands in. */
typedef struct sl_photon_polygon {
    sl_vec3 corner[4];
    float over_area; /* 1 / A_q; 0: none */
    float depth;     /* by how much its plane may miss the surface */
    sl_polygon_light triangle[2];
} sl_photon_polygon;

/* corners: in turn, counter-clockwise seen from the lit side. */
sl_photon_polygon sl_photon_polygon_of(const sl_vec3 corner[4], sl_vec3 normal, float area, float depth);

typedef struct sl_map_photons {
    size_t count, room;      /* of the arrays */
    sl_map_photon *photon;   /* in order of light, face, row, column, group: of every sum */
    sl_photon_lobe *lobe;    /* NULL where all surfaces are Lambertian */
    sl_photon_polygon *polygon; /* NULL unless the polygon weight is wanted */
    /* samples without a photon: nearer to the light than 1e-4 of the diagonal of the scene's central region,
     * or without light */
    size_t dropped;
    float nearest;           /* r below which a photon gives nothing: 1e-6 of the scene's scale */
    float box_diagonal;      /* ||B_max - B_min|| of (15) */
} sl_map_photons;

/* settings are complete. A pure function of scene and map: nothing outlives a frame. */
sl_status sl_map_photons_take(const sl_scene *scene, const sl_radiance_map *map,
                              const sl_radiance_map_settings *settings, sl_map_photons **photons,
                              sl_counters *counters, sl_error *error);
void sl_map_photons_destroy(sl_map_photons *photons);
size_t sl_map_photons_bytes(const sl_map_photons *photons);

/* ---- photons in the making ---- */

/* Photons in the making, and what their samples are taken from. */
typedef struct sl_photon_maker {
    const sl_scene *scene;
    const sl_radiance_map *map;
    sl_map_photons *photons;
    size_t samples; /* of the light whose photons are taken */
} sl_photon_maker;

/* Texels each way of a block. */
static inline int sl_block_texels(const sl_map_face *face) { return face->width / face->columns; }
static inline bool sl_face_is_directional(const sl_radiance_map *map, const sl_map_face *face) {
    return map->lights->light[face->light].source.kind == SL_SOURCE_DIRECTIONAL;
}

/* Solid angle, sr (directional: area, m^2), of a square of so many texels whose lower left one that is. */
double sl_map_part(const sl_radiance_map *map, const sl_map_face *face, int column, int row, int texels);

/* Appends the sample; nothing where it holds no light, or where a float cannot hold it. */
void sl_photon_add(sl_photon_maker *list, const sl_map_face *face, const sl_map_texel *sample);

enum { SL_PHOTON_GROUPS = 4 }; /* surfaces of a block, at most */
/* Appends a photon for each surface of the block whose lower left texel that is (photon_groups.c). */
void sl_photon_groups_take(sl_photon_maker *list, const sl_map_face *face, int column, int row);
