#include "cache/frame/cache_file.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/random.h"
#include "image/formats.h"

typedef struct file_head {
    char magic[8], version[24];
    uint64_t size, scene, setting_count;
} file_head;

enum { CHECKSUM_BYTES = 8 };

static file_head head_of(const sl_cache_header *header, size_t size) {
    file_head head = {.size = size, .scene = header->scene, .setting_count = header->setting_count};
    _Static_assert(sizeof SL_VERSION <= sizeof head.version, "a version has less than 24 bytes");
    memcpy(head.magic, "SLCACHE2", sizeof head.magic);
    memcpy(head.version, SL_VERSION, sizeof SL_VERSION);
    return head;
}

static uint64_t checksum(const uint8_t *bytes, size_t size) { return sl_hash_bytes(size, bytes, size); }

/* ---- writing ---- */

/* Returns where the next part goes. */
static uint8_t *put(uint8_t *to, const void *data, size_t bytes) {
    if (bytes) memcpy(to, data, bytes);
    return to + bytes;
}

sl_status sl_cache_file_write(const char *path, const sl_cache_header *header, const sl_cache_part *parts,
                              size_t part_count, sl_error *error) {
    size_t size = sizeof(file_head) + header->setting_count * sizeof(double) + CHECKSUM_BYTES;
    for (size_t i = 0; i < part_count; i++) size += parts[i].bytes;
    uint8_t *bytes = sl_allocate_unset(size, 1), *at = bytes;
    if (!bytes) return sl_fail_memory(error, "a cache file");
    const file_head head = head_of(header, size);
    at = put(at, &head, sizeof head);
    for (size_t i = 0; i < header->setting_count; i++)
        at = put(at, &header->settings[i].value, sizeof(double));
    for (size_t i = 0; i < part_count; i++) at = put(at, parts[i].data, parts[i].bytes);
    const uint64_t sum = checksum(bytes, size - CHECKSUM_BYTES);
    put(at, &sum, sizeof sum);
    const sl_status status = sl_output_whole(path, bytes, size, error);
    sl_free(bytes);
    return status;
}

/* ---- reading ---- */

const void *sl_cache_next(sl_cache_content *c, size_t count, size_t size) {
    if (count > (c->end - c->at) / size) return NULL;
    c->at += count * size;
    return c->file + c->at - count * size;
}

sl_status sl_cache_damaged(const char *path, sl_error *error) {
    return sl_fail(error, SL_ERROR_INPUT, "%s: is damaged; make the cache anew", path);
}

/* Tells whose file it is, if it is whole, and if it says what was written. */
static sl_status check_envelope(const sl_bytes *file, file_head *head, sl_error *error) {
    const file_head ours = head_of(&(sl_cache_header){0}, 0);
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
        return sl_cache_damaged(file->path, error);
    return SL_OK;
}

static sl_status check_origin(const char *path, const file_head *head, const sl_cache_header *header,
                              sl_cache_content *content, sl_error *error) {
    if (head->scene != header->scene)
        return sl_fail(error, SL_ERROR_INPUT,
                       "%s: was made for another scene (geometry, materials, lights or environment differ)",
                       path);
    if (head->setting_count != header->setting_count) return sl_cache_damaged(path, error);
    for (size_t i = 0; i < header->setting_count; i++) {
        const void *value = sl_cache_next(content, 1, sizeof(double));
        if (!value) return sl_cache_damaged(path, error);
        if (memcmp(value, &header->settings[i].value, sizeof(double)) != 0)
            return sl_fail(error, SL_ERROR_INPUT, "%s: was made with another %s", path,
                           header->settings[i].name);
    }
    return SL_OK;
}

sl_status sl_cache_file_read(const char *path, const sl_cache_header *header, sl_cache_content *content,
                             sl_error *error) {
    sl_bytes file;
    file_head head;
    sl_status status = sl_bytes_read(path, SIZE_MAX - 1, &file, error);
    if (status != SL_OK) return status;
    status = check_envelope(&file, &head, error);
    *content = (sl_cache_content){file.data, sizeof head, file.size - CHECKSUM_BYTES};
    if (status == SL_OK) status = check_origin(path, &head, header, content, error);
    if (status != SL_OK) sl_free(file.data);
    return status;
}
