/* Along the Morton curve through the triangles' centres. */
#include "trace/triangle_order.h"

#include "base/code_sort.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/morton.h"

enum { AXIS_BITS = 20 };

/* Along one axis, from the scene's low end in units of its largest extent. */
static uint64_t cell(float a, float b, float c, float low, double extent) {
    double middle = ((double)a + (double)b + (double)c) / 3.0 - (double)low;
    double last = (double)((1 << AXIS_BITS) - 1), x = extent > 0.0 ? middle / extent * last : 0.0;
    return x > 0.0 ? (uint64_t)(x < last ? x : last) : 0; /* also where it is not a number */
}

static uint64_t morton_code(const sl_scene *s, size_t triangle, double extent) {
    sl_vec3 a = sl_scene_position(s, s->vertex[0][triangle]),
            b = sl_scene_position(s, s->vertex[1][triangle]);
    sl_vec3 c = sl_scene_position(s, s->vertex[2][triangle]);
    return sl_morton_code(cell(a.x, b.x, c.x, s->box_min.x, extent),
                          cell(a.y, b.y, c.y, s->box_min.y, extent),
                          cell(a.z, b.z, c.z, s->box_min.z, extent));
}

sl_status sl_triangle_order(const sl_scene *scene, uint32_t *order, size_t count, sl_error *error) {
    sl_coded *places = sl_allocate_unset(count, sizeof *places);
    if (!places) return sl_fail_memory(error, "the order of the tracer's triangles");
    sl_vec3d size = sl_subd(sl_to_double(scene->box_max), sl_to_double(scene->box_min));
    double extent = fmax(size.x, fmax(size.y, size.z));
    for (size_t i = 0; i < count; i++)
        places[i] = (sl_coded){morton_code(scene, order[i], extent), order[i]};
    sl_sort_coded(places, count);
    for (size_t i = 0; i < count; i++) order[i] = places[i].item;
    sl_free(places);
    return SL_OK;
}
