/* The scene as everyone behind the public header sees it: triangles in structure-of-arrays form, materials,
 * lights, camera. Immutable between edits; an edit raises `version`. */
#pragma once

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "scene/transport.h"

#define SL_NO_INDEX UINT32_MAX

/* f = kd/pi + ks (n+2)/(2 pi) max(0, cos alpha)^n, or a perfect mirror. kd + ks <= 1 in every channel. */
typedef struct sl_material {
    char *name;
    sl_rgb diffuse;       /* kd, multiplied by the texture where there is one */
    sl_rgb specular;      /* ks */
    float exponent;       /* n, 0 to SL_LARGEST_EXPONENT from files */
    sl_rgb mirror;        /* reflectance of a perfect mirror; then diffuse and specular are 0 */
    sl_rgb emission;      /* radiance L_e, leaving the front (counter-clockwise) side */
    bool emission_two_sided;
    uint32_t texture;     /* of kd, or SL_NO_INDEX */
    /* alpha mask (its alpha channel, or its luminance where it has none), tested at 0.5, or SL_NO_INDEX */
    uint32_t alpha_texture;
    uint32_t height_map;  /* for shading alone (bump.h), or SL_NO_INDEX */
    float bump_depth;     /* from black to white, in widths of the texture: 0 to 1 */
} sl_material;

#define SL_BUMP_DEPTH 0.04f /* where no file says */
#define SL_LARGEST_EXPONENT 1e6

static inline bool sl_material_is_diffuse(const sl_material *m) { return sl_rgb_max(m->diffuse) > 0.0f; }
static inline bool sl_material_is_glossy(const sl_material *m) { return sl_rgb_max(m->specular) > 0.0f; }
static inline bool sl_material_is_mirror(const sl_material *m) { return sl_rgb_max(m->mirror) > 0.0f; }
static inline bool sl_material_is_emitter(const sl_material *m) { return sl_rgb_max(m->emission) > 0.0f; }

/* 8-bit sRGB RGBA, row 0 at the top; v = 0 is the bottom row as in OBJ and OpenGL; repeats in both
 * directions. */
typedef struct sl_texture {
    char *file;
    int width, height;
    bool has_alpha;
    uint8_t *texels; /* 4 bytes a texel */
} sl_texture;

/* Lights without extent. Emissive triangles (sl_emitter) are the area lights; a quad becomes two. */
typedef struct sl_light {
    sl_light_type type;  /* never SL_LIGHT_QUAD */
    sl_vec3 position;    /* point, spot */
    sl_vec3 direction;   /* unit, the way the light travels: spot axis, directional */
    /* point, spot: radiant intensity I in W/sr; directional: irradiance E in W/m^2 on a plane facing it */
    sl_rgb intensity;
    /* spot: full intensity inside, none outside, smoothstep of the cosine between; equal: a step */
    float cos_inner, cos_outer;
} sl_light;

/* One that gives nothing stays in the list, to be turned on by an edit. */
static inline bool sl_light_is_lit(const sl_light *light) { return sl_rgb_max(light->intensity) > 0.0f; }

typedef struct sl_emitter {
    uint32_t triangle;
    float area;          /* > 0 */
    sl_rgb radiance;     /* where its mask leaves it */
    bool two_sided;
    float opaque;        /* the share of its area that its mask leaves: sl_scene_opaque_share() */
} sl_emitter;

/* Latitude-longitude radiance, or one constant where width is 0.
 * direction = (sin theta sin phi, cos theta, -sin theta cos phi), phi = 2 pi (u - 1/2), theta = pi v, v = 0
 * the top row. */
typedef struct sl_environment {
    bool present;
    sl_rgb constant;     /* where width = 0; scale included */
    int width, height;
    float *texels;       /* RGB, scale included; each texel is one constant piece of the sky */
    /* Sampling proportional to luminance times solid angle: cumulative sums, double, normalised to end at 1.
     */
    double *row_cdf;     /* height values */
    double *column_cdf;  /* height x width values */
    /* By the k-th of `count` equal parts of [0,1): the first of the sums that is above its beginning. */
    uint32_t *row_guide, *column_guide;
    double *row_edge;    /* height + 1 cosines of the polar angle, from above */
} sl_environment;

/* A bicubic Bezier surface. The scene holds triangles of it, which is what everyone sees who does not ask for
 * the surface itself: vertices first_vertex + row * (steps + 1) + column at (u, v) = (column, row) / steps;
 * from first_triangle on, row by row, two triangles a cell, (column, row)
 * (+1, 0) (+1, +1) and (column, row) (+1, +1) (0, +1), but for those without area (where an edge of the
 * surface is one point): sl_bicubic_triangle() in scene/bicubic.h finds them. */
