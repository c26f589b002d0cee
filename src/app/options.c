#include "app/options.h"

#include "app/manual.h"
#include "base/values.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* ---- how a scene is read ---- */

static const double degree = 0.017453292519943295;

/* Writes the options of reading a scene. */
static void reading_options(sl_reading *r, sl_option *options) {
    sl_viewpoint *v = &r->view;
    const sl_option own[] = {
        SL_VECTOR("eye", v->eye, &v->has_eye,
                  "where the camera stands, as softlux info tells places [the scene's]"),
        SL_VECTOR("target", v->target, &v->has_target,
                  "what it looks at [the scene's; with --eye the middle of its box]"),
        SL_VECTOR("up", v->up, &v->has_up,
                  "what is up in the picture [the scene's; with --eye or --target 0,1,0]"),
        SL_REAL("fov", &r->fov_degrees, &v->has_fov, "DEGREES", 0.01, 179.0,
                "field of view from top to bottom [the scene's]"),
        SL_CHOICE("up-axis", &r->up_axis, "AXIS", "auto|y|z",
                  "of a mesh file, y or z points up [auto: as its format says; else by its shape]"),
        SL_FLAG("allow-outside", &r->allow_outside,
                "files that the scene names may lie outside of its folder"),
    };
    memcpy(options, own, sizeof own);
}

static void take_reading(sl_reading *r) {
    sl_viewpoint *v = &r->view;
    v->vertical_fov_rad = (float)(r->fov_degrees * degree);
    bool any = v->has_eye || v->has_target || v->has_up || v->has_fov;
    r->load = (sl_load_options){.allow_outside = r->allow_outside,
                                .up_axis = (sl_up_axis)r->up_axis,
                                .view = any ? v : NULL};
}

/* ---- help ---- */

static void print_option(char letter, const char *name, const char *unit, const char *help) {
    char left[64], short_form[8] = "    ";
    if (letter) snprintf(short_form, sizeof short_form, "-%c, ", letter);
    snprintf(left, sizeof left, "%s--%s%s%s", short_form, name, *unit ? " " : "", unit);
    if (strlen(left) > 32) printf("  %s\n  %32s %s\n", left, "", help);
    else printf("  %-32s %s\n", left, help);
}

void sl_each_option(const sl_command_line *line, sl_option_printer print) {
    for (const sl_option *o = line->options; o->name; o++)
        print(o->letter, o->name, o->metavar ? o->metavar : "", o->help);
    if (!line->settings) return;
    const sl_setting *s;
    for (size_t i = 0; (s = sl_setting_at(i)) != NULL; i++) {
        char help[256];
        sl_setting_help(s, help, sizeof help);
        if (s->everyday) print(s->letter, sl_setting_flag(s), s->unit, help);
    }
    print(0, "set", "NAME=VALUE", "any other option of a method; softlux help settings lists them");
}

static void print_help(const sl_command_line *line) {
    printf("usage: %s\n\n%s\n\noptions:\n", line->usage, line->summary);
    printf("  %-32s %s\n", "-h, --help", "this page");
    printf("  %-32s %s\n", "    --man", "this page as a manual page, for man(1)");
    sl_each_option(line, print_option);
    if (line->details) printf("\n%s\n", line->details);
}

