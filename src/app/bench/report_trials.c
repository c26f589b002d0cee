/* The tables that a file of trials asks for. A column is
 *
 *   cpu, wall, first            seconds of the processor and by the clock; until a first picture
 *   peak, method                MB of the whole process, and of what the method tells of itself
 *   matched, one-bounce, full   relative RMSE against the trial's truth, one bounce, all light
 *   matched.mse, matched.bias   the mean square of the relative error; the mean's difference
 *   estimate, bound             the error told without a reference, and its bound
 *   part.NAME                   processor seconds of all passes whose names begin so
 *   any other word              the picture's metadata softlux.WORD: counter.records, octree.leaves */
#include "app/bench/report.h"

#include <stdlib.h>
#include <string.h>

enum { CELL = 64 };

/* Returns the processor seconds of all passes whose names begin so. */
static double part_seconds(const sl_bench_row *row, const char *name) {
    double share = 0.0;
    const cJSON *part;
    cJSON_ArrayForEach(part, cJSON_GetObjectItem(row->look, "parts"))
        share += strncmp(part->string, name, strlen(name)) == 0 ? part->valuedouble : 0.0;
    return share * row->cpu.median;
}

static bool error_cell(const sl_bench_row *row, const char *column, char *cell) {
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        const char *name = sl_bench_truth_name((sl_bench_truth)t), *more = column + strlen(name);
        const sl_bench_error *e = &row->error[t];
        if (strncmp(column, name, strlen(name)) != 0) continue;
        if (!*more || !e->known) sl_error_text(e, cell);
        else if (strcmp(more, ".mse") == 0) snprintf(cell, CELL, "%.2e", e->rel_mse);
        else snprintf(cell, CELL, "%+.2f %%", 100.0 * e->bias);
        return true;
    }
    return false;
}

static bool number_cell(const sl_bench_row *row, const char *column, char *cell) {
    const struct {
        const char *name;
        double value;
        bool share;
    } numbers[] = {{"cpu", row->cpu.median, false},
                   {"wall", row->wall.median, false},
                   {"first", sl_bench_number(row->look, "first_picture"), false},
                   {"peak", sl_bench_number(row->result, "peak_bytes") / 1048576.0, false},
                   {"method", sl_bench_number(row->result, "method_bytes") / 1048576.0, false},
                   {"estimate", sl_bench_number(row->result, "estimate"), true},
                   {"bound", sl_bench_number(row->result, "bound"), true}};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        if (strcmp(column, numbers[i].name) != 0) continue;
        if (!numbers[i].share) sl_seconds_text(numbers[i].value, cell);
        else if (!sl_bench_promises(row)) snprintf(cell, CELL, "-");
        else snprintf(cell, CELL, "%.2f %%", 100.0 * numbers[i].value);
        return true;
    }
    return false;
}

static void put_cell(FILE *out, const sl_bench_row *row, const sl_image *picture, const char *column) {
    char cell[CELL], key[CELL + 16];
    snprintf(key, sizeof key, "softlux.%s", column);
    const char *told = picture ? sl_image_metadata(picture, key) : NULL;
    if (strncmp(column, "part.", 5) == 0) sl_seconds_text(part_seconds(row, column + 5), cell);
    else if (!number_cell(row, column, cell) && !error_cell(row, column, cell))
        snprintf(cell, sizeof cell, "%s", told ? told : "");
    fprintf(out, " %s |", cell);
}

/* Takes the next of a table's columns; false after the last. */
static bool next_column(const char **at, char column[CELL]) {
    size_t length;
    const char *item = sl_next_item(at, ", ", &length);
    if (item) snprintf(column, CELL, "%.*s", (int)length, item);
    return item != NULL;
}

static void put_row(FILE *out, const sl_trial_table *table, const char *scene, const sl_bench_row *row) {
    const char *at = table->columns;
    char column[CELL];
    sl_image *picture = NULL;
    fprintf(out, "| %s | %s |", scene, row->trial->name);
    if (row->end == SL_CHILD_DONE && sl_image_read(row->picture, &picture, NULL) != SL_OK) picture = NULL;
    if (row->end != SL_CHILD_DONE) fprintf(out, " %s: %s |", sl_bench_end_name(row->end), row->why);
    else
        while (next_column(&at, column)) put_cell(out, row, picture, column);
    fputc('\n', out);
    sl_image_destroy(picture);
}

static void put_table(FILE *out, const sl_bench_results *r, int index) {
    const sl_trial_table *table = &r->trials->table[index];
    const char *at = table->columns;
    char column[CELL], columns[1024] = "scene|trial";
    for (size_t used; next_column(&at, column);)
        used = strlen(columns), snprintf(columns + used, sizeof columns - used, "|>%s", column);
    fprintf(out, "<!-- table %s -->\n", table->name);
    sl_report_head(out, columns);
    for (size_t s = 0; s < r->scene_count; s++) {
        for (size_t i = 0; i < r->scenes[s].row_count; i++) {
            const sl_bench_row *row = &r->scenes[s].rows[i];
            if (row->trial->table == index) put_row(out, table, r->scenes[s].name, row);
        }
    }
    fputs("<!-- end -->\n", out);
}

void sl_report_trials(FILE *out, const sl_bench_results *r) {
    fprintf(out,
            "<!-- table machine -->\nsoftlux %s, %s, %d thread%s, %d run%s. Times are the processor's.\n<!-- "
            "end -->\n",
            r->version, r->machine, r->threads, r->threads == 1 ? "" : "s", r->repeats,
            r->repeats == 1 ? "" : "s");
    for (size_t i = 0; i < r->trials->table_count; i++) put_table(out, r, (int)i);
}
