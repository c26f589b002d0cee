/* A surface point: its place, normals and colours. Which side is seen and which way normals point is decided
 * in surface_rules.h alone. */
#include "scene/bump.h"
#include "scene/surface_rules.h"
#include "scene/texture.h"

sl_rgb sl_scene_diffuse(const sl_scene *scene, uint32_t triangle, float w1, float w2) {
    const sl_material *material = sl_triangle_material(scene, triangle);
    if (material->texture == SL_NO_INDEX) return material->diffuse;
    const sl_texture_place at = sl_texture_place_at(scene, triangle, w1, w2);
    return sl_rgb_mul(material->diffuse, sl_texture_color(&scene->textures[material->texture], at.u, at.v));
}

/* Applies what a height map changes: the normal, and where the colour is looked up. */
static void raise(const sl_scene *scene, uint32_t triangle, float w1, float w2, sl_vec3 to_viewer,
                  sl_surface *s) {
    sl_texture_place at = sl_texture_place_at(scene, triangle, w1, w2);
    sl_bump(scene, triangle, to_viewer, &at.u, &at.v, s);
    if (s->material->texture != SL_NO_INDEX)
        s->diffuse = sl_rgb_mul(s->material->diffuse,
                                sl_texture_color(&scene->textures[s->material->texture], at.u, at.v));
}

void sl_scene_surface(const sl_scene *scene, uint32_t triangle, float w1, float w2, sl_vec3 to_viewer,
                      sl_surface *surface) {
    surface->material = sl_triangle_material(scene, triangle);
    surface->diffuse = sl_scene_diffuse(scene, triangle, w1, w2);
    surface->position = sl_position_at(scene, triangle, w1, w2);

    sl_vec3 geometric = sl_scene_geometric_normal(scene, triangle);
    float side = sl_side_seen(geometric, to_viewer);
    surface->front = side > 0.0f;
    surface->geometric_normal = sl_scale(geometric, side);
    surface->normal =
        sl_shading_normal(sl_vertex_normal_at(scene, triangle, w1, w2), surface->geometric_normal);
    if (sl_material_is_bumpy(surface->material)) raise(scene, triangle, w1, w2, to_viewer, surface);
}

sl_rgb sl_scene_diffuse_nearest(const sl_scene *scene, uint32_t triangle, float w1, float w2) {
    const sl_material *material = sl_triangle_material(scene, triangle);
    if (material->texture == SL_NO_INDEX) return material->diffuse;
    const sl_texture_place at = sl_texture_place_at(scene, triangle, w1, w2);
    return sl_rgb_mul(material->diffuse, sl_texture_nearest(&scene->textures[material->texture], at.u, at.v));
}

bool sl_scene_has_alpha(const sl_scene *scene, uint32_t triangle) {
    return sl_triangle_material(scene, triangle)->alpha_texture != SL_NO_INDEX;
}

bool sl_scene_is_opaque(const sl_scene *scene, uint32_t triangle, float w1, float w2) {
    const sl_material *material = sl_triangle_material(scene, triangle);
    if (material->alpha_texture == SL_NO_INDEX) return true;
    const sl_texture_place at = sl_texture_place_at(scene, triangle, w1, w2);
    return sl_texture_alpha(&scene->textures[material->alpha_texture], at.u, at.v) >= 0.5f;
}

/* Texels of the mask in the box around the triangle's texture coordinates. */
static double masked_texels(const sl_scene *scene, uint32_t triangle) {
    const sl_texture *mask = &scene->textures[sl_triangle_material(scene, triangle)->alpha_texture];
    const uint32_t *const *vertex = (const uint32_t *const *)scene->vertex;
    const float *u = scene->texture_u, *v = scene->texture_v;
    const uint32_t a = vertex[0][triangle], b = vertex[1][triangle], c = vertex[2][triangle];
    const double wide = (double)(fmaxf(u[a], fmaxf(u[b], u[c])) - fminf(u[a], fminf(u[b], u[c])));
    const double high = (double)(fmaxf(v[a], fmaxf(v[b], v[c])) - fminf(v[a], fminf(v[b], v[c])));
    return (wide * mask->width + 1.0) * (high * mask->height + 1.0);
}

static int mask_points(const sl_scene *scene, uint32_t triangle) {
    enum { A_TEXEL = 16, LEAST = 1024, MOST = 4096 };
    const double wanted = A_TEXEL * masked_texels(scene, triangle);
    return wanted < MOST ? (wanted > LEAST ? (int)wanted : LEAST) : MOST;
}

/* Roberts's sequence, folded into the triangle: unlike a grid it keeps no step with stripes and lattices. */
static bool mask_point(const sl_scene *scene, uint32_t triangle, int index, float *w1, float *w2) {
    const double a1 = 0.75487766624669276, a2 = 0.56984029099805327; /* 1/g and 1/g^2, g^3 = g + 1 */
    double x = 0.5 + a1 * index, y = 0.5 + a2 * index;
    x -= (double)(int)x;
    y -= (double)(int)y;
    const bool beyond = x + y > 1.0;
    *w1 = (float)(beyond ? 1.0 - x : x);
    *w2 = (float)(beyond ? 1.0 - y : y);
    return sl_scene_is_opaque(scene, triangle, *w1, *w2);
}

float sl_scene_opaque_share(const sl_scene *scene, uint32_t triangle) {
    if (!sl_scene_has_alpha(scene, triangle)) return 1.0f;
    const int count = mask_points(scene, triangle);
    int opaque = 0;
    for (int i = 0; i < count; i++) {
        float w1, w2;
        opaque += mask_point(scene, triangle, i, &w1, &w2);
    }
    return (float)opaque / (float)count;
}

sl_rgb sl_scene_emission(const sl_scene *scene, uint32_t triangle, sl_vec3 geometric_normal) {
    const sl_material *m = sl_triangle_material(scene, triangle);
    bool front = sl_dot(geometric_normal, sl_scene_geometric_normal(scene, triangle)) > 0.0f;
    return front || m->emission_two_sided ? m->emission : sl_grey(0.0f);
}
