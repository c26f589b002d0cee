/* Bidirectional path tracing (Lafortune and Willems 1993; Veach and Guibas 1994, 1995): what its files share.
 *
 * A path is v_0 (the eye), v_1, ..., v_m (on a light). It can be made in m + 2 ways: t vertices by a walk
 * from the eye, the other s = m + 1 - t by a walk from the light, joined by a ray between v_(t-1) and v_t.
 * Densities are per area of the geometric surfaces; an infinitely distant v_m has one per solid angle. A
 * mirror chooses its direction with certainty: that delta function is in the density of every way that can
 * make the path, so it counts as 1.
 *
 * The measure of light is the unidirectional path tracer's, f (n_s . w_l) d omega, n_s the shading normal and
 * w_l the direction to the light; in terms of areas f (n_s . w_l) / (n_g . w_l) at every surface and
 * geometric cosines between them. So a light path is weighted by |n_s . w_i| |n_g . w_o| / (|n_g . w_i| |n_s
 * . w_o|) more than its mirror image would be (Veach 1997, section 5.3). */
#pragma once

#include "trace/bsdf.h"
#include "trace/sequence.h"
#include "trace/trace.h"

/* Russian roulette (0.95 at most) lets one walk in a thousand get as far */
enum { SL_SUBPATH_VERTICES_MAX = 128 };

typedef enum sl_vertex_kind {
    SL_VERTEX_EYE,
    SL_VERTEX_SURFACE,
    SL_VERTEX_MIRROR,
    SL_VERTEX_LIGHT,   /* where a light subpath starts */
    SL_VERTEX_SKY      /* where an eye subpath left the scene */
} sl_vertex_kind;

typedef struct sl_path_vertex {
    sl_vertex_kind kind;
    sl_vec3 origin;           /* where its rays start: lifted off the surface */
    sl_vec3 back;             /* unit, to the vertex before; of an infinitely distant light, towards it */
    sl_vec3 geometric_normal; /* on the side of `back` */
    double pdf_forward;       /* the density with which its own walk made it */
    /* the density with which the other walk would have, coming from the vertex after it */
    double pdf_reverse;
    sl_bsdf bsdf;             /* seen from the vertex before */
    /* f cos / pdf of the walk so far; of light: flux / pdf, over the scene's radius squared */
    sl_rgb weight;
    /* eye subpaths: radiance towards the vertex before, times emission_weight the path's light */
    sl_rgb emitted;
    sl_rgb emission_weight;
    uint32_t triangle;
    uint32_t surfaces;        /* of its walk so far, itself included, mirrors not */
    /* entry of the light sampler, where light starts or may start; or SL_NO_INDEX */
    uint32_t light;
} sl_path_vertex;

typedef struct sl_subpath {
    unsigned count;
    sl_path_vertex vertex[SL_SUBPATH_VERTICES_MAX];
} sl_subpath;

/* Common to all paths of a picture, or of a set of points. */
typedef struct sl_path_maker {
    const sl_scene *scene;
    const sl_tracer *tracer;
    const sl_light_sampler *lights;
    const sl_sequence *sequence;
    sl_transport transport;
    uint32_t roulette_after;  /* surfaces; UINT32_MAX: no roulette but for mirrors */
    double radius;            /* of the sphere that holds the scene: flux is told in units of its square */
    /* light subpaths are joined to the camera (t = 1), but for light that comes straight from a lamp (s = 2):
     * light samples, which are better spread, make that way cost more than it saves */
    bool light_image;
    /* connections that carry less are taken in a share of cases, and count for more there; 0: all are
     * taken */
    float least;
    unsigned eye_vertices;    /* those that are given: 1, the eye, or 2, a point before it */
    float tan_x, tan_y;       /* of half the camera's fields of view */
} sl_path_maker;

