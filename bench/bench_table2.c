/* Table 2 of Gautron et al. 2005: records, seconds and errors on whole scenes, and beside Radiance (Ward
 * 1994) at equal error.
 *
 * The error is that of the method: against the path tracer on exactly the paths that splatting models, at one
 * pixel of each block. Its parts are relative to the whole picture, so that they add up. Where there is an
 * environment, how its light is split between direct and indirect part is the method's own affair, so only
 * the whole is compared. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cache/splatting/plan.h"
#include "splat_bench.h"
#include "timing.h"

typedef struct setting {
    const char *name;
    sl_quality quality;
    double accuracy; /* 0: by quality */
    int gather;      /* 0: by quality */
    uint32_t spp;    /* 0: by quality */
} setting;

static sl_settings settings_of(const setting *s, int width, int height) {
    sl_settings settings = sl_settings_default();
    settings.method = "splatting";
    settings.width = width;
    settings.height = height;
    settings.quality = s->quality;
    settings.accuracy = s->accuracy;
    settings.gather_size = s->gather;
    settings.spp = s->spp;
    return settings;
}

/* ---- errors on the chosen pixels ---- */

typedef struct target {
    bench_pixels pixels;
    bench_reference direct, indirect, whole;
    bool parts; /* direct and indirect part can be compared apart */
    float *values[3];
} target;

static void open_target(const sl_scene *scene, int width, int height, int block, uint32_t samples,
                        target *t) {
    sl_tracer *tracer;
    sl_error error;
    sl_transport transport, direct;
    sl_settings settings = sl_settings_default();
    sl_splat_transport(&settings, &transport);
    direct = transport;
    direct.receiver_lobes = 0;
    transport.emission = false;
    transport.direct_lobes = 0;
    if (sl_tracer_create(scene, 2, NULL, &tracer, &error) != SL_OK) bench_fail("tracer", &error);
    bench_pixels_make(scene, tracer, width, height, block, &t->pixels);
    bench_reference_get(scene, tracer, &direct, &t->pixels, samples, &t->direct);
    bench_reference_get(scene, tracer, &transport, &t->pixels, samples, &t->indirect);
    bench_reference_sum(&t->direct, &t->indirect, &t->whole);
    t->parts = !scene->environment.present;
    for (int i = 0; i < 3; i++) t->values[i] = calloc(3 * t->pixels.count + 1, sizeof(float));
    sl_tracer_destroy(tracer);
}

static void close_target(target *t) {
    for (int i = 0; i < 3; i++) free(t->values[i]);
    bench_reference_free(&t->direct);
    bench_reference_free(&t->indirect);
    bench_reference_free(&t->whole);
    bench_pixels_free(&t->pixels);
}

/* whole, direct, indirect */
static void errors_of(const sl_image *image, target *t, bench_error errors[3]) {
    bench_pick(image, NULL, &t->pixels, t->values[0]);
    bench_pick(image, "direct", &t->pixels, t->values[1]);
    for (size_t i = 0; i < 3 * t->pixels.count; i++) t->values[2][i] = t->values[0][i] - t->values[1][i];
    errors[0] = bench_compare(t->values[0], &t->whole, NULL);
    errors[1] = bench_compare(t->values[1], &t->direct, &t->whole);
    errors[2] = bench_compare(t->values[2], &t->indirect, &t->whole);
}

/* ---- scenes ---- */

static const char *const scene_paths[] = {
    "scenes/generated/atrium.json",    "scenes/generated/cathedral.json",
    "scenes/generated/room.json",      "scenes/cornell.json",
    "bench/scenes/sponza.json",        "bench/scenes/sponza-flat.json",
    "bench/scenes/sponza-crytek.json", "bench/scenes/fzk-haus.json",
    "bench/scenes/classroom.json",     "bench/scenes/veach-ajar.json",
    "bench/scenes/map-complex.json",   "bench/scenes/living-room.json",
};

