/* The records of a method on disk, for another run. They depend on geometry, materials, lights and
 * environment, and on the settings below; not on the camera, which may have moved. A picture from the same
 * place then needs no new records and has the same bits. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "cache/frame/cache_file.h"
#include "cache/splatting/state.h"

enum { SETTINGS = 15 };

/* Begins a class's records. */
typedef struct class_head {
    uint32_t count, clamped, coefficients;
} class_head;

static sl_cache_header header_of(const sl_splat_state *s, sl_cache_setting settings[SETTINGS]) {
    const sl_settings *g = &s->settings;
    const sl_cache_setting all[SETTINGS] = {
        {"quality", g->quality},
        {"accuracy", s->settings.accuracy},
        {"glossy accuracy", s->settings.glossy_accuracy},
        {"gather", g->gather},
        {"gather size", s->plan.gather.size},
        {"direct light", g->direct},
        {"number of light samples a hit", g->hit_samples},
        {"seed", (double)(g->seed & UINT32_MAX)},
        {"seed", (double)(g->seed >> 32)},
        {"metric", g->metric},
        {"order of the harmonics", s->plan.harmonics_order},
        {"number of bounces", g->bounces},
        {"order of pixels", g->order},
        {"kind of picture: a walk's records do not follow the pixels", g->records_per_frame > 0},
        {"size of a record", (double)sizeof(sl_record)},
    };
    memcpy(settings, all, sizeof all);
    return (sl_cache_header){sl_scene_light_hash(s->scene), SETTINGS, settings};
}

/* ---- save ---- */

sl_status sl_splat_save(const void *state, const char *path, sl_error *error) {
    const sl_splat_state *s = state;
    sl_cache_setting settings[SETTINGS];
    const sl_cache_header header = header_of(s, settings);
    class_head heads[SL_RECEIVER_CLASSES];
    sl_cache_part parts[3 * SL_RECEIVER_CLASSES];
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        const sl_record_list *list = &s->cache[c].list;
        const size_t floats = list->coefficients ? sl_splat_coefficients(s, (sl_receiver_class)c) : 0;
        heads[c] = (class_head){(uint32_t)list->count, (uint32_t)s->cache[c].clamped, (uint32_t)floats};
        parts[3 * c] = (sl_cache_part){&heads[c], sizeof heads[c]};
        parts[3 * c + 1] = (sl_cache_part){list->records, list->count * sizeof *list->records};
        parts[3 * c + 2] = (sl_cache_part){list->coefficients, list->count * floats * sizeof(float)};
    }
    return sl_cache_file_write(path, &header, parts, 3 * SL_RECEIVER_CLASSES, error);
}

/* ---- load ---- */

/* Of one class; nothing is kept of it where any class fails. */
typedef struct {
    sl_record_list list;
    size_t clamped;
} loaded;

static bool is_sane(const sl_record *r) {
    return sl_is_finite(r->position) && sl_is_finite(r->normal) && isfinite(r->radius) && r->radius > 0.0f &&
           isfinite(r->own_radius) && r->own_radius > 0.0f && isfinite(r->minimum_radius) &&
           r->stretch > 0.0f && sl_rgb_is_finite(r->irradiance);
}

/* Of records without coefficients floats is NULL. */
static sl_status append(const sl_record *records, const float *floats, size_t wanted, size_t count,
                        const char *path, loaded *l, sl_error *error) {
    sl_status status = SL_OK;
    for (size_t i = 0; status == SL_OK && i < count; i++) {
        if (!is_sane(&records[i])) return sl_cache_damaged(path, error);
        status = sl_record_list_append(&l->list, &records[i], floats ? floats + i * wanted : NULL, wanted,
                                       error);
    }
    return status;
}

static sl_status read_cache(sl_cache_content *content, size_t wanted, const char *path, loaded *l,
                            sl_error *error) {
    const class_head *head = sl_cache_next(content, 1, sizeof *head);
    if (!head || head->clamped > head->count || (head->count > 0 && head->coefficients != wanted))
        return sl_cache_damaged(path, error);
    const sl_record *records = sl_cache_next(content, head->count, sizeof *records);
    const float *floats = wanted ? sl_cache_next(content, head->count, wanted * sizeof *floats) : NULL;
    if (!records || (wanted && !floats)) return sl_cache_damaged(path, error);
    l->clamped = head->clamped;
    return append(records, floats, wanted, head->count, path, l, error);
}

static sl_status read_all(sl_cache_content *content, const sl_splat_state *s, const char *path,
                          loaded *classes, sl_error *error) {
    sl_status status = SL_OK;
    for (int c = 0; status == SL_OK && c < SL_RECEIVER_CLASSES; c++)
        status = read_cache(content, sl_splat_coefficients(s, (sl_receiver_class)c), path, &classes[c], error);
    return status == SL_OK && content->at != content->end ? sl_cache_damaged(path, error) : status;
}

sl_status sl_splat_load(void *state, const char *path, sl_error *error) {
    sl_splat_state *s = state;
    sl_cache_setting settings[SETTINGS];
    const sl_cache_header header = header_of(s, settings);
    sl_cache_content content;
    loaded classes[SL_RECEIVER_CLASSES] = {{{0}, 0}};
    sl_status status = sl_cache_file_read(path, &header, &content, error);
    if (status != SL_OK) return status;
    status = read_all(&content, s, path, classes, error);
    sl_free(content.file);
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        if (status != SL_OK) {
            sl_record_list_free(&classes[c].list);
            continue;
        }
        sl_record_list_free(&s->cache[c].list);
        s->cache[c].list = classes[c].list;
        s->cache[c].clamped = classes[c].clamped;
    }
    if (status == SL_OK) s->full = false; /* the others were */
    return status;
}