/* lights: those of the transport, sl_light_sampler_create_for(). */
void sl_path_maker_init(sl_path_maker *maker, const sl_scene *scene, const sl_tracer *tracer,
                        const sl_light_sampler *lights, const sl_sequence *sequence,
                        const sl_transport *transport);

/* ---- what the transport lets reflect, at surface 1, 2, ... from the eye ---------------------- */

enum { SL_LOBES_ROUGH = SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY };

/* Direct light of a light that is seen without a mirror; and all else. */
static inline unsigned sl_direct_lobes(const sl_path_maker *m, uint32_t surface) {
    return SL_LOBES_ROUGH & (surface == 1 ? m->transport.direct_lobes : m->transport.bounce_lobes);
}
static inline unsigned sl_indirect_lobes(const sl_path_maker *m, uint32_t surface) {
    return SL_LOBES_ROUGH & (surface == 1 ? m->transport.receiver_lobes : m->transport.bounce_lobes);
}
/* Those from which an eye subpath draws its next direction. A light subpath always draws from
 * sl_indirect_lobes(m, 2). */
static inline unsigned sl_eye_lobes(const sl_path_maker *m, uint32_t surface) {
    return sl_direct_lobes(m, surface) | sl_indirect_lobes(m, surface);
}
static inline bool sl_mirrors_followed(const sl_path_maker *m) {
    return m->transport.bounce_lobes & SL_LOBE_MIRROR;
}
/* Surfaces of a path, mirrors not counted. */
static inline bool sl_surfaces_allowed(const sl_path_maker *m, uint32_t surfaces) {
    return surfaces == 0 || surfaces - 1 <= m->transport.bounces;
}

/* ---- densities ------------------------------------------------------------------------------- */

/* Per area at `to`, of a direction that has this density per solid angle at `from`. */
double sl_density_at(const sl_path_vertex *from, const sl_path_vertex *to, double pdf);
/* Of the vertex before v in v's walk, for the other walk, which comes to v the way that v's walk leaves it
 * and goes on there with this density per solid angle. */
double sl_density_before(const sl_path_maker *maker, const sl_path_vertex *v, const sl_path_vertex *before,
                         double pdf);
/* Per solid angle, of a walk that comes to a surface from direction `from` and leaves in direction `to`. */
double sl_vertex_pdf(const sl_path_vertex *v, sl_vec3 from, sl_vec3 to, unsigned lobes);
/* f (n_s . w_l) / (n_g . w_l) of a vertex of a light subpath, towards an eye; black where either side is
 * wrong. */
sl_rgb sl_light_vertex_value(const sl_path_vertex *v, sl_vec3 to_eye, unsigned lobes);

/* ---- emission -------------------------------------------------------------------------------- */

/* Where light starts, and its first ray, from two points of a sequence. *pdf: of the direction per solid
 * angle, or, if the light is infinitely distant (*parallel), per area that faces it. False: no light. */
bool sl_emission_sample(const sl_path_maker *maker, const float where[3], const float whither[3],
                        sl_path_vertex *light, sl_vec3 *direction, double *pdf, bool *parallel);
/* A vertex on a light for the end of a ray from p, made by the light sampler or met by chance (then direction
 * and emitter's distance). */
sl_path_vertex sl_emission_sampled(const sl_path_maker *maker, sl_vec3 p, const sl_light_sample *sample);
/* Density with which light starts at this vertex (of kind LIGHT or SKY, or on an emitter); and with which it
 * then goes to the surface. */
double sl_emission_origin_pdf(const sl_path_maker *maker, const sl_path_vertex *light);
double sl_emission_pdf(const sl_path_maker *maker, const sl_path_vertex *light,
                       const sl_path_vertex *surface);
/* A light that no ray meets by chance. */
bool sl_emission_is_delta(const sl_path_maker *maker, uint32_t entry);
bool sl_emission_is_infinite(const sl_path_maker *maker, uint32_t entry);

/* ---- walks ----------------------------------------------------------------------------------- */

