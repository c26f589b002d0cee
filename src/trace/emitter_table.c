#include "trace/emitter_table.h"

#include "base/error.h"
#include "base/memory.h"

#include <math.h>

sl_status sl_emitter_table_create(const sl_scene *scene, sl_emitter_table *t, sl_error *error) {
    enum { COLUMNS = 9 };
    size_t n = scene->emitter_count;
    t->block = sl_allocate(COLUMNS * n, sizeof *t->block);
    if (!t->block) return sl_fail_memory(error, "direct light");
    float **columns[COLUMNS] = {&t->x, &t->y, &t->z, &t->normal_x, &t->normal_y, &t->normal_z, &t->strength,
                                &t->extent_squared, &t->two_sided};
    for (size_t c = 0; c < COLUMNS; c++) *columns[c] = t->block + c * n;
    t->count = n;
    for (size_t i = 0; i < n; i++) {
        const sl_emitter *e = &scene->emitters[i];
        sl_vec3 corner[3], normal = sl_scene_geometric_normal(scene, e->triangle);
        for (int c = 0; c < 3; c++) corner[c] = sl_scene_position(scene, scene->vertex[c][e->triangle]);
        sl_vec3 centre = sl_scale(sl_add(sl_add(corner[0], corner[1]), corner[2]), 1.0f / 3.0f);
        t->x[i] = centre.x, t->y[i] = centre.y, t->z[i] = centre.z;
        t->normal_x[i] = normal.x, t->normal_y[i] = normal.y, t->normal_z[i] = normal.z;
        t->strength[i] = sl_rgb_mean(e->radiance) * e->area;
        t->two_sided[i] = e->two_sided ? 1.0f : 0.0f;
        for (int c = 0; c < 3; c++) {
            sl_vec3 d = sl_sub(corner[c], centre);
            t->extent_squared[i] = fmaxf(t->extent_squared[i], sl_dot(d, d));
        }
    }
    return SL_OK;
}

void sl_emitter_table_destroy(sl_emitter_table *table) { sl_free(table->block); }

float sl_emitter_importance(const sl_emitter_table *t, size_t i, sl_vec3 position, sl_vec3 normal) {
    float dx = t->x[i] - position.x, dy = t->y[i] - position.y, dz = t->z[i] - position.z;
    float squared = dx * dx + dy * dy + dz * dz, extent = t->extent_squared[i];
    float bounded = squared > extent ? squared : extent;
    float over = bounded > 0.0f ? 1.0f / sqrtf(bounded) : 0.0f;
    float above = normal.x * dx + normal.y * dy + normal.z * dz;
    float front = -(t->normal_x[i] * dx + t->normal_y[i] * dy + t->normal_z[i] * dz);
    if (t->two_sided[i] > 0.0f) front = fabsf(front);
    if (!(front > 0.0f) || above * fabsf(above) < -extent) return 0.0f;
    float cosine = above * over, cosine_emitter = front * over;
    cosine = cosine > 0.1f ? cosine : 0.1f;
    cosine_emitter = cosine_emitter > 0.1f ? cosine_emitter : 0.1f;
    return t->strength[i] * cosine * cosine_emitter * over * over;
}

void sl_emitters_weigh(const sl_emitter_table *table, sl_vec3 position, sl_vec3 normal,
                       sl_emitter_choice *choice) {
    double sum = 0.0;
    choice->count = table->count <= SL_EMITTER_CHOICES_MAX ? table->count : 0;
    for (size_t i = 0; i < choice->count; i++)
        choice->sums[i] = sum += (double)sl_emitter_importance(table, i, position, normal);
    if (!(sum > 0.0) || !isfinite(sum)) choice->count = 0;
}

size_t sl_emitters_choose(const sl_emitter_choice *choice, float u, float *chance) {
    double total = choice->sums[choice->count - 1], target = (double)u * total;
    size_t low = 0, high = choice->count - 1;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (target < choice->sums[middle]) high = middle;
        else low = middle + 1;
    }
    *chance = (float)((choice->sums[low] - (low ? choice->sums[low - 1] : 0.0)) / total);
    return low;
}
