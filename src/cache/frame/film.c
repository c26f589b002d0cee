#include "cache/frame/film.h"

#include "base/batch.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/frame/picture_value.h"
#include "cache/frame/rims.h"
#include "image/unset.h"
#include "raster/textures/mip.h"
#include "raster/views/outlines.h"
#include "trace/film.h"
#include "trace/sequence.h"

#include <math.h>
#include <string.h>

/* Whole sub-frames, unless there are no more than these in all: then the first is whole, for frames of things
 * that move; those of edges for which the cache is asked, one in so many and no more than the next; and into
 * how many light samples are shared out behind the pilot. */
enum { PILOT = 4, ASKS_ONE_IN = 16, ASKED_MOST = 8, LATER_SHARE = 8, EDGE_LEAST = 16 };

struct sl_film {
    const sl_scene *scene;
    int width, height;
    unsigned samples, threads;
    bool asks;
    sl_sequence sequence;
    sl_pixel_shape shape;
    sl_outlines *outlines; /* NULL: none yet, of where objects stand */
    bool edges_known;
    unsigned asked, drawn; /* sub-frames */
    unsigned most;         /* of any pixel, once the pilot is there */
    sl_mip *mips;          /* NULL: nothing is textured */
    uint16_t *count;       /* sub-frames that each pixel is in, its first so many; rows from the bottom */
    uint8_t *edge;         /* pixels at edges */
    uint8_t *wanted;       /* of the next sub-frame, behind the pilot */
    sl_image *sums;        /* NULL: no sub-frame yet */
    float *low, *high;     /* of the pilot's samples, in luminance; rows from the bottom */
    double mean;           /* luminance of the pilot's pictures */
    uint8_t *rim;          /* pixels at lamps' rims; NULL: there are none */
    float *rim_emission;   /* what a close-up sees of lamps and sky there, three floats a pixel */
    sl_counters counters, with_method;
};

static unsigned smaller(unsigned a, unsigned b) { return a < b ? a : b; }
static bool is_quick(const sl_film *f) { return f->samples <= PILOT; }
static unsigned pilot_of(const sl_film *f) { return is_quick(f) ? 1 : PILOT; }
static size_t pixels_of(const sl_film *f) { return (size_t)f->width * (size_t)f->height; }

sl_status sl_film_create(const sl_scene *scene, const sl_settings *settings, bool asks, sl_film **film,
                         sl_error *error) {
    sl_film *f = *film = sl_allocate(1, sizeof *f);
    if (!f) return sl_fail_memory(error, "a film");
    *f = (sl_film){.scene = scene, .width = settings->width, .height = settings->height,
                   .samples = settings->sub_samples, .threads = settings->threads, .asks = asks,
                   .shape = sl_pixel_shape_of(settings->filter, sl_filter_radius(settings))};
    const size_t pixels = pixels_of(f);
    f->count = sl_allocate(pixels, sizeof *f->count);
    f->edge = sl_allocate(pixels, sizeof *f->edge);
    f->wanted = sl_allocate(pixels, sizeof *f->wanted);
    f->low = sl_allocate(pixels, sizeof *f->low);
    f->high = sl_allocate(pixels, sizeof *f->high);
    sl_sequence_make(&f->sequence);
    const bool room = f->count && f->edge && f->wanted && f->low && f->high;
    sl_status status = room ? SL_OK : sl_fail_memory(error, "a film");
    if (status == SL_OK) status = sl_mips_create(scene, settings->threads, &f->mips, error);
    if (status == SL_OK) return SL_OK;
    sl_film_destroy(f);
    *film = NULL;
    return status;
}

static void forget_rims(sl_film *f) {
    sl_free(f->rim);
    sl_free(f->rim_emission);
    f->rim = NULL;
    f->rim_emission = NULL;
}

void sl_film_destroy(sl_film *f) {
    if (!f) return;
    forget_rims(f);
    sl_outlines_destroy(f->outlines);
    sl_image_destroy(f->sums);
    sl_mips_destroy(f->scene, f->mips);
    SL_FREE_ALL(f->count, f->edge, f->wanted, f->low, f->high, f);
}