static const setting settings_shown[] = {{"draft", SL_QUALITY_DRAFT, 0.0, 0, 0},
                                         {"normal", SL_QUALITY_NORMAL, 0.0, 0, 0},
                                         {"high, a 0.15", SL_QUALITY_HIGH, 0.15, 0, 0},
                                         {"high, a 0.1", SL_QUALITY_HIGH, 0.10, 0, 0}};

/* Nothing where nothing was measured. */
static const char *or_blank(double value, int digits, char text[24]) {
    text[0] = '\0';
    if (value > 0.0) snprintf(text, 24, "%.*f", digits, value);
    return text;
}

static void scene_row(bench_report *r, const char *scene, const setting *s, const splat_run *run, target *t) {
    bench_error errors[3];
    char whole[32], direct[32], indirect[32], wall[24], gain[24];
    errors_of(run->image, t, errors);
    double faster = run->wall_two > 0.0 ? run->wall_one / run->wall_two : 0.0;
    double rest = run->cpu[SPLAT_SETUP] + run->cpu[SPLAT_GBUFFER] + run->cpu[SPLAT_COMPOSE];
    bench_row(r, "%s|%s|%zu|%zu|%.2f|%.2f|%.3f|%.2f|%.2f|%s|%s|%.2f|%s|%s|%s|%.1e|%+.2f", scene, s->name,
              run->records[0], run->records[1], run->cpu[SPLAT_DIRECT],
              run->cpu[SPLAT_RECORDS] + run->cpu[SPLAT_RECORDS + 1],
              run->cpu[SPLAT_SPLATS] + run->cpu[SPLAT_SPLATS + 1], rest, run->cpu_all,
              or_blank(run->wall_two, 2, wall), or_blank(faster, 2, gain), 100.0 * errors[0].rel_rmse,
              bench_mse_text(&errors[0], whole), t->parts ? bench_mse_text(&errors[1], direct) : "",
              t->parts ? bench_mse_text(&errors[2], indirect) : "", errors[0].noise, 100.0 * errors[0].bias);
}

/* What a record and its splat cost, and what a gather at every pixel would. */
typedef struct cost_row {
    char scene[64];
    const char *setting;
    double records, receivers, gathers, gather_seconds, splat_seconds, all_seconds;
} cost_row;

enum { COST_ROWS = 64 };
typedef struct costs {
    size_t count;
    cost_row row[COST_ROWS];
} costs;

static void note_costs(costs *c, const char *scene, const setting *s, const splat_run *run) {
    if (c->count == COST_ROWS) return;
    cost_row *row = &c->row[c->count++];
    snprintf(row->scene, sizeof row->scene, "%s", scene);
    row->setting = s->name;
    row->records = (double)(run->records[0] + run->records[1]);
    row->receivers = (double)run->receivers;
    row->gathers = (double)run->counters.value[SL_COUNT_GATHERS];
    row->gather_seconds = run->cpu[SPLAT_RECORDS] + run->cpu[SPLAT_RECORDS + 1];
    row->splat_seconds = run->cpu[SPLAT_SPLATS] + run->cpu[SPLAT_SPLATS + 1];
    row->all_seconds = run->cpu_all;
}

static void costs_table(bench_report *r, const costs *c) {
    bench_say(r, "\nA record and its splat, and a gather at every pixel that reflects, of which the records "
                 "are a sample; *times* as long as\n"
                 "records and splats together (the paper: 29.7 and 47.1, beside another program)\n");
    bench_table(r, "costs", "scene|setting|ms a record|us a splat|splats %|every pixel s|times");
    for (size_t i = 0; i < c->count; i++) {
        const cost_row *row = &c->row[i];
        double every = row->gather_seconds / row->gathers * row->receivers;
        if (!(row->records > 0.0) || !(row->gathers > 0.0)) continue;
        bench_row(r, "%s|%s|%.2f|%.2f|%.2f|%.0f|%.0f", row->scene, row->setting,
                  1e3 * row->gather_seconds / row->records, 1e6 * row->splat_seconds / row->records,
                  100.0 * row->splat_seconds / row->all_seconds, every,
                  every / (row->gather_seconds + row->splat_seconds));
    }
}

