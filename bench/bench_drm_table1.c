/* Table 1 of Frisvad et al. 2005: frames a second at 512 x 512 with 3 x 3 photons, everything computed again
 * for every frame; the paper's ratios between its rows beside ours, and OSMesa drawing the same passes in the
 * same run (drm_osmesa.h).
 *
 * What a frame's milliseconds are: a moved camera, light and object told to the method, one update, and the
 * picture resolved, as R, G and B in float; of OSMesa, all passes drawn and the picture read back, in float
 * too. Nothing of either is kept from frame to frame, but in the columns where the camera alone moves: then
 * depth cube and photons stay. A column of its own has ours with emission, direct and indirect light and
 * their uncertainty as layers of the picture, which OSMesa does not make.
 *
 * OSMesa learns its number of threads once a process; so each number of threads has a process of its own. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/math.h"
#include "cache/direct_radiance/direct_radiance.h"
#include "cache/direct_radiance/map.h"
#include "drm_bench.h"
#include "drm_osmesa.h"
#include "raster_osmesa.h"

enum { SIZE = 512, ROWS_MAX = 5, NO_PEER = DRM_SHADINGS };

typedef struct row {
    const char *name;
    sl_photon_weight weight;
    sl_mirror_light mirror_light;
    int shading;           /* of the peer's, or NO_PEER */
    double paper;          /* frames a second; 0: not given */
    bool local, direct;    /* direct: no indirect light */
} row;

typedef struct table {
    const char *name, *path;
    int rows;
    row row[ROWS_MAX];
} table;

static const table tables[] = {
    {"Cornell, Figs. 3, 4", "scenes/cornell-lamp.json", 5,
     {{"local shading", SL_WEIGHT_BOX, SL_MIRROR_LIGHT_FULL, DRM_LOCAL, 769.231, true, true},
      {"direct", SL_WEIGHT_BOX, SL_MIRROR_LIGHT_FULL, DRM_DIRECT, 137.3, false, true},
      {"(15)", SL_WEIGHT_BOX, SL_MIRROR_LIGHT_FULL, DRM_BOX, 48.622, false, false},
      {"(11)", SL_WEIGHT_EVEN, SL_MIRROR_LIGHT_FULL, DRM_EVEN, 48.622, false, false},
      {"(14)", SL_WEIGHT_DISC, SL_MIRROR_LIGHT_FULL, DRM_DISC, 20.87, false, false}}},
    {"two mirror balls, Fig. 8", "scenes/mirror-balls.json", 3,
     {{"(14), no indirect in mirrors", SL_WEIGHT_DISC, SL_MIRROR_LIGHT_DIRECT, NO_PEER, 15.178, false, false},
      {"(14), trick", SL_WEIGHT_DISC, SL_MIRROR_LIGHT_TRICK, NO_PEER, 15.178, false, false},
      {"(14), full", SL_WEIGHT_DISC, SL_MIRROR_LIGHT_FULL, NO_PEER, 9.898, false, false}}},
    {"cave, Fig. 9", "scenes/generated/mirror-cave.json", 3,
     {{"direct", SL_WEIGHT_BOX, SL_MIRROR_LIGHT_FULL, NO_PEER, 20.761, false, true},
      {"(15)", SL_WEIGHT_BOX, SL_MIRROR_LIGHT_FULL, NO_PEER, 11.888, false, false},
      {"(14)", SL_WEIGHT_DISC, SL_MIRROR_LIGHT_FULL, NO_PEER, 7.695, false, false}}},
    {"cave without mirrors", "bench/scenes/dull-cave.json", 3,
     {{"direct", SL_WEIGHT_BOX, SL_MIRROR_LIGHT_FULL, DRM_DIRECT, 48.0, false, true},
      {"(15)", SL_WEIGHT_BOX, SL_MIRROR_LIGHT_FULL, DRM_BOX, 18.4, false, false},
      {"(14)", SL_WEIGHT_DISC, SL_MIRROR_LIGHT_FULL, DRM_DISC, 10.3, false, false}}},
    {"figure", "scenes/generated/figure.json", 3,
     {{"direct", SL_WEIGHT_BOX, SL_MIRROR_LIGHT_FULL, DRM_DIRECT, 0.0, false, true},
      {"(15)", SL_WEIGHT_BOX, SL_MIRROR_LIGHT_FULL, DRM_BOX, 1.8, false, false},
      {"(14)", SL_WEIGHT_DISC, SL_MIRROR_LIGHT_FULL, DRM_DISC, 0.92, false, false}}},
};

