#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/print.h"
#include "cache/direct_radiance/direct_radiance.h"
#include "scene/ambient.h"

#include <math.h>

/* each point is two receivers, one on either side */
enum { TILES = 16, POINTS = TILES * SL_TILE_PIXELS / 2 };

/* (15) is of no use in scenes so many times as large as the light's way. */
static const double LARGEST_SCENE = 10.0;
/* A frustum that misses half of the light is worth a line; in a room without anything in it 1 arrives, with
 * two boxes 1.07. */
static const double LEAST_CAPTURED = 0.5, MOST_RECEIVED = 1.25;

/* ---- points all over the scene ---- */

typedef struct report_point {
    uint32_t triangle;
    float w1, w2;
} report_point;

typedef struct {
    const sl_scene *scene;
    double share; /* of the receiving area for each point; 0: nothing receives */
    report_point point[POINTS];
} report_points;

static double receiving_area(const sl_scene *s, uint32_t t) {
    const sl_material *m = sl_triangle_material(s, t);
    return sl_material_is_diffuse(m) || sl_material_is_glossy(m) ? sl_triangle_area(s, t) : 0.0;
}

/* Returns a point, uniform over a triangle, from two numbers in [0,1): along it the point's number among
 * those of the same triangle, across it multiples of the golden ratio, so that a wall of two triangles is
 * covered as evenly as a mesh of thousands. */
static report_point point_in(uint32_t triangle, double along, size_t index) {
    double across = (double)index * 0.61803398874989485, side = sqrt(along);
    across -= floor(across);
    return (report_point){triangle, (float)(side * (1.0 - across)), (float)(side * across)};
}

static double all_area(const sl_scene *scene) {
    double total = 0.0;
    for (uint32_t t = 0; t < scene->triangle_count; t++) total += receiving_area(scene, t);
    return total;
}

/* Takes the middles of equal shares of all area, triangle after triangle. */
static void spread(const sl_scene *scene, report_points *points) {
    double total = all_area(scene), before = 0.0;
    size_t next = 0;
    points->scene = scene;
    points->share = total / POINTS;
    for (uint32_t t = 0; t < scene->triangle_count && total > 0.0; t++) {
        double area = receiving_area(scene, t);
        for (; next < POINTS && ((double)next + 0.5) * points->share < before + area; next++)
            points->point[next] =
                point_in(t, (((double)next + 0.5) * points->share - before) / area, next);
        before += area;
    }
    /* rounding of the sums */
    for (size_t k = next; k < POINTS; k++) points->point[k] = k ? points->point[k - 1] : (report_point){0};
}

/* ---- how much of the photons' flux arrives ---- */

static void put_receiver(sl_receiver_tile *tile, size_t i, sl_vec3 p, sl_vec3 n) {
    sl_put(tile->x, tile->y, tile->z, i, p);
    sl_put(tile->geometric_x, tile->geometric_y, tile->geometric_z, i, n);
    sl_put(tile->normal_x, tile->normal_y, tile->normal_z, i, n);
}

/* Fronts in even lanes, backs in odd ones. */
static void fill(const report_points *points, size_t tile_index, sl_receiver_tile *tile) {
    const sl_scene *s = points->scene;
    *tile = (sl_receiver_tile){.count = SL_TILE_PIXELS, .padded = SL_TILE_PIXELS};
    for (size_t i = 0; i < SL_TILE_PIXELS / 2; i++) {
        const report_point *r = &points->point[tile_index * (SL_TILE_PIXELS / 2) + i];
        sl_vec3 corner[3], n = sl_scene_geometric_normal(s, r->triangle);
        for (int c = 0; c < 3; c++) corner[c] = sl_scene_position(s, s->vertex[c][r->triangle]);
        sl_vec3 p = sl_mad(sl_mad(corner[0], r->w1, sl_sub(corner[1], corner[0])), r->w2,
                           sl_sub(corner[2], corner[0]));
        put_receiver(tile, 2 * i, p, n);
        put_receiver(tile, 2 * i + 1, p, sl_neg(n));
    }
}

typedef struct {
    const report_points *points;
    const sl_photon_sums *sums;
    double arriving[TILES]; /* W */
} receiving;

