#include "app/live/stages.h"

#include "app/clock.h"

#include <stdio.h>
#include <string.h>

static sl_stage *stage_named(sl_stages *s, const char *name) {
    for (int i = 0; i < s->count; i++) {
        if (strcmp(s->stage[i].name, name) == 0) return &s->stage[i];
    }
    if (s->count == SL_STAGES_MAX) return &s->stage[SL_STAGES_MAX - 1];
    sl_stage *stage = &s->stage[s->count++];
    snprintf(stage->name, sizeof stage->name, "%s", name);
    return stage;
}

/* A pass ends where it is announced. */
static void end_of_pass(void *context, const sl_pass *pass) {
    sl_stages *s = context;
    double now = sl_thread_seconds();
    sl_stage *stage = stage_named(s, pass->name);
    stage->times++;
    stage->seconds += now - s->last;
    s->last = now;
}

void sl_stages_begin(sl_stages *s) {
    *s = (sl_stages){.observer = {.context = s, .pass = end_of_pass}};
}

double sl_stages_seconds(const sl_stages *s) {
    double sum = 0.0;
    for (int i = 0; i < s->count; i++) sum += s->stage[i].seconds;
    return sum;
}