/* ---- the peer ---- */

/* What the light's map is seen through is asked of the method's own map, so that photons are the same. */
static drm_peer *open_peer(const sl_scene *scene, const sl_settings *settings) {
    sl_settings complete = *settings;
    sl_counters counters = {{0}};
    sl_map_lights *lights;
    sl_raster *raster;
    sl_radiance_map *map;
    sl_error error;
    sl_radiance_complete(&complete);
    const sl_radiance_map_options options = {.lambertian = true, .normals = true, .threads = 1};
    if (sl_map_lights_find(scene, 1, &lights, &error) != SL_OK ||
        sl_raster_create(scene, 1, &raster, &error) != SL_OK ||
        sl_radiance_map_render(scene, raster, lights, &complete.radiance_map, &options, &map, &counters,
                               &error) != SL_OK)
        bench_fail("map", &error);
    const sl_map_light *light = &lights->light[0];
    drm_peer_options o = {.size = SIZE,
                          .shadow_size = complete.radiance_map.shadow_size,
                          .samples = complete.radiance_map.samples,
                          .map_fov = complete.radiance_map.map_fov,
                          .map_view = map->face[0].view,
                          .position = light->position,
                          .direction = light->direction,
                          .area = light->kind == SL_MAP_LIGHT_AREA,
                          .intensity = light->intensity};
    bool fits = lights->count == 1 && map->face_count == 1;
    sl_radiance_map_destroy(map);
    sl_raster_destroy(raster);
    sl_map_lights_destroy(lights);
    return fits ? drm_peer_create(scene, &o) : NULL;
}

typedef struct peer_frames {
    drm_peer *peer;
    drm_shading shading;
    drm_way way;
} peer_frames;

static void peer_all(void *context) {
    const peer_frames *f = context;
    drm_peer_frame(f->peer, f->shading, f->way, false);
}

static void peer_camera(void *context) {
    const peer_frames *f = context;
    drm_peer_frame(f->peer, f->shading, f->way, true);
}

/* Whichever way is fastest on this scene. */
static drm_way best_way(peer_frames *f, unsigned threads) {
    peer_frames each[DRM_WAYS];
    drm_timed timed[DRM_WAYS];
    int best = 0;
    for (int way = 0; way < DRM_WAYS; way++) {
        each[way] = *f;
        each[way].way = (drm_way)way;
        timed[way] = (drm_timed){peer_camera, &each[way], 0.0, 0.0};
    }
    peer_all(f);
    drm_time(timed, DRM_WAYS, threads, 1.0);
    for (int way = 1; way < DRM_WAYS; way++) {
        if (timed[way].ms < timed[best].ms) best = way;
    }
    return (drm_way)best;
}

/* Mean absolute difference over the mean. */
static double difference(const sl_image *image, const float *rgba) {
    double sum = 0.0, mean = 0.0;
    for (size_t c = 0; c < 3; c++) {
        const float *plane = drm_layer(image, NULL, "RGB"[c]);
        for (size_t i = 0; i < SIZE * SIZE; i++) {
            size_t x = i % SIZE, y = i / SIZE, below = (SIZE - 1 - y) * SIZE + x;
            sum += fabs((double)plane[i] - (double)rgba[4 * below + c]);
            mean += (double)plane[i];
        }
    }
    return mean > 0.0 ? sum / mean : 0.0;
}

/* ---- a table ---- */

typedef struct lane { /* all that is measured of a row */
    drm_frames frames, layered;
    peer_frames peer;
    double apart;          /* the two pictures */
    sl_counters counters;
} lane;

static void ours_all(void *context) { drm_frame(&((lane *)context)->frames, DRM_CHANGED_ALL); }
static void ours_layered(void *context) { drm_frame(&((lane *)context)->layered, DRM_CHANGED_ALL); }
static void ours_light(void *context) {
    drm_frame(&((lane *)context)->frames, SL_CHANGED_LIGHTS | SL_CHANGED_CAMERA);
}
static void ours_camera(void *context) { drm_frame(&((lane *)context)->frames, SL_CHANGED_CAMERA); }

enum { ALL, LAYERED, LIGHT, CAMERA, OURS };

static sl_settings settings_of(const row *w, unsigned threads) {
    sl_settings settings = drm_paper_settings(SIZE, w->weight);
    settings.threads = threads;
    settings.radiance_map.mirror_light = w->mirror_light;
    settings.radiance_map.local_light_only = w->local;
    settings.radiance_map.direct_light_only = w->direct;
    settings.radiance_map.without_layers = true;
    return settings;
}

