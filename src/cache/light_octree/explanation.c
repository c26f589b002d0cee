/* The explanation of a pixel: its shading, taken apart by the shader's own kernel. Around the pixel lie eight
 * voxels; each gives the lights of one set. The kernel is linear in the lights: asked about one of them it
 * says what that one adds, and asked about a voxel that holds the constant 1, the others 0, how much that
 * voxel weighs. */
#include "cache/light_octree/light_octree.h"

#include "base/math.h"
#include "base/memory.h"

/* ---- telling ---- */

typedef struct telling {
    const sl_octree_told *told;
    sl_explanation_writer *writer;
    sl_shade_kernel *kernel;
    sl_octree_pixel *pixel;
    float throughput[3];   /* of the mirrors before it */
} telling;

/* The voxel's weight after all are normalized: with facing and void ones as the kernel treats them. */
static double weight_of(const telling *t, int corner) {
    static const sl_unpacked_light one = {{0.0f, 0.0f, 1.0f}, {1.0f, 1.0f, 1.0f}};
    sl_shade_cells cells = t->pixel->cells;
    cells.lobes = SL_LOBES_NONE;
    for (int k = 0; k < cells.corners; k++) {
        for (int s = 0; s < cells.corner[k].sets; s++) {
            cells.corner[k].set[s].light = &one;
            cells.corner[k].set[s].lights = k == corner;
        }
    }
    t->kernel(&cells, SL_SHADE_LANES, false, &t->pixel->block);
    return (double)t->pixel->block.irradiance[0][0];
}

static sl_vec3 middle_of(const telling *t, int corner) {
    const sl_voxel_texture *texture = t->told->shading.texture;
    double edge = texture->edge / (double)(1u << texture->depth);
    const int32_t *cell = t->pixel->cell;
    sl_vec3d at = sl_v3d(cell[0] + (corner & 1) + 0.5, cell[1] + (corner >> 1 & 1) + 0.5,
                         cell[2] + (corner >> 2) + 0.5);
    return sl_to_float(sl_addd(texture->origin, sl_scaled(at, edge)));
}

/* Asks the kernel for the pixel's light as if all voxels together held but one light. */
static void tell_light(const telling *t, int corner, int set, int number, double weight) {
    sl_shade_cells cells = t->pixel->cells;
    sl_shade_block *b = &t->pixel->block;
    for (int k = 0; k < cells.corners; k++) {
        for (int s = 0; s < cells.corner[k].sets; s++) cells.corner[k].set[s].lights = 0;
    }
    sl_shade_set *one = &cells.corner[corner].set[set];
    one->light += number;
    one->lights = 1;
    t->kernel(&cells, SL_SHADE_LANES, t->pixel->glossy, b);
    sl_vec3 at = middle_of(t, corner);
    sl_explanation_term term = {.layer = "indirect",
                                .kind = cells.lobes == SL_LOBES_NONE
                                            ? "voxel: irradiance"
                                            : "directional light of a voxel: irradiance perpendicular to it",
                                .placed = true,
                                .position = {at.x, at.y, at.z},
                                .weight = weight};
    term.index = (uint64_t)(one->light - t->told->shading.texture->unpacked);
    bool any = false;
    const sl_octree_point *p = &t->pixel->point;
    const float diffuse[3] = {p->diffuse.r, p->diffuse.g, p->diffuse.b},
                specular[3] = {p->specular.r, p->specular.g, p->specular.b};
    for (int c = 0; c < 3; c++) {
        double reflected = (double)(diffuse[c] * (float)(1.0 / SL_PI)) * (double)b->irradiance[c][0];
        if (t->pixel->glossy) reflected += (double)specular[c] * (double)b->lobe[c][0];
        term.value[c] = one->light->color[c];
        term.contribution[c] = reflected * (double)t->throughput[c];
        any |= term.contribution[c] != 0.0;
    }
    if (any) sl_explanation_add(t->writer, &term);
}

static void tell_voxels(const telling *t) {
    const sl_shade_cells *cells = &t->pixel->cells;
    for (int k = 0; k < cells->corners; k++) {
        double weight = cells->corner[k].sets > 0 ? weight_of(t, k) : 0.0;
        for (int s = 0; weight != 0.0 && s < cells->corner[k].sets; s++) {
            for (int j = 0; j < cells->corner[k].set[s].lights; j++) tell_light(t, k, s, j, weight);
        }
    }
}

