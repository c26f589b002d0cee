/* bench_auto FOLDER: what --method auto is to know, from the measurements that `make report` leaves in FOLDER
 * (results.csv, scenes.csv): src/app/auto_table.h on stdout. With --judge: how good its choices are for
 * scenes that were left out of the table, as Markdown. */
#include "app/auto_choice.h"
#include "app/bench/curves.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SCENES = 128, FIELDS = 96, ROWS = 64 };

/* ---- CSV ---- */

typedef struct csv {
    FILE *in;
    char *line;
    size_t room, fields, heads;
    char *field[FIELDS], *head[FIELDS], *names;
} csv;

/* Cuts the line up where it stands; quotes around a field go, doubled ones inside become one. */
static size_t cut(char *line, char **field) {
    size_t count = 0;
    line[strcspn(line, "\r\n")] = '\0';
    for (char *at = line; count < FIELDS;) {
        bool quoted = *at == '"';
        char *to = at += quoted;
        field[count++] = at;
        while (*at && (quoted ? *at != '"' || at[1] == '"' : *at != ',')) {
            if (quoted && *at == '"') at++;
            *to++ = *at++;
        }
        if (quoted && *at) at++;
        bool more = *at == ',';
        *to = '\0';
        if (!more) break;
        at++;
    }
    return count;
}

static bool csv_open(csv *c, const char *folder, const char *name) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    *c = (csv){.in = fopen(path, "r")};
    if (!c->in || getline(&c->line, &c->room, c->in) <= 0 || !(c->names = strdup(c->line))) {
        fprintf(stderr, "bench_auto: cannot read %s\n", path);
        return false;
    }
    c->heads = cut(c->names, c->head);
    return true;
}

static bool csv_next(csv *c) {
    if (getline(&c->line, &c->room, c->in) <= 0) return false;
    c->fields = cut(c->line, c->field);
    return true;
}

static const char *text(const csv *c, const char *name) {
    for (size_t i = 0; i < c->heads && i < c->fields; i++) {
        if (strcmp(c->head[i], name) == 0) return c->field[i];
    }
    return "";
}

static double number(const csv *c, const char *name) { return strtod(text(c, name), NULL); }

static void csv_close(csv *c) {
    if (c->in) fclose(c->in);
    free(c->line);
    free(c->names);
}

/* ---- what was measured ---- */

typedef struct measured {
    size_t count;
    sl_auto_scene scene[SCENES];
    char name[SCENES][64], hash[SCENES][17];
    sl_bench_scene rows[SCENES];
    sl_trial trials[SCENES][ROWS];
} measured;

static bool read_scenes(const char *folder, measured *m) {
    csv c;
    if (!csv_open(&c, folder, "scenes.csv")) return false;
    while (m->count < SCENES && csv_next(&c)) {
        sl_auto_scene *s = &m->scene[m->count];
        snprintf(m->name[m->count], sizeof m->name[0], "%s", text(&c, "scene"));
        snprintf(m->hash[m->count], sizeof m->hash[0], "%s", text(&c, "hash"));
        s->name = m->name[m->count];
        s->pixels = number(&c, "pixels");
        s->kind =
            (sl_auto_kind){number(&c, "direct"),        number(&c, "second"),     number(&c, "further"),
                           number(&c, "mirrored"),      number(&c, "lit") > 0.0,  number(&c, "glossy") > 0.0,
                           number(&c, "mirrors") > 0.0, number(&c, "open") > 0.0, number(&c, "triangles"),
                           number(&c, "lights")};
        m->rows[m->count++].rows = calloc(ROWS, sizeof(sl_bench_row));
    }
    csv_close(&c);
    return m->count > 0;
}

