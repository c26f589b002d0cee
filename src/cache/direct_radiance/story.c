/* The story of a pixel: (10) told photon by photon. */
#include "cache/direct_radiance/story.h"

#include "base/error.h"
#include "base/memory.h"

struct sl_radiance_story {
    sl_light_pass light;
    sl_receivers *receivers; /* whole, since pictures that are drawn in strips leave none */
    sl_receiver_kinds kinds;
    sl_photon_sums *sums;    /* NULL: no photons */
};

sl_status sl_radiance_story_create(const sl_light_pass *light, const sl_raster *raster, const sl_view *view, const sl_mirrors *planar,
                                   int reflections, sl_radiance_story **out, sl_error *error) {
    sl_counters ignored = {{0}};
    sl_radiance_story *story = sl_allocate(1, sizeof *story);
    *out = NULL;
    if (!story) return sl_fail_memory(error, "the stories of pixels");
    *story = (sl_radiance_story){.light = *light};
    sl_status status = sl_receivers_render(light->scene, raster, view, planar, reflections, light->threads, &story->receivers, &ignored, error);
    if (status == SL_OK) status = sl_receiver_kinds_find(light->scene, light->trick_albedo, &story->kinds, error);
    if (status == SL_OK && light->photons && light->photons->count) {
        status = sl_photon_sums_create(&story->light, &story->sums, error);
        if (status == SL_OK) status = sl_photon_sums_see(story->sums, story->receivers, &story->kinds, &ignored, error);
    }
    if (status != SL_OK) sl_radiance_story_destroy(story);
    else *out = story;
    return status;
}

void sl_radiance_story_destroy(sl_radiance_story *story) {
    if (!story) return;
    sl_photon_sums_destroy(story->sums);
    sl_receiver_kinds_release(&story->kinds);
    sl_receivers_destroy(story->receivers);
    sl_free(story);
}

size_t sl_radiance_story_bytes(const sl_radiance_story *story) {
    return story ? sizeof *story + (story->receivers ? sl_receivers_bytes(story->receivers) : 0) : 0;
}

/* ---- one pixel ---- */

typedef struct {
    const sl_radiance_story *story;
    size_t pixel;
    sl_story_writer *writer;
} telling;

static void tell_photon(void *context, size_t photon, float weight, const float radiance[3]) {
    const telling *t = context;
    const sl_map_photon *p = &t->story->light.photons->photon[photon];
    sl_story_term term = {.layer = "indirect", .kind = "photon of the map", .index = photon, .placed = true, .weight = (double)weight,
                          .position = {p->position.x, p->position.y, p->position.z}, .value = {p->flux.r, p->flux.g, p->flux.b}};
    for (int c = 0; c < 3; c++) {
        const float *throughput = t->story->receivers->throughput[c];
        term.contribution[c] = (double)radiance[c] * (throughput ? (double)throughput[t->pixel] : 1.0);
    }
    sl_story_add(t->writer, &term);
}

/* The tile's lanes up to one pixel's, and as few as loops take: what lies beyond has no say. */
static sl_receiver_tile up_to(const sl_receiver_tile *tile, size_t lane) {
    sl_receiver_tile shorter = *tile;
    shorter.count = lane + 1;
    shorter.padded = (lane / SL_TILE_LANES + 1) * SL_TILE_LANES;
    shorter.whole = false;
    return shorter;
}

/* Of the tiles of its strip the one that has the pixel. */
static void tell_tile(void *context, const sl_receiver_tile *tile, bool glossy, sl_counters *counters) {
    const telling *t = context;
    for (size_t lane = 0; lane < tile->count; lane++) {
        if (tile->pixel[lane] != t->pixel) continue;
        const sl_receiver_tile shorter = up_to(tile, lane);
        sl_indirect_light_apart(t->story->sums, &shorter, glossy, lane, tell_photon, context, counters);
    }
}

void sl_radiance_story_tell(const sl_radiance_story *story, int x, int y, sl_story_writer *writer) {
    const sl_receivers *r = story->receivers;
    telling t = {story, (size_t)y * (size_t)r->width + (size_t)x, writer};
    sl_counters ignored = {{0}};
    sl_story_add_layer(writer, "emission", "emitted light");
    sl_story_add_layer(writer, "direct", "direct light");
    uint32_t material = r->gbuffer->material[t.pixel];
    bool mirror = material != SL_NO_INDEX && sl_material_is_mirror(&story->light.scene->materials[material]);
    if (mirror) sl_story_add_layer(writer, "indirect", "what a curved mirror shows");
    else if (story->sums) sl_receiver_tiles_strip(r, &story->kinds, y - y % SL_TILE_HEIGHT, tell_tile, &t, &ignored);
}

/* ---- marks ---- */

void sl_announce_photons(sl_announcer *announcer, const sl_map_photons *photons) {
    sl_mark *marks = sl_announcing(announcer) && photons->count ? sl_allocate(photons->count, sizeof *marks) : NULL;
    if (!marks) return;
    for (size_t j = 0; j < photons->count; j++) {
        const sl_map_photon *p = &photons->photon[j];
        marks[j] = (sl_mark){.kind = SL_MARK_POINT, .at = {p->position.x, p->position.y, p->position.z}, .colour = {p->flux.r, p->flux.g, p->flux.b}};
    }
    sl_announce_marks(announcer, "sample photons", "samples of the direct radiance map", marks, photons->count);
    sl_free(marks);
}