static void whole_scene(bench_report *r, const bench_options *o, const char *path, costs *paid) {
    char name[64];
    sl_scene *scene;
    target t;
    bench_scene_name(path, name);
    if (!bench_wants(o, name) || !bench_open_scene(r, path, &scene)) return;
    int size = o->brief ? 200 : o->size ? o->size : 1000;
    uint32_t samples = o->samples ? o->samples : o->brief ? 256 : size < 1000 ? 4096 : 16384;
    open_target(scene, size, size, o->brief ? 10 : size / 50, samples, &t);
    for (size_t i = 0; i < (o->brief ? 2 : sizeof settings_shown / sizeof *settings_shown); i++) {
        const setting *s = &settings_shown[i];
        if (!bench_wants_row(o, s->name)) continue;
        sl_settings settings = settings_of(s, size, size);
        splat_run run;
        splat_render(scene, &settings, o->once, &run);
        scene_row(r, name, s, &run, &t);
        note_costs(paid, name, s, &run);
        if (o->pictures && i < 3) bench_write_picture(r, name, s->name, run.image);
        splat_run_free(&run);
    }
    close_target(&t);
    sl_scene_destroy(scene);
}

static void whole_scenes(bench_report *r, const bench_options *o) {
    bench_say(r, "\nProcessor seconds of one thread; wall 2: of a clock with two threads, and how many times "
                 "as fast those are as one; errors of the whole picture and of its two parts, in shares\n"
                 "of the whole; in brackets where the reference's noise is over a tenth of the squared "
                 "error, which is then not to be relied on.\n");
    bench_table(r, "scenes",
                "scene|setting|irr. rec.|rad. rec.|direct s|records s|splats s|rest s|all s|wall 2 s|2 "
                "threads|relRMSE %|relMSE|of direct|of indirect|"
                "noise|bias %");
    costs paid = {0};
    for (size_t i = 0; i < sizeof scene_paths / sizeof *scene_paths; i++)
        whole_scene(r, o, scene_paths[i], &paid);
    costs_table(r, &paid);
}

/* ---- beside Radiance ---- */

typedef struct peer {
    const char *name;
    double cpu, rel_rmse, rel_mse; /* seconds, share, relMSE; 0: not known */
} peer;

/* Processor seconds on the same kind of machine, and errors measured as ours are (radiance 5.3a unless it
 * says otherwise). */
static const peer cornell_peers[] = {
    {"Radiance .5/256 ds .2", 0.68, 0.106, 1.55e-3},   {"Radiance .5/1024 ds .1", 2.16, 0.042, 2.4e-4},
    {"Radiance .5/1024 ds .05", 6.82, 0.018, 4.8e-5},  {"Radiance .25/1024 dj 0", 7.51, 0.011, 1.8e-5},
    {"Radiance .25/1024 dj .7", 9.65, 0.0094, 1.28e-5}, {"Radiance .15/4096", 30.8, 0.013, 2.4e-5},
    {"Radiance one pass", 133.0, 0.015, 3.1e-5},       {"Radiance 5.4a .5/512", 8.14, 0.019, 5.0e-5},
    {"pbrt-v2 cache 256", 6.55, 0.036, 1.5e-4},        {"pbrt-v2 cache 4096", 21.1, 0.032, 1.2e-4},
};

/* Errors are relative RMS of the means of blocks of 20 x 20 pixels. */
static const peer sponza_peers[] = {
    {"Radiance .25/4096", 93.0, 0.009, 0.0},
    {"Radiance 5.4a .25/1024", 31.0, 0.009, 0.0},
    {"Radiance .25/512", 22.9, 0.011, 0.0},
};

typedef struct trial {
    setting s;
    double part[3]; /* direct light, records, splats */
    double cpu, wall, rel_rmse, rel_mse;
    unsigned long long records;
    char name[48];
} trial;

enum { TRIALS_MAX = 256 };

/* Every accuracy with every gather and every number of light samples; lists end with 0. */
typedef struct trial_grid {
    double accuracy[8];
    int gather[8];
    uint32_t samples[8];
} trial_grid;

