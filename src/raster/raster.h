/* The simulated raster hardware. Conventions are OpenGL's: clip space, viewport, pixel centres at .5,
 * vertices snapped to 1/256 pixel (round to nearest even), left and lowest-row edges inclusive, float depth,
 * nearer wins, on a tie the first submitted triangle. Targets have row 0 at the bottom; sl_raster_flip()
 * turns a plane into an image's order.
 *
 * How it works is told, and done in its simplest form, in tests/raster/plain.c: read that first.
 *
 * Visibility comes first: one hot kernel writes triangle id and depth. Everything that is interpolated is
 * then resolved per pixel from the id, once per visible pixel (G-buffer, Gouraud).
 *
 *     view ── sl_raster_id() ── id, depth ──┬── sl_raster_gbuffer()   positions, normals, albedo, material
 *                                           └── sl_raster_gouraud()   perspective-correct vertex attributes
 *     records ── sl_raster_splats() ── additive float blending ── sl_raster_reduce() ── sums
 *
 * Counters are added to, and wanted; an error may be NULL.
 */
#pragma once

#include "base/isa.h"
#include "scene/scene.h"

/* The triangles as the hardware holds them: vertices, indices, clusters with bounds. Immutable but for
 * sl_raster_move(); many passes at once. */
typedef struct sl_raster sl_raster;

/* The scene must outlive it. */
sl_status sl_raster_create(const sl_scene *scene, unsigned threads, sl_raster **raster, sl_error *error);
void sl_raster_destroy(sl_raster *raster);
size_t sl_raster_memory_bytes(const sl_raster *raster);
size_t sl_raster_cluster_count(const sl_raster *raster);
/* The most that one takes while it is made, and what it keeps, by the count of triangles. */
double sl_raster_memory_need(size_t triangles);
double sl_raster_memory_kept(size_t triangles);
/* Follows vertices that have moved in the scene's (or mesh's) arrays, be it whole objects or each vertex by
 * itself: pictures are then, bit by bit, those of a rasterizer made anew; how much was culled may differ. No
 * pass may be running; a sl_raster_scratch must be made anew. After a failure it can be destroyed, no more.
 */
sl_status sl_raster_move(sl_raster *raster, unsigned threads, sl_error *error);

typedef enum sl_depth_kind {
    SL_DEPTH_WINDOW,    /* z/w mapped to [0,1], smaller is nearer: what OpenGL stores */
    SL_DEPTH_INVERSE_W  /* 1/w, linear on the screen, larger is nearer, no far plane; cleared to 0 */
} sl_depth_kind;

/* Is told of every pass before it is drawn, on the thread that asks for it. */
typedef struct sl_view sl_view;
typedef struct sl_gouraud_pass sl_gouraud_pass;
typedef struct sl_raster_observer {
    void (*draw)(void *context, const sl_raster *raster, const sl_view *view, bool small);
    void (*gouraud)(void *context, const sl_raster *raster, const sl_view *view, const uint32_t *id,
                    const sl_gouraud_pass *pass);
    void *context;
} sl_raster_observer;

/* Triangles as they stand: corners are indices of vertices. Nothing is welded or dropped beforehand;
 * coordinates may be NaN, triangles without area. */
typedef struct sl_raster_mesh {
    size_t vertex_count, triangle_count;
    const float *x, *y, *z;
    const uint32_t *vertex[3];
} sl_raster_mesh;
/* A rasterizer of triangles that are no scene (refined meshes, tests): ids are triangle numbers; no G-buffer,
 * no alpha masks. The arrays must outlive it. */
sl_status sl_raster_create_mesh(const sl_raster_mesh *mesh, unsigned threads, sl_raster **raster,
                                sl_error *error);

/* Half-open, in pixels of the target; x0 = x1 = 0: no scissor. */
typedef struct sl_scissor {
    int x0, y0, x1, y1;
} sl_scissor;

/* A view: clip = matrix * (p - origin, 1), rows first: clip_i = sum_j m[i][j] q_j. The origin (the eye) is
 * subtracted first, in float, so that tiny near distances keep their precision. */
