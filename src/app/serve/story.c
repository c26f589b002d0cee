/* The story of a pixel: what made it, so that it adds up to the pixel's exact value, and the text, the
 * equation and the source of the passes that did. It is told by the thread that updates the method. */
#include "app/serve/stage_parts.h"

#include "app/steps/explanations.h"
#include "app/steps/narrative.h"
#include "base/error.h"

#include <stdlib.h>
#include <string.h>

enum { TOLD = 24 }; /* terms; the smaller ones are told as one */

typedef struct story {
    sl_mail *mail;
    unsigned client;
    int side, x, y;
    sl_mark_view view;
} story;

/* ---- terms ---- */

static void add_term(cJSON *list, const sl_mark_view *view, const sl_explanation_term *t) {
    cJSON *o = cJSON_CreateObject();
    double at[2];
    cJSON_AddStringToObject(o, "layer", t->layer);
    cJSON_AddStringToObject(o, "kind", t->kind);
    cJSON_AddNumberToObject(o, "index", (double)t->index);
    cJSON_AddNumberToObject(o, "weight", t->weight);
    sl_add_floats(o, "value", t->value, 3);
    sl_add_numbers(o, "contribution", t->contribution, 3);
    if (t->placed && sl_mark_project(view, t->position, &at[0], &at[1])) sl_add_numbers(o, "at", at, 2);
    cJSON_AddItemToArray(list, o);
}

static void add_terms(cJSON *m, const sl_mark_view *view, sl_explanation *e) {
    cJSON *list = cJSON_AddArrayToObject(m, "terms");
    sl_explanation_fold(e, TOLD);
    for (size_t i = 0; i < e->count; i++) add_term(list, view, &e->terms[i]);
}

/* ---- what is told of passes ---- */

/* The functions, as the linker has put them in. */
extern const char _binary_sources_json_start[], _binary_sources_json_end[];

void sl_add_told(cJSON *to, const cJSON *told) {
    const char *const names[] = {"title", "equation", "code"};
    const char *const as[] = {"title", "equation", "function"};
    cJSON *text = told ? cJSON_GetObjectItem(told, "text") : NULL;
    for (int i = 0; i < 3 && told; i++) {
        const char *value = cJSON_GetStringValue(cJSON_GetObjectItem(told, names[i]));
        if (value) cJSON_AddStringToObject(to, as[i], value);
    }
    if (text) cJSON_AddItemToObject(to, "text", cJSON_Duplicate(text, true));
}

static void add_sources(cJSON *passes) {
    cJSON *all = cJSON_ParseWithLength(_binary_sources_json_start,
                                       (size_t)(_binary_sources_json_end - _binary_sources_json_start));
    cJSON *pass;
    cJSON_ArrayForEach(pass, passes) {
        const char *function = cJSON_GetStringValue(cJSON_GetObjectItem(pass, "function"));
        cJSON *source = function ? cJSON_GetObjectItemCaseSensitive(all, function) : NULL;
        if (source) cJSON_AddItemToObject(pass, "source", cJSON_Duplicate(source, true));
    }
    cJSON_Delete(all);
}

static bool has_layer(const sl_explanation *e, const char *layer) {
    for (size_t i = 0; i < e->count; i++)
        if (strcmp(e->terms[i].layer, layer) == 0) return true;
    return false;
}

/* The passes that made the layers which the pixel has. */
static void add_passes(cJSON *m, const char *method, const sl_explanation *e) {
    cJSON *narrative = sl_narrative_of(method), *paper = cJSON_GetObjectItem(narrative, "paper");
    cJSON *list = cJSON_AddArrayToObject(m, "passes");
    const cJSON *told;
    cJSON_ArrayForEach(told, cJSON_GetObjectItem(narrative, "passes")) {
        const char *layer = cJSON_GetStringValue(cJSON_GetObjectItem(told, "layer"));
        if (!layer || !has_layer(e, layer)) continue;
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "pass", cJSON_GetStringValue(cJSON_GetObjectItem(told, "pass")));
        cJSON_AddStringToObject(o, "layer", layer);
        sl_add_told(o, told);
        cJSON_AddItemToArray(list, o);
    }
    add_sources(list);
    if (paper) cJSON_AddItemToObject(m, "paper", cJSON_Duplicate(paper, true));
    cJSON_Delete(narrative);
}

/* ---- the visit ---- */

static cJSON *message_of(const story *y, const char *method, sl_explanation *e) {
    cJSON *m = sl_message_of_side("story", y->side);
    cJSON_AddNumberToObject(m, "x", y->x);
    cJSON_AddNumberToObject(m, "y", y->y);
    sl_add_floats(m, "pixel", e->pixel, 3);
    sl_add_numbers(m, "rounding", e->rounding, 3);
    add_passes(m, method, e);
    add_terms(m, &y->view, e);
    return m;
}

static void visit(void *context, sl_method *method) {
    story *y = context;
    sl_image *picture = NULL;
    sl_explanation *e = NULL;
    sl_error error;
    sl_status status = method ? sl_method_resolve(method, &picture, &error)
                              : sl_fail(&error, SL_ERROR_USAGE, "story: the method has ended");
    if (status == SL_OK) status = sl_method_explanation(method, picture, y->x, y->y, &e, &error);
    cJSON *m = status == SL_OK ? message_of(y, sl_image_metadata(picture, "softlux.method"), e)
                               : sl_refusal("story", &error);
    sl_mail_send(y->mail, sl_packet_text(y->client, m));
    sl_explanation_destroy(e);
    sl_image_destroy(picture);
    free(y);
}

sl_status sl_take_story(sl_stage *s, sl_taking *t) {
    int column, row;
    const int side = sl_take_side(t);
    if (sl_take_pixel(t, &s->side[0].settings, &column, &row) != SL_OK) return t->status;
    if (!s->side[side].live)
        return sl_fail(t->error, SL_ERROR_USAGE, "story: nothing is shown on that side");
    story *y = malloc(sizeof *y);
    if (!y) return sl_fail_memory(t->error, "a story");
    *y = (story){s->mail, s->client, side, column, row, sl_stage_view(s)};
    y->view.tracer = NULL;
    if (sl_live_visit(s->side[side].live, visit, y)) return SL_OK;
    free(y);
    return sl_fail(t->error, SL_ERROR_USAGE, "story: another one is being told");
}
