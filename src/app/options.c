#include "app/options.h"

#include "app/manual.h"
#include "base/values.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* ---- options beside a command's own ---- */

enum { OPTIONS = 256 };
static const double degree = 0.017453292519943295;

/* Appends the options of reading a scene. */
static void add_reading(sl_option *options, size_t *count, sl_reading *r) {
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
                  "of a mesh file, y or z points up [auto: as its format says, else y]"),
        SL_FLAG("allow-outside", &r->allow_outside,
                "files that the scene names may lie outside of its folder"),
    };
    memcpy(options + *count, own, sizeof own);
    *count += sizeof own / sizeof *own;
}

/* Appends all settings of methods, and --set. */
static void add_settings(sl_option *options, size_t *count, const sl_command_line *line) {
    const sl_setting *s;
    for (size_t i = 0; (s = sl_setting_at(i)) != NULL; i++) {
        const char *flag = sl_setting_flag(s);
        options[(*count)++] = (sl_option){.name = flag,
                                          .letter = s->letter,
                                          .kind = SL_OPTION_SETTING,
                                          .value = line->settings,
                                          .given = strcmp(flag, "quality") == 0 ? line->quality_given : NULL,
                                          .metavar = *s->unit ? s->unit : NULL,
                                          .setting = s};
    }
    options[(*count)++] =
        (sl_option){.name = "set",
                    .kind = SL_OPTION_SET,
                    .value = line->settings,
                    .metavar = "NAME=VALUE",
                    .help = "any other option of a method; softlux help settings lists them"};
}

/* Tells whether it is reached by --set alone. */
static bool is_hidden(const sl_option *o) { return o->setting && !o->setting->everyday; }

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
    for (const sl_option *o = line->options; o->name; o++) {
        char help[256];
        if (o->setting) sl_setting_help(o->setting, help, sizeof help);
        if (!is_hidden(o))
            print(o->letter, o->name, o->metavar ? o->metavar : "", o->setting ? help : o->help);
    }
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
    const char *names[OPTIONS];
    size_t count = 0;
    for (const sl_option *o = line->options; o->name; o++) names[count++] = o->name;
    const char *near = sl_nearest_word(word, names, count);
    if (!near) return mistake(status, "unknown option --%s; see --help", word);
    const sl_option *o = line->options;
    while (o->name != near) o++;
    if (!is_hidden(o)) return mistake(status, "unknown option --%s; did you mean --%s?", word, near);
    return mistake(status, "unknown option --%s; write --set %s=%s", word, o->setting->name,
                   o->metavar ? o->metavar : "1");
}

/* Sets one of a method's settings; a flag comes without text. The library's line begins with the full name. */
static bool take_setting(const sl_option *o, const char *text, int *status) {
    const sl_setting *setting = o->setting;
    sl_error error;
    if (o->given) *o->given = true;
    if (sl_settings_set(o->value, setting->name, text ? text : "1", &error) == SL_OK) return true;
    return mistake(status, "--%s%s%s", is_hidden(o) ? "set " : "", is_hidden(o) ? setting->name : o->name,
                   error.message + strlen(setting->name));
}

/* --set light-octree.depth=6 */
static bool set_by_name(const sl_command_line *line, const char *text, int *status) {
    char name[64];
    const char *equals = strchr(text, '=');
    sl_error error;
    if (!equals) return mistake(status, "--set: expected NAME=VALUE, got '%s'", text);
    snprintf(name, sizeof name, "%.*s", (int)(equals - text), text);
    const sl_setting *setting = sl_setting_named(name);
    for (const sl_option *o = line->options; setting && o->name; o++)
        if (o->setting == setting) return take_setting(o, equals + 1, status);
    sl_settings_set(line->settings, name, equals + 1, &error);
    return mistake(status, "--set: %s", error.message);
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
    default: return SL_OK;
    }
}

static bool take_value(const sl_command_line *line, const sl_option *o, const char *text, int *status) {
    sl_error error;
    if (o->kind == SL_OPTION_SET) return set_by_name(line, text, status);
    if (o->kind == SL_OPTION_SETTING) return take_setting(o, text, status);
    if (o->given) *o->given = true;
    if (read_value(o, text, &error) == SL_OK) return true;
    return mistake(status, "--%s: %s", o->name, error.message);
}

/* By its name, or with NULL by its letter. */
static const sl_option *find_option(const sl_command_line *line, const char *name, char letter) {
    for (const sl_option *o = line->options; o->name; o++)
        if (!is_hidden(o) && (name ? strcmp(o->name, name) == 0 : o->letter == letter)) return o;
    return NULL;
}

/* One option at argv[*i]; moves *i on to its value. */
static bool take_option(const sl_command_line *line, int argc, char **argv, int *i, int *status) {
    char *word = argv[*i], *name = word + 2;
    const char *value = NULL;
    const sl_option *o = NULL;
    if (word[1] == '-') {
        const size_t length = strcspn(name, "=");
        if (name[length] == '=') value = name + length + 1;
        name[length] = '\0';
        o = find_option(line, name, 0);
    } else if (!word[2]) {
        o = find_option(line, NULL, word[1]);
    }
    if (!o)
        return word[1] == '-' ? unknown_option(line, name, status)
                              : mistake(status, "unknown option %s; see --help", word);
    if (!o->metavar)
        return value ? mistake(status, "%s takes no value", word) : take_value(line, o, NULL, status);
    if (!value && *i + 1 < argc) value = argv[++*i];
    if (!value) return mistake(status, "%s needs a value: %s", word, o->metavar);
    return take_value(line, o, value, status);
}

static bool is_word(const char *word, const char *name, const char *letter) {
    return strcmp(word, name) == 0 || (letter && strcmp(word, letter) == 0);
}

static bool take_words(const sl_command_line *line, int argc, char **argv, const char **operands, int *count,
                       int *status) {
    bool only_operands = false;
    for (int i = 0; i < argc; i++) {
        if (!only_operands && is_word(argv[i], "--help", "-h")) return print_help(line), false;
        if (!only_operands && is_word(argv[i], "--man", NULL)) return sl_print_command_manual(line), false;
        if (!only_operands && is_word(argv[i], "--", NULL)) {
            only_operands = true;
        } else if (!only_operands && argv[i][0] == '-' && argv[i][1]) {
            if (!take_option(line, argc, argv, &i, status)) return false;
        } else {
            if (*count == line->operands_max)
                return mistake(status, "unexpected '%s'; usage: %s", argv[i], line->usage);
            operands[(*count)++] = argv[i];
        }
    }
    return *count >= line->operands_min || mistake(status, "usage: %s", line->usage);
}

/* Behind the command's own options there are those of reading a scene, and the methods'. */
bool sl_options_parse(const sl_command_line *given, int argc, char **argv, const char **operands,
                      int *operand_count, int *status) {
    sl_option options[OPTIONS] = {0};
    sl_command_line whole = *given;
    size_t count = 0;
    for (; given->options[count].name && count < OPTIONS / 4; count++) options[count] = given->options[count];
    if (given->reading) add_reading(options, &count, given->reading);
    if (given->settings) add_settings(options, &count, given);
    whole.options = options;
    *operand_count = *status = 0;
    if (!take_words(&whole, argc, argv, operands, operand_count, status)) return false;
    if (given->reading) take_reading(given->reading);
    return true;
}
