#include "scene/sight.h"

#include <math.h>

#include "base/math.h"

enum { GRID = 8 };
_Static_assert(GRID * GRID == SL_SIGHT_RAYS, "a square of rays");

void sl_sight_set(sl_sight *s, int ray, sl_vec3 direction) {
    sl_put(s->x, s->y, s->z, (size_t)ray, direction);
}

/* A spiral from pole to pole, each turn further by the golden angle. */
void sl_sight_sphere(sl_sight *s, const sl_scene *scene, sl_vec3 origin) {
    const double golden_angle = 2.3999632297286533;
    s->origin = origin;
    for (int i = 0; i < SL_SIGHT_RAYS; i++) {
        double y = 1.0 - (2.0 * i + 1.0) / SL_SIGHT_RAYS, radius = sqrt(1.0 - y * y), turn = golden_angle * i;
        sl_sight_set(s, i, sl_to_float(sl_v3d(radius * sl_cos(turn), y, radius * sl_sin(turn))));
    }
    sl_sight_cast(s, scene);
}

void sl_sight_horizon(sl_sight *s, const sl_scene *scene, sl_vec3 origin) {
    s->origin = origin;
    for (int i = 0; i < SL_SIGHT_RAYS; i++) {
        double turn = 2.0 * SL_PI * i / SL_SIGHT_RAYS;
        sl_sight_set(s, i, sl_to_float(sl_v3d(sl_cos(turn), 0.0, sl_sin(turn))));
    }
    sl_sight_cast(s, scene);
}

void sl_sight_view(sl_sight *s, const sl_scene *scene, const sl_camera *c) {
    const double aspect = (double)scene->film_width / (double)scene->film_height;
    double high = sl_tan(0.5 * (double)c->vertical_fov), wide = high * aspect;
    s->origin = c->eye;
    for (int i = 0; i < SL_SIGHT_RAYS; i++) {
        double x = wide * ((2.0 * (i % GRID) + 1.0) / GRID - 1.0),
               y = high * ((2.0 * (i / GRID) + 1.0) / GRID - 1.0);
        sl_vec3d across = sl_addd(sl_scaled(sl_to_double(c->right), x), sl_scaled(sl_to_double(c->up), y));
        sl_vec3d d = sl_subd(across, sl_to_double(c->back));
        sl_sight_set(s, i, sl_to_float(sl_scaled(d, 1.0 / sl_lengthd(d))));
    }
    sl_sight_cast(s, scene);
}

/* Möller and Trumbore 1997, every ray against one triangle; from is its first corner as the origin sees
 * it. */
static void meet(sl_sight *restrict s, uint32_t triangle, sl_vec3 from, sl_vec3 e1, sl_vec3 e2) {
    sl_vec3 q = sl_cross(from, e1);
    float along = sl_dot(e2, q);
#pragma omp simd
    for (int i = 0; i < SL_SIGHT_RAYS; i++) {
        sl_vec3 d = sl_v3(s->x[i], s->y[i], s->z[i]), p = sl_cross(d, e2);
        float determinant = sl_dot(e1, p), inverse = 1.0f / (determinant != 0.0f ? determinant : 1.0f);
        float u = sl_dot(from, p) * inverse, v = sl_dot(d, q) * inverse, distance = along * inverse;
        bool hit = (determinant != 0.0f) & (u >= 0.0f) & (v >= 0.0f) & (u + v <= 1.0f) & (distance > 0.0f) &
                   (distance < s->distance[i]);
        s->distance[i] = hit ? distance : s->distance[i];
        s->facing[i] = hit ? determinant : s->facing[i];
        s->triangle[i] = hit ? triangle : s->triangle[i];
    }
}

void sl_sight_cast(sl_sight *s, const sl_scene *scene) {
    for (int i = 0; i < SL_SIGHT_RAYS; i++)
        s->distance[i] = INFINITY, s->facing[i] = 0.0f, s->triangle[i] = SL_NO_INDEX;
    for (size_t t = 0; t < scene->triangle_count; t++) {
        sl_vec3 a = sl_scene_position(scene, scene->vertex[0][t]),
                b = sl_scene_position(scene, scene->vertex[1][t]);
        meet(s, (uint32_t)t, sl_sub(s->origin, a), sl_sub(b, a),
             sl_sub(sl_scene_position(scene, scene->vertex[2][t]), a));
    }
}

static bool front_is_hit(const sl_sight *s, int ray) {
    return isfinite(s->distance[ray]) && s->facing[ray] > 0.0f;
}

static bool is_first_of_its_material(const sl_sight *s, const sl_scene *scene, int ray) {
    for (int i = 0; i < ray; i++) {
        if (front_is_hit(s, i) &&
            scene->material_index[s->triangle[i]] == scene->material_index[s->triangle[ray]])
            return false;
    }
    return true;
}

sl_sight_count sl_sight_counted(const sl_sight *s, const sl_scene *scene) {
    sl_sight_count count = {0};
    for (int i = 0; i < SL_SIGHT_RAYS; i++) {
        if (!isfinite(s->distance[i])) continue;
        count.hit++;
        count.mean_distance += (double)s->distance[i];
        if (!front_is_hit(s, i)) continue;
        count.front++;
        count.materials += is_first_of_its_material(s, scene, i);
    }
    count.mean_distance /= count.hit ? count.hit : 1;
    return count;
}
