#include "scene/copy.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"

/* Everything that sl_scene_set_time() and sl_scene_derive() write to. */
enum { MOVED = 13 };

typedef struct moved_array {
    /* where the scene keeps it, whatever it points to: read and written as bytes */
    void *pointer;
    size_t bytes;
} moved_array;

static size_t emissive_triangles(const sl_scene *s) {
    size_t count = 0;
    for (size_t t = 0; t < s->triangle_count; t++)
        count += sl_material_is_emitter(&s->materials[s->material_index[t]]);
    return count;
}

static void list_moved(sl_scene *s, moved_array list[MOVED]) {
    float **by_vertex[] = {&s->position_x, &s->position_y, &s->position_z,
                           &s->normal_x,   &s->normal_y,   &s->normal_z};
    float **by_triangle[] = {&s->geometric_normal_x, &s->geometric_normal_y, &s->geometric_normal_z};
    size_t n = 0;
    for (int k = 0; k < 6; k++) list[n++] = (moved_array){by_vertex[k], s->vertex_count * sizeof(float)};
    for (int k = 0; k < 3; k++) list[n++] = (moved_array){by_triangle[k], s->triangle_count * sizeof(float)};
    list[n++] = (moved_array){&s->emitter_of_triangle, s->triangle_count * sizeof *s->emitter_of_triangle};
    list[n++] = (moved_array){&s->emitters, emissive_triangles(s) * sizeof *s->emitters};
    list[n++] = (moved_array){&s->lights, s->light_count * sizeof *s->lights};
    list[n++] = (moved_array){&s->bicubics, s->bicubic_count * sizeof *s->bicubics};
}

size_t sl_scene_copy_bytes(const sl_scene *scene) {
    sl_scene s = *scene; /* whose pointers are listed, and not followed */
    moved_array moved[MOVED];
    size_t bytes = sizeof s;
    list_moved(&s, moved);
    for (int k = 0; k < MOVED; k++) bytes += moved[k].bytes;
    return bytes;
}

sl_status sl_scene_copy(const sl_scene *scene, sl_scene **scene_copy, sl_error *error) {
    *scene_copy = NULL;
    sl_scene *t = sl_allocate(1, sizeof *t);
    if (!t) return sl_fail_memory(error, "a copy of the scene");
    *t = *scene;
    moved_array moved[MOVED];
    list_moved(t, moved);
    bool ok = true;
    for (int k = 0; k < MOVED; k++) {
        void *from, *own = ok ? sl_allocate(moved[k].bytes, 1) : NULL;
        memcpy(&from, moved[k].pointer, sizeof from);
        if (own && moved[k].bytes) memcpy(own, from, moved[k].bytes);
        memcpy(moved[k].pointer, &own, sizeof own);
        ok = own != NULL;
    }
    if (ok) {
        *scene_copy = t;
        return SL_OK;
    }
    sl_scene_copy_destroy(t);
    return sl_fail_memory(error, "a copy of the scene");
}

void sl_scene_copy_destroy(sl_scene *scene_copy) {
    if (!scene_copy) return;
    moved_array moved[MOVED];
    list_moved(scene_copy, moved);
    for (int k = 0; k < MOVED; k++) {
        void *own;
        memcpy(&own, moved[k].pointer, sizeof own);
        sl_free(own);
    }
    sl_free(scene_copy);
}
