#include "app/steps/watched.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static sl_watched_pass *find(sl_watched *w, const sl_pass *told) {
    for (size_t i = 0; i < w->count; i++)
        if (strcmp(w->pass[i].name, told->name) == 0) return &w->pass[i];
    if (w->count == SL_WATCHED_MAX) return NULL;
    sl_watched_pass *made = &w->pass[w->count++];
    *made = (sl_watched_pass){.place = SL_WATCHED_MAX};
    snprintf(made->name, sizeof made->name, "%s", told->name);
    snprintf(made->source, sizeof made->source, "%s", told->source);
    made->told = sl_narrative_pass(w->narrative, told->name, &made->place);
    return made;
}

static bool keep_picture(sl_watched_pass *p, const sl_image *buffer) {
    const size_t values = (size_t)buffer->width * (size_t)buffer->height * (size_t)buffer->channels;
    sl_image_destroy(p->latest);
    p->latest = NULL;
    p->width = buffer->width, p->height = buffer->height;
    if (sl_image_create(buffer->width, buffer->height, buffer->channels, NULL, &p->latest, NULL) != SL_OK)
        return false;
    memcpy(p->latest->planes, buffer->planes, values * sizeof(float));
    p->pictures++;
    return true;
}

static bool keep_marks(sl_watched_pass *p, const sl_pass *told) {
    enum { MOST = 4000 };
    const size_t count = told->mark_count < MOST ? told->mark_count : MOST;
    free(p->marks);
    p->marks = malloc(count * sizeof *p->marks);
    p->mark_count = p->marks ? count : 0;
    p->all_marks = told->mark_count;
    for (size_t i = 0; i < p->mark_count; i++) p->marks[i] = told->marks[i * told->mark_count / count];
    return p->marks != NULL;
}

void sl_watched_keep(void *watched, const sl_pass *told) {
    sl_watched *w = watched;
    sl_watched_pass *p = find(w, told);
    bool kept = p != NULL;
    if (p) {
        p->times++;
        for (int i = 0; i < SL_COUNTERS; i++) p->cost.value[i] += told->counters->value[i];
        if (told->buffer) kept = keep_picture(p, told->buffer);
        if (told->mark_count) kept = keep_marks(p, told) && kept;
    }
    w->failed = w->failed || !kept;
}

void sl_watched_clear(sl_watched *w) {
    for (size_t i = 0; i < w->count; i++) {
        sl_image_destroy(w->pass[i].latest);
        free(w->pass[i].marks);
    }
    w->count = 0;
}
