/* OSMesa's shaders, for raster_osmesa.c alone. Those of scenes begin with `transform`. */
#pragma once

static const char transform[] =
    "layout(location = 0) in vec3 position;\n"
    "uniform mat4 clip;\n"
    "uniform vec3 origin;\n"
    "vec4 to_clip() { return clip * vec4(position - origin, 1.0); }\n";

static const char depth_vertex[] = "void main() { gl_Position = to_clip(); }\n";
static const char depth_fragment[] = "void main() {}\n";
static const char id_vertex[] =
    "layout(location = 1) in float triangle;\n"
    "flat out float t;\n"
    "void main() { t = triangle; gl_Position = to_clip(); }\n";
static const char id_fragment[] =
    "flat in float t;\n"
    "layout(location = 0) out uint id;\n"
    "void main() { id = uint(t); }\n";

static const char gbuffer_vertex[] =
    "layout(location = 1) in vec3 normal;\n"
    "layout(location = 2) in vec3 colour;\n"
    "out vec3 p, n, c;\n"
    "void main() { p = position; n = normal; c = colour; gl_Position = to_clip(); }\n";
/* Unit normals, turned to the viewer, as ours are. */
static const char gbuffer_fragment[] =
    "in vec3 p, n, c;\n"
    "layout(location = 0) out vec4 place;\n"
    "layout(location = 1) out vec4 direction;\n"
    "layout(location = 2) out vec4 diffuse;\n"
    "void main() {\n"
    "    vec3 unit = normalize(n);\n"
    "    place = vec4(p, 1.0);\n"
    "    direction = vec4(gl_FrontFacing ? unit : -unit, 0.0);\n"
    "    diffuse = vec4(c, 1.0);\n"
    "}\n";

static const char gouraud_vertex[] =
    "layout(location = 1) in vec3 colour;\n"
    "out vec3 c;\n"
    "void main() { c = colour; gl_Position = to_clip(); }\n";
static const char gouraud_fragment[] =
    "in vec3 c;\n"
    "layout(location = 0) out vec4 sum;\n"
    "void main() { sum = vec4(c, 1.0); }\n";

/* Six vertices a splat; its record comes from a texture of one row a splat, once a vertex. */
static const char splat_vertex[] =
    "uniform sampler2D records;\n"
    "uniform vec2 size;\n"
    "flat out vec4 k[9];\n"
    "const int corner[6] = int[6](0, 1, 3, 0, 3, 2);\n"
    "void main() {\n"
    "    int splat = gl_VertexID / 6, c = corner[gl_VertexID % 6];\n"
    "    vec4 rect = texelFetch(records, ivec2(0, splat), 0);\n"
    "    for (int i = 0; i < 9; i++) k[i] = texelFetch(records, ivec2(i + 1, splat), 0);\n"
    "    vec2 at = vec2((c & 1) != 0 ? rect.z : rect.x, (c & 2) != 0 ? rect.w : rect.y);\n"
    "    gl_Position = vec4(at / size * 2.0 - 1.0, 0.0, 1.0);\n"
    "}\n";
/* splat_kernels.c, line by line. k: position and R; normal; E; three rotational gradients with their lengths;
 * three translational. */
static const char splat_fragment[] =
    "flat in vec4 k[9];\n"
    "uniform sampler2D positions, normals;\n"
    "uniform vec3 rules;\n" /* a, 1/a or 0, front tolerance */
    "layout(location = 0) out vec4 sum;\n"
    "layout(location = 1) out vec4 count;\n"
    "float extrapolate(float e, vec4 rotational, vec3 translational, vec3 turn, float turn_length, vec3 "
    "delta) {\n"
    "    float value = e + dot(turn, rotational.xyz) + dot(delta, translational);\n"
    "    return max(min(value, e * (1.0 + rules.x) + rotational.w * turn_length), 0.0);\n"
    "}\n"
    "void main() {\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    vec4 p = texelFetch(positions, at, 0);\n" /* w: whether the pixel receives light */
    "    vec3 n = texelFetch(normals, at, 0).xyz;\n"
    "    vec3 delta = p.xyz - k[0].xyz;\n"
    "    float distance = length(delta), radius = rules.x * k[0].w;\n"
    "    float d = distance / k[0].w + length(n - k[1].xyz) * 0.70710678;\n"
    "    float s = 0.5 * dot(delta, n + k[1].xyz), front = -(0.01 * radius + rules.z);\n"
    "    bool accepted = p.w != 0.0 && d <= rules.x && distance <= radius && s >= front && "
    "s <= 0.5 * radius + rules.z;\n"
    "    float w = accepted ? max(1.0 / max(d, 1e-3) - rules.y, 0.0) : 0.0;\n" /* discarding costs llvmpipe a
                                                                                  little more */
    "    vec3 turn = cross(k[1].xyz, n);\n"
    "    float l = length(turn);\n"
    "    sum = vec4(w * extrapolate(k[2].x, k[3], k[6].xyz, turn, l, delta), w * extrapolate(k[2].y, k[4], "
    "k[7].xyz, turn, l, delta),\n"
    "               w * extrapolate(k[2].z, k[5], k[8].xyz, turn, l, delta), w);\n"
    "    count = vec4(w > 0.0 ? 1.0 : 0.0);\n"
    "}\n";

/* One triangle over the whole target. */
static const char screen_vertex[] = "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, "
                                    "gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }\n";
static const char copy_fragment[] =
    "uniform sampler2D from;\n"
    "layout(location = 0) out vec4 same;\n"
    "void main() { same = texelFetch(from, ivec2(gl_FragCoord.xy), 0); }\n";
static const char halve_fragment[] =
    "uniform sampler2D from;\n"
    "layout(location = 0) out vec4 sum;\n"
    "void main() {\n"
    "    ivec2 at = 2 * ivec2(gl_FragCoord.xy);\n"
    "    sum = (texelFetch(from, at, 0) + texelFetch(from, at + ivec2(1, 0), 0)) +\n"
    "          (texelFetch(from, at + ivec2(0, 1), 0) + texelFetch(from, at + ivec2(1, 1), 0));\n"
    "}\n";