__attribute__((format(printf, 2, 3))) static bool mistake(int *status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs("softlux: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    *status = 2;
    return false;
}

/* An option that is only for experiments tells how it is reached. */
static bool unknown_option(const sl_command_line *line, const char *word, int *status) {
    enum { NAMES = 256 };
    const char *names[NAMES];
    size_t count = 0;
    for (const sl_option *o = line->options; o->name && count < NAMES; o++) names[count++] = o->name;
    for (size_t i = 0; line->settings && sl_setting_at(i) && count < NAMES; i++)
        names[count++] = sl_setting_flag(sl_setting_at(i));
    const char *near = sl_nearest_word(word, names, count);
    const sl_setting *setting = near && line->settings ? sl_setting_of_flag(near) : NULL;
    if (setting && !setting->everyday)
        return mistake(status, "unknown option --%s; write --set %s=%s", word, setting->name,
                       *setting->unit ? setting->unit : "1");
    if (near) return mistake(status, "unknown option --%s; did you mean --%s?", word, near);
    return mistake(status, "unknown option --%s; see --help", word);
}

static sl_status read_value(const sl_option *o, const char *text, sl_error *error) {
    switch (o->kind) {
    case SL_OPTION_FLAG: *(bool *)o->value = true; return SL_OK;
    case SL_OPTION_TEXT: *(const char **)o->value = text; return SL_OK;
    case SL_OPTION_REAL: return sl_value_real(text, o->minimum, o->maximum, o->value, error);
    case SL_OPTION_COUNT: return sl_value_count(text, o->minimum, o->maximum, o->value, error);
    case SL_OPTION_CHOICE: return sl_value_choice(text, o->choices, o->value, error);
    case SL_OPTION_SIZE: return sl_value_size(text, 32768, o->value, error);
    case SL_OPTION_VECTOR: return sl_value_vector(text, o->value, error);
    }
    return SL_OK;
}

static bool take_value(const sl_option *o, const char *text, int *status) {
    sl_error error;
    if (o->given) *o->given = true;
    if (read_value(o, text, &error) == SL_OK) return true;
    return mistake(status, "--%s: %s", o->name, error.message);
}

/* The library's line begins with the whole name. */
static bool take_setting(const sl_command_line *line, const sl_setting *setting, const char *text,
                         int *status) {
    sl_error error;
    const char *flag = sl_setting_flag(setting);
    if (line->quality_given && strcmp(flag, "quality") == 0) *line->quality_given = true;
    if (sl_settings_set(line->settings, setting->name, text, &error) == SL_OK) return true;
    return mistake(status, "--%s%s%s", setting->everyday ? "" : "set ",
                   setting->everyday ? flag : setting->name, error.message + strlen(setting->name));
}

/* --set light-octree.depth=6 */
static bool set_by_name(const sl_command_line *line, const char *text, int *status) {
    char name[64];
    const char *equals = strchr(text, '=');
    sl_error error;
    if (!equals) return mistake(status, "--set: expected NAME=VALUE, got '%s'", text);
    snprintf(name, sizeof name, "%.*s", (int)(equals - text), text);
    const sl_setting *setting = sl_setting_named(name);
    if (setting) return take_setting(line, setting, equals + 1, status);
    sl_settings_set(line->settings, name, equals + 1, &error);
    return mistake(status, "--set: %s", error.message);
}

/* A word of the command line names an option of the command, a setting, or --set. */
typedef struct named {
    const sl_option *option;
    const sl_setting *setting;
    bool set;
} named;

static named find_letter(const sl_command_line *line, char letter) {
    for (const sl_option *o = line->options; o->name; o++)
        if (o->letter == letter) return (named){.option = o};
    for (size_t i = 0; line->settings && sl_setting_at(i); i++)
        if (sl_setting_at(i)->letter == letter) return (named){.setting = sl_setting_at(i)};
    return (named){0};
}

static named find_name(const sl_command_line *line, const char *name) {
    for (const sl_option *o = line->options; o->name; o++)
        if (strcmp(o->name, name) == 0) return (named){.option = o};
    const sl_setting *setting = line->settings ? sl_setting_of_flag(name) : NULL;
    return (named){.setting = setting && setting->everyday ? setting : NULL,
                   .set = line->settings && strcmp(name, "set") == 0};
}

static bool take_named(const sl_command_line *line, const named *n, const char *text, int *status) {
    if (n->option) return take_value(n->option, text, status);
    return n->set ? set_by_name(line, text, status)
                  : take_setting(line, n->setting, text ? text : "1", status);
}

static bool is_flag(const named *n) {
    return n->option ? n->option->kind == SL_OPTION_FLAG : n->setting && !*n->setting->unit;
}

static const char *unit_of(const named *n) {
    return n->option ? n->option->metavar : n->setting ? n->setting->unit : "NAME=VALUE";
}

/* One option at argv[*i]; moves *i on to its value. */
static bool take_option(const sl_command_line *line, int argc, char **argv, int *i, int *status) {
    char *word = argv[*i], *name = word + 2;
    const char *value = NULL;
    named n = {0};
    if (word[1] == '-') {
        const size_t length = strcspn(name, "=");
        if (name[length] == '=') value = name + length + 1;
        name[length] = '\0';
        n = find_name(line, name);
    } else if (!word[2]) {
        n = find_letter(line, *--name);
    }
    if (!n.option && !n.setting && !n.set)
        return word[1] == '-' ? unknown_option(line, name, status)
                              : mistake(status, "unknown option %s; see --help", word);
    if (is_flag(&n))
        return value ? mistake(status, "%s takes no value", word) : take_named(line, &n, NULL, status);
    if (!value && *i + 1 < argc) value = argv[++*i];
    if (!value) return mistake(status, "%s needs a value: %s", word, unit_of(&n));
    return take_named(line, &n, value, status);
}

/* Parses with the options of reading a scene behind the command's own. */
bool sl_options_parse(const sl_command_line *given, int argc, char **argv, const char **operands,
                      int *operand_count, int *status) {
    enum { OPTIONS = 40 };
    sl_option options[OPTIONS] = {0};
    sl_command_line whole = *given, *line = &whole;
    size_t own = 0;
    for (; given->options[own].name && own < OPTIONS / 2; own++) options[own] = given->options[own];
    if (given->reading) reading_options(given->reading, options + own);
    whole.options = options;
    int count = 0;
    bool only_operands = false;
    *status = 0;
    for (int i = 0; i < argc; i++) {
        if (!only_operands && (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)) {
            print_help(line);
            return false;
        }
        if (!only_operands && strcmp(argv[i], "--man") == 0) {
            sl_print_command_manual(line);
            return false;
        }
        if (!only_operands && strcmp(argv[i], "--") == 0) {
            only_operands = true;
        } else if (!only_operands && argv[i][0] == '-' && argv[i][1]) {
            if (!take_option(line, argc, argv, &i, status)) return false;
        } else {
            if (count == line->operands_max)
                return mistake(status, "unexpected '%s'; usage: %s", argv[i], line->usage);
            operands[count++] = argv[i];
        }
    }
    if (count < line->operands_min) return mistake(status, "usage: %s", line->usage);
    *operand_count = count;
    if (given->reading) take_reading(given->reading);
    return true;
}
