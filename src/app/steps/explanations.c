#include "app/steps/explanations.h"

#include "app/html.h"

#include "base/error.h"
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { KINDS_MAX = 64, FLOATS = 7 }; /* of a term: weight, contribution, value */

typedef struct item {
    uint32_t kind; /* into kinds */
    uint64_t index;
    bool placed;
    float position[3];
} item;

typedef struct told_term {
    uint32_t item;
    float weight, contribution[3], value[3];
} told_term;

struct sl_explanations {
    struct {
        const char *layer, *kind;
    } kinds[KINDS_MAX];
    uint32_t kind_count;
    item *items;
    size_t item_count, item_capacity;
    uint32_t *table; /* of items by hash; item number + 1 */
    size_t table_size;
    told_term *terms;
    size_t term_count, term_capacity;
    size_t pixels;
    uint32_t *begin;   /* pixels + 1 */
    double *rounding;  /* 3 a pixel */
};

/* Room for one more of `size` bytes; false: no memory. */
static bool make_room(void **array, size_t *capacity, size_t count, size_t size) {
    if (count < *capacity) return true;
    size_t more = *capacity ? 2 * *capacity : 1024;
    void *grown = realloc(*array, more * size);
    if (!grown) return false;
    *array = grown, *capacity = more;
    return true;
}

static uint32_t kind_of(sl_explanations *s, const sl_explanation_term *t) {
    for (uint32_t k = 0; k < s->kind_count; k++)
        if (strcmp(s->kinds[k].layer, t->layer) == 0 && strcmp(s->kinds[k].kind, t->kind) == 0) return k;
    if (s->kind_count == KINDS_MAX) return KINDS_MAX - 1;
    s->kinds[s->kind_count].layer = t->layer;
    s->kinds[s->kind_count].kind = t->kind;
    return s->kind_count++;
}

static size_t slot_of(const sl_explanations *s, uint32_t kind, uint64_t index) {
    uint64_t h = (index * 64 + kind) * 0x9e3779b97f4a7c15u;
    for (size_t at = (size_t)(h >> 20) & (s->table_size - 1);; at = (at + 1) & (s->table_size - 1)) {
        uint32_t number = s->table[at];
        if (!number || (s->items[number - 1].kind == kind && s->items[number - 1].index == index)) return at;
    }
}

/* The table stays at most half full. */
static bool grow_table(sl_explanations *s) {
    if (2 * (s->item_count + 1) <= s->table_size) return true;
    size_t size = s->table_size ? 2 * s->table_size : 4096;
    uint32_t *table = calloc(size, sizeof *table);
    if (!table) return false;
    free(s->table);
    s->table = table, s->table_size = size;
    for (size_t i = 0; i < s->item_count; i++)
        s->table[slot_of(s, s->items[i].kind, s->items[i].index)] = (uint32_t)i + 1;
    return true;
}

static bool find_item(sl_explanations *s, const sl_explanation_term *t, uint32_t *number) {
    if (!grow_table(s) || !make_room((void **)&s->items, &s->item_capacity, s->item_count, sizeof *s->items))
        return false;
    uint32_t kind = kind_of(s, t);
    size_t slot = slot_of(s, kind, t->index);
    if (!s->table[slot]) {
        item *made = &s->items[s->item_count];
        *made = (item){.kind = kind, .index = t->index, .placed = t->placed};
        memcpy(made->position, t->position, sizeof made->position);
        s->table[slot] = (uint32_t)++s->item_count;
    }
    *number = s->table[slot] - 1;
    return true;
}

static double size_of(const sl_explanation_term *t) {
    return fabs(t->contribution[0]) + fabs(t->contribution[1]) + fabs(t->contribution[2]);
}

/* The terms that are shown, the largest: their places in the explanation, in descending order of size; of
 * equal ones the first. */
static size_t find_largest(const sl_explanation *explanation, size_t place[SL_EXPLANATION_TERMS_SHOWN]) {
    size_t count = 0;
    for (size_t i = 0; i < explanation->count; i++) {
        double size = size_of(&explanation->terms[i]);
        size_t at = count;
        while (at > 0 && size > size_of(&explanation->terms[place[at - 1]])) at--;
        if (at == SL_EXPLANATION_TERMS_SHOWN) continue;
        if (count < SL_EXPLANATION_TERMS_SHOWN) count++;
        for (size_t k = count - 1; k > at; k--) place[k] = place[k - 1];
        place[at] = i;
    }
    return count;
}

static bool is_among(const size_t *place, size_t count, size_t i) {
    for (size_t k = 0; k < count; k++)
        if (place[k] == i) return true;
    return false;
}

static bool add_term(sl_explanations *s, const sl_explanation_term *t, double left[3]) {
    told_term told = {.weight = (float)t->weight};
    if (!find_item(s, t, &told.item) ||
        !make_room((void **)&s->terms, &s->term_capacity, s->term_count, sizeof *s->terms))
        return false;
    for (int c = 0; c < 3; c++) {
        told.contribution[c] = (float)t->contribution[c];
        told.value[c] = t->value[c];
        left[c] -= (double)told.contribution[c];
    }
    s->terms[s->term_count++] = told;
    return true;
}

