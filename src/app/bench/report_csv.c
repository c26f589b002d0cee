/* One line a row: for programs. And the same as JSON. */
#include "app/bench/report.h"

#include "app/utf8.h"

#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

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

/* ---- JSON ---- */

static void add_spread(cJSON *to, const char *name, const sl_bench_spread *s) {
    cJSON *o = cJSON_AddObjectToObject(to, name);
    cJSON_AddNumberToObject(o, "median", s->median);
    cJSON_AddNumberToObject(o, "least", s->least);
    cJSON_AddNumberToObject(o, "most", s->most);
}

static cJSON *row_object(const sl_bench_row *r) {
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "method", r->method);
    cJSON_AddStringToObject(o, "curve", r->curve);
    cJSON_AddStringToObject(o, "setting", r->name);
    cJSON_AddStringToObject(o, "quality", sl_bench_quality_name(r->quality));
    cJSON_AddStringToObject(o, "arguments", r->arguments);
    cJSON_AddStringToObject(o, "end", sl_bench_end_name(r->end));
    if (r->end != SL_BENCH_RAN) cJSON_AddStringToObject(o, "why", r->why);
    cJSON_AddNumberToObject(o, "runs", r->cpu.count);
    add_spread(o, "cpu_seconds", &r->cpu);
    add_spread(o, "wall_seconds", &r->wall);
    cJSON_AddNumberToObject(o, "first_picture_cpu_seconds", r->first_picture);
    cJSON_AddNumberToObject(o, "peak_bytes", (double)r->peak_bytes);
    cJSON *errors = cJSON_AddObjectToObject(o, "errors");
    for (int t = 0; t < SL_BENCH_TRUTHS; t++) {
        const sl_bench_error *e = &r->error[t];
        if (!e->known) continue;
        cJSON *one = cJSON_AddObjectToObject(errors, sl_bench_truth_name((sl_bench_truth)t));
        cJSON_AddNumberToObject(one, "rel_rmse", e->rel_rmse);
        cJSON_AddBoolToObject(one, "is_bound", e->lost);
        cJSON_AddNumberToObject(one, "doubt", e->doubt);
        cJSON_AddNumberToObject(one, "reference_noise", e->noise);
        cJSON_AddNumberToObject(one, "rel_mse", e->rel_mse);
        cJSON_AddNumberToObject(one, "bias", e->bias);
        cJSON_AddNumberToObject(one, "flip", e->flip);
    }
    return o;
}

void sl_report_json(const sl_bench_results *results, FILE *out) {
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "version", results->version);
    cJSON_AddStringToObject(root, "machine", results->machine);
    cJSON_AddNumberToObject(root, "processors", results->processors);
    cJSON_AddNumberToObject(root, "threads", results->threads);
    cJSON_AddBoolToObject(root, "noisy", results->noisy);
    cJSON_AddNumberToObject(root, "unrest", results->unrest);
    cJSON_AddBoolToObject(root, "interrupted", results->interrupted);
    cJSON *scenes = cJSON_AddArrayToObject(root, "scenes");
    for (size_t s = 0; s < results->scene_count; s++) {
        const sl_bench_scene *scene = &results->scenes[s];
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "scene", scene->path);
        cJSON_AddStringToObject(o, "hash", scene->hash);
        cJSON_AddNumberToObject(o, "width", scene->width);
        cJSON_AddNumberToObject(o, "height", scene->height);
        if (scene->trouble[0]) cJSON_AddStringToObject(o, "trouble", scene->trouble);
        cJSON *rows = cJSON_AddArrayToObject(o, "rows");
        for (size_t i = 0; i < scene->row_count; i++) cJSON_AddItemToArray(rows, row_object(&scene->rows[i]));
        cJSON_AddItemToArray(scenes, o);
    }
    char *text = cJSON_Print(root);
    if (text) fprintf(out, "%s\n", sl_utf8_mend(text));
    cJSON_free(text);
    cJSON_Delete(root);
}
