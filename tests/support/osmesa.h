/* OpenGL on the CPU: Mesa's llvmpipe rasterizer, as judge of ours (tests/raster/test_osmesa_*.c) and as its
 * rival (bench/bench_raster*.c). A small harness in terms of what those need, so that they hold no OpenGL
 * calls and build without it.
 *
 *     osmesa_open() ── osmesa_target_create() ── osmesa_draw_to() ── osmesa_clear() ── osmesa_draw(program,
 * mesh) ── osmesa_read()
 *
 * llvmpipe is reached through libOSMesa, or where there is none (Mesa has dropped it with release 25.1)
 * through EGL without a surface. Where neither is installed osmesa_open() says so, and nothing else of this
 * file may be called. Any other failure (a program that does not compile, an incomplete target, a GL error)
 * is a mistake of the caller: a message, then abort(). */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Opens the context, once a process: 0 threads is rasterization on the calling thread, n is n more threads
 * (LP_NUM_THREADS). False, with the reason, where it is not installed, is not llvmpipe, or cannot agree with
 * us in every bit because the CPU has no fused multiply-add. A second call only repeats the answer. */
bool osmesa_open(unsigned threads, const char **reason);
void osmesa_close(void);
/* "llvmpipe (LLVM ...)" and Mesa's version. */
const char *osmesa_name(void);

/* ---- targets: colour planes of any formats at once, and depth -------------------------------- */

typedef enum osmesa_format {
    PLANE_R32UI,
    PLANE_RG32UI,
    PLANE_R32F,
    PLANE_RG32F,
    PLANE_RGB32F,
    PLANE_RGBA32F
} osmesa_format;
enum { OSMESA_PLANES = 4 };

typedef struct osmesa_target {
    int width, height, planes;
    osmesa_format format[OSMESA_PLANES];
    unsigned framebuffer, plane[OSMESA_PLANES], depth; /* plane and depth are textures, for osmesa_input() */
} osmesa_target;

/* depth: a D32F plane too. */
osmesa_target osmesa_target_create(int width, int height, int planes, const osmesa_format *formats,
                                   bool depth);
void osmesa_target_destroy(osmesa_target *target);
/* Draws here from then on, the whole target being the viewport. */
void osmesa_draw_to(const osmesa_target *target);
void osmesa_viewport(int x, int y, int width, int height);
/* Whatever the viewport: unsigned planes to 0xffffffff (SL_NO_INDEX), float planes to 0, depth to 1. */
void osmesa_clear(const osmesa_target *target);
/* Row 0 at the bottom, channels interleaved as in the format. */
void osmesa_read(const osmesa_target *target, int plane, void *pixels);
void osmesa_read_depth(const osmesa_target *target, float *depth);

/* ---- geometry -------------------------------------------------------------------------------- */

/* Input `location` = its index of the vertex shader. */
typedef struct osmesa_stream {
    const float *values; /* count * components */
    size_t count;
    int components;      /* 1..4 */
    bool per_instance;   /* advances with the instance, not the vertex */
} osmesa_stream;
enum { OSMESA_STREAMS = 8 };

typedef struct osmesa_mesh {
    unsigned array, buffer[OSMESA_STREAMS + 1];
    bool indexed;
    size_t count; /* of indices, or vertices */
} osmesa_mesh;

/* Copies them into buffers. indices NULL: vertices in order, three a triangle. No streams: `index_count`
 * vertices that the shader makes from gl_VertexID. */
osmesa_mesh osmesa_mesh_create(int streams, const osmesa_stream *stream, size_t index_count,
                               const uint32_t *indices);
void osmesa_mesh_destroy(osmesa_mesh *mesh);

/* ---- programs and state ---------------------------------------------------------------------- */

/* GLSL, with or without its #version line (then: 330 core). Outputs go to the planes in order of their
 * layout(location). */
unsigned osmesa_program(const char *vertex_shader, const char *fragment_shader);
void osmesa_program_destroy(unsigned program);
/* Uniforms by name: 1..4 floats; a matrix whose rows come first, as in sl_view. */
void osmesa_uniform(unsigned program, const char *name, int components, const float *values);
void osmesa_uniform_array(unsigned program, const char *name, int count, const float *values); /* of vec4 */
void osmesa_uniform_matrix(unsigned program, const char *name, const float rows[4][4]);

/* An RGBA float texture of a full-screen pass: nearest texel, no MIP maps, edges clamped. */
unsigned osmesa_texture(int width, int height, const float *rgba);
void osmesa_texture_destroy(unsigned texture);

/* Binds a texture (a target's plane too) to a sampler2D or usampler2D of the program. */
void osmesa_input(unsigned program, const char *sampler, int unit, unsigned texture);

/* depth: GL_LESS and written; add: blending (ONE, ONE) on every plane. At first neither. Nothing is culled.
 */
void osmesa_state(bool depth, bool add);
/* With a depth plane, until told otherwise: depth is drawn alone, the colour planes being left as they are;
 * or only what lies no deeper than what is there is drawn, so that with a depth pass first every pixel is
 * shaded once. */
typedef enum osmesa_order { ORDER_USUAL, ORDER_DEPTH_ALONE, ORDER_VISIBLE_ALONE } osmesa_order;
void osmesa_draw_order(osmesa_order order);
/* Draws `count` indices (or vertices) from `first` on, `instances` times (0: not instanced). */
void osmesa_draw(unsigned program, const osmesa_mesh *mesh, size_t first, size_t count, size_t instances);
/* The whole mesh once. */
void osmesa_draw_all(unsigned program, const osmesa_mesh *mesh);
/* Waits until everything is drawn. */
void osmesa_finish(void);
