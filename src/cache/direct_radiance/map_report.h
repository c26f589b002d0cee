/* What direct radiance maps leave out or count twice, told with every picture: the share of the lights' flux that they hold, the share of
 * the photons' flux that arrives somewhere (more than 1 where missing indirect shadows let it arrive behind what should stop it), and whether
 * (15) can mean anything in a scene of that size. */
#ifndef SL_CACHE_DIRECT_RADIANCE_MAP_REPORT_H
#define SL_CACHE_DIRECT_RADIANCE_MAP_REPORT_H

#include "cache/direct_radiance/light_openings.h"
#include "cache/direct_radiance/light_receivers.h"

typedef struct sl_map_report {
    double captured; /* sl_radiance_map_captured() of all lights together, by their flux; directional ones, of unknown flux, aside */
    double received; /* integral of E dA over both sides of all that receives light, over rho Phi: in a closed room without anything in
                        it 1 (less what the weight loses), beyond that excess. NaN where there is nothing to divide by */
    double way;      /* mean b of the map's texels; 0 without any */
    double diagonal; /* of the scene */
    sl_light_openings openings; /* of area lights */
} sl_map_report;

/* Points all over a scene's receiving surfaces, as many to a square metre everywhere, that stay where they are on their triangles when
 * these move. */
typedef struct sl_report_points sl_report_points;
sl_status sl_report_points_spread(const sl_scene *scene, sl_report_points **points, sl_error *error);
/* After objects have moved: spreads them anew if that has changed how much area there is by more than a hundredth. NULL is allowed. */
void sl_report_points_follow(sl_report_points *points);
void sl_report_points_destroy(sl_report_points *points);
size_t sl_report_points_bytes(const sl_report_points *points);

double sl_radiance_maps_captured(const sl_radiance_map *map);
double sl_radiance_map_mean_way(const sl_radiance_map *map);
/* *received by the pass's weight and photons, without visibility. The points' places are read from the scene anew. */
sl_status sl_flux_received(const sl_light_pass *pass, sl_report_points *points, double *received, sl_error *error);

/* (15) divides by the square of the scene's diagonal: in a scene more than ten times as large as the way of the light there is next to
 * nothing left. One line; empty where there is nothing to say. */
void sl_map_report_warning(const sl_map_report *report, sl_photon_weight weight, char *text, size_t size);
/* Metadata of a picture: softlux.flux_captured, softlux.flux_received, softlux.warning. The latter tells also of maps that hold less
 * than half of the flux, of photons whose flux arrives more than 1.25 times, and of points that bars have moved. */
sl_status sl_map_report_stamp(const sl_map_report *report, sl_photon_weight weight, sl_image *image, sl_error *error);

#endif
