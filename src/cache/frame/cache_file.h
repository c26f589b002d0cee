/* A cache on disk:
 *
 *     "SLCACHE2"             8 bytes
 *     library version        24 bytes of text, padded with zeros
 *     size of the file       u64, all of it
 *     scene                  u64, sl_scene_light_hash()
 *     settings               u64 count, then that many doubles
 *     what the method writes
 *     checksum               u64, of all before
 *
 * Numbers are little endian, as those of every machine that softlux runs on. It appears whole or not at all,
 * and is read whole or not at all. */
#pragma once

#include "softlux.h"

/* A setting that decides what is in a cache. */
typedef struct sl_cache_setting {
    const char *name; /* as the program calls it, for messages */
    double value;
} sl_cache_setting;

typedef struct sl_cache_header {
    uint64_t scene;
    size_t setting_count;
    const sl_cache_setting *settings;
} sl_cache_header;

/* Numbers of 32 bits, or structs of such. */
typedef struct sl_cache_part {
    const void *data;
    size_t bytes;
} sl_cache_part;

sl_status sl_cache_file_write(const char *path, const sl_cache_header *header, const sl_cache_part *parts,
                              size_t part_count, sl_error *error);

/* Points to the method's own part, from `at` on. */
typedef struct sl_cache_content {
    uint8_t *file;
    size_t at, end;
} sl_cache_content;

/* Reads the file and checks everything that does not depend on the method. On failure nothing is to be freed,
 * else content->file by sl_free(). */
sl_status sl_cache_file_read(const char *path, const sl_cache_header *header, sl_cache_content *content,
                             sl_error *error);
/* Returns the next `count` things of `size` bytes; NULL: there are not so many. */
const void *sl_cache_next(sl_cache_content *content, size_t count, size_t size);
/* "PATH: is damaged ...": its content is nonsense, whatever the checksum says. */
sl_status sl_cache_damaged(const char *path, sl_error *error);
