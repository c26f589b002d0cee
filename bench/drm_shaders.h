/* OSMesa's shaders, for drm_osmesa.c alone. Those of scenes begin with raster_osmesa.c's transform, all with
 * #defines:
 *
 *     SHADOWS     light may be blocked
 *     WEIGHT      11, 14 or 15, or 0: no indirect light
 *     PHOTONS     how many
 *     AREA        an area light, which shines to one side by (9); otherwise (5)
 *     DEFERRED    surfaces come from textures */
#ifndef SL_BENCH_DRM_SHADERS_H
#define SL_BENCH_DRM_SHADERS_H

static const char surface_vertex[] =
    "layout(location = 1) in vec3 normal;\n"
    "layout(location = 2) in vec4 colour;\n"
    "out vec3 p, n;\n"
    "out vec4 c;\n"
    "invariant gl_Position;\n"
    "void main() { p = position; n = normal; c = colour; gl_Position = to_clip(); }\n";
static const char depth_vertex[] =
    "invariant gl_Position;\n"
    "void main() { gl_Position = to_clip(); }\n";
static const char depth_fragment[] = "void main() {}\n";
static const char screen_vertex[] = "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, "
                                    "gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }\n";
/* beta of a receiver through p, from its geometric normal: by how much 1/w may be off within a texel, times
 * the texels a side. */
static const char slope_function[] =
    "uniform vec3 light;\n"
    "float slope(vec3 p) {\n"
    "    vec3 q = p - light, g = cross(dFdx(p), dFdy(p)), a = abs(q), m = abs(g);\n"
    "    float across = a.x >= a.y && a.x >= a.z ? m.y + m.z : a.y >= a.z ? m.z + m.x : m.x + m.y;\n"
    "    return across / abs(dot(g, q));\n"
    "}\n";

static const char gbuffer_fragment[] =
    "in vec3 p, n;\n"
    "in vec4 c;\n"
    "layout(location = 0) out vec4 place;\n"
    "layout(location = 1) out vec4 direction;\n"
    "layout(location = 2) out vec4 colour;\n"
    "void main() {\n"
    "    place = vec4(p, 1.0);\n"
    "    direction = vec4(gl_FrontFacing ? n : -n, slope(p));\n"
    "    colour = c;\n"
    "}\n";

/* Irradiance of the light at x: (4), (8). */
static const char light_functions[] =
    "uniform vec3 intensity;\n"
    "uniform vec3 axis;\n" /* an area light's normal */
    "float falloff(vec3 d, float inverse_square, float inverse) {\n"
    "#if AREA\n"
    "    return inverse_square * max(-dot(axis, d) * inverse, 0.0);\n"
    "#else\n"
    "    return inverse_square;\n"
    "#endif\n"
    "}\n";

/* The direct radiance map, passes 2a to 2c at once. */
static const char map_fragment[] = "in vec3 p, n;\n"
                                   "in vec4 c;\n"
                                   "layout(location = 0) out vec4 place;\n"
                                   "layout(location = 1) out vec4 radiance;\n"
                                   "layout(location = 2) out vec4 direction;\n"
                                   "void main() {\n"
                                   "    vec3 d = light - p, unit = normalize(n);\n"
                                   "    float inverse_square = 1.0 / dot(d, d), inverse = "
                                   "sqrt(inverse_square), cosine = dot(unit, d) * inverse;\n"
                                   "    place = vec4(p, 1.0);\n"
                                   "    radiance = vec4(c.rgb * intensity * (0.318309886 * abs(cosine) * "
                                   "falloff(d, inverse_square, inverse)), 1.0);\n"
                                   "    direction = vec4(cosine < 0.0 ? -unit : unit, 0.0);\n"
                                   "}\n";

/* Passes 6 and 7. `shadow` holds 1 - near/w of six faces, side by side; 1/w is linear across a face, and
 * within a texel the receiver's own plane can be off by at most beta. Photons: y and what is left of A', L_o
 * with all that does not depend on x, n_y. */
