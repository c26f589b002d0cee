#include "cache/direct_radiance/map_pictures.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"

enum {
    PIXELS = 256, /* resolved together */
    VIEWS = 8     /* drawn together */
};

/* ---- one texel ---- */

/* As an 8-bit colour holds a coordinate: scaled into the scene's box, in steps of 1/255 of its extent. */
static float eight_bits(float value, float low, float high) {
    float extent = high - low;
    if (!(extent > 0.0f)) return low;
    float step = floorf((value - low) / extent * 255.0f + 0.5f);
    step = step > 0.0f ? step : 0.0f;
    return low + (step < 255.0f ? step : 255.0f) / 255.0f * extent;
}

static void write_position(const sl_map_drawing *d, size_t i, const sl_surface *s, float way) {
    const sl_scene *scene = d->scene;
    sl_radiance_map *map = d->map;
    sl_vec3 p = s->position;
    if (d->settings->eight_bit_positions) {
        p = sl_v3(eight_bits(p.x, scene->box_min.x, scene->box_max.x), eight_bits(p.y, scene->box_min.y, scene->box_max.y),
                  eight_bits(p.z, scene->box_min.z, scene->box_max.z));
    }
    map->position[0][i] = p.x;
    map->position[1][i] = p.y;
    map->position[2][i] = p.z;
    map->geometric[0][i] = s->geometric_normal.x;
    map->geometric[1][i] = s->geometric_normal.y;
    map->geometric[2][i] = s->geometric_normal.z;
    map->path[i] = way;
}

/* L_o = rho / pi E. Where numbers overflow (the light in the surface): nothing. */
static void write_color(const sl_map_drawing *d, size_t i, const sl_surface *s, const sl_texel_light *light) {
    sl_rgb color = s->diffuse;
    if (d->map->lambertian) {
        float cosine = sl_dot(s->normal, light->arrival);
        float scale = (float)(1.0 / SL_PI) * (cosine > 0.0f && sl_dot(s->geometric_normal, light->arrival) > 0.0f ? cosine : 0.0f);
        color = sl_rgb_scale(sl_rgb_mul(color, light->facing), scale);
        if (!sl_rgb_is_finite(color)) color = sl_grey(0.0f);
    }
    d->map->color[0][i] = color.r;
    d->map->color[1][i] = color.g;
    d->map->color[2][i] = color.b;
}

void sl_map_texel_write(const sl_map_drawing *d, size_t i, const sl_surface *s, const sl_texel_light *light) {
    write_position(d, i, s, light->way);
    write_color(d, i, s, light);
    if (d->map->normal[0]) {
        d->map->normal[0][i] = s->normal.x;
        d->map->normal[1][i] = s->normal.y;
        d->map->normal[2][i] = s->normal.z;
    }
}

sl_vec3 sl_map_face_departure(const sl_map_drawing *d, const sl_map_face *face, sl_vec3 direction) {
    if (face->mirror == SL_NO_INDEX) return direction;
    sl_vec3d n = d->options->mirrors->plane[face->mirror].normal, v = sl_to_double(direction);
    return sl_to_float(sl_subd(v, sl_scaled(n, 2.0 * sl_dotd(v, n))));
}

/* How a light's light comes straight, or unfolded from behind a mirror, to y. */
static sl_texel_light light_at(const sl_map_drawing *d, const sl_map_face *face, sl_vec3 y) {
    const sl_map_light *light = &d->map->lights->light[face->light];
    sl_vec3d way = sl_subd(sl_to_double(y), sl_to_double(face->eye));
    if (light->kind == SL_MAP_LIGHT_DIRECTIONAL) {
        return (sl_texel_light){sl_neg(face->frame.z), sl_rgb_mul(light->intensity, face->reflectance),
                                (float)sl_dotd(way, sl_to_double(face->frame.z))};
    }
    double squared = sl_dotd(way, way), length = sqrt(squared);
    if (!(squared > 0.0) || !isfinite(squared)) return (sl_texel_light){face->frame.z, {0, 0, 0}, 0.0f};
    sl_vec3 direction = sl_to_float(sl_scaled(way, 1.0 / length));
    sl_rgb intensity = sl_rgb_mul(sl_map_light_intensity(light, sl_map_face_departure(d, face, direction)), face->reflectance);
    return (sl_texel_light){sl_neg(direction), sl_rgb_scale(intensity, (float)(1.0 / squared)), (float)length};
}

/* ---- one face ---- */

typedef struct {
    const sl_map_drawing *drawing;
    uint64_t *shaded; /* by face */
} resolution;

