/* The results as files in a folder: results.csv, report.md, report.html, and plots as SVG. A file appears
 * whole or not at all. */
#ifndef SL_APP_BENCH_REPORT_H
#define SL_APP_BENCH_REPORT_H

#include "app/bench/results.h"
#include "softlux.h"

#include <stdio.h>

sl_status sl_report_csv(const sl_bench_results *results, const char *folder, sl_error *error);
sl_status sl_report_markdown(const sl_bench_results *results, const char *folder, sl_error *error);
sl_status sl_report_html(const sl_bench_results *results, const char *folder, sl_error *error);
/* tables.md: what a page in words quotes, each table between <!-- table NAME --> and <!-- end -->. */
sl_status sl_report_summary(const sl_bench_results *results, const char *folder, sl_error *error);
/* Puts the tables of a file of trials into that file: a row for each trial in each scene. */
void sl_report_trials(FILE *out, const sl_bench_results *results);
/* SCENE-one-bounce.svg and the like. */
sl_status sl_report_plots(const sl_bench_results *results, const char *folder, sl_error *error);
/* Prints to the terminal what matters, a line each. */
void sl_report_terminal(const sl_bench_results *results, FILE *out);

/* ---- what the writers share ---- */

/* Print the report's beginning, and what it says of a scene, as Markdown. */
void sl_report_overview(FILE *out, const sl_bench_results *results);
void sl_report_scene(FILE *out, const sl_bench_scene *scene);

/* Writes text as folder/name. */
sl_status sl_report_write(const char *folder, const char *name, const char *text, sl_error *error);
/* Writes what put prints of the results as folder/name. */
sl_status sl_report_compose(const sl_bench_results *results, const char *folder, const char *name,
                            void (*put)(FILE *out, const sl_bench_results *results), sl_error *error);
/* "3.2 %"; "3.2 ± 0.4 %" where more than a tenth of it is in doubt; "< 0.04 %": at most, and perhaps nothing;
 * "-" where it is not known. */
void sl_error_text(const sl_bench_error *error, char text[32]);
/* Prints how often errors told without a reference hold, as a table. */
void sl_report_promises(FILE *out, const sl_bench_results *results);
/* Writes the smallest error told with a reference, and how much of the reference's noise is in it; "" where
 * none is told. */
void sl_reference_text(const sl_bench_reference *reference, char text[96]);
/* Writes what a reference leaves out of full global illumination, with so many digits behind the point:
 * "36.19 %"; "≥ 17.2 %", with one digit less, where the estimate is below what the missing energy alone makes
 * of it, and so lost in the references' noise. */
void sl_missing_text(const sl_bench_reference *reference, int digits, char text[32]);
/* "3.1 %, at most 3.9 %", or "-". */
void sl_promise_text(const sl_bench_promise *promise, char text[64]);
/* "0.31" to three digits. */
void sl_seconds_text(double seconds, char text[32]);

/* How much sooner than the path tracer the best of the methods reaches an error against a truth. */
typedef struct sl_bench_lead {
    const char *method; /* NULL: none reaches it */
    double seconds;
    double path_seconds; /* until the path tracer is there */
    bool path_later;     /* it was not there after path_seconds, the longest that was tried */
} sl_bench_lead;
sl_bench_lead sl_bench_lead_at(const sl_bench_scene *scene, sl_bench_truth truth, double error);

#endif