/* Makes what is shown add up to the pixel, too: what the page leaves out, or rounds to float, goes to the
 * rest. */
static bool add_explanation(sl_explanations *s, const sl_explanation *explanation, size_t pixel) {
    sl_explanation_term smaller = {.layer = "several", .kind = "smaller ones, together"};
    double left[3] = {(double)explanation->pixel[0], (double)explanation->pixel[1],
                      (double)explanation->pixel[2]};
    size_t largest[SL_EXPLANATION_TERMS_SHOWN], shown = find_largest(explanation, largest);
    bool fits = explanation->count == shown;
    s->begin[pixel] = (uint32_t)s->term_count;
    for (size_t i = 0; i < explanation->count; i++) {
        const sl_explanation_term *t = &explanation->terms[i];
        if (is_among(largest, shown, i)) {
            if (!add_term(s, t, left)) return false;
            continue;
        }
        smaller.weight += t->weight;
        for (int c = 0; c < 3; c++) smaller.contribution[c] += t->contribution[c];
    }
    if (!fits && !add_term(s, &smaller, left)) return false;
    memcpy(&s->rounding[3 * pixel], left, sizeof left);
    return true;
}

sl_status sl_explanations_collect(sl_method *method, const sl_image *picture, sl_explanations **explanations,
                                  sl_error *error) {
    sl_explanations *s = calloc(1, sizeof *s);
    *explanations = s;
    if (!s) return sl_fail_memory(error, "the explanations of the pixels");
    s->pixels = (size_t)picture->width * (size_t)picture->height;
    s->begin = calloc(s->pixels + 1, sizeof *s->begin);
    s->rounding = calloc(3 * s->pixels, sizeof *s->rounding);
    sl_status status =
        s->begin && s->rounding ? SL_OK : sl_fail_memory(error, "the explanations of the pixels");
    for (size_t p = 0; p < s->pixels && status == SL_OK; p++) {
        sl_explanation *explanation;
        status = sl_method_explanation(method, picture, (int)(p % (size_t)picture->width),
                                       (int)(p / (size_t)picture->width), &explanation, error);
        if (status == SL_OK && !add_explanation(s, explanation, p))
            status = sl_fail_memory(error, "the explanations of the pixels");
        if (status == SL_OK) sl_explanation_destroy(explanation);
    }
    if (status == SL_OK) {
        s->begin[s->pixels] = (uint32_t)s->term_count;
        return SL_OK;
    }
    sl_explanations_destroy(s);
    *explanations = NULL;
    return status;
}

void sl_explanations_destroy(sl_explanations *s) {
    if (!s) return;
    free(s->items);
    free(s->table);
    free(s->terms);
    free(s->begin);
    free(s->rounding);
    free(s);
}

/* ---- as JSON ---- */

static void put_item(const item *i, const sl_mark_view *view, FILE *out) {
    double column, row;
    fprintf(out, "[%u,%llu", i->kind, (unsigned long long)i->index);
    if (i->placed && sl_mark_project(view, i->position, &column, &row))
        fprintf(out, ",%.1f,%.1f", column, row);
    else fputs(",null,null", out);
    fputc(']', out);
}

static void put_array(FILE *out, const char *name, const void *data, size_t bytes) {
    char *text = sl_base_64(data, bytes);
    fprintf(out, ",\n\"%s\":\"%s\"", name, text ? text : "");
    free(text);
}

static void put_terms(const sl_explanations *s, FILE *out) {
    uint32_t *number = malloc((s->term_count + 1) * sizeof *number);
    float *values = malloc((FLOATS * s->term_count + 1) * sizeof *values);
    if (number && values) {
        for (size_t i = 0; i < s->term_count; i++) {
            number[i] = s->terms[i].item;
            values[FLOATS * i] = s->terms[i].weight;
            memcpy(&values[FLOATS * i + 1], s->terms[i].contribution, sizeof s->terms[i].contribution);
            memcpy(&values[FLOATS * i + 4], s->terms[i].value, sizeof s->terms[i].value);
        }
        put_array(out, "item", number, s->term_count * sizeof *number);
        put_array(out, "values", values, FLOATS * s->term_count * sizeof *values);
    }
    free(number);
    free(values);
}

void sl_explanations_put(const sl_explanations *s, const sl_mark_view *view, FILE *out) {
    fputs("{\"kinds\":[", out);
    for (uint32_t k = 0; k < s->kind_count; k++)
        fprintf(out, "%s[\"%s\",\"%s\"]", k ? "," : "", s->kinds[k].layer, s->kinds[k].kind);
    fputs("],\n\"items\":[", out);
    for (size_t i = 0; i < s->item_count; i++) {
        if (i) fputc(',', out);
        put_item(&s->items[i], view, out);
    }
    fputs("]", out);
    put_array(out, "begin", s->begin, (s->pixels + 1) * sizeof *s->begin);
    put_terms(s, out);
    put_array(out, "rounding", s->rounding, 3 * s->pixels * sizeof *s->rounding);
    fputs("}", out);
}