typedef enum sl_view_kind {
    SL_VIEW_CAMERA,
    SL_VIEW_PYRAMID,
    SL_VIEW_HEMICUBE_FACE,
    SL_VIEW_LIGHT,
    SL_VIEW_KINDS
} sl_view_kind;
struct sl_view {
    sl_view_kind kind;      /* of which it was made; told to observers */
    float clip[4][4];
    sl_vec3 origin;
    int width, height;      /* of the viewport */
    int x, y;               /* its lower left corner in the target */
    /* only these pixels of the viewport are cleared and drawn, with the same bits as without it */
    sl_scissor scissor;
    sl_depth_kind depth;
    bool corner_planes; /* window depth from plane equations at the target's corner, OSMesa's way bit by bit:
                         * for comparing with it; less accurate on slivers and small triangles than the
                         * default */
    /* not drawn (a gather's own triangle); SL_NO_INDEX, or any number that no triangle has: all are drawn */
    uint32_t skip_triangle;
    const uint8_t *left_out; /* by triangle: 1: not drawn (what another pass draws); NULL: all are drawn */
    /* by pixel of the viewport, which fills the target then: 0: shows no triangle; depth is drawn everywhere.
     * NULL: all pixels show theirs */
    const uint8_t *stencil;
};

/* A scene's camera as methods want it: inverse-w depth, no far plane, near plane at 1e-5 of the scene's
 * scale. */
sl_view sl_view_scene(const sl_scene *scene, int width, int height);
/* The same from where another camera stands. */
sl_view sl_view_of_camera(const sl_scene *scene, const sl_camera *camera, int width, int height);
/* The unit direction in which a point of the viewport looks (x, y in pixels, centres at .5), whatever the
 * view's matrix. */
sl_vec3 sl_view_direction(const sl_view *view, double x, double y);
/* Returns what a pixel of it shows that shines: a triangle that is seen there, or, SL_NO_INDEX, the
 * environment. */
sl_rgb sl_view_emission(const sl_view *view, const sl_scene *scene, uint32_t triangle, size_t x, size_t y);
/* Any pyramid: frame x right, y up, looks along +z of the frame; tangents of the four sides at unit distance;
 * clip at w >= near; inverse-w depth. The plane above a surface point: frame z = normal, tangents
 * +-tan(fov/2). */
sl_view sl_view_pyramid(const sl_frame *frame, sl_vec3 eye, float left, float right, float bottom, float top,
                        int width, int height, float near);
/* Face 0..4 of a hemicube around frame z: the top, size x size pixels, and the upper halves of its four
 * sides, +x -x +y -y of the frame, each turned so that it folds out from the top's edge: a cross in which
 * neighbouring pixels see neighbouring directions. */
sl_view sl_view_hemicube_face(const sl_frame *frame, sl_vec3 eye, int face, int size, float near);

/* The planes of a pbuffer; all caller-owned arrays of width*height (NULL: not wanted), row 0 at the bottom.
 */
typedef struct sl_target {
    int width, height;
    uint32_t *id;   /* triangle index, SL_NO_INDEX where nothing is */
    float *depth;
} sl_target;

/* Scratch for one worker's small renders (gathers), reused from call to call; for targets of up to that size.
 */
typedef struct sl_raster_scratch sl_raster_scratch;
sl_status sl_raster_scratch_create(const sl_raster *raster, int max_width, int max_height,
                                   sl_raster_scratch **scratch, sl_error *error);
void sl_raster_scratch_destroy(sl_raster_scratch *scratch);

/* Clears the viewport and draws the whole scene into id and depth; alpha masks are tested. Large targets:
 * parallel over tiles. Both forms give the same bits. id or depth may be NULL. Clusters of triangles that lie
 * behind what is drawn already are not drawn, and counted as culled. */
sl_status sl_raster_id(const sl_raster *raster, const sl_view *view, unsigned threads,
                       const sl_target *target, sl_counters *counters, sl_error *error);
/* Several views at once, a target for each: the same as one after another, but the threads share all of their
 * tiles. */
sl_status sl_raster_ids(const sl_raster *raster, size_t count, const sl_view *views, unsigned threads,
                        const sl_target *targets, sl_counters *counters, sl_error *error);
/* The same on the calling thread alone, without allocating; the viewport must lie within the target. */
void sl_raster_id_small(const sl_raster *raster, const sl_view *view, const sl_target *target,
                        sl_raster_scratch *scratch, sl_counters *counters);

/* False where no pass with this view can draw anything: all clusters' bounds lie outside one of its planes.
 * Costs a fraction of a pass. */
bool sl_raster_meets(const sl_raster *raster, const sl_view *view);

