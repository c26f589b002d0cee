/* Primitives, on which the patch hierarchy stands: the scene's triangles, those pairs of them that make a
 * parallelogram (importers cut quadrilaterals in two), and bicubic patches, each with parameters (u, v).
 *
 *   triangle   u, v >= 0, u + v <= 1: the barycentric weights of corners 1 and 2
 *   quad       [0,1]^2, bilinear: corners (0,0), (1,0), (1,1), (0,1)
 *   bicubic    [0,1]^2, the scene's patch
 *
 *   primitives.c        what they are: quads found
 *   primitive_points.c  points of roots
 *   primitive_edges.c   where roots meet: edges and corners on which shading is shared
 *
 * A root is a side of a primitive: 2 p its front, 2 p + 1 its back; light on them has nothing in common. */
#pragma once

#include "cache/light/light_sample.h"
#include "cache/patches/solids.h"
#include "scene/scene.h"
#include "scene/surface_rules.h"

enum { SL_PATCH_DEPTH_MAX = 14, SL_PATCH_DYADIC = 1 << SL_PATCH_DEPTH_MAX };

typedef enum sl_primitive_kind {
    SL_PRIMITIVE_TRIANGLE,
    SL_PRIMITIVE_QUAD,
    SL_PRIMITIVE_BICUBIC
} sl_primitive_kind;

typedef struct sl_primitives {
    const sl_scene *scene;
    size_t count;
    uint8_t *kind;
    uint8_t *turn;              /* of quads, see sl_quad_first() */
    uint32_t *first_triangle;   /* in the scene */
    uint32_t *bicubic;          /* index into the scene's patches, or SL_NO_INDEX; NULL: it has none */
    uint32_t *of_triangle;      /* by scene triangle */
    size_t curved;              /* how many are bicubic */
    sl_rgb *mean_diffuse;       /* NULL: the scene has no textures */
    /* Where primitives meet, by 4 primitive + edge (corner i to i + 1) or corner: the next in a ring of those
     * that are one; of corners, of which many meet, also the lowest of them. */
    uint32_t *edge_next, *corner_first, *corner_next;
    uint8_t *edge_kind;         /* SL_EDGE_ bits */
    sl_solids *solids;          /* of the scene: sl_solids_edit() after objects or lights have moved */
} sl_primitives;

enum { SL_EDGE_BACKWARDS = 1, /* it runs against the way that the ring agrees on */
       SL_EDGE_POINT = 2 };   /* it is one point: a pole */

/* Returns which corner of a quad's half is its first: of half 0 the quad's corner 0, of half 1, which has
 * corners 0, 2 and 3, its corner 0 too. */
static inline int sl_quad_first(const sl_primitives *p, uint32_t primitive, int half) {
    return half == 0 ? (p->turn[primitive] / 3 + 1) % 3 : p->turn[primitive] % 3;
}
/* Returns a corner as a scene vertex; corner 3 of a triangle: SL_NO_INDEX. */
uint32_t sl_primitive_corner(const sl_primitives *primitives, uint32_t primitive, int corner);
/* Returns how many triangles of the scene: 1 of a triangle, 2 of a quad, all of its tessellation of a bicubic
 * patch. */
uint32_t sl_primitive_triangles(const sl_primitives *primitives, uint32_t primitive);

sl_status sl_primitives_find(const sl_scene *scene, sl_primitives **primitives, sl_error *error);
/* Each triangle by itself: root r is side r % 2 of triangle r / 2, a face. */
sl_status sl_primitives_of_triangles(const sl_scene *scene, sl_primitives **primitives, sl_error *error);
void sl_primitives_destroy(sl_primitives *primitives);
size_t sl_primitives_memory_bytes(const sl_primitives *primitives);

/* Gives a point of a root, as the scene stands now (objects move; their points move with them): normals are
 * unit, on the root's side, the limit where a parameter line collapses to a point; its triangle is
 * SL_NO_INDEX on corners and edges of triangles. u and v in 1/SL_PATCH_DYADIC. Points lie on the scene's
 * triangles, which rays meet, also those of bicubic patches; the normal is then the surface's own. The
 * surface itself: sl_bicubic_at() in scene/bicubic.h. */
void sl_root_point_at(const sl_primitives *primitives, uint32_t root, uint32_t u, uint32_t v,
                      sl_lit_point *point);
/* the same one, alone */
sl_vec3 sl_root_position(const sl_primitives *primitives, uint32_t root, uint32_t u, uint32_t v);
/* Returns the scene triangle that holds (u, v) of a root and the weights of its corners 1 and 2 there: for
 * its texture. */
uint32_t sl_root_triangle_at(const sl_primitives *primitives, uint32_t root, double u, double v, float *w1,
                             float *w2);
/* Gives, the other way, (u, v) in [0,1] of a point of a scene triangle. */
void sl_root_parameters(const sl_primitives *primitives, uint32_t triangle, float w1, float w2, double *u,
                        double *v);
/* Gives those of a triangle's corners. */
void sl_root_corner_parameters(const sl_primitives *primitives, uint32_t triangle, float uv[6]);
static inline const sl_material *sl_root_material(const sl_primitives *p, uint32_t root) {
    return sl_triangle_material(p->scene, p->first_triangle[root / 2]);
}
/* Returns the radiance that a material sends to the side of a root: from its front, unless it shines on both.
 */
static inline sl_rgb sl_root_emission(const sl_material *material, uint32_t root) {
    return root % 2 == 0 || material->emission_two_sided ? material->emission : sl_grey(0.0f);
}
/* Not only diffuse: it looks otherwise from elsewhere, so radiance towards the eye is kept beside irradiance.
 */
static inline bool sl_material_has_lobe(const sl_material *material) {
    return sl_material_is_glossy(material) || sl_material_is_mirror(material);
}
/* Returns the root of which an eye sees a plane triangle; of the scene that the primitives were found in, or
 * of a copy of it. */
static inline uint32_t sl_root_seen(const sl_primitives *p, const sl_scene *scene, uint32_t triangle,
                                    sl_vec3 eye) {
    sl_vec3 to_eye = sl_sub(eye, sl_scene_position(scene, scene->vertex[0][triangle]));
    return 2 * p->of_triangle[triangle] +
           (sl_side_seen(sl_scene_geometric_normal(scene, triangle), to_eye) < 0.0f);
}
/* Tells whether a triangle has no area to speak of (below 1e-12 of the scene's scale squared; NaN has none):
 * it receives nothing, and hides light all the same. */
bool sl_triangle_is_degenerate(const sl_scene *scene, uint32_t triangle);
static inline uint32_t sl_root_object(const sl_primitives *p, uint32_t root) {
    return p->scene->object_index[p->first_triangle[root / 2]];
}
/* The place that stands for all places of roots of one side that share their shading: on edges and corners
 * where position, normal, material and object agree that of the lowest primitive, and for an edge that is one
 * point its first corner. */
typedef struct sl_root_place {
    uint32_t root;
    uint16_t u, v;
} sl_root_place;
sl_root_place sl_root_canonical(const sl_primitives *primitives, sl_root_place place);
/* k_d over the root's texture, averaged: what display levels of diffuse patches are reckoned with. */
sl_rgb sl_root_mean_diffuse(const sl_primitives *primitives, uint32_t root);
