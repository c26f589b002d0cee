/* The display arrays: two copies of the patches' trees and of what their vertices show. */
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/frame/picture_value.h"
#include "cache/patches/display/display.h"

/* Grows a list to `wanted` entries; what was in it stays, what is new is zero. `list` as in sl_regrow(). */
static bool grow(void *list, size_t *capacity, size_t wanted, size_t entry_bytes) {
    if (wanted <= *capacity) return true;
    size_t room = *capacity + *capacity / 128 + 32; /* what is allocated and not used counts, too */
    if (room < wanted) room = wanted;
    if (!sl_regrow(list, *capacity, room, entry_bytes)) return false;
    *capacity = room;
    return true;
}

/* ---- life ------------------------------------------------------------------------------------ */

static void release_copy(sl_display_copy *copy) {
    SL_FREE_ALL(copy->wanted, copy->root, copy->word, copy->middle, copy->value, copy->fans.spoke);
}

void sl_display_destroy(sl_display *d) {
    if (!d) return;
    for (int k = 0; k < 2; k++) release_copy(&d->copy[k]);
    sl_window_close(&d->own);
    sl_free(d->curved);
    sl_monitor_close(&d->copies.swap);
    SL_FREE_ALL(d->left_out, d);
}

static bool allocate_arrays(sl_display *d) {
    size_t roots = 2 * d->primitives->count;
    bool curved = d->primitives->curved > 0, ok = true;
    for (int k = 0; ok && k < 2; k++) {
        d->copy[k].root = sl_allocate_unset(roots, sizeof *d->copy[k].root);
        ok = d->copy[k].root != NULL;
        if (ok) memset(d->copy[k].root, 0xff, roots * sizeof *d->copy[k].root); /* SL_NO_INDEX */
    }
    if (ok && curved)
        ok = (d->left_out = sl_allocate(d->scene->triangle_count, 1)) &&
             (d->curved = sl_allocate(d->primitives->curved, sizeof *d->curved));
    for (uint32_t i = 0; ok && curved && i < d->primitives->count; i++) {
        if (d->primitives->kind[i] == SL_PRIMITIVE_BICUBIC) d->curved[d->curved_count++] = i;
    }
    for (size_t t = 0; ok && curved && t < d->scene->triangle_count; t++)
        d->left_out[t] = d->primitives->kind[d->primitives->of_triangle[t]] == SL_PRIMITIVE_BICUBIC;
    return ok;
}

sl_status sl_display_create(const sl_scene *scene, const sl_primitives *primitives,
                            const sl_display_settings *settings, sl_display **display, sl_error *error) {
    *display = NULL;
    sl_display *d = sl_allocate(1, sizeof *d);
    if (!d) return sl_fail_memory(error, "the display");
    if (!sl_monitor_open(&d->copies.swap)) {
        sl_free(d);
        return sl_fail(error, SL_ERROR_RESOURCES, "no lock for the display");
    }
    d->scene = scene;
    d->primitives = primitives;
    d->settings = *settings;
    d->copy[0].guess = d->copy[1].guess = settings->guess;
    for (size_t m = 0; m < scene->material_count; m++)
        d->textured |= scene->materials[m].texture != SL_NO_INDEX;
    sl_status status = allocate_arrays(d) ? SL_OK : sl_fail_memory(error, "the display");
    if (status == SL_OK) status = sl_window_open(d, scene, settings->threads, &d->own, error);
    if (status == SL_OK) *display = d;
    else sl_display_destroy(d);
    return status;
}

size_t sl_display_memory_bytes(const sl_display *d) {
    size_t bytes = 0;
    for (int k = 0; k < 2; k++) {
        const sl_display_copy *c = &d->copy[k];
        bytes += c->root_capacity * sizeof *c->wanted + c->patch_capacity * sizeof *c->word +
                 c->block_capacity * sizeof *c->middle +
                 c->vertex_capacity * c->channels * sizeof *c->value;
        bytes += c->fans.capacity * sizeof *c->fans.spoke;
    }
    return bytes;
}

/* ---- trees ----------------------------------------------------------------------------------- */