static void open_lane(lane *l, sl_scene *scene, const row *w, drm_peer *peer, unsigned threads) {
    sl_settings settings = settings_of(w, threads);
    *l = (lane){.apart = -1.0};
    drm_frames_open(&l->frames, scene, &settings);
    drm_frame(&l->frames, DRM_CHANGED_ALL);
    l->counters = l->frames.counters;
    settings.radiance_map.without_layers = false;
    drm_frames_open(&l->layered, scene, &settings);
    if (!peer || w->shading == NO_PEER) return;
    l->peer = (peer_frames){peer, (drm_shading)w->shading, DRM_FORWARD};
    l->peer.way = best_way(&l->peer, threads);
    l->apart = difference(l->frames.image, drm_peer_frame(peer, l->peer.shading, l->peer.way, false));
}

static void close_lane(lane *l) {
    drm_frames_close(&l->frames);
    drm_frames_close(&l->layered);
}

static void write_pictures(const bench_report *r, const char *name, int which, lane *l) {
    char what[64];
    sl_image *image;
    sl_error error;
    snprintf(what, sizeof what, "%d", which);
    drm_frame(&l->frames, DRM_CHANGED_ALL);
    bench_write_picture(r, name, what, l->frames.image);
    if (l->apart < 0.0 || sl_image_create(SIZE, SIZE, 3, NULL, &image, &error) != SL_OK) return;
    const float *rgba = drm_peer_frame(l->peer.peer, l->peer.shading, l->peer.way, false);
    for (size_t i = 0; i < 3 * SIZE * SIZE; i++) {
        size_t c = i / (SIZE * SIZE), x = i % SIZE, y = i / SIZE % SIZE;
        image->planes[i] = rgba[4 * ((SIZE - 1 - y) * SIZE + x) + c];
    }
    snprintf(what, sizeof what, "%d-osmesa", which);
    bench_write_picture(r, name, what, image);
    sl_image_destroy(image);
}

static const char *number(double value, const char *unit, char text[24]) {
    text[0] = '\0';
    if (value > 0.0) snprintf(text, 24, "%.*f%s", value < 10.0 ? 2 : 1, value, unit);
    return text;
}

static double fps(double ms) { return ms > 0.0 ? 1e3 / ms : 0.0; }

static void print_row(bench_report *r, const table *t, int i, const lane *l, drm_timed ours[][OURS],
                      drm_timed peer[][2]) {
    const row *w = &t->row[i], *first = &t->row[0];
    double all = ours[i][ALL].ms, camera = ours[i][CAMERA].ms;
    char a[24], b[24], c[24], d[24], e[24], f[24], apart[24] = "";
    if (l->apart >= 0.0) snprintf(apart, sizeof apart, "%.2f", 100.0 * l->apart);
    bench_row(r, "%s|%s|%s|%s|%.2f|%.1f|%.0f|%.1f|%.1f|%.1f|%s|%s|%s|%s|%s|%s", t->name, w->name,
              number(w->paper, "", a),
              number(w->paper > 0.0 && first->paper > 0.0 ? first->paper / w->paper : 0.0, "", b),
              all / ours[0][ALL].ms, fps(all), 100.0 * ours[i][ALL].apart, fps(ours[i][LAYERED].ms),
              fps(ours[i][LIGHT].ms), fps(camera), number(fps(peer[i][0].ms), "", c),
              number(fps(peer[i][1].ms), "", d), number(peer[i][0].ms / all, "", e),
              number(peer[i][1].ms / camera, "", f), l->apart >= 0.0 ? drm_way_name(l->peer.way) : "", apart);
}

