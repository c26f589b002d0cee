/* See osmesa.h. SL_HAVE_OSMESA or SL_HAVE_EGL is the Makefile's finding; with neither only osmesa_open() does
 * anything. */
#define _GNU_SOURCE /* dl_iterate_phdr() */
#include "osmesa.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined SL_HAVE_OSMESA || defined SL_HAVE_EGL

#define GL_GLEXT_PROTOTYPES
#ifdef SL_HAVE_OSMESA
#include <GL/osmesa.h>
#else
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#include <dlfcn.h>
#include <link.h>
#endif
#include <GL/glext.h>

static void die(const char *what, const char *detail) {
    fprintf(stderr, "osmesa: %s %s\n", what, detail);
    abort();
}

static void expect_no_error(const char *where) {
    GLenum error = glGetError();
    char text[32];
    snprintf(text, sizeof text, "0x%04x", (unsigned)error);
    if (error != GL_NO_ERROR) die(where, text);
}

/* ---- the context ----------------------------------------------------------------------------- */

static char renderer[256];

#ifdef SL_HAVE_OSMESA
static OSMesaContext context;
static float *front_buffer; /* making current wants a real buffer even where only targets are drawn */

static const char *context_open(void) {
    const int wanted[] = {OSMESA_FORMAT,
                          OSMESA_RGBA,
                          OSMESA_DEPTH_BITS,
                          0,
                          OSMESA_PROFILE,
                          OSMESA_CORE_PROFILE,
                          OSMESA_CONTEXT_MAJOR_VERSION,
                          3,
                          OSMESA_CONTEXT_MINOR_VERSION,
                          3,
                          0};
    context = OSMesaCreateContextAttribs(wanted, NULL);
    if (!context) return "OSMesa gives no OpenGL 3.3 context";
    front_buffer = calloc((size_t)16 * 16 * 4, sizeof *front_buffer);
    if (!front_buffer || !OSMesaMakeCurrent(context, front_buffer, GL_FLOAT, 16, 16))
        return "OSMesa's context cannot be used";
    return NULL;
}

static void context_close(void) {
    if (context) OSMesaDestroyContext(context);
    free(front_buffer);
    context = NULL;
    front_buffer = NULL;
}
#else
static EGLDisplay display;
static EGLContext context;

static const char *context_open(void) {
    setenv("LIBGL_ALWAYS_SOFTWARE", "true", 1);
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    display =
        get_display ? get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL) : EGL_NO_DISPLAY;
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, NULL, NULL))
        return "EGL has no surfaceless platform of Mesa";
    if (!eglBindAPI(EGL_OPENGL_API)) return "EGL has no OpenGL";
    const EGLint wanted[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3,
                             EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted);
    if (context == EGL_NO_CONTEXT) return "EGL gives no OpenGL 3.3 context";
    if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
        return "EGL's context cannot be used";
    return NULL;
}

static int keep_loaded(struct dl_phdr_info *module, size_t size, void *data) {
    dlopen(module->dlpi_name, RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE);
    return 0;
}

static void context_close(void) {
    if (display == EGL_NO_DISPLAY) return;
    /* eglTerminate() unloads the driver, and lsan.supp knows its blocks by its name */
    dl_iterate_phdr(keep_loaded, NULL);
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglTerminate(display);
    display = EGL_NO_DISPLAY;
}
#endif

/* The agreement was found where llvmpipe uses fused multiply-adds; without them it rounds otherwise. */
static bool cpu_fuses(void) {
#if defined __x86_64__
    return __builtin_cpu_supports("fma") && __builtin_cpu_supports("avx2");
#else
    return false;
#endif
}

/* The driver reads these once, at the first call; the shader cache would write to the home folder and start a
 * thread. */
static void set_environment(unsigned threads) {
    char text[16];
    snprintf(text, sizeof text, "%u", threads);
    setenv("LP_NUM_THREADS", text, 1);
    setenv("MESA_SHADER_CACHE_DISABLE", "true", 1);
    unsetenv("GALLIUM_DRIVER");
    unsetenv("GALLIUM_OVERRIDE_CPU_CAPS");
    unsetenv("LP_NATIVE_VECTOR_WIDTH");
}

