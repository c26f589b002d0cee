/* The film: a pixel is the mean over its square, taken from sub-frames: pictures whose samples lie beside the
 * pixels' centres, as an accumulation buffer takes them (Haeberli and Akeley 1990). Methods draw a sub-frame
 * as they draw a view; their caches belong to the scene and stay.
 *
 * The first sub-frames, the pilot, are whole pictures: four, or one where there are no more than four in all.
 * Others are drawn where they matter alone: at edges, which geometry tells (raster/views/outlines.h), and
 * where the pilot's samples differ. Behind four, how many samples a pixel gets is settled when the pilot is
 * there, in such a way that the mean stays unbiased. */
#pragma once

#include "cache/frame/settings.h"
#include "raster/raster.h"
#include "scene/scene.h"

typedef struct sl_film sl_film;

/* For pictures of that scene, as large as settings say, with at most settings->sub_samples a pixel. asks: the
 * method's cache grows by what is seen, and has to be asked before any sub-frame is shown. */
sl_status sl_film_create(const sl_scene *scene, const sl_settings *settings, bool asks, sl_film **film,
                         sl_error *error);
void sl_film_destroy(sl_film *film);
/* Begins a picture; objects_moved: since the last one. */
void sl_film_begin(sl_film *film, bool objects_moved);
/* Tells the sub-frame to draw next. False: the picture is whole. */
bool sl_film_next(const sl_film *film, sl_sub_frame *next);
/* The next one is drawn: its picture, rows from the top; NULL where it was only asked for. raster: of the
 * scene. */
sl_status sl_film_add(sl_film *film, const sl_raster *raster, const sl_image *picture, sl_error *error);
/* Returns how many sub-frames, from the next one on, could be drawn in any order and elsewhere, since none
 * asks, and none tells which there are; *first: the number of the next one. */
unsigned sl_film_ahead(const sl_film *film, unsigned *first);
/* Returns the one that is so many behind the next. Its pixels are listed in the film until another is. */
sl_sub_frame sl_film_at(sl_film *film, unsigned ahead);
/* Packs what sub-frame `first` and those behind it show of a picture; packed (NULL: nothing is written) has
 * as many floats as are returned. */
size_t sl_film_pack(const sl_film *film, unsigned first, const sl_image *picture, float *packed);
void sl_film_unpack(const sl_film *film, unsigned first, const float *packed, sl_image *picture);
/* Makes a picture to unpack into, of any values. The caller destroys it. */
sl_status sl_film_picture(const sl_film *film, sl_image **picture, sl_error *error);
/* Counts what was counted elsewhere. */
void sl_film_count(sl_film *film, const sl_counters *counted);
/* Returns what the film has counted on top of the method's own; valid until the next call. */
const sl_counters *sl_film_counters(sl_film *film, const sl_counters *of_method);
/* Returns how much of the picture is there, by sub-frames. */
double sl_film_share(const sl_film *film);
/* False: no sub-frame is there. */
bool sl_film_has_picture(const sl_film *film);
/* The mean of the samples that are there, of every channel, with the first sub-frame's metadata; where there
 * are layers, one more tells how many samples each pixel is the mean of. The caller destroys it. */
sl_status sl_film_develop(const sl_film *film, sl_image **image, sl_error *error);
size_t sl_film_bytes(const sl_film *film);
/* An upper estimate of that, and of what its making takes besides, before anything is there. */
double sl_film_need(const sl_scene *scene, const sl_settings *settings);
