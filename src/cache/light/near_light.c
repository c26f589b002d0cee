#include "cache/light/near_light.h"

#include <math.h>

/* Nearer than such a share of the distance of its farthest corner from its middle. */
#define NEAR_EXTENT 0.5f

static float gap(float a, float b, float c, float p) {
    float low = fminf(a, fminf(b, c)), high = fmaxf(a, fmaxf(b, c));
    return p < low ? low - p : p > high ? p - high : 0.0f;
}

bool sl_light_is_near(const sl_polygon_light *light, sl_vec3 p) {
    const sl_vec3 *c = light->corner;
    float x = gap(c[0].x, c[1].x, c[2].x, p.x), y = gap(c[0].y, c[1].y, c[2].y, p.y),
          z = gap(c[0].z, c[1].z, c[2].z, p.z);
    return x * x + y * y + z * z < NEAR_EXTENT * NEAR_EXTENT * light->extent_squared;
}

#define COSINE_MIN 0.05

/* The cosine above the receiver differs between the corners, so numbers are bent by what is bilinear between
 * the corners' cosines (Hart et al. 2020, "Practical product sampling by fitting and composing warps"). */
void sl_near_light_make(const sl_polygon_light *light, sl_vec3 p, sl_vec3 n, sl_near_light *near) {
    sl_seen_triangle_make(light->corner, p, n, &near->seen);
    for (int k = 0; k < near->seen.parts; k++) {
        const sl_spherical_triangle *t = &near->seen.part[k];
        const sl_vec3d towards[3] = {t->a, t->b, t->c};
        for (int c = 0; c < 3; c++)
            near->cosine[k][c] = fmax(COSINE_MIN, sl_dotd(towards[c], sl_to_double(n)));
    }
    near->out = sl_to_double(light->normal);
    near->height = sl_dotd(near->out, sl_subd(sl_to_double(p), sl_to_double(light->corner[0])));
}

/* Density proportional to a line from `low` at 0 to `high` at 1, both > 0. */
static double draw_line(double u, double low, double high) {
    return u * (low + high) / (low + sqrt(low * low + u * (high * high - low * low)));
}

sl_vec3d sl_near_light_draw(const sl_near_light *near, double u1, double u2, double *density,
                            double *distance) {
    int part = sl_seen_triangle_part(&near->seen, &u1);
    const double *c = near->cosine[part], mean = 0.5 * c[1] + 0.25 * (c[0] + c[2]);
    u2 = draw_line(u2, c[1], 0.5 * (c[0] + c[2]));
    double low = c[1] + u2 * (c[0] - c[1]), high = c[1] + u2 * (c[2] - c[1]);
    u1 = draw_line(u1, low, high);
    *density = (low + u1 * (high - low)) / mean;
    sl_vec3d direction = sl_spherical_triangle_point(&near->seen.part[part], u1, u2);
    double emitted = -sl_dotd(near->out, direction);
    *distance = emitted > 0.0 ? near->height / emitted : 0.0;
    return direction;
}
