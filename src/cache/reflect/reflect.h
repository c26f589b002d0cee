/* Pixels that show a mirror show what it reflects: rays are followed from mirror to mirror, and what they
 * find takes the mirror's place in the G-buffer. And what a G-buffer's pixels emit, by way of mirrors too. */
#ifndef SL_CACHE_REFLECT_H
#define SL_CACHE_REFLECT_H

#include "raster/raster.h"
#include "trace/trace.h"

enum { SL_REFLECTIONS_MAX = 16 }; /* what two facing mirrors still show after that is black */

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
/* Returns light seen without further reflection, L S* E: of pixel (x, y) of a view, the G-buffer's i-th, L_e
 * on the shining side of emitters, or the environment; and of mirror pixel k what its mirrors leave of that.
 */
sl_rgb sl_gbuffer_emission(const sl_scene *scene, const sl_view *view, const sl_gbuffer *g, size_t i, int x,
                           int y);
sl_rgb sl_reflections_emission(const sl_scene *scene, const sl_gbuffer *g, const sl_reflections *reflections,
                               size_t k);
void sl_reflections_destroy(sl_reflections *reflections);

#endif
