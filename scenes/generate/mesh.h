/* A mesh in the making, and the shapes that the generated scenes are built of.
 *
 * Everything is metres, y up, counter-clockwise seen from the visible side. Coordinates are snapped to a
 * tenth of a millimetre when they enter the mesh, so that a triangle is degenerate in the file exactly if it
 * was found to be so here (it is then left out). Only + - * / sqrt and base/math.h are used: the files are
 * the same on every machine. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct v2 { double x, y; } v2;
typedef struct v3 { double x, y, z; } v3;

static inline v3 gen_v3(double x, double y, double z) { return (v3){x, y, z}; }
static inline v3 gen_add(v3 a, v3 b) { return gen_v3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline v3 gen_sub(v3 a, v3 b) { return gen_v3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline v3 gen_scale(v3 a, double s) { return gen_v3(a.x * s, a.y * s, a.z * s); }
static inline double gen_dot(v3 a, v3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline v3 gen_cross(v3 a, v3 b) {
    return gen_v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline v3 gen_lerp(v3 a, v3 b, double t) { return gen_add(gen_scale(a, 1.0 - t), gen_scale(b, t)); }
static inline double gen_mix(double a, double b, double t) { return a * (1.0 - t) + b * t; }
static inline double gen_min(double a, double b) { return a < b ? a : b; }
static inline double gen_max(double a, double b) { return a > b ? a : b; }
static inline double gen_clamp(double x, double lo, double hi) { return x < lo ? lo : x > hi ? hi : x; }
static inline double gen_smoothstep(double lo, double hi, double x) {
    double t = gen_clamp((x - lo) / (hi - lo), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}
double gen_length(v3 a);
v3 gen_unit(v3 a); /* (0,1,0) for the zero vector */

/* ---- the mesh (mesh.c) ----------------------------------------------------------------------- */

/* Where shapes are put: local (x, y, z) becomes origin + x X + y Y + z Z. Axes are orthogonal and
 * right-handed. */
typedef struct frame { v3 origin, x, y, z; } frame;

/* mtl: lines of the MTL file, "Kd 1 1 1\n" */
typedef struct gen_material { const char *name, *mtl; } gen_material;

typedef struct gen_corner { uint32_t position, normal; } gen_corner;
typedef struct gen_run { size_t first_face; const char *object; uint32_t material; } gen_run;

typedef struct mesh {
    frame frame;
    const gen_material *materials;
    uint32_t material_count;
    int32_t (*positions)[3]; /* in tenths of a millimetre */
    int32_t (*normals)[3];   /* in 1e-4 */
    gen_corner (*faces)[3];
    size_t position_count, position_capacity, normal_count, normal_capacity, face_count, face_capacity;
    gen_run *runs;           /* faces from first_face on belong to this object and have this material */
    size_t run_count, run_capacity;
} mesh;

void gen_mesh_init(mesh *m, const gen_material *materials, uint32_t count);
void gen_mesh_free(mesh *m);
void gen_paint(mesh *m, const char *object, uint32_t material); /* of all that follows */
uint32_t gen_position(mesh *m, v3 local);
uint32_t gen_normal(mesh *m, v3 local);
void gen_face(mesh *m, gen_corner a, gen_corner b, gen_corner c);

/* Moves the mesh's frame; each returns the frame before, to be put back by m->frame = before. */
frame gen_move(mesh *m, double x, double y, double z);
frame gen_turn(mesh *m, double degrees); /* about y, counter-clockwise seen from above */
frame gen_tilt(mesh *m, double degrees); /* about x */

void *gen_grow(void *array, size_t count, size_t *capacity, size_t size);
void *gen_allocate(size_t bytes);

/* ---- shapes (shapes.c) ----------------------------------------------------------------------- */

enum { GEN_WRAP_COLUMNS = 1, GEN_WRAP_ROWS = 2, GEN_FLAT = 4, GEN_FLIP = 8 };

/* points[row * columns + column]; the visible side is that of d/dcolumn x d/drow (GEN_FLIP: the other).
 * Smooth normals, also where a whole row shrinks to a point; GEN_FLAT: one normal a triangle. Wrapping joins
 * the last to the first. */
void gen_grid(mesh *m, const v3 *points, int columns, int rows, unsigned flags);

/* The same for a function of u, v in [0,1]; with nu x nv quadrilaterals. */
typedef v3 (*gen_surface_function)(double u, double v, const void *context);
void gen_surface(mesh *m, int nu, int nv, unsigned flags, gen_surface_function f, const void *context);

void gen_quad(mesh *m, v3 a, v3 b, v3 c, v3 d);
void gen_triangle(mesh *m, v3 a, v3 b, v3 c);
/* A quadrilateral split into nu (from a to b) times nv pieces. */
void gen_panel(mesh *m, v3 a, v3 b, v3 c, v3 d, int nu, int nv);
void gen_box(mesh *m, v3 low, v3 high);
void gen_bevel_box(mesh *m, v3 low, v3 high, double bevel); /* edges that look rounded; 44 triangles */
/* a raised, bevelled face on a quadrilateral */
void gen_stone(mesh *m, v3 a, v3 b, v3 c, v3 d, double height);