static bool reserve_copy(sl_display_copy *copy, const sl_patches *p) {
    copy->channels = (size_t)p->settings.channels;
    return grow(&copy->wanted, &copy->root_capacity, p->root_count, sizeof *copy->wanted) &&
           grow(&copy->word, &copy->patch_capacity, p->patch_count, sizeof *copy->word) &&
           grow(&copy->value, &copy->vertex_capacity, p->vertex_count,
                copy->channels * sizeof *copy->value) &&
           grow(&copy->middle, &copy->block_capacity, p->patch_count / 4, sizeof *copy->middle);
}

static bool put_fan(sl_fans *fans, const sl_patches *p, uint32_t patch, uint32_t *word) {
    sl_fan_spoke spoke[4 * SL_HANGING_MOST];
    sl_patch_place leaf = sl_patch_place_of(p, patch);
    size_t count = sl_patch_spokes(p, &leaf, SL_PATCH_DEPTH_MAX, 0, spoke), end = fans->used + 1 + count;
    if (count == 0) return true;
    if (end > SL_FAN_BIT || !grow(&fans->spoke, &fans->capacity, end, sizeof *fans->spoke))
        return false;
    fans->spoke[fans->used] = (sl_fan_spoke){.vertex = (uint32_t)count};
    memcpy(&fans->spoke[fans->used + 1], spoke, count * sizeof *spoke);
    *word = SL_FAN_BIT | (uint32_t)fans->used;
    fans->used = end;
    return true;
}

static bool put_patch(sl_display_copy *copy, const sl_patches *p, uint32_t patch) {
    uint32_t *word = &copy->word[patch];
    *word = SL_DISPLAY_LEAF;
    if (sl_patch_is_leaf(p, patch))
        return sl_patch_has_no_spokes(p, patch) || put_fan(&copy->fans, p, patch, word);
    *word = p->patch[patch].child / 4;
    memcpy(copy->middle[*word], p->block[*word].middle, sizeof copy->middle[0]);
    return true;
}

/* ---- values of vertices ---------------------------------------------------------------------- */

/* Shows its samples; or, before it has any, what the nearest patch around it shows there all of whose corners
 * have; or the guess. As that depends on where the vertex lies and on nothing else, all leaves that have it
 * show the same, and nothing is seen of a split until its samples come. Finite, as pictures are. */
static void show_vertex(const sl_display_copy *copy, const sl_patches *p, uint32_t vertex) {
    const sl_patch_vertex *v = &p->vertex[vertex];
    float around[6] = {copy->guess.r, copy->guess.g, copy->guess.b};
    const float *value = sl_vertex_value(p, vertex);
    if (v->evaluated == SL_VERTEX_NEVER) {
        sl_vertex_surroundings(p, vertex, around);
        value = around;
    }
    for (size_t i = 0; i < copy->channels; i++)
        copy->value[vertex * copy->channels + i] = sl_picture_value(value[i]);
}

/* ---- the whole ------------------------------------------------------------------------------- */

static bool make_copy(sl_display *d, sl_display_copy *copy, const sl_patches *p) {
    copy->fans.used = 0;
    copy->guess = d->settings.guess;
    if (!reserve_copy(copy, p)) return false;
    for (uint32_t i = 0; i < p->root_count; i++) {
        copy->wanted[i] = p->root[i];
        copy->root[p->root[i].root] = i;
    }
    for (uint32_t i = 0; i < p->patch_count; i++)
        if (sl_patch_is_alive(p, i) && !put_patch(copy, p, i)) return false;
    for (uint32_t i = 0; i < p->vertex_count; i++)
        if (p->vertex[i].references) show_vertex(copy, p, i);
    return true;
}

sl_status sl_display_build(sl_display *d, const sl_patches *p, sl_error *error) {
    sl_display_copy *copy = &d->copy[sl_copies_hidden(&d->copies, true)];
    sl_status status = make_copy(d, copy, p) ? SL_OK : sl_fail_memory(error, "the display");
    if (status == SL_OK && d->curved) status = sl_tessellate(&d->own, error);
    if (status == SL_OK) sl_copies_swap(&d->copies);
    return status;
}

static bool much_the_same(sl_rgb a, sl_rgb b) {
    return sl_is_much_the_same((double)a.r, (double)b.r) && sl_is_much_the_same((double)a.g, (double)b.g) &&
           sl_is_much_the_same((double)a.b, (double)b.b);
}

bool sl_display_guess(sl_display *d, sl_rgb guess) {
    if (much_the_same(guess, d->settings.guess)) return false;
    d->settings.guess = guess;
    return true;
}
