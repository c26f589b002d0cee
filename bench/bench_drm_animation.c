/* Flicker: a light or an object glides along a path in front of a fixed camera, and the indirect light of
 * each pixel ought to glide too. With few photons it jumps, whenever a sample moves from one surface to
 * another (the paper's flashing).
 *
 * A frame's flicker at a pixel is |(v_t - v_(t-1)) - (r_t - r_(t-1))|, r being the same method with so many
 * photons (24 x 24 a face, flux filter) that none of them matters; so what the light's own motion changes is
 * taken off. Beside it the second difference |v_(t+1) - 2 v_t + v_(t-1)|, which needs no reference. Both in
 * shares of the mean of r. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "drm_bench.h"
#include "timing.h"

enum { FRAMES = 100, REFERENCE_SAMPLES = 24, VARIANTS_MAX = 16 };
static const double frames_a_second = 25.0;

typedef struct variant {
    char name[32];
    int samples;
    sl_map_filter filter;
} variant;

typedef struct flicker {
    double mean, largest;             /* of |dv - dr|, over pixels, frames: mean and maximum */
    double worst_frame;               /* largest mean of a frame */
    double second, second_largest;    /* second differences */
    double apart;                     /* mean |v - r| */
    double seconds;                   /* processor time of a frame */
    double frame[FRAMES];             /* mean of each */
} flicker;

typedef struct series {
    int size, frames;
    size_t values;                    /* of a frame */
    float *reference, *ours;          /* all frames */
    double mean;
} series;

/* ---- frames ---- */

static sl_settings settings_of(const series *s, const variant *v) {
    sl_settings settings = sl_settings_default();
    settings.method = "direct-radiance";
    settings.width = settings.height = s->size;
    settings.threads = 1;
    sl_radiance_map_settings *m = &settings.radiance_map;
    m->samples = v->samples;
    m->filter = v->filter;
    m->weight = SL_WEIGHT_FLUX;
    return settings;
}

static void copy_layer(const sl_image *image, float *out) {
    size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t c = 0; c < 3; c++) {
        const float *plane = drm_layer(image, "indirect", "RGB"[c]);
        if (!plane) bench_fail("no indirect layer", NULL);
        memcpy(out + c * pixels, plane, pixels * sizeof *out);
    }
}

/* Returns processor seconds a frame. */
static double render(sl_scene *scene, const series *s, const variant *v, float *out, const bench_report *r,
                     const char *picture) {
    sl_settings settings = settings_of(s, v);
    drm_frames f;
    sl_error error;
    double spent = 0.0;
    unsigned changes;
    if (sl_scene_set_time(scene, 0.0, &changes, &error) != SL_OK) bench_fail("time", &error);
    drm_frames_open(&f, scene, &settings);
    for (int t = 0; t < s->frames; t++) {
        if (sl_scene_set_time(scene, t / frames_a_second * FRAMES / s->frames, &changes, &error) != SL_OK)
            bench_fail("time", &error);
        double from = process_ms();
        drm_frame(&f, t ? changes : 0);
        spent += 1e-3 * (process_ms() - from);
        copy_layer(f.image, out + (size_t)t * s->values);
        char what[32];
        snprintf(what, sizeof what, "%d", t);
        if (picture && t % (s->frames / 4) == 0) bench_write_picture(r, picture, what, f.image);
    }
    drm_frames_close(&f);
    return spent / s->frames;
}

/* ---- flicker ---- */

static double mean_of(const float *values, size_t count) {
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) sum += (double)values[i];
    return count ? sum / (double)count : 0.0;
}

static void judge_frame(const series *s, int t, flicker *f) {
    const float *v = s->ours + (size_t)t * s->values, *r = s->reference + (size_t)t * s->values;
    double sum = 0.0, scale = 1.0 / s->mean, share = 1.0 / (double)s->values;
    for (size_t i = 0; i < s->values; i++) {
        f->apart += fabs((double)v[i] - (double)r[i]) * scale * share / s->frames;
        if (t == 0) continue;
        const float *v0 = v - s->values, *r0 = r - s->values;
        double change = fabs(((double)v[i] - (double)v0[i]) - ((double)r[i] - (double)r0[i])) * scale;
        sum += change * share;
        f->largest = fmax(f->largest, change);
        if (t == s->frames - 1) continue;
        double second = fabs((double)v[i + s->values] - 2.0 * (double)v[i] + (double)v0[i]) * scale;
        f->second += second * share / (s->frames - 2);
        f->second_largest = fmax(f->second_largest, second);
    }
    f->frame[t] = sum;
    f->mean += sum / (s->frames - 1);
    f->worst_frame = fmax(f->worst_frame, sum);
}

