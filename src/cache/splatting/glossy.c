#include "cache/splatting/glossy.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

#include <math.h>

/* Below this share a truncated lobe is as good as the interpolation between records. */
static const double largest_truncation = 0.05;

int sl_glossy_order_for(const sl_scene *scene) {
    int order = 1;
    for (size_t i = 0; i < scene->material_count; i++) {
        const sl_material *m = &scene->materials[i];
        if (!sl_material_is_glossy(m)) continue;
        int wanted = sl_phong_order((double)m->exponent, largest_truncation);
        if (wanted > order) order = wanted;
    }
    return order;
}

double sl_glossy_truncation(const sl_scene *scene, int order, double *exponent) {
    bool glossy = false;
    *exponent = 0.0;
    for (size_t i = 0; i < scene->material_count; i++) {
        const sl_material *m = &scene->materials[i];
        if (!sl_material_is_glossy(m)) continue;
        glossy = true;
        if ((double)m->exponent > *exponent) *exponent = (double)m->exponent;
    }
    /* Below an exponent of 1 it is no sharpness that the error tells of. */
    return glossy ? sl_phong_truncation(order, *exponent > 1.0 ? *exponent : 1.0) : 0.0;
}

static sl_status make_lobes(sl_glossy *glossy, const sl_scene *scene, sl_error *error) {
    sl_status status = SL_OK;
    glossy->material_count = scene->material_count;
    glossy->lobe = sl_allocate(scene->material_count, sizeof *glossy->lobe);
    glossy->made = sl_allocate(scene->material_count, sizeof *glossy->made);
    if (!glossy->lobe || !glossy->made) return sl_fail_memory(error, "glossy materials");
    for (size_t i = 0; status == SL_OK && i < scene->material_count; i++) {
        const float exponent = scene->materials[i].exponent;
        if (!sl_material_is_glossy(&scene->materials[i])) continue;
        for (size_t k = 0; k < i && !glossy->lobe[i]; k++)
            if (scene->materials[k].exponent == exponent) glossy->lobe[i] = glossy->lobe[k];
        if (glossy->lobe[i]) continue;
        status = sl_moved_lobe_create(glossy->order, (double)exponent, &glossy->lobe[i], error);
        if (status == SL_OK) glossy->made[glossy->made_count++] = glossy->lobe[i];
    }
    return status;
}

sl_status sl_glossy_create(const sl_scene *scene, int order, sl_glossy **out, sl_error *error) {
    *out = NULL;
    sl_glossy *glossy = sl_allocate(1, sizeof *glossy);
    if (!glossy) return sl_fail_memory(error, "glossy materials");
    glossy->order = order;
    glossy->even = sl_hsh_odd_start(order);
    glossy->stride = sl_hsh_stride(order);
    sl_status status = make_lobes(glossy, scene, error);
    if (status != SL_OK) {
        sl_glossy_destroy(glossy);
        return status;
    }
    *out = glossy;
    return SL_OK;
}

void sl_glossy_destroy(sl_glossy *glossy) {
    if (!glossy) return;
    for (size_t i = 0; i < glossy->made_count; i++) sl_moved_lobe_destroy(glossy->made[i]);
    SL_FREE_ALL(glossy->lobe, glossy->made, glossy);
}

size_t sl_glossy_bytes(const sl_glossy *glossy) {
    size_t bytes = sizeof *glossy + 2 * glossy->material_count * sizeof *glossy->lobe;
    for (size_t i = 0; i < glossy->made_count; i++) bytes += sl_moved_lobe_bytes(glossy->made[i]);
    return bytes;
}