static bool is_lit(const sl_octree_told *told, size_t pixel) {
    uint32_t material = told->gbuffer->material[pixel];
    return material != SL_NO_INDEX && !sl_material_is_mirror(&told->scene->materials[material]);
}

void sl_octree_tell(const sl_octree_told *told, size_t pixel, sl_explanation_writer *writer) {
    sl_octree_pixel seen;
    telling t = {
        .told = told, .writer = writer, .kernel = sl_shade_kernel_for(sl_isa_best()), .pixel = &seen};
    if (!told->drawn) return;
    sl_explanation_add_layer(writer, "emission", "emitted light");
    sl_explanation_add_layer(writer, "direct", "direct light");
    if (!is_lit(told, pixel)) return;
    bool looked_up =
        told->atlas && !sl_material_is_glossy(&told->scene->materials[told->gbuffer->material[pixel]]);
    if (!told->shading.texture || looked_up) {
        sl_explanation_add_layer(writer, "indirect", looked_up ? "texel of the atlas" : told->otherwise);
        return;
    }
    const sl_rgb left = sl_reflections_throughput(told->reflections, pixel);
    t.throughput[0] = left.r, t.throughput[1] = left.g, t.throughput[2] = left.b;
    if (sl_octree_pixel_cells(&told->shading, told->scene, told->gbuffer, told->scene->camera.eye, pixel,
                              &seen))
        tell_voxels(&t);
}

/* ---- marks ---- */

enum { MARKS = 4096 };

void sl_octree_announce_photons(sl_announcer *announcer, const sl_photon_list *photons) {
    size_t step = photons->count / MARKS + 1, made = 0;
    sl_mark *mark = sl_announcing(announcer) && photons->count > 0
                        ? sl_allocate(photons->count / step + 1, sizeof *mark)
                        : NULL;
    if (!mark) return;
    for (size_t i = 0; i < photons->count; i += step) {
        const sl_photon *p = &photons->photon[i];
        mark[made++] = (sl_mark){.kind = SL_MARK_POINT,
                                 .at = {p->position[0], p->position[1], p->position[2]},
                                 .colour = {p->flux[0], p->flux[1], p->flux[2]}};
    }
    sl_announce_marks(announcer, "photon hits", "photon map", mark, made);
    sl_free(mark);
}

/* As long as half a voxel. */
static size_t put_arrows(const sl_voxel_lights *lights, size_t index, float length, sl_mark *mark) {
    const sl_voxel_set *set = &lights->set[index];
    size_t made = 0;
    for (int j = 0; j < set->lights; j++) {
        const sl_directional_light *light = &lights->light[index * (size_t)lights->texels + (size_t)j];
        sl_vec3 to = sl_mad(set->centroid, length, sl_direction_unpack(light->packed));
        mark[made++] = (sl_mark){.kind = SL_MARK_SEGMENT,
                                 .at = {set->centroid.x, set->centroid.y, set->centroid.z},
                                 .to = {to.x, to.y, to.z},
                                 .colour = {light->color[0], light->color[1], light->color[2]}};
    }
    return made;
}

void sl_octree_announce_lights(sl_announcer *announcer, const sl_octree *octree,
                               const sl_voxel_lights *lights) {
    bool directed = lights->options.lobes != SL_LOBES_NONE;
    size_t step = lights->set_count * (size_t)lights->texels / MARKS + 1, made = 0;
    if (!sl_announcing(announcer) || !directed || lights->set_count == 0) return;
    sl_mark *mark = sl_allocate((lights->set_count / step + 1) * (size_t)lights->texels, sizeof *mark);
    if (!mark) return;
    for (size_t i = 0; i < lights->set_count; i += step)
        made += put_arrows(lights, i, (float)(0.5 * sl_octree_voxel(octree)), mark + made);
    if (made > 0)
        sl_announce_marks(announcer, "lights of the voxels", "virtual directional lights", mark, made);
    sl_free(mark);
}