typedef struct sl_bicubic {
    sl_vec3 point[4][4];  /* control points as the scene stands now: point[j][i], i along u, j along v */
    uint32_t first_vertex, first_triangle, triangle_count;
    int steps;
} sl_bicubic;

typedef struct sl_camera {
    sl_vec3 eye;
    sl_vec3 right, up, back; /* orthonormal; looks along -back */
    float vertical_fov;      /* radians */
} sl_camera;

/* Purpose of a sub-frame: methods whose cache grows by what is seen draw some to ask for it alone. */
typedef enum sl_sub_frame_purpose {
    SL_SUB_FRAME_BOTH,
    SL_SUB_FRAME_ASKS,
    SL_SUB_FRAME_SHOWS
} sl_sub_frame_purpose;

/* Which of a picture's sub-frames methods draw: the camera's picture with its samples beside the pixels'
 * centres. {0}: the centres themselves. */
typedef struct sl_sub_frame {
    float right, up;       /* of the centre, in pixels */
    sl_sub_frame_purpose purpose;
    unsigned turn, share;  /* light samples of a pixel are shared out among so many, and take turns; 0: one */
    /* 1: pixels that are drawn, 0: those that are not, and keep what they had; rows from the bottom. NULL:
     * all are drawn */
    const uint8_t *wanted;
    /* by texture: of those that are filtered (raster/textures/mip.h); NULL: none is */
    const struct sl_mip *mips;
} sl_sub_frame;

/* Pixels [first, end). */
typedef struct sl_pixel_run {
    size_t first, end;
} sl_pixel_run;

/* Returns the first run of pixels of [first, end) that the sub-frame shows; none: an empty one. */
static inline sl_pixel_run sl_sub_frame_run(const sl_sub_frame *at, size_t first, size_t end) {
    const uint8_t *wanted = at->wanted;
    if (!wanted) return (sl_pixel_run){first, end};
    const uint8_t *from = memchr(wanted + first, 1, end - first);
    if (!from) return (sl_pixel_run){end, end};
    const uint8_t *to = memchr(from, 0, (size_t)(wanted + end - from));
    return (sl_pixel_run){(size_t)(from - wanted), to ? (size_t)(to - wanted) : end};
}

/* Clears the pixels that it shows, in `planes` planes one after the other. */
void sl_sub_frame_clear(const sl_sub_frame *at, unsigned threads, float *plane, size_t planes, size_t pixels);

enum { SL_CHANGES = 7, SL_CHANGED_ALL = (1 << SL_CHANGES) - 1 }; /* bits of SL_CHANGED_ */

typedef struct sl_animation sl_animation; /* keyframes of camera, objects and lights: scene/animation.h */

struct sl_scene {
    uint64_t version;     /* raised by every edit */
    uint64_t changed[SL_CHANGES]; /* by bit of SL_CHANGED_: the version that last changed it */
    const struct sl_raster_observer *observer; /* of the passes that draw it (raster/raster.h), or NULL */

    size_t vertex_count;
    float *position_x, *position_y, *position_z;
    float *normal_x, *normal_y, *normal_z; /* unit shading normals */
    float *texture_u, *texture_v;

    size_t triangle_count;
    uint32_t *vertex[3];        /* corner indices */
    uint32_t *material_index;
    uint32_t *object_index;     /* into objects */
    /* unit, by counter-clockwise winding */
    float *geometric_normal_x, *geometric_normal_y, *geometric_normal_z;

    size_t bicubic_count;
    sl_bicubic *bicubics;       /* in triangle order */

    size_t material_count;
    sl_material *materials;
    size_t texture_count;
    sl_texture *textures;
    size_t light_count;
    sl_light *lights;
    size_t emitter_count;
    sl_emitter *emitters;       /* in triangle order */
    uint32_t *emitter_of_triangle; /* triangle_count, or SL_NO_INDEX */
    /* triangles of emissive materials: emitters, and what is too small (or too large) to have an area now */
    size_t emissive_count;
    float *opaque_share;        /* of each of them, in triangle order: no motion changes it */
    sl_environment environment;

    sl_camera camera;
    sl_sub_frame sub_frame;     /* {0} but in copies that a film makes (cache/frame/film.h) */
    int film_width, film_height;

    size_t object_count;
    char **object_names;
    sl_animation *animation;    /* NULL: nothing moves */
    double time;                /* to which keyframes have moved it */