/* Sixteen at a time. key[i] and index say which random points walk i uses. */
void sl_walk_from_lights(const sl_path_maker *maker, unsigned count, const uint64_t *key,
                         const uint32_t *index, sl_subpath *const *paths, sl_counters *counters);
/* Rays from the camera; a ray's direction is unit and pdf[i] its density per solid angle. */
void sl_walk_from_eye(const sl_path_maker *maker, unsigned count, sl_vec3 eye, const sl_vec3 *direction,
                      const double *pdf, const uint64_t *key, const uint32_t *index, sl_subpath *const *paths,
                      sl_counters *counters);
/* From a surface point instead, which becomes v_1 of each: its bsdf, origin, normals, triangle and `back` are
 * given. */
void sl_walk_from_point(const sl_path_maker *maker, unsigned count, const sl_path_vertex *point,
                        const uint64_t *key, const uint32_t *index, sl_subpath *const *paths,
                        sl_counters *counters);

/* ---- connections ----------------------------------------------------------------------------- */

typedef struct sl_connection {
    const sl_path_vertex *eye, *light; /* v_0 ... of the eye subpath; v_m ... of the light subpath */
    unsigned t, s;
    sl_path_vertex own;       /* an end that belongs to no walk: a light sample (s = 1) or the eye (t = 1) */
    sl_rgb radiance;          /* unweighted; where nothing hides the vertices from each other */
    /* in: key of the random numbers that decide where the maker's `least` is not reached */
    uint64_t roulette;
    double scale;             /* what those that survive that count for more */
    bool may_be_hidden;
    sl_vec3 from, towards;    /* the ray between them, from v_(t-1) to v_t */
    float far;
    uint32_t skip;
    /* Densities that the connection tells of each walk's end: of the last vertices and of those before. */
    double eye_last, eye_before, light_last, light_before;
} sl_connection;

/* s = 0: the eye subpath's vertex t - 1 shines. */
bool sl_connect_nothing(const sl_path_maker *maker, const sl_path_vertex *eye, unsigned t, sl_connection *c);
/* s = 1: vertex t - 1 and a light sample of its own. */
bool sl_connect_light(const sl_path_maker *maker, const sl_path_vertex *eye, unsigned t,
                      const sl_light_sample *sample, sl_connection *c);
/* s >= 2, t >= 2. */
bool sl_connect_walks(const sl_path_maker *maker, const sl_path_vertex *eye, unsigned t,
                      const sl_path_vertex *light, unsigned s, sl_connection *c);
/* t = 1: the light subpath's vertex s - 1 and the camera. radiance is that of the whole film; *x and *y, in
 * [0,1), say where it falls, *y from the top. */
bool sl_connect_camera(const sl_path_maker *maker, const sl_path_vertex *light, unsigned s, sl_connection *c,
                       double *x, double *y);
/* Density of a camera ray per solid angle, by the cosine with the camera's axis. */
double sl_camera_pdf(const sl_path_maker *maker, double cosine);
/* The share of this way among all that could have made the path: multiple importance sampling. */
double sl_connection_weight(const sl_path_maker *maker, const sl_connection *c);

/* ---- all ways of one eye subpath and one light subpath --------------------------------------- */

/* Receives what is visible, in the order of lanes, t and s. x and y: where t = 1. */
typedef struct sl_path_receiver {
    void *context;
    void (*add)(void *context, unsigned lane, unsigned s, unsigned t, double x, double y, sl_rgb radiance,
                double weight);
} sl_path_receiver;

/* The light vertices y_0 ... of each lane, and how many. key[i], index[i]: for the light samples of lane i.
 */
void sl_connect_all(const sl_path_maker *maker, unsigned count, sl_subpath *const *eye,
                    const sl_path_vertex *const *light, const unsigned *light_count, const uint64_t *key,
                    const uint32_t *index, const sl_path_receiver *receiver, sl_counters *counters);
