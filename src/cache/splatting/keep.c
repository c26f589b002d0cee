/* The records of a method on disk, for another run. They depend on geometry, materials, lights and
 * environment, and on the settings below; not on the camera, which may have moved. A picture from the same
 * place then needs no new records and has the same bits. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "cache/frame/cache_file.h"
#include "cache/splatting/state.h"

/* Records are written word by word. */
_Static_assert(sizeof(sl_record) % 4 == 0, "a record consists of 32-bit words");
enum { RECORD_WORDS = sizeof(sl_record) / 4, SETTINGS = 15 };

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

static void write_cache(sl_cache_writer *w, const sl_splat_state *s, sl_receiver_class class) {
    const sl_record_cache *cache = &s->cache[class];
    size_t count = cache->list.count,
           coefficients = cache->list.coefficients ? sl_splat_coefficients(s, class) : 0;
    sl_cache_write_u64(w, coefficients);
    sl_cache_write_u64(w, cache->clamped);
    sl_cache_write_u64(w, count);
    for (size_t i = 0; i < count; i++) {
        sl_cache_write_words(w, &cache->list.records[i], RECORD_WORDS);
        if (coefficients) sl_cache_write_words(w, cache->list.coefficients + i * coefficients, coefficients);
    }
}

sl_status sl_splat_save(const void *state, const char *path, sl_error *error) {
    const sl_splat_state *s = state;
    sl_cache_setting settings[SETTINGS];
    sl_cache_header header = header_of(s, settings);
    sl_cache_writer writer;
    sl_cache_write_start(&writer, &header);
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) write_cache(&writer, s, (sl_receiver_class)c);
    return sl_cache_write_end(&writer, path, error);
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

static sl_status read_cache(sl_cache_reader *r, const sl_splat_state *s, sl_receiver_class class, loaded *l,
                            sl_error *error) {
    size_t wanted = sl_splat_coefficients(s, class);
    uint64_t floats = sl_cache_read_u64(r), clamped = sl_cache_read_u64(r);
    size_t count = sl_cache_read_count(r, 4 * (RECORD_WORDS + wanted));
    if (r->overrun || clamped > count || (count > 0 && floats != wanted)) return sl_cache_damaged(r, error);
    float *coefficients = wanted && count ? sl_allocate(wanted, sizeof *coefficients) : NULL;
    sl_status status =
        coefficients || !wanted || !count ? SL_OK : sl_fail_memory(error, "the records of a cache file");
    for (size_t i = 0; status == SL_OK && i < count; i++) {
        sl_record record;
        sl_cache_read_words(r, &record, RECORD_WORDS);
        if (wanted) sl_cache_read_words(r, coefficients, wanted);
        if (r->overrun || !is_sane(&record)) status = sl_cache_damaged(r, error);
        else status = sl_record_list_append(&l->list, &record, coefficients, wanted, error);
    }
    sl_free(coefficients);
    l->clamped = (size_t)clamped;
    return status;
}

static sl_status read_all(sl_cache_reader *r, const sl_splat_state *s, loaded *classes, sl_error *error) {
    sl_status status = SL_OK;
    for (int c = 0; status == SL_OK && c < SL_RECEIVER_CLASSES; c++)
        status = read_cache(r, s, (sl_receiver_class)c, &classes[c], error);
    if (status == SL_OK && !sl_cache_read_complete(r)) status = sl_cache_damaged(r, error);
    return status;
}

sl_status sl_splat_load(void *state, const char *path, sl_error *error) {
    sl_splat_state *s = state;
    sl_cache_setting settings[SETTINGS];
    sl_cache_header header = header_of(s, settings);
    sl_cache_reader reader;
    loaded classes[SL_RECEIVER_CLASSES] = {{{0}, 0}};
    if (!s->raster)
        return sl_fail(error, SL_ERROR_RESOURCES, "an earlier edit of the scene failed; edit it again");
    sl_status status = sl_cache_read_start(&reader, path, &header, error);
    if (status != SL_OK) return status;
    status = read_all(&reader, s, classes, error);
    sl_cache_read_end(&reader);
    if (status != SL_OK) {
        for (int c = 0; c < SL_RECEIVER_CLASSES; c++) sl_record_list_free(&classes[c].list);
        return status;
    }
    s->full = false; /* the others were */
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        sl_record_list_free(&s->cache[c].list);
        s->cache[c].list = classes[c].list;
        s->cache[c].clamped = classes[c].clamped;
    }
    return SL_OK;
}
