#include "app/steps/explanations.h"

#include "app/page.h"
#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TERMS_SHOWN = 8 }; /* of a pixel; the smaller ones are told as one */

/* As the page's script reads it. */
typedef struct told_term {
    double index;
    float kind;        /* into kinds */
    float column, row; /* in the picture; NaN: nowhere */
    float weight, contribution[3], value[3];
} told_term;
_Static_assert(sizeof(told_term) == 48, "the script's stride");

typedef struct telling {
    const sl_mark_view *view;
    cJSON *kinds;
    FILE *terms;
    uint32_t term_count;
} telling;

static int kind_of(const telling *t, const sl_explanation_term *term) {
    const cJSON *kind;
    int number = 0;
    cJSON_ArrayForEach(kind, t->kinds) {
        if (strcmp(kind->child->valuestring, term->layer) == 0 &&
            strcmp(kind->child->next->valuestring, term->kind) == 0)
            return number;
        number++;
    }
    const char *const names[] = {term->layer, term->kind};
    cJSON_AddItemToArray(t->kinds, cJSON_CreateStringArray(names, 2));
    return number;
}

/* ---- the largest terms ---- */

static double size_of(const sl_explanation_term *t) {
    return fabs(t->contribution[0]) + fabs(t->contribution[1]) + fabs(t->contribution[2]);
}

/* Largest first; of equal ones by their names, so that the order is one. */
static int by_size(const void *a, const void *b) {
    const sl_explanation_term *x = a, *y = b;
    const double of_x = size_of(x), of_y = size_of(y);
    if (of_x != of_y) return of_x > of_y ? -1 : 1;
    if (x->index != y->index) return x->index < y->index ? -1 : 1;
    const int layers = strcmp(x->layer, y->layer);
    return layers ? layers : strcmp(x->kind, y->kind);
}

void sl_explanation_fold(sl_explanation *e, size_t most) {
    sl_explanation_term rest = {.layer = "several", .kind = "smaller ones, together"};
    if (e->count) qsort(e->terms, e->count, sizeof *e->terms, by_size); /* there may be no terms at all */
    if (e->count <= most) return;
    for (size_t i = most; i < e->count; i++) {
        rest.weight += e->terms[i].weight;
        for (int c = 0; c < 3; c++) rest.contribution[c] += e->terms[i].contribution[c];
    }
    e->terms[most] = rest;
    e->count = most + 1;
}

/* ---- terms as the page has them ---- */

static void add_term(telling *t, const sl_explanation_term *term, double left[3]) {
    told_term told = {.index = (double)term->index,
                      .kind = (float)kind_of(t, term),
                      .column = NAN,
                      .row = NAN,
                      .weight = (float)term->weight};
    double column, row;
    if (term->placed && sl_mark_project(t->view, term->position, &column, &row))
        told.column = (float)column, told.row = (float)row;
    for (int c = 0; c < 3; c++) {
        told.contribution[c] = (float)term->contribution[c];
        told.value[c] = term->value[c];
        left[c] -= (double)told.contribution[c];
    }
    t->term_count += (uint32_t)fwrite(&told, sizeof told, 1, t->terms);
}

/* Makes what is shown add up to the pixel, too: what is rounded to float goes to the rest. */
static void add_explanation(telling *t, sl_explanation *e, double left[3]) {
    sl_explanation_fold(e, TERMS_SHOWN);
    for (int c = 0; c < 3; c++) left[c] = (double)e->pixel[c];
    for (size_t i = 0; i < e->count; i++) add_term(t, &e->terms[i], left);
}

static void add_bytes(cJSON *to, const char *name, const void *bytes, size_t count) {
    char *text = sl_base_64(bytes, count);
    if (text) cJSON_AddStringToObject(to, name, text);
    free(text);
}

static sl_status collect(telling *t, sl_method *method, const sl_image *picture, uint32_t *begin,
                         double *rounding, sl_error *error) {
    size_t pixels = (size_t)picture->width * (size_t)picture->height;
    sl_status status = SL_OK;
    for (size_t p = 0; p < pixels && status == SL_OK; p++) {
        sl_explanation *e;
        begin[p] = t->term_count;
        status = sl_method_explanation(method, picture, (int)(p % (size_t)picture->width),
                                       (int)(p / (size_t)picture->width), &e, error);
        if (status != SL_OK) break;
        add_explanation(t, e, rounding + 3 * p);
        sl_explanation_destroy(e);
    }
    begin[pixels] = t->term_count;
    return status;
}

sl_status sl_explanations_collect(sl_method *method, const sl_image *picture, const sl_mark_view *view,
                                  cJSON **explanations, sl_error *error) {
    size_t pixels = (size_t)picture->width * (size_t)picture->height, size = 0;
    char *bytes = NULL;
    uint32_t *begin = calloc(pixels + 1, sizeof *begin);
    double *rounding = calloc(3 * pixels, sizeof *rounding);
    cJSON *root = cJSON_CreateObject();
    telling t = {view, cJSON_AddArrayToObject(root, "kinds"), open_memstream(&bytes, &size), 0};
    bool room = begin && rounding && t.kinds && t.terms;
    sl_status status = room ? collect(&t, method, picture, begin, rounding, error) : SL_ERROR_RESOURCES;
    if (t.terms && fclose(t.terms) != 0) room = false;
    if (status == SL_OK) {
        add_bytes(root, "begin", begin, (pixels + 1) * sizeof *begin);
        add_bytes(root, "terms", bytes, size);
        add_bytes(root, "rounding", rounding, 3 * pixels * sizeof *rounding);
    }
    if (!room || (status == SL_OK && !cJSON_GetObjectItem(root, "rounding")))
        status = sl_fail_memory(error, "the explanations of the pixels");
    free(begin);
    free(rounding);
    free(bytes);
    if (status == SL_OK) *explanations = root;
    else cJSON_Delete(root);
    return status;
}
