/* Light apart by what it costs: at each vertex a cheap layer (direct light, caustics), renewed at once
 * where it changes, and a dear one (indirect light by paths), which ages. What is displayed is their sum.
 * While the dear layer is not what it is from an edit on, it follows the vertices that were sampled anew:
 * as in a hierarchical basis (Yserentant 1986), where the corners of a patch have moved all that was
 * interpolated between them moves along, and keeps its difference to that. So few samples at coarse
 * patches bring the whole layer to where light is now, and what fine patches have found is never thrown
 * away.
 *
 * Kept where there are samples of both kinds and values are no means of several sets. */
#pragma once

#include "cache/patches/patches.h"

/* Layers of light at one vertex, by what a sample costs: direct light, and caustics that have a map, by some
 * rays; indirect light by hundreds of paths. */
enum { SL_LAYER_CHEAP = 1, SL_LAYER_DEAR = 2, SL_LAYERS_ALL = 3 };

/* Versions of the scene count its edits. A dear layer that was never sampled is interpolated from the corners
 * around it when its vertex gets its cheap one. */
enum { SL_VERSION_UNKNOWN = 0, SL_VERSION_INTERPOLATED = 1, SL_VERSION_FIRST = 2 };

typedef struct sl_layers {
    bool kept;
    size_t capacity;           /* vertices */
    float *value;              /* by vertex: the cheap layer's channels, the dear one's */
    /* by vertex that was evaluated: as of which version its dear layer was sampled; UNKNOWN: it has no light
     * of its own */
    uint32_t *version;
    uint32_t now;              /* the scene's version */
    uint32_t edited, eye_moved; /* the versions of the last edit of geometry or light, and of the eye */
    /* of one update, by vertex; NULL: no dear layer was sampled again in it */
    float *shift;              /* what the dear layer has moved by */
    uint32_t *span;            /* versions since it had been sampled; 0: it has not moved yet */
} sl_layers;

void sl_layers_release(sl_layers *layers);
size_t sl_layers_bytes(const sl_layers *layers, const sl_patches *patches);
/* Makes room for all vertices; before requests are made. */
sl_status sl_layers_reserve(sl_layers *layers, const sl_patches *patches, sl_error *error);
static inline float *sl_cheap_layer(const sl_layers *layers, const sl_patches *p, uint32_t vertex) {
    return layers->value + 2 * (size_t)vertex * (size_t)p->settings.channels;
}
static inline float *sl_dear_layer(const sl_layers *layers, const sl_patches *p, uint32_t vertex) {
    return sl_cheap_layer(layers, p, vertex) + p->settings.channels;
}

/* Tells whether an evaluated vertex's dear layer is from before an edit, or interpolated. */
bool sl_dear_layer_is_stale(const sl_layers *layers, const sl_patches *patches, uint32_t vertex);
/* Tells whether a vertex's dear layer could be interpolated from those around it. */
bool sl_dear_layer_is_near(const sl_layers *layers, const sl_patches *patches, uint32_t vertex);
/* Keeps the layers that were sampled (parts[0]: cheap, parts[1]: dear), and gives the sum of both where one
 * of the two was not. The vertex is not marked as evaluated yet. */
void sl_layers_commit(sl_layers *layers, const sl_patches *patches, uint32_t vertex, unsigned sampled,
                      const float parts[2][6], float sum[6]);
/* Before the commits of an update in which dear layers were sampled again, and after them: the other vertices
 * follow. Those that were sampled more lately than the ones they follow go the less of the way. */
sl_status sl_layers_begin(sl_layers *layers, const sl_patches *patches, sl_error *error);
void sl_layers_follow(sl_layers *layers, sl_patches *patches);