static const char *open_reason(unsigned threads) {
    if (!cpu_fuses()) return "the CPU has no fused multiply-add, without which OSMesa rounds otherwise";
    set_environment(threads);
    const char *failure = context_open();
    if (failure) return failure;
    snprintf(renderer, sizeof renderer, "%s, %s", (const char *)glGetString(GL_RENDERER),
             (const char *)glGetString(GL_VERSION));
    if (strncmp(renderer, "llvmpipe", 8) != 0) return "Mesa's software driver is not llvmpipe";
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glDepthFunc(GL_LESS);
    glBlendFunc(GL_ONE, GL_ONE);
    expect_no_error("opening");
    return NULL;
}

bool osmesa_open(unsigned threads, const char **reason) {
    static bool tried;
    static const char *answer;
    if (!tried) answer = open_reason(threads);
    tried = true;
    *reason = answer ? answer : "";
    return answer == NULL;
}

void osmesa_close(void) { context_close(); }

const char *osmesa_name(void) { return renderer; }

/* ---- targets --------------------------------------------------------------------------------- */

static const struct { GLint internal; GLenum format, type;
} formats_of_gl[] = {
    [PLANE_R32UI] = {GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT},
    [PLANE_RG32UI] = {GL_RG32UI, GL_RG_INTEGER, GL_UNSIGNED_INT},
    [PLANE_R32F] = {GL_R32F, GL_RED, GL_FLOAT},
    [PLANE_RG32F] = {GL_RG32F, GL_RG, GL_FLOAT},
    [PLANE_RGB32F] = {GL_RGB32F, GL_RGB, GL_FLOAT},
    [PLANE_RGBA32F] = {GL_RGBA32F, GL_RGBA, GL_FLOAT},
};

/* An empty or filled texture, nearest texel. */
static GLuint make_texture(GLint internal, GLenum format, GLenum type, int width, int height,
                           const void *texels) {
    GLuint texture;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, internal, width, height, 0, format, type, texels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    return texture;
}

osmesa_target osmesa_target_create(int width, int height, int planes, const osmesa_format *formats,
                                   bool depth) {
    osmesa_target target = {.width = width, .height = height, .planes = planes};
    GLenum buffers[OSMESA_PLANES];
    if (planes > OSMESA_PLANES) die("too many", "planes");
    glGenFramebuffers(1, &target.framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    for (int p = 0; p < planes; p++) {
        target.format[p] = formats[p];
        target.plane[p] = make_texture(formats_of_gl[formats[p]].internal, formats_of_gl[formats[p]].format,
                                       formats_of_gl[formats[p]].type, width, height, NULL);
        buffers[p] = GL_COLOR_ATTACHMENT0 + (GLenum)p;
        glFramebufferTexture2D(GL_FRAMEBUFFER, buffers[p], GL_TEXTURE_2D, target.plane[p], 0);
    }
    if (depth) {
        target.depth = make_texture(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, width, height, NULL);
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, target.depth, 0);
    }
    if (planes) glDrawBuffers(planes, buffers);
    else glDrawBuffer(GL_NONE), glReadBuffer(GL_NONE);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) die("incomplete", "target");
    expect_no_error("target");
    return target;
}

void osmesa_target_destroy(osmesa_target *target) {
    glDeleteFramebuffers(1, &target->framebuffer);
    glDeleteTextures(target->planes, target->plane);
    if (target->depth) glDeleteTextures(1, &target->depth);
    *target = (osmesa_target){0};
}

void osmesa_draw_to(const osmesa_target *target) {
    glBindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    glViewport(0, 0, target->width, target->height);
}

void osmesa_viewport(int x, int y, int width, int height) { glViewport(x, y, width, height); }

void osmesa_clear(const osmesa_target *target) {
    const GLuint nothing[4] = {UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX};
    const GLfloat zero[4] = {0}, far = 1;
    osmesa_draw_to(target);
    for (int p = 0; p < target->planes; p++) {
        if (formats_of_gl[target->format[p]].type == GL_UNSIGNED_INT) glClearBufferuiv(GL_COLOR, p, nothing);
        else glClearBufferfv(GL_COLOR, p, zero);
    }
    if (target->depth) glClearBufferfv(GL_DEPTH, 0, &far);
}

void osmesa_read(const osmesa_target *target, int plane, void *pixels) {
    glBindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    glReadBuffer(GL_COLOR_ATTACHMENT0 + (GLenum)plane);
    glReadPixels(0, 0, target->width, target->height, formats_of_gl[target->format[plane]].format,
                 formats_of_gl[target->format[plane]].type, pixels);
    expect_no_error("reading");
}

void osmesa_read_depth(const osmesa_target *target, float *depth) {
    glBindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    glReadPixels(0, 0, target->width, target->height, GL_DEPTH_COMPONENT, GL_FLOAT, depth);
    expect_no_error("reading depth");
}

