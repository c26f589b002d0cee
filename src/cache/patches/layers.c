#include "cache/patches/layers.h"

#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"

/* ---- memory ---- */

static void end(sl_layers *l) {
    sl_free(l->shift);
    sl_free(l->span);
    l->shift = NULL;
    l->span = NULL;
}

void sl_layers_release(sl_layers *l) {
    end(l);
    sl_free(l->value);
    sl_free(l->version);
}

size_t sl_layers_bytes(const sl_layers *l, const sl_patches *p) {
    return l->capacity * (2 * (size_t)p->settings.channels * sizeof *l->value + sizeof *l->version);
}

sl_status sl_layers_reserve(sl_layers *l, const sl_patches *p, sl_error *error) {
    if (!l->kept || p->vertex_capacity <= l->capacity) return SL_OK;
    if (!sl_regrow(&l->value, l->capacity, p->vertex_capacity,
                   2 * (size_t)p->settings.channels * sizeof *l->value) ||
        !sl_regrow(&l->version, l->capacity, p->vertex_capacity, sizeof *l->version))
        return sl_fail_memory(error, "layers of light");
    memset(l->version + l->capacity, 0, (p->vertex_capacity - l->capacity) * sizeof *l->version);
    l->capacity = p->vertex_capacity;
    return SL_OK;
}

/* ---- one vertex ---- */

bool sl_dear_layer_is_stale(const sl_layers *l, const sl_patches *p, uint32_t vertex) {
    if (!l->kept || p->vertex[vertex].extrapolated) return false;
    bool lobe = sl_material_has_lobe(sl_root_material(p->primitives, p->vertex[vertex].root));
    return l->version[vertex] < l->edited || (lobe && l->version[vertex] < l->eye_moved);
}

/* Gives the shares of the corners around a vertex; false: the layers of one of them are not known. */
static bool find_around(const sl_layers *l, const sl_patches *p, uint32_t vertex, sl_vertex_shares *around) {
    if (!sl_vertex_shares_around(p, vertex, around)) return false;
    for (size_t k = 0; k < around->count; k++) {
        uint32_t other = around->vertex[k];
        if (other >= l->capacity || l->version[other] == SL_VERSION_UNKNOWN) return false;
    }
    return true;
}

bool sl_dear_layer_is_near(const sl_layers *l, const sl_patches *p, uint32_t vertex) {
    sl_vertex_shares around;
    return find_around(l, p, vertex, &around);
}

static void interpolate(sl_layers *l, const sl_patches *p, uint32_t vertex) {
    sl_vertex_shares around;
    double sum[6] = {0.0};
    float *dear = sl_dear_layer(l, p, vertex);
    if (!find_around(l, p, vertex, &around)) around.count = 0;
    for (size_t k = 0; k < around.count; k++) {
        for (int c = 0; c < p->settings.channels; c++)
            sum[c] += around.weight[k] * (double)sl_dear_layer(l, p, around.vertex[k])[c];
    }
    for (int c = 0; c < p->settings.channels; c++) dear[c] = (float)sum[c];
    l->version[vertex] = SL_VERSION_INTERPOLATED;
}

static void put_dear(sl_layers *l, const sl_patches *p, uint32_t vertex, bool again, const float part[6]) {
    float *dear = sl_dear_layer(l, p, vertex);
    const size_t channels = (size_t)p->settings.channels;
    float before[6];
    memcpy(before, dear, channels * sizeof *dear);
    memcpy(dear, part, channels * sizeof *dear);
    for (size_t c = 0; l->shift && again && c < channels; c++)
        l->shift[vertex * channels + c] = dear[c] - before[c];
    if (l->shift) l->span[vertex] = again ? l->now - l->version[vertex] + 1 : 1;
    l->version[vertex] = l->now;
}

void sl_layers_commit(sl_layers *l, const sl_patches *p, uint32_t vertex, unsigned sampled,
                      const float parts[2][6], float sum[6]) {
    bool first = p->vertex[vertex].evaluated == SL_VERTEX_NEVER;
    float *cheap = sl_cheap_layer(l, p, vertex), *dear = sl_dear_layer(l, p, vertex);
    if (sampled & SL_LAYER_CHEAP) memcpy(cheap, parts[0], (size_t)p->settings.channels * sizeof *cheap);
    if (sampled & SL_LAYER_DEAR)
        put_dear(l, p, vertex, !first && l->version[vertex] != SL_VERSION_UNKNOWN, parts[1]);
    else if (first) interpolate(l, p, vertex);
    for (int c = 0; c < p->settings.channels && sampled != SL_LAYERS_ALL; c++) sum[c] = cheap[c] + dear[c];
}

/* ---- all that follow ---- */

sl_status sl_layers_begin(sl_layers *l, const sl_patches *p, sl_error *error) {
    end(l);
    l->shift = sl_allocate(p->vertex_count, (size_t)p->settings.channels * sizeof *l->shift);
    l->span = sl_allocate(p->vertex_count, sizeof *l->span);
    if (l->shift && l->span) return SL_OK;
    end(l);
    return sl_fail_memory(error, "layers of light");
}

/* Moves a vertex by the mean of what those around it have moved by; by less of it where its own sample is
 * younger than what they had. */
static void follow(sl_layers *l, sl_patches *p, uint32_t vertex, int count, const uint32_t *around) {
    const size_t channels = (size_t)p->settings.channels;
    const sl_patch_vertex *v = &p->vertex[vertex];
    float *shift = l->shift + vertex * channels, *dear = sl_dear_layer(l, p, vertex);
    if (l->span[vertex] || v->evaluated == SL_VERTEX_NEVER || v->extrapolated || vertex >= l->capacity ||
        l->version[vertex] == SL_VERSION_UNKNOWN)
        return;
    uint32_t span = 0;
    for (int k = 0; k < count; k++) span = l->span[around[k]] > span ? l->span[around[k]] : span;
    if (!span) return;
    float old = (float)(l->now - l->version[vertex] + 1), part = old < (float)span ? old / (float)span : 1.0f;
    for (size_t c = 0; c < channels; c++) {
        float sum = 0.0f;
        for (int k = 0; k < count; k++) sum += l->shift[around[k] * channels + c];
        float moved = dear[c] + part * sum / (float)count;
        moved = moved > 0.0f ? moved : 0.0f;
        shift[c] = moved - dear[c];
        dear[c] = moved;
        sl_vertex_value(p, vertex)[c] = sl_cheap_layer(l, p, vertex)[c] + moved;
    }
    l->span[vertex] = span;
}

/* From the top down: a split's vertices lie between the corners of what was split. */
static void follow_below(sl_layers *l, sl_patches *p, uint32_t patch) {
    uint32_t first = p->patch[patch].child, corner[4];
    if (first == SL_NO_INDEX) return;
    int corners = sl_patch_corners(p, patch);
    for (int c = 0; c < corners; c++) corner[c] = sl_patch_corner(p, patch, c);
    const uint32_t *middle = sl_patch_block_of(p, first)->middle;
    for (int m = 0; m < corners; m++)
        follow(l, p, middle[m], 2, (const uint32_t[2]){corner[m], corner[(m + 1) % corners]});
    if (corners == 4) follow(l, p, middle[4], 4, corner);
    for (uint32_t k = 0; k < 4; k++) follow_below(l, p, first + k);
}

void sl_layers_follow(sl_layers *l, sl_patches *p) {
    for (size_t i = 0; l->shift && i < p->root_count; i++) follow_below(l, p, p->root[i].patch);
    end(l);
}
