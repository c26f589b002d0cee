/* The records of a method on disk, for another run. They depend on geometry, materials, lights and
 * environment, and on the settings below; not on the camera, which may have moved. A picture from the same
 * place then needs no new records and has the same bits.
 *
 *     "SLCACHE2"             8 bytes
 *     library version        24 bytes of text, padded with zeros
 *     size of the file       u64, all of it
 *     scene                  u64, sl_scene_light_hash()
 *     settings               u64 count, then that many doubles
 *     for each class         class_head, records, coefficients
 *     checksum               u64, of all before
 *
 * Numbers are little endian, as those of every machine that softlux runs on. The file appears whole or not at
 * all, and is read whole or not at all. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/splatting/state.h"
#include "image/formats.h"

enum { SETTINGS = 15, CHECKSUM_BYTES = 8 };

typedef struct file_head {
    char magic[8], version[24];
    uint64_t size, scene, setting_count;
} file_head;

/* Begins a class's records. */
typedef struct class_head {
    uint32_t count, clamped, coefficients;
} class_head;

static file_head head_of(uint64_t scene, size_t size) {
    file_head head = {.size = size, .scene = scene, .setting_count = SETTINGS};
    _Static_assert(sizeof SL_VERSION <= sizeof head.version, "a version has less than 24 bytes");
    memcpy(head.magic, "SLCACHE2", sizeof head.magic);
    memcpy(head.version, SL_VERSION, sizeof SL_VERSION);
    return head;
}

/* A setting that decides what is in a cache, as messages call it. */
typedef struct setting {
    const char *name;
    double value;
} setting;

static void list_settings(const sl_splat_state *s, setting to[SETTINGS]) {
    const sl_settings *g = &s->settings;
    const setting all[SETTINGS] = {
        {"quality", g->quality},
        {"accuracy", g->accuracy},
        {"glossy accuracy", g->glossy_accuracy},
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
    memcpy(to, all, sizeof all);
}

static uint64_t checksum(const uint8_t *bytes, size_t size) { return sl_hash_bytes(size, bytes, size); }

/* ---- save ---- */

/* Returns where the next part goes. */
static size_t put(uint8_t *to, size_t at, const void *data, size_t bytes) {
    if (to && bytes) memcpy(to + at, data, bytes);
    return at + bytes;
}

/* Puts all but the checksum, and returns how many bytes that is; to: NULL, they are counted alone. */
static size_t put_all(const sl_splat_state *s, uint64_t scene, uint8_t *to, size_t size) {
    const file_head head = head_of(scene, size);
    setting settings[SETTINGS];
    list_settings(s, settings);
    size_t at = put(to, 0, &head, sizeof head);
    for (int i = 0; i < SETTINGS; i++) at = put(to, at, &settings[i].value, sizeof(double));
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        const sl_record_list *list = &s->cache[c].list;
        const size_t floats = list->coefficients ? sl_splat_coefficients(s, (sl_receiver_class)c) : 0;
        const class_head class = {(uint32_t)list->count, (uint32_t)s->cache[c].clamped, (uint32_t)floats};
        at = put(to, at, &class, sizeof class);
        at = put(to, at, list->records, list->count * sizeof *list->records);
        at = put(to, at, list->coefficients, list->count * floats * sizeof(float));
    }
    return at;
}

sl_status sl_splat_save(const void *state, const char *path, sl_error *error) {
    const sl_splat_state *s = state;
    const uint64_t scene = sl_scene_light_hash(s->scene);
    const size_t end = put_all(s, scene, NULL, 0), size = end + CHECKSUM_BYTES;
    uint8_t *bytes = sl_allocate_unset(size, 1);
    if (!bytes) return sl_fail_memory(error, "a cache file");
    put_all(s, scene, bytes, size);
    const uint64_t sum = checksum(bytes, end);
    put(bytes, end, &sum, sizeof sum);
    const sl_status status = sl_output_whole(path, bytes, size, error);
    sl_free(bytes);
    return status;
}

/* ---- load ---- */

/* What is left of a file's content. */
typedef struct unread {
    const char *path;
    const uint8_t *at, *end;
} unread;

/* Returns the next `count` things of `size` bytes; NULL: there are not so many. */
static const void *next(unread *c, size_t count, size_t size) {
    if (count > (size_t)(c->end - c->at) / size) return NULL;
    c->at += count * size;
    return c->at - count * size;
}

