#include "app/settings_text.h"

#include <stdio.h>
#include <string.h>

const char *sl_setting_flag(const sl_setting *setting) {
    const char *dot = strchr(setting->name, '.');
    return dot ? dot + 1 : setting->name;
}

const sl_setting *sl_setting_of_flag(const char *flag) {
    const sl_setting *s = sl_setting_named(flag);
    return s && strcmp(sl_setting_flag(s), flag) == 0 ? s : NULL;
}

/* [5, 5, 6 by quality] */
static void write_default(const sl_setting *s, char *text, size_t room) {
    const double *d = s->by_quality;
    text[0] = '\0';
    if (s->otherwise) snprintf(text, room, " [%s]", s->otherwise);
    else if (strchr(s->unit, '|')) snprintf(text, room, " [%.*s]", (int)strcspn(s->unit, "|"), s->unit);
    else if (*s->unit && d[0] == d[1] && d[1] == d[2]) snprintf(text, room, " [%g]", d[0]);
    else if (*s->unit) snprintf(text, room, " [%.7g, %.7g, %.7g by quality]", d[0], d[1], d[2]);
}

void sl_setting_help(const sl_setting *s, char *text, size_t room) {
    char standard[96];
    const char *dot = strchr(s->name, '.');
    write_default(s, standard, sizeof standard);
    snprintf(text, room, "%.*s%s%s%s", dot ? (int)(dot - s->name) : 0, s->name, dot ? ": " : "", s->help,
             standard);
}

static void print_setting(const sl_setting *s) {
    char left[96], standard[96], bounds[64] = "", symbol[32] = "";
    write_default(s, standard, sizeof standard);
    if (s->minimum < s->maximum && *s->unit && strcmp(s->unit, "BYTES") != 0)
        snprintf(bounds, sizeof bounds, ", %.7g to %.7g", s->minimum, s->maximum);
    if (*s->symbol) snprintf(symbol, sizeof symbol, " (the paper's %s)", s->symbol);
    snprintf(left, sizeof left, "%s=%s", s->name, *s->unit ? s->unit : "1");
    printf("%c %s\n      %s%s%s%s\n", s->everyday ? '*' : ' ', left, s->help, symbol, bounds, standard);
}

void sl_print_settings(void) {
    const char *methods = NULL;
    const sl_setting *s;
    printf("Options of the methods: --set NAME=VALUE, and of those with a star --NAME VALUE without the "
           "method's name.\n");
    for (size_t i = 0; (s = sl_setting_at(i)) != NULL; i++) {
        if (!methods || strcmp(methods, s->methods) != 0)
            printf("\n%s:\n", *s->methods ? s->methods : "every method");
        methods = s->methods;
        print_setting(s);
    }
}
