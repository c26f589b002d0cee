/* Pass 4: environment cubes of curved mirrors. Each face is a picture of the scene like the camera's, planar
 * mirrors included, lit by the same passes. */
#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/direct_radiance/direct_radiance.h"

#include <math.h>
#include <string.h>

enum { FACES = 6 };

static void destroy_cubes(sl_environment_cube *cube, size_t count) {
    for (size_t n = 0; cube && n < count; n++) {
        for (int p = 0; p < SL_CUBE_PARTS; p++) sl_cube_map_destroy(cube[n].part[p]);
    }
    sl_free(cube);
}

/* ---- one face ---- */

typedef struct {
    const sl_mirror_pass *pass;
    const sl_mirror_object *object;
    sl_environment_cube *cube; /* to be filled */
    uint8_t *left_out;         /* by triangle */
    bool unknown[FACES];       /* some texels show mirrors that nothing tells about */
    sl_status status[FACES];
    sl_error error[FACES];
    sl_counters counters[FACES];
} cube_pass;

/* Tells if the pixel shows a mirror of which nothing is known: a curved one, or a planar one beyond the
 * nesting limit.
 */
static bool is_unknown_mirror(const sl_scene *scene, uint32_t id) {
    return id != SL_NO_INDEX && sl_material_is_mirror(&scene->materials[scene->material_index[id]]);
}

/* Keeps one row of one part of a face, from the picture's channels, whose top row is first. A mirror that is
 * not known keeps the factor by which it will show the cube's mean. */
static void keep_row(cube_pass *g, const sl_receivers *r, const sl_image *image, int face, int part,
                     size_t row) {
    static const size_t channel[SL_CUBE_PARTS] = {[SL_CUBE_EMISSION] = SL_RADIANCE_EMISSION,
                                                  [SL_CUBE_DIRECT] = SL_RADIANCE_DIRECT,
                                                  [SL_CUBE_INDIRECT] = SL_RADIANCE_INDIRECT};
    const sl_scene *scene = g->pass->scene;
    const size_t size = (size_t)r->width, pixels = size * size;
    const float *red = image->planes + channel[part] * pixels + (size - 1 - row) * size,
                *green = red + pixels, *blue = green + pixels;
    float *texel = sl_cube_map_texel(g->cube->part[part], 0, face, 0, (int)row);
    for (size_t x = 0; x < size; x++, texel += 4) {
        const size_t i = row * size + x;
        const uint32_t id = r->gbuffer->id[i];
        texel[0] = red[x], texel[1] = green[x], texel[2] = blue[x], texel[3] = 1.0f;
        if (!is_unknown_mirror(scene, id)) continue;
        g->unknown[face] = true;
        const sl_rgb ks = scene->materials[scene->material_index[id]].mirror;
        const bool through = r->throughput[0] != NULL;
        texel[0] = ks.r * (through ? r->throughput[0][i] : 1.0f);
        texel[1] = ks.g * (through ? r->throughput[1][i] : 1.0f);
        texel[2] = ks.b * (through ? r->throughput[2][i] : 1.0f);
        texel[3] = 0.0f;
    }
}

static sl_status make_face(cube_pass *g, int face, sl_counters *counters, sl_error *error) {
    const sl_mirror_pass *pass = g->pass;
    sl_light_pass light = *pass->light;
    sl_view view =
        sl_view_cube_face(g->object->centre, face, pass->cube_size, 1e-5f * pass->scene->scale);
    sl_receivers *r = NULL;
    sl_image *image = NULL;
    view.left_out = g->left_out;
    light.threads = 1;
    light.trick_albedo = sl_grey(0.0f);
    if (!pass->indirect) light.photons = NULL;
    sl_status status = sl_receivers_outline(pass->scene, pass->raster, &view, pass->planar,
                                            pass->reflections, 1, &r, counters, error);
    const sl_strip_pass strips = {.raster = pass->raster, .outline = r, .light = &light, .layers = true};
    if (status == SL_OK) status = sl_radiance_draw_strips(&strips, &image, counters, error);
    for (int part = 0; part < SL_CUBE_PARTS && status == SL_OK; part++) {
        for (size_t row = 0; g->cube->part[part] && row < (size_t)pass->cube_size; row++)
            keep_row(g, r, image, face, part, row);
    }
    sl_receivers_destroy(r);
    sl_image_destroy(image);
    return status;
}

static void make_face_task(void *context, size_t face, unsigned worker) {
    (void)worker;
    cube_pass *g = context;
    g->status[face] = make_face(g, (int)face, &g->counters[face], &g->error[face]);
}

/* ---- one cube, when its faces are there ---- */

typedef struct {
    double sum[3], weight;
} cube_mean;

/* Sums by solid angle, which is proportional to (1 + x^2 + y^2)^(-3/2) at a point of the face. */
static void sum_face(const sl_cube_map *map, int face, cube_mean *mean) {
    const int n = map->size;
    for (int y = 0; y < n; y++) {
        const double v = (2.0 * y + 1.0) / n - 1.0;
        for (int x = 0; x < n; x++) {
            const float *texel = sl_cube_map_texel(map, 0, face, x, y);
            const double u = (2.0 * x + 1.0) / n - 1.0, squared = 1.0 + u * u + v * v;
            const double weight = texel[3] > 0.0f ? 1.0 / (squared * sqrt(squared)) : 0.0;
            for (int k = 0; k < 3; k++) mean->sum[k] += weight > 0.0 ? weight * (double)texel[k] : 0.0;
            mean->weight += weight;
        }
    }
}

