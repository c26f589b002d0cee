/* The results as files in a folder: results.csv, report.md, report.html, tables.md, and plots as
 * SVG. A file appears whole or not at all. */
#pragma once

#include "app/bench/results.h"

#include <stdio.h>

/* Writes all of them. */
sl_status sl_report_write(const sl_bench_results *results, const char *folder, sl_error *error);
/* Prints to the terminal what matters. */
void sl_report_terminal(const sl_bench_results *results, FILE *out);

/* ---- what the writers share ---- */

/* Prints the report's beginning, of sl_bench_results, as Markdown. */
void sl_report_overview(FILE *out, const void *results);
/* Prints what it says of an sl_bench_scene. */
void sl_report_scene(FILE *out, const void *scene);
/* tables.md: what a page in words quotes, each table between <!-- table NAME --> and <!-- end -->; those of a
 * file of trials are a row for each trial in each scene. Of sl_bench_results. */
void sl_report_tables(FILE *out, const void *results);

/* Prints the head of a table in Markdown; columns stand between bars, figures with a > before their names. */
void sl_report_head(FILE *out, const char *columns);
/* "3.2 %"; "3.2 ± 0.4 %" where more than a tenth of it is in doubt; "< 0.04 %": at most, and perhaps nothing;
 * "-" where it is not known. */
void sl_error_text(const sl_bench_error *error, char text[32]);
/* Writes what a reference leaves out of full global illumination: "36.2 %"; "≥ 17 %" where the estimate is
 * below what the missing energy alone makes of it, and so lost in the references' noise. */
void sl_missing_text(const sl_bench_reference *reference, char text[32]);
/* "0.31" to three digits; "" for 0. */
void sl_seconds_text(double seconds, char text[32]);

/* ---- plot.c: SVG, for light and for dark paper, as files and inside a page ---- */

/* Error over time, both logarithmic, a curve a method. */
typedef struct sl_plot {
    const sl_bench_scene *scene;
    sl_bench_truth truth;
} sl_plot;

/* Tells whether there is anything to be drawn: two settings with a known error. */
bool sl_plot_is_there(const sl_plot *plot);
/* Draws an sl_plot. */
void sl_put_plot(FILE *out, const void *plot);

/* ---- tables about trials (cells.c has the columns' names) ---- */

enum { SL_CELL = 512 };

/* Takes the next name of a list with commas between; false after the last. */
bool sl_next_column(const char **at, char column[SL_CELL]);
/* plain: a bare number, or nothing where it is not known. */
void sl_cell(const sl_bench_scene *scene, const sl_bench_row *row, const char *column, bool plain,
             char cell[SL_CELL]);
/* Tells whether the column's cells are words. */
bool sl_cell_is_text(const char *column);
/* Prints a table's head; then a scene's rows, those of one of the trials' tables (-1: of any). A trial that
 * did not run to its end says so instead of figures. */
void sl_report_columns(FILE *out, const char *columns);
void sl_report_rows(FILE *out, const sl_bench_scene *scene, int table, const char *columns);
