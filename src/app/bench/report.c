#include "app/bench/report.h"

#include "app/bench/curves.h"
#include "app/html.h"
#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

sl_status sl_report_write(const char *folder, const char *name, const char *text, sl_error *error) {
    char path[SL_BENCH_PATH];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return sl_text_write(path, text, strlen(text), error);
}

sl_status sl_report_compose(const sl_bench_results *results, const char *folder, const char *name,
                            void (*put)(FILE *out, const sl_bench_results *results), sl_error *error) {
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (out) put(out, results);
    bool whole = out && !ferror(out);
    if (out && fclose(out) != 0) whole = false;
    sl_status status = whole ? sl_report_write(folder, name, text, error) : sl_fail_memory(error, name);
    free(text);
    return status;
}

/* What is in doubt by less than this share of an error goes without saying. */
static const double silent_doubt = 0.1;

static int digits_of(double percent) {
    return percent >= 100.0 ? 0 : percent >= 9.95 ? 1 : percent >= 0.995 ? 2 : 3;
}

void sl_error_text(const sl_bench_error *e, char text[32]) {
    double percent = 100.0 * e->rel_rmse, doubt = 100.0 * e->doubt;
    if (!e->known) snprintf(text, 32, "-");
    else if (e->lost || !(e->doubt > silent_doubt * e->rel_rmse))
        snprintf(text, 32, "%s%.*f %%", e->lost ? "< " : "", digits_of(percent), percent);
    else snprintf(text, 32, "%.*f ± %.*f %%", digits_of(percent), percent, digits_of(percent), doubt);
}

void sl_reference_text(const sl_bench_reference *r, char text[96]) {
    if (!(r->wanted > 0.0)) text[0] = '\0';
    else
        snprintf(text, 96, "%.2g ± %.1g %%%s", 1000.0 * r->wanted, 1000.0 * r->wanted * r->doubt,
                 r->noise <= r->wanted ? "" : ", noise above a tenth");
}

/* No picture is nearer to another, by the root of the mean square, than their means are. */
void sl_missing_text(const sl_bench_reference *r, int digits, char text[32]) {
    const double slack = 0.98; /* of two figures that are noisy, too */
    int fewer = digits > 0 ? digits - 1 : 0;
    double least = fabs(1.0 - r->energy), step = pow(10.0, -fewer);
    bool lost = r->energy > 0.0 && r->missing < slack * least && 100.0 * least >= 0.5 * step;
    if (lost) snprintf(text, 32, "≥ %.*f %%", fewer, 100.0 * least);
    else snprintf(text, 32, "%.*f %%", digits, 100.0 * r->missing);
}

void sl_promise_text(const sl_bench_promise *p, char text[64]) {
    if (p->known) snprintf(text, 64, "%.3g %%, at most %.3g %%", 100.0 * p->estimate, 100.0 * p->bound);
    else snprintf(text, 64, "-");
}

void sl_seconds_text(double seconds, char text[32]) {
    int digits = seconds >= 99.5 ? 0 : seconds >= 9.95 ? 1 : seconds >= 0.995 ? 2 : 3;
    snprintf(text, 32, "%.*f", digits, seconds);
}

sl_bench_lead sl_bench_lead_at(const sl_bench_scene *scene, sl_bench_truth truth, double error) {
    sl_curve curves[SL_CURVES];
    sl_bench_lead lead = {NULL, 0.0, 0.0, false};
    char path[SL_BENCH_NAME];
    size_t count = sl_curves_of(scene, truth, curves);
    snprintf(path, sizeof path, "path, %s", sl_bench_truth_name(truth));
    for (size_t i = 0; i < count; i++) {
        double seconds = sl_curve_time_to(&curves[i], truth, error);
        if (strcmp(curves[i].name, path) == 0) {
            lead.path_later = !(seconds > 0.0);
            lead.path_seconds = lead.path_later ? curves[i].row[curves[i].count - 1]->cpu.median : seconds;
        }
        if (sl_curve_is_peer(&curves[i]) || !(seconds > 0.0)) continue;
        if (!lead.method || seconds < lead.seconds) lead.method = curves[i].name, lead.seconds = seconds;
    }
    return lead;
}