/* ---- which sub-frames ---- */

static sl_status find_edges(sl_film *f, const sl_raster *raster, sl_error *error) {
    const sl_view view = sl_view_of_camera(f->scene, &f->scene->camera, f->width, f->height);
    float *depth = sl_allocate(pixels_of(f), sizeof *depth);
    const sl_target target = {f->width, f->height, NULL, depth};
    sl_status status = depth ? SL_OK : sl_fail_memory(error, "a film");
    if (status == SL_OK && !f->outlines) status = sl_outlines_create(f->scene, &f->outlines, error);
    if (status == SL_OK) status = sl_raster_id(raster, &view, f->threads, &target, &f->counters, error);
    if (status == SL_OK) status = sl_outlines_draw(f->outlines, &view, depth, f->edge, error);
    sl_free(depth);
    return status;
}

/* Adds the pixels beside those that are marked. */
static sl_status widen(const sl_film *f, uint8_t *marked, sl_error *error) {
    const int w = f->width, h = f->height;
    uint8_t *narrow = sl_copy_of(marked, pixels_of(f), sizeof *narrow);
    if (!narrow) return sl_fail_memory(error, "a film");
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++) {
            for (int k = 0; k < 9; k++) {
                const int u = x + k % 3 - 1, v = y + k / 3 - 1;
                if (u < 0 || v < 0 || u >= w || v >= h || !narrow[(size_t)v * (size_t)w + (size_t)u])
                    continue;
                marked[(size_t)y * (size_t)w + (size_t)x] = 1;
            }
        }
    }
    sl_free(narrow);
    return SL_OK;
}

/* Lists the pixels of sub-frame `index`. */
static void set_wanted(sl_film *f, unsigned index) {
    for (size_t i = 0; i < pixels_of(f); i++) f->wanted[i] = f->count[i] > index;
}

void sl_film_begin(sl_film *f, bool objects_moved) {
    sl_image_destroy(f->sums);
    f->sums = NULL;
    f->asked = f->drawn = 0;
    forget_rims(f);
    f->edges_known = false;
    f->most = is_quick(f) ? f->samples : PILOT + f->samples;
    if (!objects_moved) return;
    sl_outlines_destroy(f->outlines);
    f->outlines = NULL;
}

/* Finds where sub-frames behind the pilot will see what others do not. */
static sl_status know_edges(sl_film *f, const sl_raster *raster, sl_error *error) {
    const unsigned others = pilot_of(f), at_edges = is_quick(f) ? f->samples : PILOT + f->samples;
    if (f->edges_known) return SL_OK;
    memset(f->edge, 0, pixels_of(f));
    sl_status status = f->samples > 1 ? find_edges(f, raster, error) : SL_OK;
    for (float r = 0.5f; status == SL_OK && r < f->shape.radius; r += 1.0f) status = widen(f, f->edge, error);
    for (size_t i = 0; i < pixels_of(f); i++) f->count[i] = (uint16_t)(f->edge[i] ? at_edges : others);
    set_wanted(f, others);
    f->edges_known = status == SL_OK;
    return status;
}

/* Everything is asked for but what light alone will want. */
static unsigned asks_of(const sl_film *f) {
    const unsigned of_edges = smaller(f->samples / ASKS_ONE_IN, ASKED_MOST);
    return f->asks ? smaller(f->samples, PILOT + of_edges) : 0;
}

/* Returns into how many sub-frames a pixel's light samples are shared out. */
static unsigned share_of(const sl_film *f, unsigned index) {
    if (is_quick(f)) return index ? f->samples : 1;
    return index < PILOT ? PILOT : LATER_SHARE;
}

/* Of few sub-frames the first is nearest to the pixels' centres: most pixels are seen in no other. */
static unsigned point_of(const sl_film *f, unsigned index) {
    return is_quick(f) ? index ^ 2 : index < PILOT ? index : index - PILOT;
}

