/* Second-level records on disk. */
#include "cache/bounces/second_level.h"

#include "base/memory.h"

_Static_assert(sizeof(sl_record) % 4 == 0 && sizeof(sl_second_walls) % 4 == 0,
               "records consist of 32-bit words");
enum {
    RECORD_WORDS = sizeof(sl_record) / 4,
    WALL_WORDS = sizeof(sl_second_walls) / 4,
    POINT_WORDS = 10, /* and the key */
    BYTES_EACH = 4 * (RECORD_WORDS + WALL_WORDS + POINT_WORDS) + 8
};

static void write_point(sl_cache_writer *w, const sl_gather_point *p) {
    sl_cache_write_words(w, &p->position, 3);
    sl_cache_write_words(w, &p->geometric_normal, 3);
    sl_cache_write_words(w, &p->normal, 3);
    sl_cache_write_u32(w, p->triangle);
    sl_cache_write_u64(w, p->key);
}

static void read_point(sl_cache_reader *r, sl_gather_point *p) {
    sl_cache_read_words(r, &p->position, 3);
    sl_cache_read_words(r, &p->geometric_normal, 3);
    sl_cache_read_words(r, &p->normal, 3);
    p->triangle = sl_cache_read_u32(r);
    p->key = sl_cache_read_u64(r);
}

void sl_second_cache_write(const sl_second_cache *cache, sl_cache_writer *writer) {
    const sl_second_list *list = &cache->list;
    const sl_second_report *report = &cache->report;
    sl_cache_write_u32(writer, report->bounces);
    sl_cache_write_u32(writer, report->converged);
    sl_cache_write_words(writer, &report->change, 1);
    sl_cache_write_words(writer, &report->missed, 1);
    sl_cache_write_u64(writer, list->count);
    for (size_t i = 0; i < list->count; i++) {
        sl_cache_write_words(writer, &list->records[i], RECORD_WORDS);
        sl_cache_write_words(writer, &list->walls[i], WALL_WORDS);
        write_point(writer, &list->points[i]);
    }
}

static bool is_sane(const sl_record *r, const sl_gather_point *p) {
    return sl_is_finite(r->position) && sl_is_finite(r->normal) && isfinite(r->radius) && r->radius > 0.0f &&
           sl_rgb_is_finite(r->irradiance) && sl_is_finite(p->position) && sl_is_finite(p->normal) &&
           sl_is_finite(p->geometric_normal);
}

static sl_status read_records(sl_cache_reader *r, sl_second_cache *cache, sl_error *error) {
    sl_second_list *list = &cache->list;
    const float a = (float)cache->settings.accuracy;
    const sl_weight_rules rules = {a, 1.0f / a, 1e-5f * cache->scene->scale};
    size_t count = sl_cache_read_count(r, BYTES_EACH);
    sl_status status = sl_second_list_reserve(list, count, error);
    for (size_t i = 0; status == SL_OK && i < count; i++) {
        sl_cache_read_words(r, &list->records[i], RECORD_WORDS);
        sl_cache_read_words(r, &list->walls[i], WALL_WORDS);
        read_point(r, &list->points[i]);
        if (r->overrun || !is_sane(&list->records[i], &list->points[i])) return sl_cache_damaged(r, error);
        list->terms[i] = sl_record_terms_of(&list->records[i], &rules);
        list->count = i + 1;
    }
    if (status == SL_OK && r->overrun) status = sl_cache_damaged(r, error);
    return status;
}

sl_status sl_second_cache_read(const sl_scene *scene, const sl_tracer *tracer,
                               const sl_second_settings *settings, sl_cache_reader *reader,
                               sl_second_cache **out, sl_error *error) {
    sl_second_cache *cache;
    *out = NULL;
    sl_status status = sl_second_cache_blank(scene, tracer, settings, &cache, error);
    if (status != SL_OK) return status;
    cache->report.bounces = sl_cache_read_u32(reader);
    cache->report.converged = sl_cache_read_u32(reader) != 0;
    sl_cache_read_words(reader, &cache->report.change, 1);
    sl_cache_read_words(reader, &cache->report.missed, 1);
    status = read_records(reader, cache, error);
    if (status == SL_OK) status = sl_second_cache_shine(cache, error);
    if (status == SL_OK) *out = cache;
    else sl_second_cache_destroy(cache);
    return status;
}