static void resolve_texel(const sl_map_drawing *d, const sl_map_face *face, size_t i, float w1, float w2) {
    uint32_t triangle = d->map->triangle[i];
    sl_surface surface;
    /* Every point of the triangle is seen from the same side. */
    sl_vec3 to_light = sl_sub(face->eye, sl_scene_position(d->scene, d->scene->vertex[0][triangle]));
    if (d->map->lights->light[face->light].kind == SL_MAP_LIGHT_DIRECTIONAL) to_light = sl_neg(face->frame.z);
    sl_scene_surface(d->scene, triangle, w1, w2, to_light, &surface);
    sl_texel_light light = light_at(d, face, surface.position);
    sl_map_texel_write(d, i, &surface, &light);
}

static void resolve_face(void *context, size_t index, unsigned worker) {
    (void)worker;
    const resolution *r = context;
    const sl_map_drawing *d = r->drawing;
    const sl_map_face *face = &d->map->face[index];
    size_t texels = (size_t)face->width * (size_t)face->height;
    uint32_t pixel[PIXELS];
    float w1[PIXELS], w2[PIXELS];
    for (size_t first = 0; first < texels; first += PIXELS) {
        size_t count = texels - first < PIXELS ? texels - first : PIXELS;
        for (size_t i = 0; i < count; i++) pixel[i] = (uint32_t)(first + i);
        sl_raster_barycentrics(d->raster, &face->view, count, pixel, d->map->triangle + face->first + first, w1, w2);
        for (size_t i = 0; i < count; i++) {
            size_t texel = face->first + first + i;
            if (d->map->triangle[texel] == SL_NO_INDEX) continue;
            resolve_texel(d, face, texel, w1[i], w2[i]);
            r->shaded[index]++;
        }
    }
}

/* ---- all ---- */

/* Texels in which the light does not see the mirror do not see what the mirror shows either. */
static void apply_stencil(const sl_map_drawing *d, const sl_map_face *face, const sl_planned_face *planned) {
    size_t texels = (size_t)face->width * (size_t)face->height;
    for (size_t i = 0; i < texels; i++) {
        uint32_t seen = d->stencil[planned->stencil + i];
        if (seen == SL_NO_INDEX || d->options->mirrors->of_triangle[seen] != face->mirror) d->map->triangle[face->first + i] = SL_NO_INDEX;
    }
}

sl_status sl_map_triangles_draw(const sl_raster *raster, size_t count, const sl_view *views, const sl_target *targets, unsigned threads,
                                sl_counters *counters, sl_error *error) {
    sl_status status = SL_OK;
    for (size_t i = 0; i < count && status == SL_OK; i += VIEWS)
        status = sl_raster_ids(raster, count - i < VIEWS ? count - i : VIEWS, views + i, threads, targets + i, counters, error);
    return status;
}

static sl_status draw_triangles(const sl_map_drawing *d, sl_error *error) {
    sl_radiance_map *map = d->map;
    sl_view *views = sl_allocate(map->face_count, sizeof *views);
    sl_target *targets = sl_allocate(map->face_count, sizeof *targets);
    sl_status status = views && targets ? SL_OK : sl_fail_memory(error, "a radiance map's faces");
    for (size_t f = 0; f < map->face_count && status == SL_OK; f++) {
        views[f] = map->face[f].view;
        targets[f] = (sl_target){map->face[f].width, map->face[f].height, map->triangle + map->face[f].first, NULL};
    }
    if (status == SL_OK) status = sl_map_triangles_draw(d->raster, map->face_count, views, targets, d->options->threads, d->counters, error);
    for (size_t f = 0; f < map->face_count && status == SL_OK; f++) {
        if (map->face[f].mirror != SL_NO_INDEX) apply_stencil(d, &map->face[f], &d->planned[f]);
    }
    sl_free(views);
    sl_free(targets);
    return status;
}

sl_status sl_map_pictures_draw(const sl_map_drawing *d, sl_error *error) {
    size_t faces = d->map->face_count;
    if (!faces) return SL_OK;
    resolution r = {d, sl_allocate(faces, sizeof *r.shaded)};
    if (!r.shaded) return sl_fail_memory(error, "a radiance map's faces");
    sl_status status = draw_triangles(d, error);
    if (status == SL_OK) {
        sl_parallel_for(sl_thread_count(d->options->threads), faces, resolve_face, &r);
        for (size_t f = 0; f < faces; f++) sl_count(d->counters, SL_COUNT_FRAGMENTS_SHADED, r.shaded[f]);
        /* Four floats a texel; 8-bit positions have four bytes. */
        size_t bytes = (d->settings->eight_bit_positions ? 4u : 16u) + (d->map->normal[0] ? 32u : 16u);
        sl_count(d->counters, SL_COUNT_BYTES_READ_BACK, bytes * d->map->texels);
    }
    sl_free(r.shaded);
    return status;
}