static const trial_grid cornell_grid = {
    {1.2, 0.8, 0.5, 0.4, 0.3, 0.15}, {12, 14, 16, 18, 28, 44}, {1, 2, 4, 8, 16, 64}};
static const trial_grid cornell_brief = {{1.2, 0.5, 0.15}, {12, 28}, {1, 4, 64}};
static const trial_grid sponza_grid = {{0.8, 0.5, 0.35, 0.25}, {12, 16, 20, 28}, {1, 2, 4}};

static size_t make_trials(const trial_grid *grid, trial *trials) {
    size_t count = 0;
    for (size_t a = 0; grid->accuracy[a] > 0.0; a++) {
        for (size_t g = 0; grid->gather[g]; g++) {
            for (size_t n = 0; grid->samples[n]; n++) {
                trial *t = &trials[count++];
                double accuracy = grid->accuracy[a];
                *t = (trial){.s = {NULL, accuracy < 0.3 ? SL_QUALITY_HIGH : SL_QUALITY_NORMAL, accuracy,
                                   grid->gather[g], grid->samples[n]}};
                snprintf(t->name, sizeof t->name, "a %g N %d spp %u", accuracy, grid->gather[g],
                         grid->samples[n]);
            }
        }
    }
    return count;
}

static const trial *cheapest(const trial *trials, size_t count, const peer *p) {
    const trial *best = NULL;
    for (size_t i = 0; i < count; i++) {
        if (trials[i].rel_rmse > p->rel_rmse || (p->rel_mse > 0.0 && trials[i].rel_mse > p->rel_mse))
            continue;
        if (!best || trials[i].cpu < best->cpu) best = &trials[i];
    }
    return best;
}

static void ratio_rows(bench_report *r, const peer *peers, size_t peer_count, const trial *trials,
                       size_t count) {
    for (size_t i = 0; i < peer_count; i++) {
        const peer *p = &peers[i];
        const trial *t = cheapest(trials, count, p);
        char error[32] = "", wall[24], ratio[24];
        if (p->rel_mse > 0.0) snprintf(error, sizeof error, "%.2e", p->rel_mse);
        if (!t)
            bench_row(r, "%s|%.2f|%.2f|%s|none as good|||||||", p->name, p->cpu, 100.0 * p->rel_rmse, error);
        else
            bench_row(r, "%s|%.2f|%.2f|%s|%s|%llu|%.2f|%.2e|%.3f|%s|%.0f|%s", p->name, p->cpu,
                      100.0 * p->rel_rmse, error, t->name, t->records, 100.0 * t->rel_rmse, t->rel_mse,
                      t->cpu, or_blank(t->wall, 3, wall), p->cpu / t->cpu,
                      or_blank(t->wall > 0.0 ? p->cpu / t->wall : 0.0, 0, ratio));
    }
}

static const char ratio_header[] =
    "renderer|its CPU s|relRMSE %|relMSE|ours|records|relRMSE %|relMSE|CPU s|wall 2 s|CPU ratio|wall ratio";

/* Errors under the mask as the peers' were measured: relMSE with 0.01 absolute, noise taken off by two
 * independent references. */
static void masked_errors(const sl_image *x, const sl_image *const reference[2], const sl_image *mask,
                          trial *t) {
    static const char *const names[] = {"R", "G", "B"};
    double square = 0.0, relative = 0.0, mean = 0.0, values = 0.0;
    size_t pixels = (size_t)x->width * (size_t)x->height;
    for (int c = 0; c < 3; c++) {
        const float *p = sl_image_channel(x, names[c]), *a = sl_image_channel(reference[0], names[c]),
                    *b = sl_image_channel(reference[1], names[c]);
        for (size_t i = 0; i < pixels; i++) {
            if (!(mask->planes[i] > 0.5f)) continue;
            double product = ((double)p[i] - (double)a[i]) * ((double)p[i] - (double)b[i]),
                   r = 0.5 * ((double)a[i] + (double)b[i]);
            square += product;
            relative += product / (r * r + 0.01);
            mean += r;
            values++;
        }
    }
    t->rel_mse = fmax(0.0, relative / values);
    t->rel_rmse = sqrt(fmax(0.0, square / values)) / (mean / values);
}