/* Surface of revolution about y: profile (radius, height) from the bottom to the top of the outer side. A
 * point given twice is a sharp edge. */
void gen_lathe(mesh *m, const v2 *profile, int count, int segments);
/* A profile pushed along a path that lies in the plane with the given normal. Walk the path with the head
 * along the normal: profile x is to the right, y is up, and the profile runs counter-clockwise for faces
 * outwards; again a point given twice is a sharp edge. GEN_WRAP_COLUMNS: the path is closed. GEN_FLAT for
 * paths with corners, which are mitred. */
void gen_sweep(mesh *m, const v3 *path, int path_count, v3 normal, const v2 *profile, int count,
               unsigned flags);
void gen_rod(mesh *m, v3 from, v3 to, double radius_from, double radius_to, int segments);
/* A closed ball, or ellipsoid, with an optional displacement along the radius of `rough` times noise. */
void gen_ball(mesh *m, v3 centre, v3 radii, int segments, int rings, double rough, uint32_t seed);

/* ---- profiles ---- */

typedef struct outline { v2 p[128]; int count; } outline;
void gen_to(outline *o, double x, double y);
void gen_sharp(outline *o, double x, double y); /* the point twice */
void gen_arc(outline *o, double cx, double cy, double rx, double ry, double from_deg, double to_deg,
             int steps);

/* ---- arches and vaults (arches.c) ------------------------------------------------------------ */

/* Height over the springing, 0 at s = +-1 and 1 at s = 0, of an arch struck with radius `pointedness` times
 * its span: 0.5 is round, 1 equilateral. */
double gen_arch_height(double s, double pointedness);

typedef struct arch {
    /* of the opening; spring: height of the imposts above the floor */
    double half_width, spring, rise, pointedness;
    int steps;                                    /* of each half */
} arch;

/* The opening's outline from the left impost over the crown to the right one: 2 steps + 1 points (x, y). */
int gen_arch_points(const arch *a, double widen, v2 *points);
/* A wall from x0 to x1, floor to top, thickness deep about z = 0, with the arch cut out about x = 0. sill >
 * 0: the opening begins there (a window). Faces front, back, soffit, jambs, sill. */
void gen_arch_wall(mesh *m, const arch *a, double x0, double x1, double sill, double top, double thickness);
/* A moulding swept along the arch at z, facing +z. */
void gen_arch_moulding(mesh *m, const arch *a, double widen, double z, double width, double depth);
/* A groin vault over [-a,a] x [-b,b], springing at `spring`; the underside is what one sees; with ribs of
 * radius rib. */
void gen_vault(mesh *m, double a, double b, double spring, double rise, double pointedness, int steps);
void gen_vault_ribs(mesh *m, double a, double b, double spring, double rise, double pointedness, double rib,
                    int steps);

/* ---- noise (noise.c) ------------------------------------------------------------------------- */

double gen_random(uint32_t seed, uint32_t a, uint32_t b); /* in [0,1), a hash of its arguments */
double gen_noise(v3 p, uint32_t seed);                    /* value noise in [-1,1], smooth, one unit a cell */
double gen_fractal(v3 p, int octaves, uint32_t seed);     /* halving amplitudes, within [-2,2] */

/* ---- bicubic surfaces (curved.c) ------------------------------------------------------------- */

typedef struct gen_bicubic { v3 p[4][4]; } gen_bicubic; /* [v][u], as in .bpt files */

/* Turns a cubic curve (radius, height), from the bottom up, about y: `parts` surfaces of equal angles.
 * Returns parts. */
int gen_revolve(const v2 curve[4], int parts, gen_bicubic *surfaces);
void gen_write_bicubic(const char *folder, const char *name, const gen_bicubic *surfaces, int count);

/* ---- the files of a scene (output.c) --------------------------------------------------------- */

void gen_write_scene(const char *folder, const char *name, const mesh *m, const char *json_middle);
/* Their parts, for scenes of several meshes: NAME.obj and NAME.mtl alone; and any text, as NAME and ENDING.
 */
void gen_write_mesh(const char *folder, const char *name, const mesh *m);
__attribute__((format(printf, 4, 5))) void gen_write_text(const char *folder, const char *name,
                                                          const char *ending, const char *format, ...);
/* A latitude-longitude picture, row 0 at the top, as PFM. */
void gen_write_pfm(const char *folder, const char *name, const float *rgb, int width, int height);

/* ---- the scenes, a file each ----------------------------------------------------------------- */

void gen_room(const char *folder);
void gen_cave(const char *folder);
void gen_mirror_cave(const char *folder);
void gen_atrium(const char *folder);
void gen_castle(const char *folder);
void gen_cathedral(const char *folder);
void gen_figure(const char *folder);
void gen_study(const char *folder);
void gen_loft(const char *folder);
void gen_pool(const char *folder);
void gen_ring(const char *folder);
void gen_parlour(const char *folder);
void gen_metals(const char *folder);

/* What the study takes from the room (room.c). */
void gen_room_walls(mesh *m); /* begins the mesh: walls, floor, window, curtains, door */
void gen_room_table(mesh *m); /* and the rug under it */
void gen_room_chair(mesh *m, double x, double z, double degrees);
void gen_room_sides(mesh *m); /* sofa, shelves, pictures */