static sl_status fail_damaged(const char *path, sl_error *error) {
    return sl_fail(error, SL_ERROR_INPUT, "%s: is damaged; make the cache anew", path);
}

/* Tells whose file it is, if it is whole, and if it says what was written. */
static sl_status check_envelope(const sl_bytes *file, file_head *head, sl_error *error) {
    const file_head ours = head_of(0, 0);
    *head = ours;
    memcpy(head, file->data, file->size < sizeof *head ? file->size : sizeof *head);
    if (file->size < sizeof head->magic || memcmp(head->magic, ours.magic, sizeof head->magic) != 0)
        return sl_fail(error, SL_ERROR_INPUT, "%s: is not a cache of softlux", file->path);
    if (memcmp(head->version, ours.version, sizeof head->version) != 0)
        return sl_fail(error, SL_ERROR_INPUT,
                       "%s: was written by another version than %s; make the cache anew", file->path,
                       SL_VERSION);
    if (file->size < sizeof *head + CHECKSUM_BYTES || file->size < head->size)
        return sl_fail(error, SL_ERROR_INPUT, "%s: is cut short; make the cache anew", file->path);
    uint64_t sum;
    memcpy(&sum, file->data + file->size - CHECKSUM_BYTES, sizeof sum);
    if (file->size > head->size || sum != checksum(file->data, file->size - CHECKSUM_BYTES))
        return fail_damaged(file->path, error);
    return SL_OK;
}

static sl_status check_origin(const sl_splat_state *s, const file_head *head, unread *content,
                              sl_error *error) {
    setting settings[SETTINGS];
    list_settings(s, settings);
    if (head->scene != sl_scene_light_hash(s->scene))
        return sl_fail(error, SL_ERROR_INPUT,
                       "%s: was made for another scene (geometry, materials, lights or environment differ)",
                       content->path);
    if (head->setting_count != SETTINGS) return fail_damaged(content->path, error);
    for (int i = 0; i < SETTINGS; i++) {
        const void *value = next(content, 1, sizeof(double));
        if (!value) return fail_damaged(content->path, error);
        if (memcmp(value, &settings[i].value, sizeof(double)) != 0)
            return sl_fail(error, SL_ERROR_INPUT, "%s: was made with another %s", content->path,
                           settings[i].name);
    }
    return SL_OK;
}

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
        if (!is_sane(&records[i])) return fail_damaged(path, error);
        status = sl_record_list_append(&l->list, &records[i], floats ? floats + i * wanted : NULL, wanted,
                                       error);
    }
    return status;
}

static sl_status read_class(unread *content, size_t wanted, loaded *l, sl_error *error) {
    const class_head *head = next(content, 1, sizeof *head);
    if (!head || head->clamped > head->count || (head->count > 0 && head->coefficients != wanted))
        return fail_damaged(content->path, error);
    const sl_record *records = next(content, head->count, sizeof *records);
    const float *floats = wanted ? next(content, head->count, wanted * sizeof *floats) : NULL;
    if (!records || (wanted && !floats)) return fail_damaged(content->path, error);
    l->clamped = head->clamped;
    return append(records, floats, wanted, head->count, content->path, l, error);
}

static sl_status read_all(const sl_splat_state *s, const sl_bytes *file, loaded *classes, sl_error *error) {
    file_head head;
    sl_status status = check_envelope(file, &head, error);
    if (status != SL_OK) return status;
    unread content = {file->path, file->data + sizeof head, file->data + file->size - CHECKSUM_BYTES};
    status = check_origin(s, &head, &content, error);
    for (int c = 0; status == SL_OK && c < SL_RECEIVER_CLASSES; c++)
        status = read_class(&content, sl_splat_coefficients(s, (sl_receiver_class)c), &classes[c], error);
    return status == SL_OK && content.at != content.end ? fail_damaged(file->path, error) : status;
}

sl_status sl_splat_load(void *state, const char *path, sl_error *error) {
    sl_splat_state *s = state;
    sl_bytes file;
    loaded classes[SL_RECEIVER_CLASSES] = {{{0}, 0}};
    sl_status status = sl_bytes_read(path, SIZE_MAX - 1, &file, error);
    if (status != SL_OK) return status;
    status = read_all(s, &file, classes, error);
    sl_free(file.data);
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