static void write_trials(const bench_options *o, const char *name, const trial *trials, size_t count) {
    char path[700];
    snprintf(path, sizeof path, "%s/table2-%s-trials.csv", o->folder, name);
    FILE *file = fopen(path, "w");
    if (!file) return;
    fprintf(
        file,
        "accuracy,gather,light samples,records,relRMSE,relMSE,direct s,records s,splats s,cpu s,wall 2 s\n");
    for (size_t i = 0; i < count; i++) {
        const trial *t = &trials[i];
        fprintf(file, "%g,%d,%u,%llu,%.5f,%.4e,%.4f,%.4f,%.4f,%.4f,%.4f\n", t->s.accuracy, t->s.gather,
                t->s.spp, t->records, t->rel_rmse, t->rel_mse, t->part[0], t->part[1], t->part[2], t->cpu,
                t->wall);
    }
    fclose(file);
}

static void run_trials(const bench_options *o, const char *name, const sl_scene *scene, int size,
                       trial *trials, size_t count,
                       void (*judge)(const sl_image *image, void *context, trial *t), void *context) {
    for (size_t i = 0; i < count; i++) {
        sl_settings settings = settings_of(&trials[i].s, size, size);
        splat_run run;
        splat_render(scene, &settings, o->once, &run);
        trials[i].cpu = run.cpu_all;
        trials[i].wall = run.wall_two;
        trials[i].records = run.records[0] + run.records[1];
        trials[i].part[0] = run.cpu[SPLAT_DIRECT];
        trials[i].part[1] = run.cpu[SPLAT_RECORDS] + run.cpu[SPLAT_RECORDS + 1];
        trials[i].part[2] = run.cpu[SPLAT_SPLATS] + run.cpu[SPLAT_SPLATS + 1];
        judge(run.image, context, &trials[i]);
        splat_run_free(&run);
    }
    write_trials(o, name, trials, count);
}

typedef struct cornell_judge {
    sl_image *reference[2], *mask;
} cornell_judge;

static void judge_cornell(const sl_image *image, void *context, trial *t) {
    const cornell_judge *j = context;
    const sl_image *references[2] = {j->reference[0], j->reference[1]};
    masked_errors(image, references, j->mask, t);
}

static bool read_image(bench_report *r, const char *path, sl_image **image) {
    sl_error error;
    if (sl_image_read(path, image, &error) == SL_OK) return true;
    bench_say(r, "skip: %s\n", error.message);
    return false;
}

static void beside_radiance_cornell(bench_report *r, const bench_options *o) {
    sl_scene *scene;
    cornell_judge j = {{NULL, NULL}, NULL};
    trial *trials = calloc(TRIALS_MAX, sizeof *trials);
    if (!trials || !bench_wants(o, "cornell-measured") ||
        !bench_open_scene(r, "bench/scenes/cornell-measured.json", &scene)) {
        free(trials);
        return;
    }
    if (read_image(r, "../shared/refs/cornell512_1b_pbrt2048.pfm", &j.reference[0]) &&
        read_image(r, "../shared/refs/cornell512_1b_cycles256.pfm", &j.reference[1]) &&
        read_image(r, "../shared/refs/cornell512_mask.pfm", &j.mask)) {
        size_t count = make_trials(o->brief ? &cornell_brief : &cornell_grid, trials);
        run_trials(o, "cornell", scene, 512, trials, count, judge_cornell, &j);
        bench_say(r, "\nCornell box, 512 x 512, direct light and one diffuse bounce, under the mask; at "
                     "equal or lower error in both columns\n");
        bench_table(r, "radiance-cornell", ratio_header);
        ratio_rows(r, cornell_peers, sizeof cornell_peers / sizeof *cornell_peers, trials, count);
    }
    for (int i = 0; i < 2; i++) sl_image_destroy(j.reference[i]);
    sl_image_destroy(j.mask);
    sl_scene_destroy(scene);
    free(trials);
}