static void run_table(bench_report *r, const bench_options *o, const table *t, unsigned threads, bool peers) {
    char name[64];
    sl_scene *scene;
    lane lanes[ROWS_MAX];
    drm_timed timed[DRM_TIMED_MAX], ours[ROWS_MAX][OURS], peer[ROWS_MAX][2];
    size_t count = 0;
    static void (*const kinds[OURS])(void *) = {ours_all, ours_layered, ours_light, ours_camera};
    bench_scene_name(t->path, name);
    if (!bench_wants(o, name) || !bench_open_scene(r, t->path, &scene)) return;
    sl_settings settings = settings_of(&t->row[0], threads);
    drm_peer *osmesa = peers && t->row[t->rows - 1].shading != NO_PEER ? open_peer(scene, &settings) : NULL;
    memset(peer, 0, sizeof peer);
    for (int i = 0; i < t->rows; i++) {
        open_lane(&lanes[i], scene, &t->row[i], osmesa, threads);
        for (int k = 0; k < OURS; k++) timed[count++] = (drm_timed){kinds[k], &lanes[i], 0.0, 0.0};
        if (lanes[i].apart < 0.0) continue;
        timed[count++] = (drm_timed){peer_all, &lanes[i].peer, 0.0, 0.0};
        timed[count++] = (drm_timed){peer_camera, &lanes[i].peer, 0.0, 0.0};
    }
    drm_time(timed, count, threads, o->brief ? 1.0 : o->once ? 4.0 : 20.0);
    count = 0;
    for (int i = 0; i < t->rows; i++) {
        for (int k = 0; k < OURS; k++) ours[i][k] = timed[count++];
        for (int k = 0; k < 2 && lanes[i].apart >= 0.0; k++) peer[i][k] = timed[count++];
        print_row(r, t, i, &lanes[i], ours, peer);
        if (o->pictures && threads == 1) write_pictures(r, name, i, &lanes[i]);
    }
    for (int i = 0; i < t->rows; i++) close_lane(&lanes[i]);
    drm_peer_destroy(osmesa);
    sl_scene_destroy(scene);
}

/* ---- what a frame costs the hardware ---- */

static void counter_rows(bench_report *r, const bench_options *o, const table *t) {
    static const sl_counter shown[] = {SL_COUNT_RASTER_PASSES,    SL_COUNT_TRIANGLES_SUBMITTED,
                                       SL_COUNT_FRAGMENTS_SHADED, SL_COUNT_SHADOW_LOOKUPS,
                                       SL_COUNT_MAP_PHOTONS,      SL_COUNT_PHOTON_LOOK_UPS,
                                       SL_COUNT_BYTES_READ_BACK};
    char name[64];
    sl_scene *scene;
    bench_scene_name(t->path, name);
    if (!bench_wants(o, name) || !bench_open_scene(r, t->path, &scene)) return;
    for (int i = 0; i < t->rows; i++) {
        lane l;
        char line[512];
        int at = snprintf(line, sizeof line, "%s|%s", t->name, t->row[i].name);
        open_lane(&l, scene, &t->row[i], NULL, 1);
        for (size_t k = 0; k < sizeof shown / sizeof *shown; k++)
            at += snprintf(line + at, sizeof line - (size_t)at, "|%llu",
                           (unsigned long long)l.counters.value[shown[k]]);
        bench_row(r, "%s", line);
        close_lane(&l);
    }
    sl_scene_destroy(scene);
}

/* ---- a process for each number of threads ---- */

static void run_tables(bench_report *r, const bench_options *o, unsigned threads) {
    const char *missing = peer_start(threads);
    char csv[32];
    snprintf(csv, sizeof csv, "times-%u", threads);
    bench_say(r, "\n%u thread%s, %s; OSMesa: %s\n", threads, threads > 1 ? "s" : "",
              threads > 1 ? "shortest frame by a clock" : "median processor time",
              missing ? missing : peer_name());
    bench_table(r, csv,
                "scene|light|paper fps|time|ours, time|ours fps|+-%|with layers|light moves|camera "
                "moves|OSMesa fps|camera moves|ours / OSMesa|camera|"
                "its way|pictures apart %");
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
        run_table(r, o, &tables[i], threads, !missing);
    if (threads > 1) return;
    bench_say(r, "\nCounters of one frame in which everything has changed\n");
    bench_table(
        r, "counters",
        "scene|light|passes|triangles|fragments|shadow look-ups|photons|photon look-ups|bytes read back");
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++) counter_rows(r, o, &tables[i]);
}

static int run_process(bench_report *r, const bench_options *o, unsigned threads) {
    int status = 1;
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        run_tables(r, o, threads);
        bench_report_close(r);
        fflush(NULL);
        _exit(0);
    }
    if (child < 0 || waitpid(child, &status, 0) < 0) return 1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/direct-radiance");
    bench_report r;
    bench_report_open(&r, &o, "drm_table1");
    bench_say(&r, "\n512 x 512, one frustum of 18 x 18 texels, 3 x 3 photons. *time*: a frame's, over that "
                  "of the first row of the scene.\n");
    int failed = run_process(&r, &o, 1);
    if (!o.once) failed += run_process(&r, &o, 2);
    bench_report_close(&r);
    return failed != 0;
}