static sl_sub_frame sub_frame(const sl_film *f, unsigned index, bool asking) {
    float point[3];
    sl_sequence_point(&f->sequence, 0, index < PILOT ? 0 : 1, point_of(f, index), point);
    sl_pixel_shape_place(&f->shape, point);
    return (sl_sub_frame){.right = point[0] - 0.5f,
                          .up = point[1] - 0.5f,
                          .purpose = !f->asks       ? SL_SUB_FRAME_BOTH
                                     : !asking      ? SL_SUB_FRAME_SHOWS
                                     : f->asked > 0 ? SL_SUB_FRAME_ASKS
                                                    : SL_SUB_FRAME_BOTH,
                          .turn = index,
                          .share = share_of(f, index),
                          .wanted = index < pilot_of(f) ? NULL : f->wanted,
                          .mips = f->mips};
}

static bool is_asking(const sl_film *f) { return f->asked < asks_of(f); }

bool sl_film_next(const sl_film *f, sl_sub_frame *next) {
    const bool asking = is_asking(f);
    if (!asking && f->drawn >= f->most) return false;
    *next = sub_frame(f, asking ? f->asked : f->drawn, asking);
    return true;
}

unsigned sl_film_ahead(const sl_film *f, unsigned *first) {
    *first = f->drawn;
    if (is_asking(f) || !f->drawn) return 0;
    return (!is_quick(f) && f->drawn < PILOT ? PILOT : f->most) - f->drawn;
}

sl_sub_frame sl_film_at(sl_film *f, unsigned ahead) {
    set_wanted(f, f->drawn + ahead);
    return sub_frame(f, f->drawn + ahead, false);
}

double sl_film_share(const sl_film *f) {
    const double asking = f->asks ? 0.7 * (double)f->asked / (double)asks_of(f) : 0.0;
    return asking + (f->asks ? 0.3 : 1.0) * (double)f->drawn / (double)f->most;
}

/* ---- samples ---- */

bool sl_film_has_picture(const sl_film *f) { return f->sums != NULL; }

/* Makes a picture of the same channels, of any values, and one more where it is named, with the metadata. */
static sl_status make_like(const sl_image *picture, const char *more, sl_image **like, sl_error *error) {
    enum { MOST = 64 };
    const char *names[MOST] = {NULL};
    if (picture->channels >= MOST)
        return sl_fail(error, SL_ERROR_USAGE, "a film of %d channels: %d at most", picture->channels,
                       MOST - 1);
    for (int c = 0; c < picture->channels; c++) names[c] = picture->channel_name[c];
    if (more) names[picture->channels] = more;
    const int channels = picture->channels + (more != NULL);
    sl_status status =
        sl_image_create_unset(picture->width, picture->height, channels, names, like, error);
    for (size_t i = 0; status == SL_OK && i < picture->metadata_count; i++)
        status = sl_image_set_metadata(*like, picture->metadata[i].key, picture->metadata[i].value, error);
    if (status == SL_OK) return SL_OK;
    sl_image_destroy(*like);
    *like = NULL;
    return status;
}

/* Returns where a pixel of the film, whose rows run from the bottom, is in an image. */
static size_t image_place(const sl_film *f, size_t pixel) {
    const size_t width = (size_t)f->width;
    return ((size_t)f->height - 1 - pixel / width) * width + pixel % width;
}

static float brightness(const sl_image *picture, size_t at) {
    const size_t pixels = (size_t)picture->width * (size_t)picture->height;
    const float *p = picture->planes + at;
    return sl_picture_value(picture->channels < 3 ? p[0]
                                                  : sl_luminance((sl_rgb){p[0], p[pixels], p[2 * pixels]}));
}

static void note_contrast(sl_film *f, const sl_image *picture) {
    for (size_t i = 0; i < pixels_of(f); i++) {
        const float y = brightness(picture, image_place(f, i));
        f->low[i] = f->drawn && f->low[i] < y ? f->low[i] : y;
        f->high[i] = f->drawn && f->high[i] > y ? f->high[i] : y;
    }
}

/* Times the range of the pilot's samples of a pixel: what light's range within it is taken to be. */
static const float range_of_pilots = 1.4f;

/* Returns how much the pilot's samples differ around a pixel; infinite where it is alone. Its own have no
 * say: if what is seen by chance brought more samples, it would weigh less than what is missed by chance.
 * Where no edge is, light may rise from pixel to pixel: it differs within one by no more than the widest range
 * that any of them shows. */
