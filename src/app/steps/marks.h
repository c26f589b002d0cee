/* Marks that a pass leaves in the scene, drawn over the picture of the camera as SVG. */
#pragma once

#include "scene/scene.h"
#include "trace/trace.h"

#include <stdio.h>

/* The view in which marks are drawn: a camera, a picture's size, and rays that tell what is hidden (NULL:
 * nothing). */
typedef struct sl_mark_view {
    sl_camera camera;
    int width, height;
    const sl_tracer *tracer;
    float scale; /* of the scene */
} sl_mark_view;

/* Column and row, from the top, of a point; false: behind the eye. */
bool sl_mark_project(const sl_mark_view *view, const float at[3], double *column, double *row);
/* Tells whether something else lies in front of a point of a surface. */
bool sl_mark_is_hidden(const sl_mark_view *view, const float at[3]);
typedef struct sl_marks {
    const sl_mark_view *view;
    const sl_mark *marks;
    size_t count, limit;
} sl_marks;

/* Prints SVG elements for the visible ones among at most `limit` of sl_marks, evenly chosen. */
void sl_marks_put(FILE *out, const void *marks);