/* ---- geometry -------------------------------------------------------------------------------- */

static GLuint make_buffer(GLenum binding, size_t bytes, const void *data) {
    GLuint buffer;
    glGenBuffers(1, &buffer);
    glBindBuffer(binding, buffer);
    glBufferData(binding, (GLsizeiptr)bytes, data, GL_STATIC_DRAW);
    return buffer;
}

osmesa_mesh osmesa_mesh_create(int streams, const osmesa_stream *stream, size_t index_count,
                               const uint32_t *indices) {
    osmesa_mesh mesh = {.indexed = indices != NULL, .count = index_count};
    glGenVertexArrays(1, &mesh.array);
    glBindVertexArray(mesh.array);
    for (int s = 0; s < streams; s++) {
        mesh.buffer[s] =
            make_buffer(GL_ARRAY_BUFFER, stream[s].count * (size_t)stream[s].components * sizeof(float),
                        stream[s].values);
        glVertexAttribPointer((GLuint)s, stream[s].components, GL_FLOAT, GL_FALSE, 0, NULL);
        glEnableVertexAttribArray((GLuint)s);
        if (stream[s].per_instance) glVertexAttribDivisor((GLuint)s, 1);
        else if (!indices) mesh.count = stream[s].count;
    }
    if (indices)
        mesh.buffer[OSMESA_STREAMS] =
            make_buffer(GL_ELEMENT_ARRAY_BUFFER, index_count * sizeof *indices, indices);
    expect_no_error("mesh");
    return mesh;
}

void osmesa_mesh_destroy(osmesa_mesh *mesh) {
    glDeleteVertexArrays(1, &mesh->array);
    glDeleteBuffers(OSMESA_STREAMS + 1, mesh->buffer); /* zeros are ignored */
    *mesh = (osmesa_mesh){0};
}

/* ---- programs and state ---------------------------------------------------------------------- */

static GLuint compile(GLenum kind, const char *text) {
    const char *parts[] = {strncmp(text, "#version", 8) == 0 ? "" : "#version 330 core\n", text};
    GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 2, parts, NULL);
    glCompileShader(shader);
    GLint good;
    char log[2000] = "";
    glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
    glGetShaderInfoLog(shader, sizeof log, NULL, log);
    if (!good) die("shader:", log);
    return shader;
}

unsigned osmesa_program(const char *vertex_shader, const char *fragment_shader) {
    GLuint program = glCreateProgram(), shaders[] = {compile(GL_VERTEX_SHADER, vertex_shader),
                                                     compile(GL_FRAGMENT_SHADER, fragment_shader)};
    for (int s = 0; s < 2; s++) glAttachShader(program, shaders[s]);
    glLinkProgram(program);
    for (int s = 0; s < 2; s++) glDeleteShader(shaders[s]);
    GLint good;
    char log[2000] = "";
    glGetProgramiv(program, GL_LINK_STATUS, &good);
    glGetProgramInfoLog(program, sizeof log, NULL, log);
    if (!good) die("program:", log);
    return program;
}

void osmesa_program_destroy(unsigned program) { glDeleteProgram(program); }

static GLint uniform_location(GLuint program, const char *name) {
    glUseProgram(program);
    GLint location = glGetUniformLocation(program, name);
    if (location < 0) die("no uniform", name);
    return location;
}

void osmesa_uniform(unsigned program, const char *name, int components, const float *values) {
    GLint location = uniform_location(program, name);
    if (components == 1) glUniform1fv(location, 1, values);
    else if (components == 2) glUniform2fv(location, 1, values);
    else if (components == 3) glUniform3fv(location, 1, values);
    else glUniform4fv(location, 1, values);
}

void osmesa_uniform_array(unsigned program, const char *name, int count, const float *values) {
    glUniform4fv(uniform_location(program, name), count, values);
}

static void osmesa_uniform_int(unsigned program, const char *name, int value) {
    glUniform1i(uniform_location(program, name), value);
}

void osmesa_uniform_matrix(unsigned program, const char *name, const float rows[4][4]) {
    glUniformMatrix4fv(uniform_location(program, name), 1, GL_TRUE, &rows[0][0]);
}

unsigned osmesa_texture(int width, int height, const float *rgba) {
    GLuint texture = make_texture(GL_RGBA32F, GL_RGBA, GL_FLOAT, width, height, rgba);
    expect_no_error("texture");
    return texture;
}

void osmesa_texture_destroy(unsigned texture) { glDeleteTextures(1, &texture); }