static void receive_tile(void *context, size_t index, unsigned worker) {
    (void)worker;
    receiving *r = context;
    sl_receiver_tile tile;
    sl_tile_light light;
    double sum = 0.0;
    fill(r->points, index, &tile);
    sl_photon_sums_irradiance(r->sums, &tile, &light);
    for (size_t i = 0; i < SL_TILE_PIXELS; i++) {
        const sl_rgb e = {light.irradiance[0][i], light.irradiance[1][i], light.irradiance[2][i]};
        sum += (double)sl_luminance(e) * r->points->share;
    }
    r->arriving[index] = sum;
}

/* rho Phi: pi Psi, or what a material with a lobe reflects of what it receives. */
static double reflected_flux(const sl_map_photons *photons) {
    double sum = 0.0;
    for (size_t j = 0; j < photons->count; j++) {
        sl_rgb flux = photons->photon[j].flux;
        if (photons->lobe)
            flux = sl_rgb_mul(flux, sl_rgb_add(photons->lobe[j].diffuse, photons->lobe[j].specular));
        double watts = (double)sl_luminance(flux) * (photons->lobe ? 1.0 : SL_PI);
        sum += isfinite(watts) ? watts : 0.0;
    }
    return sum;
}

sl_status sl_flux_received(const sl_light_pass *pass, double *received, sl_error *error) {
    *received = NAN;
    const double sent = pass->photons ? reflected_flux(pass->photons) : 0.0;
    if (!(sent > 0.0)) return SL_OK;
    report_points *points = sl_allocate(1, sizeof *points);
    sl_photon_sums *sums = NULL;
    sl_status status = points ? sl_photon_sums_create(pass, &sums, error)
                              : sl_fail_memory(error, "points of a report");
    if (status == SL_OK) {
        receiving r = {.points = points, .sums = sums};
        double sum = 0.0;
        spread(pass->scene, points);
        sl_parallel_for(sl_thread_count(pass->threads), TILES, receive_tile, &r);
        for (size_t i = 0; i < TILES; i++) sum += r.arriving[i];
        if (points->share > 0.0) *received = sum / sent;
    }
    sl_photon_sums_destroy(sums);
    sl_free(points);
    return status;
}

/* ---- told with the picture ---- */

/* Returns the mean b of the map's texels; 0 without any. */
static double mean_way(const sl_radiance_map *map) {
    double sum = 0.0;
    size_t count = 0;
    for (size_t i = 0; i < map->texels; i++) {
        if (map->triangle[i] == SL_NO_INDEX || !isfinite(map->path[i])) continue;
        sum += (double)map->path[i];
        count++;
    }
    return count ? sum / (double)count : 0.0;
}

static sl_status warn_of_size(const sl_radiance_state *s, sl_image *image, sl_error *error) {
    const double way = mean_way(s->map), diagonal = (double)s->scene->diagonal;
    if (!(way > 0.0) || diagonal <= LARGEST_SCENE * way) return SL_OK;
    return sl_warn(image, error,
                   "weight 15 divides by the scene's diagonal squared, which is %.3g times the light's mean "
                   "way of %.3g: next to no indirect light; weight flux does not depend on the scene's size",
                   diagonal / way, way);
}

static sl_status stamp_share(sl_image *image, const char *key, double share, sl_error *error) {
    char text[32];
    sl_print(text, sizeof text, "%.4f", share);
    return isfinite(share) ? sl_image_set_metadata(image, key, text, error) : SL_OK;
}

static sl_status warn_of_flux(double captured, double received, sl_image *image, sl_error *error) {
    sl_status status = SL_OK;
    if (captured < LEAST_CAPTURED)
        status = sl_warn(image, error,
                         "the maps hold %.0f %% of the lights' flux, and no indirect light comes from the "
                         "rest; --set direct-radiance.map=cube holds all",
                         100.0 * captured);
    if (status == SL_OK && received > MOST_RECEIVED)
        status = sl_warn(image, error,
                         "indirect light passes through walls and furniture: what is reflected arrives %.2g "
                         "times; --visibility rays "
                         "stops it",
                         received);
    return status;
}

sl_status sl_radiance_stamp(const sl_radiance_state *s, sl_image *image, sl_error *error) {
    sl_status status = stamp_share(image, "softlux.flux_captured", s->map->captured, error);
    if (status == SL_OK) status = stamp_share(image, "softlux.flux_received", s->received, error);
    if (status == SL_OK && s->settings.radiance_map.weight == SL_WEIGHT_BOX)
        status = warn_of_size(s, image, error);
    return status == SL_OK ? warn_of_flux(s->map->captured, s->received, image, error) : status;
}