static float contrast_around(const sl_film *f, int x, int y, bool edge) {
    float low = INFINITY, high = -INFINITY, most = 0.0f;
    for (int v = y ? y - 1 : 0; v <= y + 1 && v < f->height; v++) {
        for (int u = x ? x - 1 : 0; u <= x + 1 && u < f->width; u++) {
            const size_t i = (size_t)v * (size_t)f->width + (size_t)u;
            if (u == x && v == y) continue;
            low = fminf(low, f->low[i]);
            high = fmaxf(high, f->high[i]);
            most = fmaxf(most, f->high[i] - f->low[i]);
        }
    }
    if (low > high) return INFINITY;
    return edge ? high - low : fminf(high - low, range_of_pilots * most);
}

/* Returns by how much a pixel may be off: at edges by what all samples leave of a contrast of twice the
 * picture's mean. Elsewhere it is light that differs, whose samples are noise besides. */
static double tolerance_of(const sl_film *f, bool edge) {
    return (edge ? 1.0 / sqrt(f->samples * sqrt(f->samples)) : 0.015) * f->mean;
}

/* Returns how many samples leave of such a contrast no more than is tolerated: n samples that are spread well
 * are off by about half the contrast over n^(3/4) at an edge. */
static unsigned samples_for(const sl_film *f, double contrast, double tolerance, unsigned least) {
    unsigned n = least;
    while (n < f->samples && sqrt(n * sqrt(n)) * tolerance < 0.5 * contrast) n *= 4;
    return smaller(n, f->samples);
}

static void settle_counts(sl_film *f) {
    f->mean = 0.0;
    for (size_t i = 0; i < pixels_of(f); i++) f->mean += 0.5 * ((double)f->low[i] + (double)f->high[i]);
    f->mean /= (double)pixels_of(f);
    f->most = PILOT;
    for (size_t i = 0; i < pixels_of(f); i++) {
        const bool edge = f->edge[i];
        const float contrast =
            contrast_around(f, (int)(i % (size_t)f->width), (int)(i / (size_t)f->width), edge);
        const unsigned least = edge ? EDGE_LEAST : PILOT,
                       n = (edge ? PILOT : 0) +
                           samples_for(f, (double)contrast, tolerance_of(f, edge), least);
        f->count[i] = (uint16_t)n;
        if (n > f->most) f->most = n;
    }
}

/* ---- lamps' rims ---- */

/* In means of the picture: brighter emission makes a rim. */
static const float rim_brightness = 4.0f;

/* Marks the pixels in which the pilot saw emission that is much brighter than the picture. */
static bool mark_lamps(sl_film *f, const float *emission) {
    const size_t pixels = pixels_of(f);
    bool any = false;
    for (size_t i = 0; i < pixels; i++) {
        const float *e = emission + image_place(f, i);
        f->rim[i] = e[0] + e[pixels] + e[2 * pixels] > 0.0f && f->high[i] > rim_brightness * (float)f->mean;
        any = any || f->rim[i];
    }
    return any;
}

/* Takes from near what pixels at lamps' edges see of emission, where the picture has a layer of it and pixels
 * are boxes. */
static sl_status look_at_rims(sl_film *f, const sl_raster *raster, sl_error *error) {
    const float *emission = sl_image_channel(f->sums, "emission.R"); /* the other two follow */
    if (f->shape.radius > 0.5f || !emission) return SL_OK;
    f->rim = sl_allocate(pixels_of(f), sizeof *f->rim);
    if (!f->rim) return sl_fail_memory(error, "a film");
    if (!mark_lamps(f, emission)) {
        forget_rims(f);
        return SL_OK;
    }
    f->rim_emission = sl_allocate_unset(pixels_of(f), 3 * sizeof *f->rim_emission);
    sl_status status = f->rim_emission ? widen(f, f->rim, error) : sl_fail_memory(error, "a film");
    for (size_t i = 0; i < pixels_of(f); i++) f->rim[i] = f->rim[i] && f->edge[i];
    if (status != SL_OK) return status;
    return sl_rims_look(f->scene, raster, f->width, f->height, f->rim, f->rim_emission, &f->counters, error);
}

