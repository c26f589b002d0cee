/* Options, tables as Markdown for people and as CSV for programs, and pictures. */
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
        else if (strcmp(argv[i], "--pictures") == 0) o.pictures = true;
        else if (strcmp(argv[i], "--only") == 0 && i + 1 < argc) o.only = argv[++i];
        else if (strcmp(argv[i], "--points") == 0 && i + 1 < argc)
            o.points = (size_t)strtoul(argv[++i], NULL, 10);
        else if (strcmp(argv[i], "--out") == 0 && i + 1 < argc)
            snprintf(o.folder, sizeof o.folder, "%s", argv[++i]);
        else {
            fprintf(stderr,
                    "usage: %s [--brief] [--only TEXT|=NAME] [--points N] [--pictures] [--out FOLDER]\n",
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
    snprintf(r->folder, sizeof r->folder, "%s", o->folder);
    snprintf(r->name, sizeof r->name, "%s", name);
    snprintf(path, sizeof path, "%s/%s.md", r->folder, name);
    r->text = open_file(path);
}

static void end_table(bench_report *r) {
    if (r->table) fclose(r->table);
    r->table = NULL;
}

void bench_report_close(bench_report *r) {
    end_table(r);
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
        fprintf(r->table, "%s%.*s", column ? "," : "", length, cell);
        cell = end ? end + 1 : NULL;
    }
    snprintf(text + at, sizeof text - (size_t)at, "|\n");
    write_both(r, text);
    fputc('\n', r->table);
    fflush(r->table);
    if (!header) return;
    for (int i = 0; i < column; i++) write_both(r, i ? "|---:" : "|:---");
    write_both(r, "|\n");
}

void bench_table(bench_report *r, const char *table, const char *header) {
    char path[700];
    end_table(r);
    snprintf(path, sizeof path, "%s/%s-%s.csv", r->folder, r->name, table);
    r->table = open_file(path);
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

/* ---- pictures ---- */

void bench_write_picture(const bench_report *r, const char *scene, const char *what, const sl_image *image) {
    char path[700];
    sl_error error;
    sl_tone tone = {SL_TONE_REINHARD, 0.0f, true};
    snprintf(path, sizeof path, "%s/%s-%s.png", r->folder, scene, what);
    if (sl_image_write_png(image, path, tone, &error) != SL_OK) fprintf(stderr, "%s\n", error.message);
}
