#include "app/steps/narrative.h"

#include <string.h>

/* narratives.json, as the linker has put it in. */
extern const char _binary_src_app_steps_narratives_json_start[], _binary_src_app_steps_narratives_json_end[];

static const char *text_of(const cJSON *object, const char *name) {
    return cJSON_GetStringValue(cJSON_GetObjectItem(object, name));
}

cJSON *sl_narrative_of(const char *method) {
    const char *begin = _binary_src_app_steps_narratives_json_start;
    cJSON *all = cJSON_ParseWithLength(begin, (size_t)(_binary_src_app_steps_narratives_json_end - begin));
    cJSON *narrative = all ? all->child : NULL;
    while (narrative && strcmp(text_of(narrative, "method"), method) != 0) narrative = narrative->next;
    if (narrative) cJSON_DetachItemViaPointer(all, narrative);
    cJSON_Delete(all);
    return narrative;
}

/* A pass has the entry that the longest beginning of its name has. */
const cJSON *sl_narrative_find(const cJSON *narrative, const char *pass, size_t *place) {
    const cJSON *best = NULL, *entry;
    size_t longest = 0, i = 0;
    cJSON_ArrayForEach(entry, cJSON_GetObjectItem(narrative, "passes")) {
        size_t length = strlen(text_of(entry, "pass"));
        if (strncmp(text_of(entry, "pass"), pass, length) == 0 && length > longest)
            best = entry, longest = length, *place = i;
        i++;
    }
    return best;
}

sl_show sl_narrative_show(const cJSON *pass) {
    static const char *const words[] = {"light", "colour", "scalar", "normals", "positions", "ids"};
    int show = SL_SHOW_LIGHT;
    while (show < SL_SHOW_IDS && strcmp(words[show], text_of(pass, "show")) != 0) show++;
    return (sl_show)show;
}