/* Perspective-correct barycentric weights of corners 1 and 2 at the pixel's centre, for `count` pixels of a
 * view given by their linear indices (y*width + x) and ids; the viewport is taken as the whole picture (x, y
 * and scissor aside); pixels with SL_NO_INDEX get 0. Weights are clamped to the triangle. w1, w2: count
 * values. */
void sl_raster_barycentrics(const sl_raster *raster, const sl_view *view, size_t count, const uint32_t *pixel,
                            const uint32_t *id, float *w1, float *w2);

/* G-buffer planes (NULL: not wanted, but for id; normals are not without positions); all of width*height, row
 * 0 at the bottom. */
typedef struct sl_gbuffer {
    int width, height;
    uint32_t *id;
    float *depth;
    float *position_x, *position_y, *position_z;
    float *normal_x, *normal_y, *normal_z;          /* shading, turned to the viewer */
    float *geometric_x, *geometric_y, *geometric_z; /* geometric, turned to the viewer */
    float *diffuse_r, *diffuse_g, *diffuse_b;       /* kd with texture */
    uint32_t *material;                             /* SL_NO_INDEX: background */
    /* where mirrors reflect to the eye what pixels show; NULL: all from the camera */
    sl_vec3 *seen_from;
} sl_gbuffer;

/* ---- one of its pixels ---- */

static inline sl_vec3 sl_gbuffer_position(const sl_gbuffer *g, size_t i) {
    return sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]);
}
static inline sl_vec3 sl_gbuffer_normal(const sl_gbuffer *g, size_t i) {
    return sl_v3(g->normal_x[i], g->normal_y[i], g->normal_z[i]);
}
static inline sl_vec3 sl_gbuffer_geometric(const sl_gbuffer *g, size_t i) {
    return sl_v3(g->geometric_x[i], g->geometric_y[i], g->geometric_z[i]);
}
/* Returns what a pixel that is no background shows, on the side that is seen. */
static inline sl_surface sl_gbuffer_surface(const sl_scene *scene, const sl_gbuffer *g, size_t i) {
    return (sl_surface){.position = sl_gbuffer_position(g, i),
                        .geometric_normal = sl_gbuffer_geometric(g, i),
                        .normal = sl_gbuffer_normal(g, i),
                        .diffuse = {g->diffuse_r[i], g->diffuse_g[i], g->diffuse_b[i]},
                        .material = &scene->materials[g->material[i]],
                        .front = true};
}
/* Returns from where an eye sees it: by way of mirrors, from the last of them. */
static inline sl_vec3 sl_gbuffer_seen_from(const sl_gbuffer *g, sl_vec3 eye, size_t i) {
    return g->seen_from ? g->seen_from[i] : eye;
}

sl_status sl_gbuffer_create(int width, int height, sl_gbuffer **gbuffer, sl_error *error); /* all planes */
void sl_gbuffer_destroy(sl_gbuffer *gbuffer);
/* ID pass and its resolution, equal to sl_scene_surface() bit by bit. Needs a scene. */
sl_status sl_raster_gbuffer(const sl_raster *raster, const sl_view *view, unsigned threads,
                            sl_gbuffer *gbuffer, sl_counters *counters, sl_error *error);
/* The resolution alone, of an id plane that is drawn already. The view is as large as the G-buffer. */
sl_status sl_raster_resolve(const sl_raster *raster, const sl_view *view, unsigned threads,
                            sl_gbuffer *gbuffer, sl_counters *counters, sl_error *error);

/* The same part by part, for who goes on with a part while it is in the cache. id: of the whole picture.
 * Each worker has one part at a time. */
typedef struct sl_resolver sl_resolver;
sl_status sl_resolver_create(const sl_raster *raster, const sl_view *view, const uint32_t *id,
                             unsigned workers, sl_resolver **resolver, sl_error *error);
void sl_resolver_destroy(sl_resolver *resolver);
/* `count` pixels from `first` on, into planes that hold those alone. Returns how many of them show a
 * triangle. */
uint64_t sl_resolver_run(const sl_resolver *resolver, unsigned worker, size_t first, size_t count,
                         sl_gbuffer *part);

/* Pixels that the Gouraud pass hands on: `count` of them from `first` on, with the interpolated values of
 * each. */