static flicker judge(const series *s) {
    flicker f = {0};
    for (int t = 0; t < s->frames; t++) judge_frame(s, t, &f);
    return f;
}

/* ---- the drawing: frames across, mean flicker up by decades ---- */

enum { LEFT = 80, RIGHT = 700, TOP = 40, BOTTOM = 400 };

typedef struct drawing {
    FILE *file;
    double low, high; /* decades */
    int frames;
} drawing;

static double place_x(const drawing *d, double t) { return LEFT + (RIGHT - LEFT) * t / d->frames; }
static double place_y(const drawing *d, double value) {
    double decade = fmin(fmax(log10(fmax(value, 1e-12)), d->low), d->high);
    return BOTTOM - (BOTTOM - TOP) * (decade - d->low) / (d->high - d->low);
}

static void draw_axes(const drawing *d, const char *title) {
    fprintf(d->file,
            "<text x=\"%d\" y=\"24\" text-anchor=\"middle\" font-size=\"15\">%s: mean flicker of the "
            "indirect light</text>\n",
            (LEFT + RIGHT) / 2, title);
    for (int t = 0; t <= d->frames; t += d->frames / 5)
        fprintf(d->file,
                "<path d=\"M%.1f %dV%d\" stroke=\"#ccc\"/><text x=\"%.1f\" y=\"%d\" "
                "text-anchor=\"middle\">%d</text>\n",
                place_x(d, t), TOP, BOTTOM, place_x(d, t), BOTTOM + 20, t);
    for (double decade = d->low; decade <= d->high; decade++) {
        double y = place_y(d, pow(10.0, decade));
        fprintf(d->file,
                "<path d=\"M%d %.1fH%d\" stroke=\"#ccc\"/><text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%g "
                "%%</text>\n",
                LEFT, y, RIGHT, LEFT - 6, y + 4.0, 100.0 * pow(10.0, decade));
    }
    fprintf(d->file, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">frame</text>\n", (LEFT + RIGHT) / 2,
            BOTTOM + 42);
}

static void draw_line(const drawing *d, const flicker *f, const char *name, const char *color, int place) {
    char command = 'M';
    fprintf(d->file, "<path fill=\"none\" stroke=\"%s\" stroke-width=\"1.5\" d=\"", color);
    for (int t = 1; t < d->frames; t++, command = 'L')
        fprintf(d->file, "%c%.1f %.1f", command, place_x(d, t), place_y(d, f->frame[t]));
    fprintf(d->file, "\"/>\n<text x=\"%d\" y=\"%d\" fill=\"%s\">%s</text>\n", RIGHT + 10,
            TOP + 18 * (place + 1), color, name);
}

static void draw(const bench_report *r, const char *scene, const variant *variants, const flicker *results,
                 int count, int frames) {
    static const char *const colors[] = {"#06c", "#c40", "#282", "#a3a", "#c90",
                                         "#088", "#444", "#e57", "#59f", "#7a0"};
    char path[700];
    snprintf(path, sizeof path, "%s/flicker-%s.svg", r->folder, scene);
    drawing d = {fopen(path, "w"), INFINITY, -INFINITY, frames};
    if (!d.file) return;
    for (int i = 0; i < count; i++) {
        for (int t = 1; t < frames; t++) {
            if (!(results[i].frame[t] > 0.0)) continue;
            d.low = fmin(d.low, floor(log10(results[i].frame[t])));
            d.high = fmax(d.high, ceil(log10(results[i].frame[t])));
        }
    }
    d.low = fmax(d.low, d.high - 4.0);
    fprintf(d.file, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"860\" height=\"460\" "
                    "font-family=\"sans-serif\" font-size=\"12\">\n"
                    "<rect width=\"860\" height=\"460\" fill=\"white\"/>\n");
    draw_axes(&d, scene);
    for (int i = 0, shown = 0; i < count; i++) {
        if (variants[i].samples == 4)
            draw_line(&d, &results[i], variants[i].name, colors[shown % 10], shown), shown++;
    }
    fprintf(d.file, "</svg>\n");
    fclose(d.file);
}

