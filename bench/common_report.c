/* Options, tables as Markdown, and curves. */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common.h"

bench_options bench_options_parse(int argc, char **argv, const char *folder) {
    bench_options o = {0};
    snprintf(o.folder, sizeof o.folder, "%s", folder);
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--brief") == 0) o.brief = true;
        else if (strcmp(argv[i], "--only") == 0 && i + 1 < argc) o.only = argv[++i];
        else if (strcmp(argv[i], "--points") == 0 && i + 1 < argc)
            o.points = (size_t)strtoul(argv[++i], NULL, 10);
        else if (strcmp(argv[i], "--out") == 0 && i + 1 < argc)
            snprintf(o.folder, sizeof o.folder, "%s", argv[++i]);
        else {
            fprintf(stderr,
                    "usage: %s [--brief] [--only TEXT|=NAME] [--points N] [--out FOLDER]\n",
                    argv[0]);
            exit(2);
        }
    }
    mkdir("build", 0777);
    mkdir(o.folder, 0777);
    return o;
}

static bool wanted(const char *pattern, const char *name) {
    if (pattern && pattern[0] == '=') return strcmp(name, pattern + 1) == 0;
    return !pattern || strstr(name, pattern);
}

bool bench_wants(const bench_options *o, const char *scene) { return wanted(o->only, scene); }

_Noreturn void bench_fail(const char *what, const sl_error *error) {
    fprintf(stderr, "%s: %s\n", what, error ? error->message : "failed");
    exit(1);
}

/* ---- the report ---- */

static FILE *open_file(const char *path) {
    FILE *file = fopen(path, "w");
    if (!file) {
        perror(path);
        exit(1);
    }
    return file;
}

void bench_report_open(bench_report *r, const bench_options *o, const char *name) {
    char path[700];
    memset(r, 0, sizeof *r);
    snprintf(path, sizeof path, "%s/%s.md", o->folder, name);
    r->text = open_file(path);
}

void bench_report_close(bench_report *r) {
    fclose(r->text);
}

static void write_both(bench_report *r, const char *text) {
    fputs(text, stdout);
    fputs(text, r->text);
    fflush(stdout);
    fflush(r->text);
}

void bench_say(bench_report *r, const char *format, ...) {
    char text[2048];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    write_both(r, text);
}

/* ---- tables ---- */

static void write_cells(bench_report *r, const char *line, bool header) {
    char text[2048];
    int at = 0, column = 0;
    for (const char *cell = line; cell; column++) {
        const char *end = strchr(cell, '|');
        int length = end ? (int)(end - cell) : (int)strlen(cell);
        if (header) r->widths[column & 31] = length > 7 ? length : 7;
        at += snprintf(text + at, sizeof text - (size_t)at, "| %*.*s ", column ? r->widths[column & 31] : -14,
                       length, cell);
        cell = end ? end + 1 : NULL;
    }
    snprintf(text + at, sizeof text - (size_t)at, "|\n");
    write_both(r, text);
    if (!header) return;
    for (int i = 0; i < column; i++) write_both(r, i ? "|---:" : "|:---");
    write_both(r, "|\n");
}

void bench_table(bench_report *r, const char *header) {
    write_both(r, "\n");
    write_cells(r, header, true);
}

void bench_row(bench_report *r, const char *format, ...) {
    char line[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    write_cells(r, line, false);
}

/* ---- scenes ---- */

bool bench_open_scene(bench_report *r, const char *path, sl_scene **scene) {
    sl_error error;
    if (access(path, R_OK) != 0 && strstr(path, "generated/") && system("make -s scenes >/dev/null") != 0) {
        bench_say(r, "skip: %s cannot be generated\n", path);
        return false;
    }
    if (sl_scene_load_with(path, &(sl_load_options){.allow_outside = true}, scene, &error) == SL_OK)
        return true;
    bench_say(r, "skip: %s\n", error.message);
    return false;
}

void bench_scene_name(const char *path, char name[64]) {
    const char *slash = strrchr(path, '/');
    snprintf(name, 64, "%s", slash ? slash + 1 : path);
    char *dot = strrchr(name, '.');
    if (dot) *dot = '\0';
}

/* ---- speed against error ---- */

double bench_between(const bench_series *s, double at, bool seconds_wanted) {
    for (size_t i = 0; i + 1 < s->count; i++) {
        const bench_point *p = &s->point[i], *q = &s->point[i + 1];
        double x0 = seconds_wanted ? p->rel_mse : p->seconds, x1 = seconds_wanted ? q->rel_mse : q->seconds;
        double y0 = seconds_wanted ? p->seconds : p->rel_mse, y1 = seconds_wanted ? q->seconds : q->rel_mse;
        if ((at - x0) * (at - x1) > 0.0 || x0 == x1) continue;
        return exp(log(y0) + (log(y1) - log(y0)) * (log(at) - log(x0)) / (log(x1) - log(x0)));
    }
    return 0.0;
}
