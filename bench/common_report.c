/* Options, scenes, and tables as Markdown. */
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/bench/report.h"
#include "base/memory.h"
#include "common.h"

bench_options bench_options_parse(int argc, char **argv) {
    bench_options o = {0};
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--brief") == 0) o.brief = true;
        else if (strcmp(argv[i], "--only") == 0 && i + 1 < argc) o.only = argv[++i];
        else if (strcmp(argv[i], "--points") == 0 && i + 1 < argc)
            o.points = (size_t)strtoul(argv[++i], NULL, 10);
        else {
            fprintf(stderr, "usage: %s [--brief] [--only TEXT|=NAME] [--points N]\n", argv[0]);
            exit(2);
        }
    }
    return o;
}

bool bench_wants(const bench_options *o, const char *scene) {
    if (o->only && o->only[0] == '=') return strcmp(scene, o->only + 1) == 0;
    return !o->only || strstr(scene, o->only);
}

_Noreturn void bench_fail(const char *what) {
    fprintf(stderr, "bench: %s\n", what);
    exit(1);
}

void bench_check(sl_status status, const sl_error *error) {
    if (status != SL_OK) bench_fail(error->message);
}

void *bench_allocate(size_t count, size_t size) {
    void *memory = sl_allocate(count, size);
    if (!memory) bench_fail("not enough memory");
    return memory;
}

/* ---- tables ---- */

void bench_table(const char *columns) {
    putchar('\n');
    sl_report_head(stdout, columns);
}

void bench_row(const char *format, ...) {
    va_list values;
    va_start(values, format);
    fputs("| ", stdout);
    vprintf(format, values);
    puts(" |");
    fflush(stdout);
    va_end(values);
}

/* ---- scenes ---- */

bool bench_open_scene(const char *path, sl_scene **scene) {
    sl_error error;
    if (access(path, R_OK) != 0 && strstr(path, "generated/") && system("make -s scenes >/dev/null") != 0) {
        fprintf(stderr, "skip: %s cannot be generated\n", path);
        return false;
    }
    if (sl_scene_load_with(path, &(sl_load_options){.allow_outside = true}, scene, &error) == SL_OK)
        return true;
    fprintf(stderr, "skip: %s\n", error.message);
    return false;
}

void bench_scene_name(const char *path, char name[64]) {
    const char *slash = strrchr(path, '/');
    snprintf(name, 64, "%s", slash ? slash + 1 : path);
    char *dot = strrchr(name, '.');
    if (dot) *dot = '\0';
}
