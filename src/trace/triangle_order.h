/* The triangles of a scene in the order in which the tracer keeps them. */
#ifndef SL_TRACE_TRIANGLE_ORDER_H
#define SL_TRACE_TRIANGLE_ORDER_H

#include "scene/scene.h"

/* Puts `count` triangles in such an order that neighbours in space are near one another in memory: rays that
 * meet one triangle then find the next ones in the cache. No hit depends on it. */
sl_status sl_triangle_order(const sl_scene *scene, uint32_t *order, size_t count, sl_error *error);

#endif
