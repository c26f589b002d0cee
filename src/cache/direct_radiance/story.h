/* What made a pixel: which photons of the map, and how much each. */
#ifndef SL_CACHE_DIRECT_RADIANCE_STORY_H
#define SL_CACHE_DIRECT_RADIANCE_STORY_H

#include "cache/frame/announce.h"
#include "cache/direct_radiance/light_tiles.h"
#include "cache/frame/method.h"

/* What all stories of a picture share. */
typedef struct sl_radiance_story sl_radiance_story;

/* light: pass 7's, whose lights and photons (or NULL) must outlive it. view, planar, reflections: as sl_receivers_render() took them for the picture. */
sl_status sl_radiance_story_create(const sl_light_pass *light, const sl_raster *raster, const sl_view *view, const sl_mirrors *planar,
                                   int reflections, sl_radiance_story **story, sl_error *error);
void sl_radiance_story_destroy(sl_radiance_story *story);
size_t sl_radiance_story_bytes(const sl_radiance_story *story);
/* Column x, row y from the bottom. */
void sl_radiance_story_tell(const sl_radiance_story *story, int x, int y, sl_story_writer *writer);

/* Photons as points, coloured by their flux; nothing without an observer. */
void sl_announce_photons(sl_announcer *announcer, const sl_map_photons *photons);

#endif
