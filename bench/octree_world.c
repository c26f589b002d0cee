/* A scene's view, which of its pixels are judged, and their reference; with the octrees and photons that
 * pictures of it are made from. */
#include <stdlib.h>
#include <string.h>

#include "octree_bench.h"

bool octree_world_open(bench_report *r, const bench_options *o, const char *path, octree_world *w) {
    int size = o->brief ? 128 : 256;
    sl_settings settings = sl_settings_default();
    sl_transport transport;
    memset(w, 0, sizeof *w);
    bench_scene_name(path, w->name);
    if (!bench_wants(o, w->name) || !octree_view_open(r, path, size, size, &w->view)) return false;
    sl_octree_transport(&settings, &transport);
    transport.emission = false;
    transport.direct_lobes = 0;
    bench_pixels_make(w->view.scene, w->view.tracer, size, size, o->brief ? 8 : 6, &w->pixels);
    bench_reference_get(w->view.scene, w->view.tracer, &transport, &w->pixels, o->brief ? 512 : 4096,
                        &w->reference);
    for (int seed = 0; seed < OCTREE_SEEDS; seed++) {
        w->values[seed] = calloc(3 * w->pixels.count + 1, sizeof(float));
        if (!w->values[seed]) bench_fail("values", NULL);
    }
    return true;
}

void octree_world_close(octree_world *w) {
    for (int seed = 0; seed < OCTREE_SEEDS; seed++) {
        free(w->values[seed]);
        for (int i = 0; i < w->maps; i++) sl_photon_tree_destroy(w->map[i].tree[seed]);
    }
    for (int depth = 0; depth <= SL_OCTREE_DEPTH_MAX; depth++) sl_octree_destroy(w->octree[depth]);
    bench_reference_free(&w->reference);
    bench_pixels_free(&w->pixels);
    octree_view_close(&w->view);
}

sl_octree *octree_world_octree(octree_world *w, int depth) {
    double seconds;
    if (!w->octree[depth]) w->octree[depth] = octree_voxels(w->view.scene, depth, 2, &seconds);
    return w->octree[depth];
}

const sl_photon_tree *octree_world_photons(octree_world *w, const sl_light_octree_settings *settings,
                                           int seed) {
    int i = 0;
    double seconds[2];
    sl_counters counters = {{0}};
    while (i < w->maps && w->map[i].photons != settings->photons) i++;
    if (i == OCTREE_MAPS) bench_fail("too many photon maps", NULL);
    if (i == w->maps) w->map[w->maps++].photons = settings->photons;
    if (!w->map[i].tree[seed])
        w->map[i].tree[seed] =
            octree_photons(w->view.scene, w->view.tracer, settings, (uint64_t)seed, 2, seconds, &counters);
    return w->map[i].tree[seed];
}

octree_picture octree_world_picture(octree_world *w, const sl_octree *octree, const sl_photon_tree *tree,
                                    const sl_light_octree_settings *settings, unsigned threads,
                                    float *values) {
    octree_light light;
    octree_light_voxels(w->view.scene, octree, tree, settings, threads, &light);
    sl_octree_shading shading = sl_octree_shading_of(settings, light.texture);
    double pixels = octree_shade_view(&w->view, &shading, threads);
    octree_view_pick(&w->view, &w->pixels, values);
    octree_picture picture = {light.seconds[0] + light.seconds[1] + pixels,
                              (double)sl_voxel_texture_bytes(light.texture) / 1048576.0};
    octree_light_free(&light);
    return picture;
}
