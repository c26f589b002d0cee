#include "app/steps/narrative.h"

#include <string.h>

const sl_narrative *sl_narrative_of(const char *method) {
    static const sl_narrative *const all[] = {&sl_splatting_narrative, &sl_direct_radiance_narrative,
                                              &sl_shading_cache_narrative, &sl_multi_mesh_narrative,
                                              &sl_light_octree_narrative};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        if (strcmp(all[i]->method, method) == 0) return all[i];
    return NULL;
}

const sl_narrative_pass *sl_narrative_find(const sl_narrative *narrative, const char *pass, size_t *place) {
    const sl_narrative_pass *best = NULL;
    size_t longest = 0;
    for (const sl_narrative_pass *p = narrative->passes; p->pass; p++) {
        size_t length = strlen(p->pass);
        if (strncmp(p->pass, pass, length) != 0 || (best && length <= longest)) continue;
        best = p, longest = length;
        *place = (size_t)(p - narrative->passes);
    }
    return best;
}
