#include "app/pass_times.h"

#include <stdio.h>
#include <string.h>

void sl_pass_times_add(sl_pass_times *t, const char *name, double seconds) {
    int i = 0;
    while (i < t->count && strcmp(t->pass[i].name, name) != 0) i++;
    if (i == SL_PASS_TIMES) i--;
    if (i == t->count) snprintf(t->pass[t->count++].name, sizeof t->pass[i].name, "%.63s", name);
    t->pass[i].times++;
    t->pass[i].seconds += seconds;
}

/* Charges a pass, which announces itself when it is done, with what passed since the last one did. */
static void end_of_pass(void *context, const sl_pass *pass) {
    sl_pass_times *t = context;
    sl_pass_times_add(t, pass->name, t->clock() - t->last);
    t->last = t->clock();
}

void sl_pass_times_begin(sl_pass_times *t, double (*clock)(void)) {
    memset(t, 0, sizeof *t);
    t->observer = (sl_observer){.context = t, .pass = end_of_pass};
    t->clock = clock;
    t->last = clock();
}

double sl_pass_times_sum(const sl_pass_times *t) {
    double sum = 0.0;
    for (int i = 0; i < t->count; i++) sum += t->pass[i].seconds;
    return sum;
}