    sl_vec3 box_min, box_max;
    float diagonal;             /* of the box, > 0 */
    /* Where most of the scene lies, if a little of it lies far apart (scale.c); else the diagonal and the
     * box. Tolerances are shares of the scale, > 0; it is a good deal larger than the central region, which
     * is where detail is. */
    float scale;
    sl_vec3 central_min, central_max;
    /* They follow from these: the middle, the radius that holds half of the vertices, the eye with which the
     * scene was made or that was set since. */
    sl_vec3d middle;
    double radius;
    sl_vec3 vantage;

    bool is_read; /* its files are: what is told from there on is of what it is made into */
    size_t warning_count, warnings_left_out;
    char **warnings, more_warnings[64]; /* the latter: on those that are left out */
    /* that it was read from, the ones that were named and the ones that those name; some more than once.
     * Writing them would lose them */
    size_t file_count;
    char **files;
};

/* Fills in how an object (from 1) is moved from its rest state, as sl_edit_transform() has it; true:
 * keyframes move it. */
bool sl_scene_transform(const sl_scene *scene, uint32_t object, double columns[16]);

/* A new version, in which this has changed: SL_CHANGED_ bits. */
static inline void sl_scene_has_changed(sl_scene *s, unsigned changes) {
    if (changes) s->version++;
    for (int i = 0; i < SL_CHANGES; i++) s->changed[i] = changes >> i & 1u ? s->version : s->changed[i];
}
/* Returns what has changed since a version. */
static inline unsigned sl_scene_changes_since(const sl_scene *s, uint64_t version) {
    unsigned changes = 0;
    for (int i = 0; i < SL_CHANGES; i++) changes |= (unsigned)(s->changed[i] > version) << i;
    return changes;
}

static inline sl_vec3 sl_scene_position(const sl_scene *s, uint32_t vertex) {
    return sl_v3(s->position_x[vertex], s->position_y[vertex], s->position_z[vertex]);
}
static inline sl_vec3 sl_scene_normal(const sl_scene *s, uint32_t vertex) {
    return sl_v3(s->normal_x[vertex], s->normal_y[vertex], s->normal_z[vertex]);
}
static inline sl_vec3 sl_scene_geometric_normal(const sl_scene *s, uint32_t triangle) {
    return sl_v3(s->geometric_normal_x[triangle], s->geometric_normal_y[triangle],
                 s->geometric_normal_z[triangle]);
}
static inline const sl_material *sl_triangle_material(const sl_scene *s, size_t triangle) {
    return &s->materials[s->material_index[triangle]];
}
/* Has the scene a part so far from the rest that what is right for one is wrong for the other? Then rounding
 * is reckoned by where a point is. */
static inline bool sl_scene_is_scattered(const sl_scene *s) { return s->scale < s->diagonal; }
static inline float sl_greatest_coordinate(sl_vec3 p) {
    return fmaxf(fabsf(p.x), fmaxf(fabsf(p.y), fabsf(p.z)));
}
/* The greatest coordinate by which a point there, and what is near to it, may have been rounded: of all the
 * scene, unless it is scattered. */
static inline float sl_scene_coordinate_near(const sl_scene *s, sl_vec3 p) {
    float all = fmaxf(sl_greatest_coordinate(s->box_min), sl_greatest_coordinate(s->box_max));
    return sl_scene_is_scattered(s) ? fminf(all, sl_greatest_coordinate(p) + s->scale) : all;
}
/* A share of the scale by which points leave their surface, in a scattered scene no less than what rounding
 * takes away there. */
static inline float sl_scene_rounding(const sl_scene *s) {
    return sl_scene_is_scattered(s) ? 0x1p-20f : 0.0f;
}
static inline float sl_scene_offset_at(const sl_scene *s, float offset, sl_vec3 p) {
    float least = sl_scene_rounding(s) * sl_greatest_coordinate(p);
    return least > offset ? least : offset;
}
static inline float sl_scene_central_diagonal(const sl_scene *s) {
    return sl_scene_is_scattered(s) ? sl_length(sl_sub(s->central_max, s->central_min)) : s->diagonal;
}
/* A surface point as it is made, for one triangle and barycentric weights (w1, w2) of corners 1 and 2. */
typedef struct sl_surface {
    sl_vec3 position;
    sl_vec3 geometric_normal;   /* turned to the viewer's side */
    sl_vec3 normal;             /* shading normal, flipped into the hemisphere of geometric_normal */
    sl_rgb diffuse;             /* kd with its texture */
    const sl_material *material;
    bool front;                 /* seen from the counter-clockwise side */
} sl_surface;

/* to_viewer need not be unit. The one place where sides, flipping and textures are decided (scene/surface.c).
 */