static bool read_rows(const char *folder, measured *m) {
    csv c;
    if (!csv_open(&c, folder, "results.csv")) return false;
    while (csv_next(&c)) {
        size_t i = 0;
        while (i < m->count && strcmp(m->hash[i], text(&c, "hash")) != 0) i++;
        if (i == m->count || strcmp(text(&c, "end"), "ran") != 0 || !text(&c, "full_rel_rmse")[0] ||
            m->rows[i].row_count == ROWS)
            continue;
        sl_trial *trial = &m->trials[i][m->rows[i].row_count];
        sl_bench_row *row = &m->rows[i].rows[m->rows[i].row_count++];
        snprintf(trial->curve, sizeof trial->curve, "%s", text(&c, "curve"));
        snprintf(trial->arguments, sizeof trial->arguments, "%s", text(&c, "arguments"));
        row->trial = trial;
        row->end = SL_BENCH_RAN;
        row->cpu = (sl_bench_spread){1, number(&c, "cpu_seconds"), 0.0, 0.0};
        row->error[SL_BENCH_FULL] = (sl_bench_error){.known = true,
                                                     .rel_rmse = number(&c, "full_rel_rmse"),
                                                     .lost = strcmp(text(&c, "full_is_bound"), "yes") == 0};
    }
    csv_close(&c);
    return true;
}

/* Where a curve ends above the error: as samples would go on from its best point, which flatters those that
 * are biased; so these pay for it. Of what is only known to be below the reference's noise nobody knows that
 * it ends there. */
static double seconds_of(const sl_curve *c, bool tracer, double error) {
    double seconds = sl_curve_time_to(c, SL_BENCH_FULL, error);
    const sl_bench_row *best = NULL;
    if (seconds > 0.0) return seconds;
    for (size_t i = 0; i < c->count; i++) {
        if (!best || c->row[i]->error[SL_BENCH_FULL].rel_rmse < best->error[SL_BENCH_FULL].rel_rmse)
            best = c->row[i];
    }
    bool goes_on = tracer || best->error[SL_BENCH_FULL].lost;
    return best->cpu.median * pow(best->error[SL_BENCH_FULL].rel_rmse / error, goes_on ? 1.7 : 4.0);
}

static void fill_seconds(measured *m) {
    for (size_t i = 0; i < m->count; i++) {
        sl_curve curves[SL_CURVES];
        size_t count = sl_curves_of(&m->rows[i], SL_BENCH_FULL, curves);
        for (int class = 0; class < SL_AUTO_CLASSES; class++) {
            for (int c = 0; c < SL_AUTO_CANDIDATES; c++) {
                double *to = &m->scene[i].seconds[class][c];
                *to = 1e6; /* it never ended there */
                for (size_t k = 0; k < count; k++) {
                    if (strcmp(curves[k].name, sl_auto_curve_of((sl_auto_candidate)c)) == 0)
                        *to =
                            fmin(1e6, seconds_of(&curves[k], c == SL_AUTO_PATH || c == SL_AUTO_BIDIRECTIONAL,
                                                 sl_auto_error_of((sl_auto_class) class)));
                }
            }
        }
    }
}

/* ---- the table ---- */

static void print_table(const measured *m) {
    printf("/* Written by bench/bench_auto.c from docs/report/results.csv and scenes.csv: what was measured "
           "of each scene. Times: %s; ",
           sl_auto_curve_of(SL_AUTO_SPLATTING));
    for (int c = 1; c < SL_AUTO_CANDIDATES; c++)
        printf("%s%s", sl_auto_curve_of((sl_auto_candidate)c), c + 1 < SL_AUTO_CANDIDATES ? "; " : ". */\n");
    puts("#ifndef SL_APP_AUTO_TABLE_H\n#define SL_APP_AUTO_TABLE_H\n\n#include "
         "\"app/auto_choice.h\"\n\nstatic const sl_auto_scene measured[] = {");
    for (size_t i = 0; i < m->count; i++) {
        const sl_auto_scene *s = &m->scene[i];
        const sl_auto_kind *k = &s->kind;
        printf("    {\"%s\", {%.4g, %.4g, %.4g, %.4g, %d, %d, %d, %d, %.0f, %.0f}, %.0f,\n     {", s->name,
               k->direct, k->second, k->further, k->mirrored, k->lit, k->glossy, k->mirrors, k->open,
               k->triangles, k->lights, s->pixels);
        for (int class = 0; class < SL_AUTO_CLASSES; class++) {
            printf("%s{", class ? "\n      " : "");
            for (int c = 0; c < SL_AUTO_CANDIDATES; c++)
                printf("%s%.3g", c ? ", " : "", s->seconds[class][c]);
            printf("}%s", class + 1 < SL_AUTO_CLASSES ? "," : "");
        }
        puts("}},");
    }
    puts("};\n\n#endif");
}

