/* A light's colour is the irradiance perpendicular to its direction, so that n . d in the shader turns it to
 * any normal:
 *
 *     V_j = sum over its members of kappa Y(Phi_i) / (A max(n_i . omega_i, epsilon)) omega_i
 *     d_j = V_j / |V_j|,   c_j = |V_j| (sum Phi_i) / (sum Y(Phi_i))
 *
 * On a flat voxel sum c_j (n_v . d_j) is kappa sum Phi / A exactly. (The sum of the perpendicular irradiances
 * themselves, instead of |V|, would be up to twice too bright.) */
#include "cache/light_octree/voxel_lights.h"

#include <string.h>

/* ---- photons as arrays ---- */

sl_lobe_photons sl_lobe_photons_in(sl_lobe_arrays *a, size_t first) {
    return (sl_lobe_photons){.x = a->x + first,
                             .y = a->y + first,
                             .z = a->z + first,
                             .flux = {a->flux[0] + first, a->flux[1] + first, a->flux[2] + first},
                             .luminance = a->luminance + first,
                             .inverse_cosine = a->inverse_cosine + first,
                             .weight = a->weight + first,
                             .nearest = a->nearest + first,
                             .of = a->of + first};
}

void sl_lobe_photons_add(sl_lobe_photons *p, sl_vec3 direction, sl_vec3 normal, const float flux[3]) {
    double y = 0.2126 * (double)flux[0] + 0.7152 * (double)flux[1] + 0.0722 * (double)flux[2];
    double cosine = (double)sl_dot(direction, normal);
    if (!(y > 0.0 && y <= DBL_MAX) || !isfinite(cosine)) return;
    size_t i = p->count++;
    sl_put(p->x, p->y, p->z, i, direction);
    for (int c = 0; c < 3; c++) p->flux[c][i] = flux[c];
    p->luminance[i] = y;
    p->inverse_cosine[i] = 1.0 / (cosine > SL_GRAZING ? cosine : SL_GRAZING);
}

/* ---- directional lights ---- */

typedef struct lobe {
    sl_vec3d vector;          /* sum of perpendicular irradiances, without scale */
    double flux[3], luminance;
} lobe;

static void sum_lobes(const sl_lobe_photons *p, int count, lobe *lobes) {
    memset(lobes, 0, (size_t)count * sizeof *lobes);
    for (size_t i = 0; i < p->count; i++) {
        lobe *l = &lobes[p->of[i]];
        double w = p->luminance[i] * p->inverse_cosine[i];
        l->vector =
            sl_addd(l->vector, sl_scaled(sl_v3d((double)p->x[i], (double)p->y[i], (double)p->z[i]), w));
        for (int c = 0; c < 3; c++) l->flux[c] += (double)p->flux[c][i];
        l->luminance += p->luminance[i];
    }
}

/* Makes up for what packing turns the direction by: it would change n . d. */
static double packing_gain(sl_vec3d d, float packed, sl_vec3 normal) {
    sl_vec3d n = sl_to_double(normal);
    double wanted = sl_dotd(n, d), got = sl_dotd(n, sl_to_double(sl_direction_unpack(packed)));
    return wanted > 0.2 && got > 0.2 ? wanted / got : 1.0;
}

static sl_directional_light light_of(const lobe *l, sl_vec3d centre, const sl_light_octree_settings *o,
                                     double scale, sl_vec3 normal) {
    double length = sl_lengthd(l->vector);
    bool perpendicular = o->lobes == SL_LOBES_PERPENDICULAR;
    sl_vec3d d = perpendicular && length > 0.0 ? sl_scaled(l->vector, 1.0 / length) : centre;
    sl_directional_light light = {.packed = sl_direction_pack(d)};
    double gain = perpendicular ? length / l->luminance * packing_gain(d, light.packed, normal) : 1.0;
    for (int c = 0; c < 3; c++) light.color[c] = (float)(scale * gain * l->flux[c]);
    return light;
}

