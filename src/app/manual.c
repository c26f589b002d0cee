/* Manual pages: the tables of options as man(7) has it. */
#include "app/manual.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

/* ---- options of methods ---- */

const char *sl_setting_flag(const sl_setting *setting) {
    const char *dot = strchr(setting->name, '.');
    return dot ? dot + 1 : setting->name;
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

/* Words as they stand: a dot or quote at a line's beginning would be a request, a backslash an escape, and a
 * plain minus a hyphen. */
static void print_text(const char *text) {
    bool line_begins = true;
    for (const char *c = text; *c; c++) {
        if (line_begins && (*c == '.' || *c == '\'')) fputs("\\&", stdout);
        line_begins = *c == '\n';
        if (*c == '\\') fputs("\\e", stdout);
        else if (*c == '-') fputs("\\-", stdout);
        else putchar(*c);
    }
}

/* Puts all of them as lines, method by method. */
static void put_settings(void (*put)(const char *text)) {
    const char *methods = NULL;
    const sl_setting *s;
    for (size_t i = 0; (s = sl_setting_at(i)) != NULL; i++) {
        char line[512], standard[96], bounds[64] = "", symbol[32] = "";
        write_default(s, standard, sizeof standard);
        if (s->minimum < s->maximum && *s->unit && strcmp(s->unit, "BYTES") != 0)
            snprintf(bounds, sizeof bounds, ", %.7g to %.7g", s->minimum, s->maximum);
        if (*s->symbol) snprintf(symbol, sizeof symbol, " (the paper's %s)", s->symbol);
        if (!methods || strcmp(methods, s->methods) != 0) {
            snprintf(line, sizeof line, "\n%s:\n", *s->methods ? s->methods : "every method");
            put(line);
        }
        methods = s->methods;
        snprintf(line, sizeof line, "%c %s=%s\n      %s%s%s%s\n", s->everyday ? '*' : ' ', s->name,
                 *s->unit ? s->unit : "1", s->help, symbol, bounds, standard);
        put(line);
    }
}

static void put_plain(const char *text) { fputs(text, stdout); }

void sl_print_settings(void) {
    printf("Options of the methods: --set NAME=VALUE, and of those with a star --NAME VALUE without the "
           "method's name.\n");
    put_settings(put_plain);
}

static void print_heading(const char *page, const char *summary) {
    printf(".TH ");
    for (const char *c = page; *c; c++) putchar(toupper((unsigned char)*c));
    printf(" 1 \"\" \"softlux %s\" \"softlux\"\n.SH NAME\n", SL_VERSION);
    print_text(page);
    printf(" \\- ");
    print_text(summary);
    putchar('\n');
}

static void print_option(char letter, const char *name, const char *unit, const char *help) {
    printf(".TP\n");
    if (letter) printf("\\fB\\-%c\\fR, ", letter);
    printf("\\fB\\-\\-");
    print_text(name);
    printf("\\fR");
    if (*unit) {
        printf(" \\fI");
        print_text(unit);
        printf("\\fR");
    }
    putchar('\n');
    print_text(help);
    putchar('\n');
}

static void print_exit_statuses(void) {
    printf(".SH EXIT STATUS\n0 success, 1 a comparison or an error bound failed, 2 usage, 3 input, 4 output, "
           "5 resources.\n"
           "After a failure one line on standard error says what was expected, and where.\n");
}

/* "softlux render SCENE ..." is described on the page softlux-render. */
static void page_name(const char *usage, char *page, size_t size) {
    size_t length = 0;
    for (int words = 0; usage[length] && length + 1 < size; length++) {
        if (usage[length] == ' ' && ++words == 2) break;
        page[length] = usage[length] == ' ' ? '-' : usage[length];
    }
    page[length] = '\0';
}

void sl_print_command_manual(const sl_command_line *line) {
    char page[64], purpose[128];
    page_name(line->usage, page, sizeof page);
    snprintf(purpose, sizeof purpose, "%.*s", (int)strcspn(line->summary, ".:;\n"), line->summary);
    print_heading(page, purpose);
    printf(".SH SYNOPSIS\n");
    print_text(line->usage);
    printf("\n.SH DESCRIPTION\n");
    print_text(line->summary);
    printf("\n.SH OPTIONS\n.TP\n\\fB\\-h\\fR, \\fB\\-\\-help\\fR\na short form of this page\n");
    sl_each_option(line, print_option);
    if (line->details) {
        printf(".SH NOTES\n.nf\n");
        print_text(line->details);
        printf("\n.fi\n");
    }
    print_exit_statuses();
    printf(".SH SEE ALSO\n.BR softlux (1)\n");
}

void sl_print_program_manual(const sl_command *commands, size_t count) {
    print_heading("softlux",
                  "global illumination of triangle scenes on a CPU, deterministic and without a GPU");
    printf(".SH SYNOPSIS\nsoftlux \\fICOMMAND\\fR ...\n.SH COMMANDS\n");
    for (size_t i = 0; i < count; i++) {
        printf(".TP\n.BR softlux\\-%s (1)\n", commands[i].name);
        print_text(commands[i].summary);
        putchar('\n');
    }
    printf(".SH OPTIONS OF METHODS\n.nf\n");
    put_settings(print_text); /* those with a star without --set, too */
    printf(".fi\n");
    print_exit_statuses();
    printf(".SH EXAMPLES\nsoftlux render scenes/cornell.json \\-o cornell.png\n.SH SEE ALSO\n");
    for (size_t i = 0; i < count; i++)
        printf(".BR softlux\\-%s (1)%s\n", commands[i].name, i + 1 < count ? "," : "");
}