/* ---- how good it is where it has not been ---- */

static void judge_class(const measured *m, sl_auto_class class, size_t *best, size_t *near,
                        size_t *within_three, double *fixed) {
    for (size_t i = 0; i < m->count; i++) {
        const sl_auto_scene *s = &m->scene[i];
        double error = sl_auto_error_of(class), least = HUGE_VAL;
        sl_auto_verdict v = sl_auto_judge(m->scene, m->count, s, &s->kind, s->pixels, class, error);
        int first = 0;
        for (int c = 0; c < SL_AUTO_CANDIDATES; c++) {
            if (s->seconds[class][c] < least) least = s->seconds[class][c], first = c;
        }
        double ratio = s->seconds[class][v.best] / least;
        *best += (int)v.best == first;
        *near += ratio <= 1.5;
        *within_three += ratio <= 3.0;
        for (int c = 0; c < SL_AUTO_CANDIDATES; c++) fixed[c] += s->seconds[class][c] <= 1.5 * least;
        printf("| %s | %g %% | %s, %.3g s | %s, %.3g s | %.1f | %s |\n", s->name, 100.0 * error,
               sl_auto_curve_of(v.best), s->seconds[class][v.best],
               sl_auto_curve_of((sl_auto_candidate)first), least, ratio, v.like ? v.like->name : "");
    }
}

static void print_judgement(const measured *m) {
    puts("# `--method auto` for scenes that were left out of its table\n\n| scene, left out | error | chosen "
         "| first | times | most like it |\n| --- | ---: | --- | --- | ---: | --- |");
    size_t best[SL_AUTO_CLASSES] = {0}, near[SL_AUTO_CLASSES] = {0}, three[SL_AUTO_CLASSES] = {0};
    double fixed[SL_AUTO_CLASSES][SL_AUTO_CANDIDATES] = {{0}};
    for (int class = 0; class < SL_AUTO_CLASSES; class ++)
        judge_class(m, (sl_auto_class) class, &best[class], &near[class], &three[class], fixed[class]);
    puts("\n<!-- table auto -->\n| error | scenes | the choice is the first | within 1.5 times the first | "
         "within 3 times | the one method that is most often within 1.5 times |\n| ---: | ---: | ---: | ---: "
         "| ---: | --- |");
    for (int class = 0; class < SL_AUTO_CLASSES; class++) {
        int most = 0;
        for (int c = 0; c < SL_AUTO_CANDIDATES; c++) most = fixed[class][c] > fixed[class][most] ? c : most;
        printf("| %g %% | %zu | %zu | %zu | %zu | %s: %.0f |\n",
               100.0 * sl_auto_error_of((sl_auto_class) class), m->count, best[class], near[class],
               three[class], sl_auto_curve_of((sl_auto_candidate)most), fixed[class][most]);
    }
    puts("<!-- end -->");
}

int main(int argc, char **argv) {
    static measured m;
    bool judge = argc > 2 && strcmp(argv[1], "--judge") == 0;
    if (argc != (judge ? 3 : 2)) {
        fputs("usage: bench_auto [--judge] FOLDER\n", stderr);
        return 2;
    }
    if (!read_scenes(argv[argc - 1], &m) || !read_rows(argv[argc - 1], &m)) return 3;
    fill_seconds(&m);
    if (judge) print_judgement(&m);
    else print_table(&m);
    for (size_t i = 0; i < m.count; i++) free(m.rows[i].rows);
    return 0;
}