enum { SL_GOURAUD_CHANNELS = 4, SL_GOURAUD_STRIP = 2048 };
typedef struct sl_gouraud_pixels {
    size_t first, count;
    unsigned worker;                          /* below the number of threads */
    const uint32_t *id;                       /* of these pixels */
    const float *value[SL_GOURAUD_CHANNELS];  /* 0 on the background */
    const float *diffuse[3];                  /* kd times texture, where the pass is textured */
} sl_gouraud_pixels;

/* Values are given by vertex (vertex v's at vertex[v * channels]), or by corner: corners() writes a
 * triangle's, `channels` for each of three. */
struct sl_gouraud_pass {
    int channels;
    const float *vertex;
    void (*corners)(const void *context, uint32_t triangle, float *value);
    bool textured;       /* needs a scene */
    float *out;          /* `channels` planes of the view's size; or NULL and */
    /* what is done with visible pixels: every strip of SL_GOURAUD_STRIP once, any thread's */
    void (*shade)(void *context, const sl_gouraud_pixels *pixels);
    void *context;
    size_t first, count; /* the pixels; count 0: all from `first` on */
};
/* Gouraud: interpolates at every pixel of an id plane of the view's width x height, perspective-correct. */
void sl_raster_gouraud(const sl_raster *raster, const sl_view *view, unsigned threads, const uint32_t *id,
                       const sl_gouraud_pass *pass, sl_counters *counters);

/* Additive float blending of screen rectangles. */
typedef struct sl_splat_rect {
    int x0, y0, x1, y1; /* half-open, in target pixels; empty is allowed */
} sl_splat_rect;

enum { SL_SPLAT_TILE = 64, SL_SPLAT_TILE_PIXELS = SL_SPLAT_TILE * SL_SPLAT_TILE };

/* A tile of the target, which one thread owns while it draws all of the tile's splats. */
typedef struct sl_splat_tile {
    int x, y;             /* its first pixel in the target */
    sl_splat_rect region; /* holds all pixels that its splats touch; within the tile and the target */
    /* tile_bytes of the worker's own, aligned to 64 bytes; what an earlier tile left is still in it */
    void *memory;
} sl_splat_tile;

/* The fragment program. begin and end (NULL: nothing to do) fetch a tile's pixels into its memory and bring
 * them back, as tile-based hardware does: rows of a target lie thousands of bytes apart, at power-of-two
 * widths all in the same lines of the cache, and a tile's pixels are blended to many times. */
typedef struct sl_splat_program {
    size_t tile_bytes;
    void (*begin)(void *context, const sl_splat_tile *tile);
    /* Shades and adds splat `index` in the rectangle, which is never empty and lies within the region.
     * Returns how many fragments it blended. */
    uint64_t (*shade)(void *context, const sl_splat_tile *tile, size_t index, sl_splat_rect rect);
    void (*end)(void *context, const sl_splat_tile *tile);
} sl_splat_program;

/* Within a tile splats run in index order, so every pixel adds in index order at any number of threads. Tiles
 * without splats are not touched. */
sl_status sl_raster_splats(int width, int height, size_t count, const sl_splat_rect *rects,
                           const sl_splat_program *program, void *context, unsigned threads,
                           sl_counters *counters, sl_error *error);
/* Bounds on the screen of a sphere (centre, radius) in a camera view, rounded outwards by a pixel and cut to
 * the target; empty if nothing can show. Each axis by the two tangents from the eye to the sphere's circle
 * (sphere_bounds.c). */
sl_splat_rect sl_sphere_bounds(const sl_camera *camera, int width, int height, float near, sl_vec3 centre,
                               float radius);

/* Reduction: repeated 2x2 sums, (a + b) + (c + d) with a, b in the lower row, of `channels` planes of size x
 * size that lie one after the other (size and final powers of two), down to final x final each; the sums are
 * left in out, plane after plane. `scratch` holds size*size/2 floats. The bits are those of halving plane by
 * plane between two pbuffers. */
void sl_raster_reduce(const float *planes, int size, int channels, int final, float *scratch, float *out,
                      sl_counters *counters);
/* The same down to SL_REDUCED pixels a side, or as many as there are; what is read back then is added up, row
 * by row: a sum a plane. */
enum { SL_REDUCED = 16, SL_REDUCED_PLANES = 3 };
void sl_raster_sum(const float *planes, int size, int channels, float *scratch, double *sum,
                   sl_counters *counters);

/* Copies a bottom-first plane into top-first order. */
void sl_raster_flip(const float *plane, int width, int height, float *image_plane);
