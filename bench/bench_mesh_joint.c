/* The paper's central claim, for which it gives no number: samples of direct light that one mesh takes in
 * which every light is sampled at every vertex (--set multi-mesh.joint-mesh=1), over those of a mesh for each
 * light, for the same error. The Cornell box with 1, 2, 4 and 8 small lights of the same power together: side
 * by side under the ceiling, so that their shadows lie apart.
 *
 * Both ways are run with several thresholds of what an eye can tell; between those errors go log-log.
 *
 *     build/bench/bench_mesh_joint [--brief] [--out FOLDER] */
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "mesh_bench.h"

enum { LIGHT_COUNTS = 4, SCALES = 4 };
static const int light_counts[LIGHT_COUNTS] = {1, 2, 4, 8};
static const double scales[SCALES] = {2.0, 1.0, 0.5, 0.25};

/* The box without its own lamp, and lights on a circle below its ceiling. */
static void write_scene(const char *path, int lights) {
    char here[512];
    FILE *file = fopen(path, "w");
    if (!file || !getcwd(here, sizeof here)) bench_fail(path, NULL);
    fprintf(file,
            "{\"softlux\": 1, \"meshes\": [{\"file\": \"%s/scenes/cornell.obj\"}],\n"
            " \"materials\": {\"light\": {\"emission\": 0}},\n"
            " \"camera\": {\"eye\": [278, 273, -800], \"target\": [278, 273, 0], \"fov_deg\": 39.3},\n "
            "\"lights\": [",
            here);
    for (int i = 0; i < lights; i++) {
        double angle = 2.0 * 3.14159265358979 * (i + 0.3) / lights, side = 30.0;
        double x = 278.0 + 190.0 * cos(angle), z = 279.0 + 190.0 * sin(angle);
        fprintf(file,
                "%s\n  {\"type\": \"quad\", \"corner\": [%.3f, 540, %.3f], \"edge1\": [%g, 0, 0], \"edge2\": "
                "[0, 0, %g], \"power\": %.9g}",
                i ? "," : "", x - 0.5 * side, z - 0.5 * side, side, side, 2e6 / lights);
    }
    fprintf(file, "]}\n");
    if (fclose(file) != 0) bench_fail(path, NULL);
}

/* Direct light alone is judged, and refined: coarse meshes sample each light at each vertex either way. */
static void converge(const mesh_world *w, double scale, bool joint, bench_series *series, uint64_t *samples,
                     bench_error *error) {
    sl_settings s = mesh_settings(w, SL_QUALITY_NORMAL);
    mesh_run run;
    bench_error e[MESH_PARTS];
    s.multi_mesh.threshold_scale = scale;
    s.multi_mesh.joint_mesh = joint;
    s.multi_mesh.coarse_depth = 1;
    s.multi_mesh.coarse_edge = 1e6;
    s.gather_size = 16;
    mesh_run_open(&run, w->scene, &s);
    while (!run.done) mesh_run_step(&run);
    sl_image *image = mesh_run_picture(&run, NULL);
    mesh_judge(w, image, e);
    sl_image_destroy(image);
    *samples = mesh_run_count(&run, SL_COUNT_LIGHT_SAMPLES);
    *error = e[MESH_DIRECT];
    series->point[series->count++] = (bench_point){.seconds = (double)*samples, .rel_mse = error->rel_mse};
    mesh_run_close(&run);
}

static void experiment(bench_report *r, const bench_options *o, int lights) {
    char path[700];
    mesh_world w;
    snprintf(path, sizeof path, "%s/lights-%d.json", o->folder, lights);
    write_scene(path, lights);
    int size = o->brief ? 128 : 384;
    if (!mesh_world_open(r, path, size, size, o->brief ? 8 : 6, o->brief ? 256 : 4096, &w)) return;
    static bench_series apart, joint;
    uint64_t samples[2][SCALES];
    bench_error error[2][SCALES];
    apart.count = joint.count = 0;
    for (int k = 0; k < SCALES; k++) {
        converge(&w, scales[k], false, &apart, &samples[0][k], &error[0][k]);
        converge(&w, scales[k], true, &joint, &samples[1][k], &error[1][k]);
    }
    for (int k = 0; k < SCALES; k++) {
        double same = bench_between(&joint, apart.point[k].rel_mse, true);
        char equal[32] = "", a[32], b[32];
        if (same > 0.0) snprintf(equal, sizeof equal, "%.2f", same / apart.point[k].seconds);
        bench_row(r, "%d|%g|%llu|%s|%llu|%s|%.2f|%s", lights, scales[k], (unsigned long long)samples[0][k],
                  bench_mse_text(&error[0][k], a), (unsigned long long)samples[1][k],
                  bench_mse_text(&error[1][k], b), (double)samples[1][k] / (double)samples[0][k], equal);
    }
    mesh_world_close(&w);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/multi-mesh");
    bench_report r;
    bench_report_open(&r, &o, "mesh_joint");
    bench_table(&r, "lights",
                "lights|threshold|meshes apart: samples|relMSE, direct|joint: samples|relMSE, direct|joint / "
                "apart|at equal error");
    for (int i = 0; i < LIGHT_COUNTS; i++) experiment(&r, &o, light_counts[i]);
    bench_report_close(&r);
    return 0;
}
