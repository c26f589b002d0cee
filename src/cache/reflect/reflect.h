/* Pixels that show a mirror show what it reflects: rays are followed from mirror to mirror, and what they
 * find takes the mirror's place in the G-buffer. */
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
} sl_reflections;

/* Changes all planes of the G-buffer but depth, and tells from where its surfaces are seen; nothing in sight:
 * id and material SL_NO_INDEX. Depth stays the mirror's. NULL in *reflections where no pixel shows a mirror.
 * tracer NULL: mirrors show the environment along the reflected view vector, and nothing that stands in the
 * way. */
sl_status sl_reflect_pixels(const sl_scene *scene, const sl_tracer *tracer, unsigned threads,
                            sl_gbuffer *gbuffer, sl_reflections **reflections, sl_counters *counters,
                            sl_error *error);
/* Pixel i shows this surface; nothing where the triangle is SL_NO_INDEX. Depth stays. */
void sl_gbuffer_show(const sl_scene *scene, sl_gbuffer *g, size_t i, uint32_t triangle, const sl_surface *s);
/* Returns what the mirrors before a pixel leave of its light: 1 where there are none, or no reflections at
 * all (NULL). */
sl_rgb sl_reflections_throughput(const sl_reflections *reflections, size_t pixel);
void sl_reflections_destroy(sl_reflections *reflections);

#endif