/* Photons of a bent surface lie on parts of it that face different ways. What comes from where only some of
 * them face was divided by the area of all of them, so that at n_v the lights make less irradiance than the
 * photons brought: on columns and mouldings a tenth. They are raised until they make it, but no more than
 * twofold. On the flat there is nothing to raise. A whole voxel's mean normal is no surface's own: there c_j
 * stays |V_j| sum Phi / sum Y(Phi). */
static const double raise_most = 2.0;

static void make_up_for_bends(const sl_lobe_photons *p, double scale, sl_vec3 normal, int count,
                              sl_directional_light *light) {
    double brought = 0.0, made = 0.0;
    for (size_t i = 0; i < p->count; i++) brought += scale * p->luminance[i];
    for (int j = 0; j < count; j++) {
        sl_rgb color = {light[j].color[0], light[j].color[1], light[j].color[2]};
        double cosine = (double)sl_dot(normal, sl_direction_unpack(light[j].packed));
        if (cosine > 0.0) made += cosine * (double)sl_luminance(color);
    }
    if (!(made > 0.0 && brought > made)) return;
    double gain = brought < raise_most * made ? brought / made : raise_most;
    for (int j = 0; j < count; j++) {
        for (int c = 0; c < 3; c++) light[j].color[c] = (float)(gain * (double)light[j].color[c]);
    }
}

static int directional_lights(const sl_lobe_photons *p, const sl_light_octree_settings *o, double scale,
                              sl_vec3 normal, int room, sl_directional_light *light, sl_lobe_spread *spread) {
    double sum = 0.0;
    for (size_t i = 0; i < p->count; i++) {
        p->weight[i] = o->unit_weights ? 1.0 : p->luminance[i] * p->inverse_cosine[i];
        sum += p->weight[i];
    }
    sl_directions directions = {p->count, p->x, p->y, p->z, p->weight};
    sl_clusters clusters;
    sl_cluster_directions(&directions, room < o->lights ? room : o->lights, p->of, p->nearest, &clusters);
    spread->cost += clusters.cost;
    spread->weight += sum;
    lobe lobes[SL_VOXEL_LIGHTS_MAX];
    sum_lobes(p, clusters.count, lobes);
    int count = 0;
    for (int j = 0; j < clusters.count; j++) {
        if (lobes[j].luminance > 0.0)
            light[count++] = light_of(&lobes[j], clusters.centre[j], o, scale, normal);
    }
    if (!o->whole_voxels && o->lobes == SL_LOBES_PERPENDICULAR)
        make_up_for_bends(p, scale, normal, count, light);
    return count;
}

/* ---- the other two ---- */

static int one_irradiance(const sl_lobe_photons *p, double scale, sl_directional_light *light) {
    double sum[3] = {0};
    for (size_t i = 0; i < p->count; i++) {
        for (int c = 0; c < 3; c++) sum[c] += (double)p->flux[c][i];
    }
    for (int c = 0; c < 3; c++) light->color[c] = (float)(scale * sum[c]);
    return 1;
}

/* One light along the normal, which makes the same irradiance there. */
static int light_along_normal(const sl_lobe_photons *p, double scale, sl_vec3 normal,
                         sl_directional_light *light) {
    sl_vec3d d = sl_to_double(normal);
    light->packed = sl_direction_pack(d);
    return one_irradiance(p, scale * packing_gain(d, light->packed, normal), light);
}

int sl_lobe_texels(const sl_light_octree_settings *o) { return o->lobes == SL_LOBES_NONE ? 1 : o->lights; }

int sl_lobes_of_photons(const sl_lobe_photons *p, const sl_light_octree_settings *o, double scale,
                        sl_vec3 normal, bool flat, int room, sl_directional_light *light,
                        sl_lobe_spread *spread) {
    if (p->count == 0 || room < 1 || !(scale > 0.0 && scale <= DBL_MAX)) return 0;
    if (flat) return light_along_normal(p, scale, normal, light);
    if (o->lobes == SL_LOBES_NONE) return one_irradiance(p, scale, light);
    return directional_lights(p, o, scale, normal, room, light, spread);
}