/* ---- the experiment ---- */

static int make_variants(variant *variants) {
    static const int samples[] = {3, 4, 8};
    static const struct {
        const char *name;
        sl_map_filter filter;
    } kinds[] = {
        {"point", SL_MAP_FILTER_POINT}, {"radiance", SL_MAP_FILTER_RADIANCE}, {"flux", SL_MAP_FILTER_FLUX}};
    int count = 0;
    for (int k = 0; k < 3; k++) {
        for (int m = 0; m < 3; m++) {
            variant *v = &variants[count++];
            *v = (variant){"", samples[m], kinds[k].filter};
            snprintf(v->name, sizeof v->name, "%s, m = %d", kinds[k].name, samples[m]);
        }
    }
    return count;
}

static void write_frames(const bench_report *r, const char *scene, const variant *variants,
                         const flicker *results, int count, int frames) {
    char path[700];
    snprintf(path, sizeof path, "%s/drm_animation-%s-frames.csv", r->folder, scene);
    FILE *file = fopen(path, "w");
    if (!file) return;
    fprintf(file, "frame");
    for (int i = 0; i < count; i++) fprintf(file, ",\"%s\"", variants[i].name);
    for (int t = 1; t < frames; t++) {
        fprintf(file, "\n%d", t);
        for (int i = 0; i < count; i++) fprintf(file, ",%.4e", results[i].frame[t]);
    }
    fprintf(file, "\n");
    fclose(file);
}

static void experiment(bench_report *r, const bench_options *o, const char *path) {
    static const variant converged = {"reference", REFERENCE_SAMPLES, SL_MAP_FILTER_FLUX, false, false};
    char name[64];
    sl_scene *scene;
    variant variants[VARIANTS_MAX];
    flicker results[VARIANTS_MAX];
    series s = {.size = o->brief ? 64 : 128, .frames = o->brief ? 20 : FRAMES};
    int count = make_variants(variants);
    bench_scene_name(path, name);
    if (!bench_wants(o, name) || !bench_open_scene(r, path, &scene)) return;
    s.values = 3 * (size_t)s.size * (size_t)s.size;
    s.reference = calloc(s.values * (size_t)s.frames, sizeof(float));
    s.ours = calloc(s.values * (size_t)s.frames, sizeof(float));
    if (!s.reference || !s.ours) bench_fail("frames", NULL);
    double seconds = render(scene, &s, &converged, s.reference, r, o->pictures ? name : NULL);
    s.mean = mean_of(s.reference, s.values * (size_t)s.frames);
    bench_say(r, "\n%s: %d frames of %d x %d; the reference takes %.1f ms a frame\n", name, s.frames, s.size,
              s.size, 1e3 * seconds);
    bench_table(r, name,
                "scene|filter|photons a face|CPU ms a frame|mean flicker %|worst frame %|largest %|second "
                "difference %|largest %|apart %");
    for (int i = 0; i < count; i++) {
        const variant *v = &variants[i];
        seconds = render(scene, &s, v, s.ours, r, NULL);
        flicker *f = &results[i];
        *f = judge(&s);
        f->seconds = seconds;
        bench_row(r, "%s|%s|%d|%.2f|%.3f|%.2f|%.1f|%.3f|%.1f|%.2f", name, v->name, v->samples * v->samples,
                  1e3 * f->seconds, 100.0 * f->mean, 100.0 * f->worst_frame, 100.0 * f->largest,
                  100.0 * f->second, 100.0 * f->second_largest, 100.0 * f->apart);
    }
    write_frames(r, name, variants, results, count, s.frames);
    draw(r, name, variants, results, count, s.frames);
    bench_say(r, "\n![flicker, %s](pictures/flicker-%s.svg)\n", name, name);
    free(s.reference);
    free(s.ours);
    sl_scene_destroy(scene);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/direct-radiance");
    bench_report r;
    bench_report_open(&r, &o, "drm_animation");
    bench_say(&r, "\nFlicker is what a pixel's indirect light changes by from frame to frame beyond what it "
                  "ought to, in shares of the mean.\n");
    experiment(&r, &o, "scenes/moving-light.json");
    experiment(&r, &o, "scenes/moving-ball.json");
    bench_report_close(&r);
    return 0;
}