/* Gives mirrors that are not known the mean of what is. */
static void fill_unknown(const sl_cube_map *map) {
    cube_mean mean = {{0.0, 0.0, 0.0}, 0.0};
    for (int face = 0; face < FACES; face++) sum_face(map, face, &mean);
    const double over = mean.weight > 0.0 ? 1.0 / mean.weight : 0.0;
    for (int face = 0; face < FACES; face++) {
        for (int y = 0; y < map->size; y++) {
            float *texel = sl_cube_map_texel(map, 0, face, 0, y);
            for (int x = 0; x < map->size; x++, texel += 4) {
                if (texel[3] > 0.0f) continue;
                for (int k = 0; k < 3; k++) texel[k] *= (float)(mean.sum[k] * over);
                texel[3] = 1.0f;
            }
        }
    }
}

/* ---- all cubes ---- */

static sl_status create_cubes(const sl_mirror_pass *pass, size_t count, sl_environment_cube **cubes,
                              sl_error *error) {
    const sl_scene *scene = pass->scene;
    const bool shines = scene->emitter_count > 0 || scene->environment.present;
    const bool wanted[SL_CUBE_PARTS] = {
        [SL_CUBE_EMISSION] = shines, [SL_CUBE_DIRECT] = true, [SL_CUBE_INDIRECT] = pass->indirect};
    *cubes = sl_allocate(count, sizeof **cubes);
    if (!*cubes) return sl_fail_memory(error, "environment cubes");
    for (size_t n = 0; n < count; n++) {
        for (int p = 0; p < SL_CUBE_PARTS; p++) {
            sl_status status =
                wanted[p] ? sl_cube_map_create(pass->cube_size, false, &(*cubes)[n].part[p], error) : SL_OK;
            if (status != SL_OK) return status;
        }
    }
    return SL_OK;
}

static sl_status make_cube(cube_pass *g, unsigned threads, sl_counters *counters, sl_error *error) {
    memset(g->counters, 0, sizeof g->counters);
    sl_mirror_object_mark(g->pass->scene, g->object, g->left_out);
    sl_parallel_for(threads, FACES, make_face_task, g);
    for (size_t i = 0; i < FACES; i++) {
        if (g->status[i] != SL_OK && error) *error = g->error[i];
        if (g->status[i] != SL_OK) return g->status[i];
        sl_counters_add(counters, &g->counters[i]);
    }
    bool unknown = false;
    for (int face = 0; face < FACES; face++) unknown = unknown || g->unknown[face];
    for (int p = 0; p < SL_CUBE_PARTS; p++) {
        if (!g->cube->part[p]) continue;
        if (unknown) fill_unknown(g->cube->part[p]);
        sl_cube_map_build(g->cube->part[p], threads);
    }
    return SL_OK;
}

static sl_status make_cubes(const sl_mirror_pass *pass, const sl_mirror_objects *objects,
                            sl_environment_cube **cubes, sl_counters *counters, sl_error *error) {
    sl_status status = create_cubes(pass, objects->count, cubes, error);
    cube_pass *g = sl_allocate(1, sizeof *g);
    uint8_t *left_out = sl_allocate(pass->scene->triangle_count, 1);
    if (status == SL_OK && (!g || !left_out)) status = sl_fail_memory(error, "environment cubes");
    for (size_t n = 0; n < objects->count && status == SL_OK; n++) {
        *g = (cube_pass){
            .pass = pass, .object = &objects->object[n], .cube = &(*cubes)[n], .left_out = left_out};
        status = make_cube(g, sl_thread_count(pass->light->threads), counters, error);
    }
    sl_free(left_out);
    sl_free(g);
    return status;
}

sl_status sl_curved_mirrors_render(const sl_mirror_pass *pass, const sl_receivers *seen,
                                   sl_curved_mirrors **mirrors, sl_counters *counters, sl_error *error) {
    *mirrors = NULL;
    sl_curved_mirrors *m = sl_allocate(1, sizeof *m);
    if (!m) return sl_fail_memory(error, "the curved mirrors");
    *m = (sl_curved_mirrors){.scene = pass->scene, .planar = pass->planar};
    sl_status status = sl_mirror_objects_find(pass->scene, pass->planar, seen, &m->objects, error);
    if (status == SL_OK && m->objects.count)
        status = make_cubes(pass, &m->objects, &m->cube, counters, error);
    if (status == SL_OK && m->objects.count) *mirrors = m;
    else sl_curved_mirrors_destroy(m);
    return status;
}

void sl_curved_mirrors_destroy(sl_curved_mirrors *m) {
    if (!m) return;
    destroy_cubes(m->cube, m->objects.count);
    sl_mirror_objects_release(&m->objects);
    sl_free(m);
}

size_t sl_curved_mirrors_bytes(const sl_curved_mirrors *m) {
    if (!m) return 0;
    size_t bytes = sizeof *m + m->objects.count * (sizeof *m->cube + sizeof *m->objects.object);
    for (size_t n = 0; n < m->objects.count; n++) {
        for (int p = 0; p < SL_CUBE_PARTS; p++) {
            const sl_cube_map *map = m->cube[n].part[p];
            size_t side = map ? (size_t)map->size + 2 : 0; /* with its border */
            bytes += FACES * side * side * 4 * sizeof(float);
        }
    }
    return bytes;
}
