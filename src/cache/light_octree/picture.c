/* A picture: emission, direct and indirect light, and what mirrors leave of them; its metadata; memory. */
#include "base/print.h"
#include "cache/light_octree/light_octree.h"
#include "image/unset.h"

#include <stdio.h>

sl_status sl_octree_create_image(const sl_octree_state *s, sl_image **image, sl_error *error) {
    return sl_image_create_unset(s->gbuffer->width, s->gbuffer->height, SL_COMPOSED_CHANNELS,
                                 sl_composed_names, image, error);
}

void sl_octree_compose(const sl_octree_state *s, sl_image *image) {
    const sl_gbuffer *g = s->gbuffer;
    float *const *direct = s->direct_light, *const *indirect = s->indirect_light;
    if (s->phase == SL_OCTREE_PHASE_GBUFFER) { /* nothing is drawn yet */
        sl_image_clear(image);
        return;
    }
    const sl_view view = sl_view_scene(s->scene, g->width, g->height);
    const sl_composition composition = {
        .scene = s->scene, .view = &view, .gbuffer = g, .reflections = s->reflections,
        .layer = {{{direct[0], direct[1], direct[2]}, SL_COMPOSED_DIRECT},
                  {{indirect[0], indirect[1], indirect[2]}, SL_COMPOSED_INDIRECT}},
        .image = image};
    sl_compose_picture(&composition, s->settings.threads);
}

/* ---- what it was made from ---- */

static sl_status write_number(sl_image *image, const char *name, double value, sl_error *error) {
    char key[SL_METADATA_KEY_MAX], text[32];
    snprintf(key, sizeof key, "softlux.octree.%s", name);
    sl_print(text, sizeof text, "%.9g", value);
    return sl_image_set_metadata(image, key, text, error);
}

static sl_status write_statistics(const sl_octree_state *s, const sl_voxel_statistics *v, sl_image *image,
                                  sl_error *error) {
    const sl_octree *octree = s->shown.octree;
    const sl_photon_list *photons = sl_photon_tree_list(s->shown.lights->tree);
    const struct {
        const char *name;
        double value;
    } numbers[] = {{"depth", octree->depth},
                   {"leaves", (double)octree->leaf_count},
                   {"photons_emitted", (double)photons->emitted},
                   {"photons_stored", (double)photons->count},
                   {"photons_a_voxel", v->mean_photons},
                   {"radius", v->mean_radius},
                   {"radius_in_voxels", v->mean_radius / sl_octree_voxel(octree)},
                   {"spread_deg", v->rms_angle * 57.29577951308232},
                   {"flux", v->flux},
                   {"sets", (double)v->sets},
                   {"texture_bytes", (double)sl_voxel_texture_bytes(s->shown.texture)},
                   {"resident_bytes", (double)sl_voxel_texture_resident_bytes(s->shown.texture)}};
    sl_status status = SL_OK;
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0] && status == SL_OK; i++)
        status = write_number(image, numbers[i].name, numbers[i].value, error);
    return status;
}

/* ---- what is to be said against it ---- */

/* Gathers that reach beyond the voxels blur more than these do; voxels that count their own photons and have
 * few count badly. */
static void write_warning(const sl_octree_state *s, const sl_voxel_statistics *v, char *text, size_t size) {
    const sl_light_octree_settings *o = &s->settings.light_octree;
    double reach = v->mean_radius / sl_octree_voxel(s->shown.octree);
    double photons = (double)sl_photon_tree_list(s->shown.lights->tree)->count,
           a_voxel = photons / (double)s->shown.octree->leaf_count;
    text[0] = '\0';
    if (o->own_photons && a_voxel < SL_OCTREE_FEW_PHOTONS * o->neighbours)
        sl_print(text, size,
                 "%.3g photons a voxel are few for voxels that count their own: more stored photons, or a "
                 "smaller depth",
                 a_voxel);
    else if (!o->own_photons && v->lit > 0 && reach > SL_OCTREE_WIDE_GATHERS)
        sl_print(text, size,
                 "photons were gathered from %.3g voxels around: light is blurred by that, not by the "
                 "voxels; more stored photons, fewer neighbours "
                 "or a smaller depth",
                 reach);
    else if (sl_octree_widens_gloss(s->scene, o))
        sl_print(text, size,
                 "%d lights a voxel cannot show sharp gloss: lobes of exponents above %d reflect indirect "
                 "light blurred",
                 o->lights, 2 * o->lights - 2);
}

sl_status sl_octree_write_report(const sl_octree_state *s, sl_image *image, sl_error *error) {
    if (!s->shown.texture || !s->shown.octree->leaf_count) return SL_OK;
    char text[256];
    const sl_voxel_statistics v = sl_voxel_lights_statistics(s->shown.lights);
    sl_status status = write_statistics(s, &v, image, error);
    write_warning(s, &v, text, sizeof text);
    return status == SL_OK && text[0] ? sl_warn(image, error, "%s", text) : status;
}

/* ---- memory ---- */

static size_t level_bytes(const sl_octree_level *level) {
    size_t bytes = level->octree ? sl_octree_bytes(level->octree) : 0;
    if (level->lights) bytes += sl_voxel_lights_bytes(level->lights);
    return bytes + (level->texture ? sl_voxel_texture_resident_bytes(level->texture) : 0);
}

size_t sl_octree_state_bytes(const void *state) {
    const sl_octree_state *s = state;
    const size_t a_pixel = (SL_OCTREE_PLANES + 14) * sizeof(float) + 2 * sizeof(uint32_t);
    size_t bytes = sizeof *s + sl_settings_pixels(&s->settings) * a_pixel;
    bytes += level_bytes(&s->shown) + level_bytes(&s->next);
    if (s->photons) bytes += s->photons->count * sizeof(sl_photon);
    if (s->tree) bytes += sl_photon_tree_bytes(s->tree);
    bytes += sl_octree_motion_bytes(&s->motion);
    if (s->canvas) bytes += sl_atlas_canvas_bytes(s->canvas);
    if (s->raster) bytes += sl_raster_memory_bytes(s->raster);
    if (s->tracer) bytes += sl_tracer_memory_bytes(s->tracer);
    return bytes;
}
