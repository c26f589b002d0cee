#include "scene/bump.h"

#include "scene/texture.h"

/* In the triangle's plane u and v grow along their gradients; across a texture's width the surface is 1 /
 * |gradient of u| long, and heights are in such lengths. No gradient: the triangle has no texture coordinates
 * to speak of. */
typedef struct uv_slopes {
    sl_vec3 u, v;
    float width; /* 0: none */
} uv_slopes;

static uv_slopes slopes_of(const sl_scene *scene, uint32_t triangle) {
    uint32_t a = scene->vertex[0][triangle], b = scene->vertex[1][triangle], c = scene->vertex[2][triangle];
    sl_vec3d p = sl_to_double(sl_scene_position(scene, a)),
             e1 = sl_subd(sl_to_double(sl_scene_position(scene, b)), p),
             e2 = sl_subd(sl_to_double(sl_scene_position(scene, c)), p);
    sl_vec3d n = sl_crossd(e1, e2), along1 = sl_crossd(e2, n), along2 = sl_crossd(n, e1);
    double square = sl_dotd(n, n), over = square > 0.0 ? 1.0 / square : 0.0;
    const float *const coordinate[2] = {scene->texture_u, scene->texture_v};
    sl_vec3 slope[2];
    for (int k = 0; k < 2; k++) {
        double by1 = (double)coordinate[k][b] - (double)coordinate[k][a],
               by2 = (double)coordinate[k][c] - (double)coordinate[k][a];
        slope[k] = sl_to_float(sl_scaled(sl_addd(sl_scaled(along1, by1), sl_scaled(along2, by2)), over));
    }
    float length = sl_length(slope[0]), width = length > 0.0f ? 1.0f / length : 0.0f;
    bool sound = width > 0.0f && width < 1e30f && sl_is_finite(slope[0]) && sl_is_finite(slope[1]);
    return (uv_slopes){slope[0], slope[1], sound ? width : 0.0f};
}

/* Central differences over a texel on either side: continuous, as the filtered heights are. */
static float rise(const sl_texture *t, float u, float v, float du, float dv) {
    float texels = du > 0.0f ? (float)t->width : (float)t->height;
    return (sl_texture_height(t, u + du, v + dv) - sl_texture_height(t, u - du, v - dv)) * (0.5f * texels);
}

void sl_bump(const sl_scene *scene, uint32_t triangle, sl_vec3 to_viewer, float *u, float *v,
             sl_surface *surface) {
    const sl_texture *heights = &scene->textures[surface->material->height_map];
    uv_slopes slope = slopes_of(scene, triangle);
    if (!(slope.width > 0.0f)) return;
    /* from behind, hills are hollows */
    float side = surface->front ? 1.0f : -1.0f, depth = side * surface->material->bump_depth * slope.width;
    sl_vec3 view = sl_normalize_or(to_viewer, surface->geometric_normal);
    float above = depth * (sl_texture_height(heights, *u, *v) - 0.5f),
          moved_u = *u + above * sl_dot(slope.u, view), moved_v = *v + above * sl_dot(slope.v, view);
    *u = moved_u;
    *v = moved_v;
    float by_u = rise(heights, moved_u, moved_v, 1.0f / (float)heights->width, 0.0f);
    float by_v = rise(heights, moved_u, moved_v, 0.0f, 1.0f / (float)heights->height);
    if (by_u == 0.0f && by_v == 0.0f) return;
    /* within the plane: the side stays */
    sl_vec3 gradient = sl_add(sl_scale(slope.u, depth * by_u), sl_scale(slope.v, depth * by_v));
    sl_vec3 normal = sl_normalize_or(sl_sub(surface->normal, gradient), surface->normal);
    if (sl_dot(normal, surface->geometric_normal) > 0.0f) surface->normal = normal;
}