static const char shade_functions[] =
    "#if SHADOWS\n"
    "uniform sampler2D shadow;\n"
    "uniform vec3 shadow_size;\n" /* texels a side, near, slack */
    "float lit(vec3 q, float slope) {\n"
    "    vec3 a = abs(q), f;\n"
    "    float face;\n"
    "    if (a.x >= a.y && a.x >= a.z) { f = q.yzx; face = 0.0; }\n"
    "    else if (a.y >= a.z) { f = q.zxy; face = 2.0; }\n"
    "    else { f = q; face = 4.0; }\n"
    "    if (f.z < 0.0) face += 1.0;\n"
    "    float size = shadow_size.x, inverse = 1.0 / abs(f.z);\n"
    "    vec2 at = min(floor((f.xy * inverse * 0.5 + 0.5) * size), size - 1.0);\n"
    "    float stored = (1.0 - texelFetch(shadow, ivec2(int(at.x + face * size), int(at.y)), 0).r) / "
    "shadow_size.y;\n"
    "    return inverse >= stored - slope / size * 1.00001 - shadow_size.z ? 1.0 : 0.0;\n"
    "}\n"
    "#endif\n"
    "#if WEIGHT\n"
    "uniform vec4 place_of[PHOTONS], radiance_of[PHOTONS], normal_of[PHOTONS];\n"
    "vec3 indirect(vec3 x, vec3 n) {\n"
    "    vec3 sum = vec3(0.0);\n"
    "    for (int j = 0; j < PHOTONS; j++) {\n"
    "        vec3 d = place_of[j].xyz - x;\n"
    "        float square = dot(d, d), cosine = max(dot(n, d), 0.0);\n"
    "#if WEIGHT == 14\n"
    "        float area = place_of[j].w;\n"
    "        sum += radiance_of[j].rgb * (cosine * max(-dot(normal_of[j].xyz, d), 0.0) * area / (square * "
    "(area + square)));\n"
    "#else\n"
    "        sum += radiance_of[j].rgb * (cosine * inversesqrt(square));\n"
    "#endif\n"
    "    }\n"
    "    return sum;\n"
    "}\n"
    "#endif\n"
    "vec4 shade(vec3 x, vec3 n, vec4 c, float slope) {\n"
    "    if (c.a > 0.5) return vec4(c.rgb, 1.0);\n" /* shines */
    "    vec3 d = light - x;\n"
    "    float inverse_square = 1.0 / dot(d, d), inverse = sqrt(inverse_square);\n"
    "    float received = max(dot(n, d) * inverse, 0.0) * falloff(d, inverse_square, inverse);\n"
    "#if SHADOWS\n"
    "    if (received > 0.0) received *= lit(-d, slope);\n"
    "#endif\n"
    "    vec3 sum = intensity * received;\n"
    "#if WEIGHT\n"
    "    sum += indirect(x, n);\n"
    "#endif\n"
    "    return vec4(c.rgb * sum * 0.318309886, 1.0);\n"
    "}\n";
static const char shade_fragment[] =
    "layout(location = 0) out vec4 result;\n"
    "#if DEFERRED\n"
    "uniform sampler2D places, normals, colours;\n"
    "void main() {\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    vec4 x = texelFetch(places, at, 0);\n"
    "    if (x.w == 0.0) { result = vec4(0.0); return; }\n"
    "    vec4 direction = texelFetch(normals, at, 0);\n"
    "    result = shade(x.xyz, normalize(direction.xyz), texelFetch(colours, at, 0), direction.w);\n"
    "}\n"
    "#else\n"
    "in vec3 p, n;\n"
    "in vec4 c;\n"
    "void main() {\n"
    "    vec3 unit = normalize(n);\n"
    "    result = shade(p, gl_FrontFacing ? unit : -unit, c, slope(p));\n"
    "}\n"
    "#endif\n";

#endif