/* Blocks in which a lamp shows are left out: its edges are a pixel filter's affair, and pbrt-v2 filters where
 * we take a pixel's centre. */
static bool shows_lamp(const sl_image *reference, int left, int top, int block) {
    enum { LAMP = 10, MARGIN = 2 };
    size_t pixels = (size_t)reference->width * (size_t)reference->height;
    for (int y = top - MARGIN; y < top + block + MARGIN; y++) {
        for (int x = left - MARGIN; x < left + block + MARGIN; x++) {
            if (x < 0 || y < 0 || x >= reference->width || y >= reference->height) continue;
            for (size_t c = 0; c < 3; c++) {
                if (reference->planes[c * pixels + (size_t)y * (size_t)reference->width + (size_t)x] >
                    (float)LAMP)
                    return true;
            }
        }
    }
    return false;
}

/* Relative RMS of the means of blocks of 20 x 20. */
static void judge_sponza(const sl_image *image, void *context, trial *t) {
    enum { BLOCK = 20 };
    const sl_image *reference = context;
    double square = 0.0, mean = 0.0, blocks = 0.0, all = 0.0;
    size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t c = 0; c < 3; c++) {
        const float *x = sl_image_channel(image, c == 0 ? "R" : c == 1 ? "G" : "B");
        const float *y = reference->planes + c * pixels;
        for (int top = 0; top + BLOCK <= image->height; top += BLOCK) {
            for (int left = 0; left + BLOCK <= image->width; left += BLOCK) {
                double a = 0.0, b = 0.0;
                if (shows_lamp(reference, left, top, BLOCK)) continue;
                for (int i = 0; i < BLOCK * BLOCK; i++) {
                    size_t at = (size_t)(top + i / BLOCK) * (size_t)image->width + (size_t)(left + i % BLOCK);
                    a += (double)x[at] / (BLOCK * BLOCK);
                    b += (double)y[at] / (BLOCK * BLOCK);
                }
                square += (a - b) * (a - b);
                mean += b;
                blocks++;
            }
        }
    }
    sl_comparison whole;
    if (sl_image_compare(image, reference, NULL, &whole, NULL, NULL) == SL_OK) all = whole.rel_mse;
    t->rel_rmse = sqrt(square / blocks) / (mean / blocks);
    t->rel_mse = all;
}

static void beside_radiance_sponza(bench_report *r, const bench_options *o) {
    sl_scene *scene;
    sl_image *reference = NULL;
    trial *trials = calloc(TRIALS_MAX, sizeof *trials);
    if (!trials || o->brief || !bench_wants(o, "sponza-flat") ||
        !bench_open_scene(r, "bench/scenes/sponza-flat.json", &scene)) {
        free(trials);
        return;
    }
    if (read_image(r, "../shared/refs/sponza1000_1b_pbrt1024.pfm", &reference)) {
        size_t count = make_trials(&sponza_grid, trials);
        run_trials(o, "sponza", scene, 1000, trials, count, judge_sponza, reference);
        bench_say(r, "\nSponza without textures, 1000 x 1000: relRMSE of the means of 20 x 20 pixels "
                     "(Radiance's: against its own finest picture;\n"
                     "ours: against pbrt-v2's 1024 samples, blocks with a lamp in them left out); our relMSE "
                     "is of single pixels and holds that reference's noise of 3e-4\n");
        bench_table(r, "radiance-sponza", ratio_header);
        ratio_rows(r, sponza_peers, sizeof sponza_peers / sizeof *sponza_peers, trials, count);
    }
    sl_image_destroy(reference);
    sl_scene_destroy(scene);
    free(trials);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/splatting");
    bench_report r;
    bench_report_open(&r, &o, "table2");
    beside_radiance_cornell(&r, &o);
    beside_radiance_sponza(&r, &o);
    whole_scenes(&r, &o);
    bench_report_close(&r);
    return 0;
}
