/* The explanation of a pixel: its shading, taken apart by the shader's own kernel. Around the pixel lie eight
 * voxels; each gives the lights of one set. The kernel is linear in the lights: asked about one of them it
 * says what that one adds, and asked about a voxel that holds the constant 1, the others 0, how much that
 * voxel weighs. */
#include "cache/light_octree/light_octree.h"

#include "base/math.h"
#include "base/memory.h"

/* ---- a pixel ---- */

typedef struct explaining {
    sl_explanation_writer *writer;
    const sl_voxel_texture *texture;
    sl_isa isa;
    sl_octree_point point;
    sl_octree_seen seen;
    float throughput[3];   /* of the mirrors before it */
} explaining;

/* The voxel's weight after all are normalized: with facing and void ones as the kernel treats them. */
static double weight_of(explaining *e, int corner) {
    static const sl_unpacked_light one = {{0.0f, 0.0f, 1.0f}, {1.0f, 1.0f, 1.0f}};
    sl_shade_cells cells = e->seen.cells;
    cells.lobes = SL_LOBES_NONE;
    for (int k = 0; k < cells.corners; k++) {
        for (int s = 0; s < cells.corner[k].sets; s++) {
            cells.corner[k].set[s].light = &one;
            cells.corner[k].set[s].lights = k == corner;
        }
    }
    SL_KERNEL_OF(e->isa, sl_shade_block)(&cells, SL_SHADE_LANES, false, &e->seen.block);
    return (double)e->seen.block.irradiance[0][0];
}

static sl_vec3 middle_of(const explaining *e, int corner) {
    const int32_t *cell = e->seen.cell;
    sl_vec3d at = sl_v3d(cell[0] + (corner & 1) + 0.5, cell[1] + (corner >> 1 & 1) + 0.5,
                         cell[2] + (corner >> 2) + 0.5);
    double edge = e->texture->edge / (double)(1u << e->texture->depth);
    return sl_to_float(sl_addd(e->texture->origin, sl_scaled(at, edge)));
}

/* Asks the kernel for the pixel's light as if all voxels together held but one light. */
static void explain_light(explaining *e, int corner, int set, int number, double weight) {
    sl_shade_cells cells = e->seen.cells;
    sl_shade_block *b = &e->seen.block;
    for (int k = 0; k < cells.corners; k++) {
        for (int s = 0; s < cells.corner[k].sets; s++) cells.corner[k].set[s].lights = 0;
    }
    sl_shade_set *one = &cells.corner[corner].set[set];
    one->light += number;
    one->lights = 1;
    SL_KERNEL_OF(e->isa, sl_shade_block)(&cells, SL_SHADE_LANES, e->seen.glossy, b);
    sl_vec3 at = middle_of(e, corner);
    sl_explanation_term term = {.layer = "indirect",
                                .kind = cells.lobes == SL_LOBES_NONE
                                            ? "voxel: irradiance"
                                            : "directional light of a voxel: irradiance perpendicular to it",
                                .index = (uint64_t)(one->light - e->texture->light),
                                .placed = true,
                                .position = {at.x, at.y, at.z},
                                .weight = weight};
    bool any = false;
    const float diffuse[3] = {e->point.diffuse.r, e->point.diffuse.g, e->point.diffuse.b},
                specular[3] = {e->point.specular.r, e->point.specular.g, e->point.specular.b};
    for (int c = 0; c < 3; c++) {
        double reflected = (double)(diffuse[c] * (float)(1.0 / SL_PI)) * (double)b->irradiance[c][0];
        if (e->seen.glossy) reflected += (double)specular[c] * (double)b->lobe[c][0];
        term.value[c] = one->light->color[c];
        term.contribution[c] = reflected * (double)e->throughput[c];
        any |= term.contribution[c] != 0.0;
    }
    if (any) sl_explanation_add(e->writer, &term);
}

static void explain_voxels(explaining *e) {
    const sl_shade_cells *cells = &e->seen.cells;
    for (int k = 0; k < cells->corners; k++) {
        double weight = cells->corner[k].sets > 0 ? weight_of(e, k) : 0.0;
        for (int s = 0; weight != 0.0 && s < cells->corner[k].sets; s++) {
            for (int j = 0; j < cells->corner[k].set[s].lights; j++) explain_light(e, k, s, j, weight);
        }
    }
}

/* Returns what the indirect light of a pixel is where it is not that of the shown octree's lights; else NULL.
 */
static const char *other_light(const sl_octree_state *s, const sl_material *material) {
    if (s->canvas && !sl_material_is_glossy(material)) return "texel of the atlas";
    if (s->settings.light_octree.photons_at_pixels) return "the photons nearest to the pixel";
    return s->lit ? NULL : "lights of voxels that made way for smaller ones";
}

sl_status sl_octree_explanation(void *state, int x, int y, sl_explanation_writer *writer, sl_error *error) {
    const sl_octree_state *s = state;
    const size_t pixel = (size_t)y * (size_t)s->settings.width + (size_t)x;
    (void)error;
    if (s->phase == SL_OCTREE_PHASE_GBUFFER) return SL_OK; /* nothing is drawn yet */
    sl_explanation_add_layer(writer, "emission", "emitted light");
    sl_explanation_add_layer(writer, "direct", "direct light");
    const uint32_t number = s->gbuffer->material[pixel];
    const sl_material *material = number != SL_NO_INDEX ? &s->scene->materials[number] : NULL;
    if (!material || sl_material_is_mirror(material)) return SL_OK;
    const char *other = other_light(s, material);
    if (other) {
        sl_explanation_add_layer(writer, "indirect", other);
        return SL_OK;
    }
    const sl_octree_shading shading = sl_octree_state_shading(s);
    const sl_rgb left = sl_reflections_throughput(s->reflections, pixel);
    explaining e = {
        .writer = writer,
        .texture = shading.texture,
        .isa = sl_isa_best(),
        .point = sl_octree_point_of_pixel(s->scene, s->gbuffer, s->scene->camera.eye, pixel),
        .throughput = {left.r, left.g, left.b}};
    if (sl_octree_see(&shading, &e.point, &e.seen)) explain_voxels(&e);
    return SL_OK;
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