void osmesa_input(unsigned program, const char *sampler, int unit, unsigned texture) {
    glActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    glBindTexture(GL_TEXTURE_2D, texture);
    glActiveTexture(GL_TEXTURE0);
    osmesa_uniform_int(program, sampler, unit);
}

static void enable(GLenum what, bool on) {
    if (on) glEnable(what);
    else glDisable(what);
}

void osmesa_state(bool depth, bool add) {
    enable(GL_DEPTH_TEST, depth);
    enable(GL_BLEND, add);
}

void osmesa_draw_order(osmesa_order order) {
    GLboolean colour = order != ORDER_DEPTH_ALONE;
    glColorMask(colour, colour, colour, colour);
    glDepthFunc(order == ORDER_VISIBLE_ALONE ? GL_LEQUAL : GL_LESS);
}

void osmesa_draw(unsigned program, const osmesa_mesh *mesh, size_t first, size_t count, size_t instances) {
    glUseProgram(program);
    glBindVertexArray(mesh->array);
    const void *offset = (const void *)(uintptr_t)(first * sizeof(uint32_t)); /* into the buffer of indices */
    GLsizei copies = instances ? (GLsizei)instances : 1;
    if (mesh->indexed) glDrawElementsInstanced(GL_TRIANGLES, (GLsizei)count, GL_UNSIGNED_INT, offset, copies);
    else glDrawArraysInstanced(GL_TRIANGLES, (GLint)first, (GLsizei)count, copies);
    expect_no_error("drawing");
}

void osmesa_draw_all(unsigned program, const osmesa_mesh *mesh) {
    osmesa_draw(program, mesh, 0, mesh->count, 0);
}

void osmesa_finish(void) { glFinish(); }

#else

bool osmesa_open(unsigned threads, const char **reason) {
    *reason = "OSMesa is not installed (Debian: libosmesa6-dev)";
    return false;
}

/* Nobody gets here after that. */
static void missing(void) {
    fprintf(stderr, "osmesa: called though it is not there\n");
    abort();
}

void osmesa_close(void) {}
const char *osmesa_name(void) { return "none"; }

osmesa_target osmesa_target_create(int width, int height, int planes, const osmesa_format *formats,
                                   bool depth) {
    missing();
    return (osmesa_target){0};
}
void osmesa_target_destroy(osmesa_target *target) { (void)target, missing(); }
void osmesa_draw_to(const osmesa_target *target) { (void)target, missing(); }
void osmesa_viewport(int x, int y, int width, int height) {
    (void)x, (void)y, (void)width, (void)height, missing();
}
void osmesa_clear(const osmesa_target *target) { (void)target, missing(); }
void osmesa_read(const osmesa_target *target, int plane, void *pixels) {
    (void)target, (void)plane, (void)pixels, missing();
}
void osmesa_read_depth(const osmesa_target *target, float *depth) { (void)target, (void)depth, missing(); }
osmesa_mesh osmesa_mesh_create(int streams, const osmesa_stream *stream, size_t index_count,
                               const uint32_t *indices) {
    missing();
    return (osmesa_mesh){0};
}
void osmesa_mesh_destroy(osmesa_mesh *mesh) { (void)mesh, missing(); }
unsigned osmesa_program(const char *vertex_shader, const char *fragment_shader) {
    missing();
    return 0;
}
void osmesa_program_destroy(unsigned program) { (void)program, missing(); }
void osmesa_uniform(unsigned program, const char *name, int components, const float *values) {
    missing();
}
void osmesa_uniform_array(unsigned program, const char *name, int count, const float *values) {
    missing();
}
void osmesa_uniform_matrix(unsigned program, const char *name, const float rows[4][4]) {
    (void)program, (void)name, (void)rows, missing();
}
unsigned osmesa_texture(int width, int height, const float *rgba) {
    missing();
    return 0;
}
void osmesa_texture_destroy(unsigned texture) { (void)texture, missing(); }
void osmesa_input(unsigned program, const char *sampler, int unit, unsigned texture) {
    missing();
}
void osmesa_state(bool depth, bool add) { (void)depth, (void)add, missing(); }
void osmesa_draw_order(osmesa_order order) { (void)order, missing(); }
void osmesa_draw(unsigned program, const osmesa_mesh *mesh, size_t first, size_t count, size_t instances) {
    missing();
}
void osmesa_draw_all(unsigned program, const osmesa_mesh *mesh) { (void)program, (void)mesh, missing(); }
void osmesa_finish(void) { missing(); }

#endif