void sl_scene_surface(const sl_scene *scene, uint32_t triangle, float w1, float w2, sl_vec3 to_viewer,
                      sl_surface *surface);
/* kd with texture alone; and whether the alpha mask is opaque there. */
sl_rgb sl_scene_diffuse(const sl_scene *scene, uint32_t triangle, float w1, float w2);
/* The same with the nearest texel alone: for gathers, which see a surface through thousands of samples, each
 * far larger than a texel. */
sl_rgb sl_scene_diffuse_nearest(const sl_scene *scene, uint32_t triangle, float w1, float w2);
bool sl_scene_is_opaque(const sl_scene *scene, uint32_t triangle, float w1, float w2);
/* The share of a triangle that its mask leaves, of points spread evenly over it; 1 without a mask. */
float sl_scene_opaque_share(const sl_scene *scene, uint32_t triangle);
/* the triangle's material has an alpha mask */
bool sl_scene_has_alpha(const sl_scene *scene, uint32_t triangle);

/* Radiance that a triangle sends to the side on which geometric_normal points (turned to the viewer): black
 * from behind, unless it shines on both. */
sl_rgb sl_scene_emission(const sl_scene *scene, uint32_t triangle, sl_vec3 geometric_normal);

/* Radiance of the environment in a unit direction; black where there is none. */
sl_rgb sl_environment_radiance(const sl_environment *environment, sl_vec3 direction);
/* A direction drawn proportional to luminance x solid angle from two numbers in [0,1); its radiance and pdf
 * (1/sr). */
sl_vec3 sl_environment_sample(const sl_environment *environment, float u1, float u2, sl_rgb *radiance,
                              float *pdf);
float sl_environment_pdf(const sl_environment *environment, sl_vec3 direction);
/* The middle of a texel (the environment is a picture), its radiance and its solid angle. */
sl_vec3 sl_environment_texel(const sl_environment *environment, int row, int column, sl_rgb *radiance,
                             float *solid_angle);
/* Sky and sun, sky + sun = all: the sky is the whole, cut in proportion to at most a luminance of
 * threshold_over_mean (> 1) times its own mean, so of low contrast; the sun is the rest, some texels or none.
 * Both with sampling tables of their own, both to be released with sl_environment_release(). A part that is
 * black is not present; a constant environment is all sky. */
sl_status sl_environment_split(const sl_environment *all, double threshold_over_mean, sl_environment *sky,
                               sl_environment *sun, sl_error *error);
void sl_environment_release(sl_environment *environment);

/* 1 inside a spot's inner cone, 0 outside the outer one, smoothstep of the cosine with the axis between; a
 * step where they are equal. */
static inline float sl_spot_falloff(float cosine, float inner, float outer) {
    float x = (cosine - outer) / (inner > outer ? inner - outer : 1.0f);
    x = x > 0.0f ? x : 0.0f;
    float smooth = x * x * (3.0f - 2.0f * x);
    return cosine >= inner ? 1.0f : cosine > outer ? smooth : 0.0f;
}
/* Irradiance-like terms of a light without extent at p: unit direction to the light, distance (infinite for
 * directional) and the irradiance on a plane that faces it. Returns false where that is zero. */
bool sl_light_illuminate(const sl_light *light, sl_vec3 p, sl_vec3 *to_light, float *distance,
                         sl_rgb *irradiance);

/* The time of the last keyframe; 0 where nothing moves. */
double sl_scene_duration(const sl_scene *scene);

/* Tells whether one of the lights without extent is lit. */
bool sl_scene_has_lit_light(const sl_scene *scene);

/* Of all that light depends on, whoever looks: geometry, materials, textures, lights, environment. */
uint64_t sl_scene_light_hash(const sl_scene *scene);
/* sl_scene_hash(), from that. */
uint64_t sl_scene_hash_of(const sl_scene *scene, uint64_t light_hash);

/* Lines that are there already are not told twice; beyond SL_WARNINGS of reading, and as many of what is made
 * of it, they are counted. */
__attribute__((format(printf, 2, 3))) void sl_scene_warn(sl_scene *scene, const char *format, ...);
/* Counts that many more warnings, which nobody would read. */
void sl_scene_leave_out_warnings(sl_scene *scene, size_t count);
enum { SL_WARNINGS = 100 };
bool sl_camera_look_at(sl_camera *camera, sl_vec3 eye, sl_vec3 target, sl_vec3 up, float vertical_fov);
/* The same of what a call gives: SL_ERROR_USAGE where that makes no view. */
sl_status sl_camera_take(sl_camera *camera, const float eye[3], const float target[3], const float up[3],
                         float vertical_fov, sl_error *error);
