/* One line a row: for programs. */
#include "app/bench/report.h"

static const char head[] = "scene,hash,width,height,method,curve,setting,quality,transport,arguments,end,why,"
                           "runs,cpu_seconds,cpu_least,cpu_most,wall_seconds,wall_least,"
                           "wall_most,first_picture_cpu_seconds,peak_bytes,method_bytes,rays,shadow_rays,"
                           "records,samples,fragments_shaded";

static void put_text(FILE *out, const char *text) {
    fputc('"', out);
    for (; *text; text++) {
        if (*text == '"') fputc('"', out);
        fputc(*text, out);
    }
    fputs("\",", out);
}

static void put_row(FILE *out, const sl_bench_scene *s, const sl_bench_row *r) {
    put_text(out, s->path);
    fprintf(out, "%s,%d,%d,", s->hash, s->width, s->height);
    put_text(out, r->method);
    put_text(out, r->curve);
    put_text(out, r->name);
    fprintf(out, "%s,%s,", sl_bench_quality_name(r->quality), r->transport);
    put_text(out, r->arguments);
    fprintf(out, "%s,", sl_bench_end_name(r->end));
    put_text(out, r->end == SL_BENCH_RAN ? "" : r->why);
    fprintf(out, "%d,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,", r->cpu.count, r->cpu.median, r->cpu.least,
            r->cpu.most, r->wall.median, r->wall.least, r->wall.most, r->first_picture);
    fprintf(out, "%llu,%llu,%llu,%llu,%llu,%llu,%llu", (unsigned long long)r->peak_bytes,
            (unsigned long long)r->method_bytes, (unsigned long long)r->rays,
            (unsigned long long)r->shadow_rays, (unsigned long long)r->records,
            (unsigned long long)r->samples, (unsigned long long)r->fragments);
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        const sl_bench_error *e = &r->error[t];
        if (!e->known) fputs(",,,,,,,,", out);
        else
            fprintf(out, ",%.6g,%s,%.6g,%.6g,%.6g,%.6g,%.6g,%llu", e->rel_rmse, e->lost ? "yes" : "no",
                    e->doubt, e->noise, e->rel_mse, e->bias, e->flip, (unsigned long long)e->nonfinite);
    }
    const sl_bench_promise *p = &r->promise;
    if (p->known) fprintf(out, ",%.6g,%.6g,%.6g", p->estimate, p->bound, p->cpu_seconds);
    else fputs(",,,", out);
    if (p->measured_known) fprintf(out, ",%.6g", p->measured);
    else fputc(',', out);
    fputc('\n', out);
}

static void put_csv(FILE *out, const sl_bench_results *results) {
    fputs(head, out);
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        const char *n = sl_bench_truth_name((sl_bench_truth)t);
        fprintf(
            out,
            ",%s_rel_rmse,%s_is_bound,%s_doubt,%s_reference_noise,%s_rel_mse,%s_bias,%s_flip,%s_nonfinite", n,
            n, n, n, n, n, n, n);
    }
    fputs(",estimate_rel_rmse,estimate_bound,estimate_cpu_seconds,whole_picture_rel_rmse\n", out);
    for (size_t s = 0; s < results->scene_count; s++) {
        for (size_t i = 0; i < results->scenes[s].row_count; i++)
            put_row(out, &results->scenes[s], &results->scenes[s].rows[i]);
    }
}

sl_status sl_report_csv(const sl_bench_results *results, const char *folder, sl_error *error) {
    return sl_report_compose(results, folder, "results.csv", put_csv, error);
}
