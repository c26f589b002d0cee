/* A cell of a table about trials, by the name of its column:
 *
 *   scene, file, hash, method, curve, trial, quality, transport, arguments, end, why
 *   width, height, runs         pixels; how often it was measured
 *   cpu, wall, first            seconds of the processor and by the clock; until a first picture. With .least
 *                               and .most, but the last
 *   peak, memory                MB of the whole process, and of what the method tells of itself
 *   matched, one-bounce, full   relative RMSE against the trial's truth, one bounce, all light. With .doubt,
 *                               .lost, .noise (of the reference), .mse, .bias, .flip, .nonfinite
 *   estimate, bound             the error told without a reference, and its bound
 *   part.NAME                   processor seconds of all passes whose names begin so
 *   any other word              the picture's metadata softlux.WORD: counter.records, octree.leaves */
#include "app/bench/report.h"

#include "app/page.h"

#include <math.h>
#include <string.h>

typedef enum form { COUNT, SECONDS, SHARE, SIGNED_SHARE, SQUARE } form;

typedef struct figure {
    const char *column;
    form form;
    double value; /* NaN: not known */
} figure;

typedef struct text {
    const char *column, *text;
} text;

enum { TEXTS = 11 };

static void list_texts(const sl_bench_scene *s, const sl_bench_row *r, text to[TEXTS]) {
    const text all[TEXTS] = {{"scene", s->name},
                             {"file", s->path},
                             {"hash", s->hash},
                             {"method", r->trial->method},
                             {"curve", r->trial->curve},
                             {"trial", r->trial->name},
                             {"quality", r->trial->quality},
                             {"transport", r->trial->transport},
                             {"arguments", r->trial->arguments},
                             {"end", sl_bench_end_name(r->end)},
                             {"why", r->end == SL_CHILD_DONE ? "" : r->why}};
    memcpy(to, all, sizeof all);
}

bool sl_cell_is_text(const char *column) {
    static const sl_trial trial = {.quality = ""};
    text texts[TEXTS];
    list_texts(&(sl_bench_scene){0}, &(sl_bench_row){.trial = &trial}, texts);
    for (int i = 0; i < TEXTS; i++)
        if (strcmp(texts[i].column, column) == 0) return true;
    return false;
}

static const char *text_cell(const sl_bench_scene *s, const sl_bench_row *r, const char *column) {
    text texts[TEXTS];
    list_texts(s, r, texts);
    for (int i = 0; i < TEXTS; i++)
        if (strcmp(texts[i].column, column) == 0) return texts[i].text;
    const char *told = cJSON_GetStringValue(
        cJSON_GetObjectItem(cJSON_GetObjectItem(r->result, "metadata"), column));
    return told ? told : "";
}

/* Returns the processor seconds of all passes whose names begin so. */
static double part_seconds(const sl_bench_row *row, const char *name) {
    double share = 0.0;
    const cJSON *part;
    cJSON_ArrayForEach(part, cJSON_GetObjectItem(row->look, "parts"))
        share += strncmp(part->string, name, strlen(name)) == 0 ? part->valuedouble : 0.0;
    return share * row->cpu.median;
}

static bool find(const figure *figures, size_t count, const char *column, figure *found) {
    for (size_t i = 0; i < count; i++) {
        if (strcmp(figures[i].column, column) != 0) continue;
        *found = figures[i];
        return true;
    }
    return false;
}

static bool find_figure(const sl_bench_scene *s, const sl_bench_row *r, const char *column, figure *found) {
    const double megabyte = 0x1p20;
    const bool told = sl_bench_promises(r);
    const figure figures[] = {
        {"width", COUNT, s->width},
        {"height", COUNT, s->height},
        {"runs", COUNT, r->cpu.count},
        {"cpu", SECONDS, r->cpu.median},
        {"cpu.least", SECONDS, r->cpu.least},
        {"cpu.most", SECONDS, r->cpu.most},
        {"wall", SECONDS, r->wall.median},
        {"wall.least", SECONDS, r->wall.least},
        {"wall.most", SECONDS, r->wall.most},
        {"first", SECONDS, sl_bench_number(r->look, "first_picture")},
        {"peak", SECONDS, sl_bench_number(r->result, "peak_bytes") / megabyte},
        {"memory", SECONDS, sl_bench_number(r->result, "method_bytes") / megabyte},
        {"estimate", SHARE, told ? sl_bench_number(r->result, "estimate") : (double)NAN},
        {"bound", SHARE, told ? sl_bench_number(r->result, "bound") : (double)NAN},
    };
    if (strncmp(column, "part.", 5) == 0) {
        *found = (figure){column, SECONDS, part_seconds(r, column + 5)};
        return true;
    }
    return find(figures, sizeof figures / sizeof *figures, column, found);
}

/* Returns the error that a column is of, and leaves in *more what stands behind its name. */
static const sl_bench_error *error_of(const sl_bench_row *row, const char *column, const char **more) {
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        const char *name = sl_bench_truth_name((sl_bench_truth)t);
        *more = column + strlen(name);
        if (strncmp(column, name, strlen(name)) == 0) return &row->error[t];
    }
    return NULL;
}

static bool find_error(const sl_bench_error *e, const char *more, figure *found) {
    const figure figures[] = {
        {"", SHARE, e->rel_rmse},        {".doubt", SHARE, e->doubt},
        {".lost", COUNT, e->lost},       {".noise", SHARE, e->noise},
        {".mse", SQUARE, e->rel_mse},    {".bias", SIGNED_SHARE, e->bias},
        {".flip", SQUARE, e->flip},      {".nonfinite", COUNT, (double)e->nonfinite},
    };
    const bool known = find(figures, sizeof figures / sizeof *figures, more, found);
    if (known && !e->known) found->value = (double)NAN;
    return known;
}

static void print_figure(const figure *f, char cell[SL_CELL]) {
    char seconds[32];
    if (isnan(f->value)) snprintf(cell, SL_CELL, "-");
    else if (f->form == COUNT) snprintf(cell, SL_CELL, "%.0f", f->value);
    else if (f->form == SHARE) snprintf(cell, SL_CELL, "%.2f %%", 100.0 * f->value);
    else if (f->form == SIGNED_SHARE) snprintf(cell, SL_CELL, "%+.2f %%", 100.0 * f->value);
    else if (f->form == SQUARE) snprintf(cell, SL_CELL, "%.2e", f->value);
    else sl_seconds_text(f->value, seconds), snprintf(cell, SL_CELL, "%s", seconds);
}

void sl_cell(const sl_bench_scene *s, const sl_bench_row *r, const char *column, bool plain,
             char cell[SL_CELL]) {
    figure f;
    const char *more;
    const sl_bench_error *e = error_of(r, column, &more);
    if (e && !*more && !plain) sl_error_text(e, cell);
    else if (!(e && find_error(e, more, &f)) && !find_figure(s, r, column, &f))
        snprintf(cell, SL_CELL, "%s", text_cell(s, r, column));
    else if (!plain) print_figure(&f, cell);
    else if (isnan(f.value)) cell[0] = '\0';
    else snprintf(cell, SL_CELL, "%.7g", f.value);
}

bool sl_next_column(const char **at, char column[SL_CELL]) {
    size_t length;
    const char *item = sl_next_item(at, ",", &length);
    const size_t spaces = item ? strspn(item, " ") : 0;
    if (item) snprintf(column, SL_CELL, "%.*s", (int)(length - spaces), item + spaces);
    return item != NULL;
}