/* Adds a run of one row; the first sub-frame is whole, and nothing is there before it. The first sample
 * behind the pilot takes its place at edges, where more follow in any case: what the pilot saw has told how
 * many. */
static void add_run(const sl_film *f, const sl_image *picture, sl_pixel_run run) {
    const size_t pixels = pixels_of(f), at = image_place(f, run.first), count = run.end - run.first;
    const uint8_t *edge = f->edge + run.first;
    for (size_t c = 0; c < (size_t)picture->channels; c++) {
        const float *restrict sample = picture->planes + c * pixels + at;
        float *restrict sum = f->sums->planes + c * pixels + at;
        if (f->drawn == PILOT)
            for (size_t i = 0; i < count; i++) sum[i] = edge[i] ? 0.0f : sum[i];
        if (f->drawn)
            for (size_t i = 0; i < count; i++) sum[i] += sample[i];
        else
            for (size_t i = 0; i < count; i++) sum[i] = 0.0f + sample[i];
    }
}

typedef struct addition {
    const sl_film *film;
    const sl_image *picture;
    sl_sub_frame drawn;
} addition;

static void add_row(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    (void)worker, (void)result;
    const addition *a = context;
    const size_t row = index * (size_t)a->film->width, end = row + (size_t)a->film->width;
    for (sl_pixel_run r = sl_sub_frame_run(&a->drawn, row, end); r.first < r.end;
         r = sl_sub_frame_run(&a->drawn, r.end, end)) {
        add_run(a->film, a->picture, r);
        sl_count(counters, SL_COUNT_SAMPLES, r.end - r.first);
    }
}

/* Adds the pixels that are wanted. */
static void add_samples(sl_film *f, const sl_image *picture) {
    addition a = {f, picture, {.wanted = f->drawn >= pilot_of(f) ? f->wanted : NULL}};
    const sl_batch rows = {.count = (size_t)f->height, .work = add_row, .context = &a};
    sl_batch_run(&rows, f->threads, &f->counters);
}

sl_status sl_film_add(sl_film *f, const sl_raster *raster, const sl_image *picture, sl_error *error) {
    sl_status status = know_edges(f, raster, error);
    if (!picture) f->asked++;
    if (!picture || status != SL_OK) return status;
    status = f->sums ? SL_OK : make_like(picture, NULL, &f->sums, error);
    if (status != SL_OK) return status;
    if (!is_quick(f) && f->drawn < PILOT) note_contrast(f, picture);
    add_samples(f, picture);
    f->drawn++;
    if (f->drawn == PILOT && !is_quick(f)) {
        settle_counts(f);
        status = look_at_rims(f, raster, error);
    }
    if (f->drawn >= pilot_of(f)) set_wanted(f, f->drawn);
    return status;
}

/* ---- sub-frames that are drawn elsewhere ---- */

/* Tells whether sub-frame `first` shows it; those behind it show no others. */
static bool is_packed(const sl_film *f, unsigned first, size_t pixel) {
    return first < pilot_of(f) || f->count[pixel] > first;
}

size_t sl_film_pack(const sl_film *f, unsigned first, const sl_image *picture, float *packed) {
    const size_t pixels = pixels_of(f);
    size_t used = 0;
    for (size_t i = 0; i < pixels; i++) {
        if (!is_packed(f, first, i)) continue;
        const size_t at = image_place(f, i), channels = (size_t)f->sums->channels;
        for (size_t c = 0; packed && c < channels; c++) packed[used + c] = picture->planes[c * pixels + at];
        used += channels;
    }
    return used;
}

void sl_film_unpack(const sl_film *f, unsigned first, const float *packed, sl_image *picture) {
    const size_t pixels = pixels_of(f);
    for (size_t i = 0; i < pixels; i++) {
        if (!is_packed(f, first, i)) continue;
        const size_t at = image_place(f, i);
        for (size_t c = 0; c < (size_t)f->sums->channels; c++) picture->planes[c * pixels + at] = *packed++;
    }
}

sl_status sl_film_picture(const sl_film *f, sl_image **picture, sl_error *error) {
    return make_like(f->sums, NULL, picture, error);
}

