#include "app/steps/narrative.h"

#include "image/color.h"

#include <math.h>
#include <string.h>

/* ---- the text ---- */

/* The ways in which a pass's buffer becomes a picture: the words of "show", in their order. */
typedef enum show_as {
    SHOW_LIGHT,     /* radiance or irradiance, tone-mapped */
    SHOW_COLOUR,    /* reflectances, as they are */
    SHOW_SCALAR,    /* from dark to bright between the least and the greatest value */
    SHOW_NORMALS,   /* (n + 1) / 2 */
    SHOW_POSITIONS, /* scaled into the box of what is seen */
    SHOW_IDS        /* distinct colours */
} show_as;

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

const cJSON *sl_narrative_pass(const cJSON *narrative, const char *pass, size_t *place) {
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

static show_as way_told(const cJSON *pass) {
    static const char *const words[] = {"light", "colour", "scalar", "normals", "positions", "ids"};
    int show = SHOW_LIGHT;
    while (show < SHOW_IDS && strcmp(words[show], text_of(pass, "show")) != 0) show++;
    return (show_as)show;
}

/* ---- a buffer as a picture ---- */

/* Linear light that a PNG stores as this displayed level. */
static float displayed(float level) { return sl_srgb_decode(fminf(fmaxf(level, 0.0f), 1.0f)); }

static void range_of(const float *plane, size_t count, float *least, float *greatest) {
    *least = INFINITY, *greatest = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(plane[i])) continue;
        *least = fminf(*least, plane[i]);
        *greatest = fmaxf(*greatest, plane[i]);
    }
}

/* Values between the extremes as brightness; one value everywhere as grey, what is not finite as black. */
static void show_scalar(const float *in, size_t count, float *out) {
    float least, greatest;
    range_of(in, count, &least, &greatest);
    float width = greatest - least;
    for (size_t i = 0; i < count; i++) {
        float level = width > 0.0f ? (in[i] - least) / width : 0.5f;
        out[i] = isfinite(in[i]) ? displayed(level) : 0.0f;
    }
}

static void show_normals(const float *in, size_t count, float *out) {
    for (size_t i = 0; i < count; i++) out[i] = isfinite(in[i]) ? displayed(0.5f + 0.5f * in[i]) : 0.0f;
}

/* A colour for a number, far from those of its neighbours; nothing (0xffffffff or negative) is black. */
static void show_ids(const float *in, size_t count, float *const out[3]) {
    for (size_t i = 0; i < count; i++) {
        bool something = isfinite(in[i]) && in[i] >= 0.0f && in[i] < 4.0e9f;
        uint32_t h = something ? (uint32_t)in[i] * 2654435761u : 0;
        h ^= h >> 15;
        h *= 2246822519u;
        for (int c = 0; c < 3; c++)
            out[c][i] = something ? displayed(0.2f + 0.75f * (float)((h >> (8 * c)) & 255u) / 255.0f) : 0.0f;
    }
}

/* Light where nothing else is known of three channels, brightness of one. */
static show_as way_to_show(const sl_image *buffer, const cJSON *told) {
    if (told) return way_told(told);
    return buffer->channels >= 3 ? SHOW_LIGHT : SHOW_SCALAR;
}

sl_status sl_pass_picture(const sl_image *buffer, const cJSON *told, sl_image **picture, bool *tone,
                          sl_error *error) {
    const show_as show = way_to_show(buffer, told);
    *tone = show == SHOW_LIGHT;
    sl_status status = sl_image_create(buffer->width, buffer->height, 3, NULL, picture, error);
    if (status != SL_OK) return status;
    size_t count = (size_t)buffer->width * (size_t)buffer->height;
    float *out[3];
    for (size_t c = 0; c < 3; c++) {
        const float *in = buffer->planes + (buffer->channels >= 3 ? c : 0) * count;
        out[c] = (*picture)->planes + c * count;
        if (show == SHOW_SCALAR || show == SHOW_POSITIONS) show_scalar(in, count, out[c]);
        else if (show == SHOW_NORMALS) show_normals(in, count, out[c]);
        else memcpy(out[c], in, count * sizeof *in);
    }
    if (show == SHOW_IDS) show_ids(buffer->planes, count, out);
    return SL_OK;
}
