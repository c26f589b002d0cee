/* Pixels that show a mirror show what it reflects: rays are followed from mirror to mirror, and what they
 * find takes the mirror's place in the G-buffer. And the picture that a G-buffer shows, mirrors included. */
#pragma once

#include "raster/raster.h"
#include "trace/trace.h"

typedef struct sl_reflections {
    size_t count;            /* mirror pixels of the picture */
    uint32_t *pixel;         /* which, ascending */
    sl_rgb *throughput;      /* product of the mirrors' reflectances */
    sl_rgb *background;      /* of rays that left the scene: the environment, throughput included; else 0 */
    float *way;              /* from the viewer to what is shown, mirror by mirror */
} sl_reflections;

/* From where a G-buffer is seen: a point, or from afar along one direction. */
typedef struct sl_viewer {
    sl_vec3 eye;
    sl_vec3 along;           /* unit: all look that way, from the plane through the eye; 0: from the eye */
} sl_viewer;

/* Changes all planes of the G-buffer but depth, and tells from where its surfaces are seen; nothing in sight:
 * id and material SL_NO_INDEX. Depth stays the mirror's. NULL in *reflections where no pixel shows a mirror.
 * tracer NULL: mirrors show the environment along the reflected view vector, and nothing that stands in the
 * way. */
sl_status sl_reflect_pixels(const sl_scene *scene, const sl_tracer *tracer, unsigned threads,
                            sl_gbuffer *gbuffer, sl_reflections **reflections, sl_counters *counters,
                            sl_error *error);
/* The same of what another than the camera sees. */
sl_status sl_reflect_seen(const sl_scene *scene, const sl_tracer *tracer, unsigned threads,
                          const sl_viewer *viewer, sl_gbuffer *gbuffer, sl_reflections **reflections,
                          sl_counters *counters, sl_error *error);
/* Pixel i shows this surface; nothing where the triangle is SL_NO_INDEX. Depth stays. */
void sl_gbuffer_show(const sl_scene *scene, sl_gbuffer *g, size_t i, uint32_t triangle, const sl_surface *s);
/* Returns what the mirrors before a pixel leave of its light: 1 where there are none, or no reflections at
 * all (NULL). */
sl_rgb sl_reflections_throughput(const sl_reflections *reflections, size_t pixel);
void sl_reflections_destroy(sl_reflections *reflections);

/* ---- a picture of what a G-buffer shows (compose.c) ---- */

/* One kind of light: radiance of the G-buffer's pixels as if there were no mirrors before them, and the first
 * of the three channels of the picture that show it. */
typedef struct sl_light_layer {
    const float *radiance[3];
    int channel;
} sl_light_layer;

/* The channels of a picture with direct and indirect light as its layers, and their names. */
enum {
    SL_COMPOSED_LAYERS = 3,
    SL_COMPOSED_EMISSION = 3,
    SL_COMPOSED_DIRECT = 6,
    SL_COMPOSED_INDIRECT = 9,
    SL_COMPOSED_CHANNELS = 12
};
extern const char *const sl_composed_names[SL_COMPOSED_CHANNELS];

/* R, G and B are the sum of what is seen without further reflection (L S* E: L_e on the shining side of
 * emitters, or the environment), which is the channels from SL_COMPOSED_EMISSION on, and of all layers, times
 * what mirrors leave of each. A picture of three channels has the sum alone. */
typedef struct sl_composition {
    const sl_scene *scene;
    const sl_view *view;
    const sl_gbuffer *gbuffer; /* of the view's rows from first_row on */
    int first_row;
    const sl_reflections *reflections; /* or NULL */
    sl_light_layer layer[SL_COMPOSED_LAYERS]; /* no channel: none */
    sl_image *image;
} sl_composition;

/* Composes what the sub-frame shows of one row of the G-buffer, which counts from the bottom as on the
 * hardware; images have row 0 at the top. Then come the pixels that show mirrors. */
void sl_compose_row(const sl_composition *composition, int row);
void sl_compose_mirrors(const sl_composition *composition);
/* All of it. */
void sl_compose_picture(const sl_composition *composition, unsigned threads);