void sl_film_count(sl_film *f, const sl_counters *counted) { sl_counters_add(&f->counters, counted); }

/* Puts what a close-up saw of lamps and sky in the place of what the pixel's own samples saw. */
static void put_rim(const sl_film *f, size_t pixel, size_t at, sl_image *image) {
    static const char *const emission[3] = {"emission.R", "emission.G", "emission.B"};
    const size_t pixels = pixels_of(f);
    for (size_t c = 0; c < 3; c++) {
        float *seen = sl_image_channel(image, emission[c]), *whole = &image->planes[c * pixels + at];
        const float near = sl_picture_value(f->rim_emission[3 * pixel + c]);
        *whole = sl_picture_value(fmaxf(*whole - seen[at], 0.0f) + near);
        seen[at] = near;
    }
}

/* Returns how many samples a pixel is the mean of. */
static unsigned samples_of(const sl_film *f, size_t pixel) {
    const unsigned drawn = smaller(f->drawn, f->count[pixel]);
    return f->drawn > PILOT && f->edge[pixel] ? drawn - PILOT : drawn;
}

typedef struct development {
    const sl_film *film;
    sl_image *image;
} development;

/* Divides one row's sums, and tells by how much where there are layers. */
static void develop_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    enum { BLOCK = 64 };
    const development *d = context;
    const sl_film *f = d->film;
    const size_t pixels = pixels_of(f), width = (size_t)f->width, channels = (size_t)f->sums->channels;
    float count[BLOCK];
    for (size_t x = 0; x < width; x += BLOCK) {
        const size_t n = x + BLOCK < width ? BLOCK : width - x, at = image_place(f, row * width + x);
        for (size_t i = 0; i < n; i++) count[i] = (float)samples_of(f, row * width + x + i);
        for (size_t c = 0; c < channels; c++) {
            const float *restrict sum = f->sums->planes + c * pixels + at;
            float *restrict mean = d->image->planes + c * pixels + at;
            for (size_t i = 0; i < n; i++) mean[i] = sl_picture_value(sum[i] / count[i]);
        }
        if (channels > 3) memcpy(d->image->planes + channels * pixels + at, count, n * sizeof *count);
    }
}

sl_status sl_film_develop(const sl_film *f, sl_image **image, sl_error *error) {
    sl_status status = make_like(f->sums, f->sums->channels > 3 ? "samples" : NULL, image, error);
    if (status != SL_OK) return status;
    sl_parallel_for(f->threads, (size_t)f->height, develop_row, &(development){f, *image});
    for (size_t i = 0; f->rim && i < pixels_of(f); i++)
        if (f->rim[i]) put_rim(f, i, image_place(f, i), *image);
    return status;
}

const sl_counters *sl_film_counters(sl_film *f, const sl_counters *of_method) {
    f->with_method = *of_method;
    sl_counters_add(&f->with_method, &f->counters);
    return &f->with_method;
}

/* ---- memory ---- */

enum { BYTES_OF_PLANES = 4 + 2 * sizeof(float), BYTES_OF_RIMS = 1 + 3 * sizeof(float), LAYERS_AT_MOST = 17 };

size_t sl_film_bytes(const sl_film *f) {
    const size_t channels = f->sums ? (size_t)f->sums->channels : 0;
    const size_t rims = f->rim ? BYTES_OF_RIMS : 0, pixel = BYTES_OF_PLANES + rims + channels * sizeof(float);
    return sizeof *f + pixels_of(f) * pixel +
           (f->outlines ? sl_outlines_bytes(f->outlines) : 0) + (f->mips ? sl_mips_need(f->scene) : 0);
}

double sl_film_need(const sl_scene *scene, const sl_settings *settings) {
    const double pixels = (double)settings->width * (double)settings->height;
    const double pictures = 2.0 * LAYERS_AT_MOST * sizeof(float); /* the sums, and one that is developed */
    return pixels * (BYTES_OF_PLANES + BYTES_OF_RIMS + pictures + sizeof(float)) +
           sl_outlines_need((double)scene->triangle_count) + (double)sl_mips_need(scene);
}
