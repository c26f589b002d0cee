/* A cache on disk. The file is little endian whatever the machine:
 *
 *     "SLCACHE\n"            8 bytes
 *     format                 u32
 *     library version        16 bytes of text, padded with zeros
 *     size of the file       u64, all of it
 *     scene                  u64, sl_scene_light_hash()
 *     settings               u32 count, then that many u64 (floating-point numbers as their bits)
 *     what the method writes
 *     checksum               u64, of all before
 *
 * It appears whole or not at all, and is read whole or not at all. */
#ifndef SL_FRAME_CACHE_FILE_H
#define SL_FRAME_CACHE_FILE_H

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

/* ---- writing: into memory, then to the disk at once ---- */

typedef struct sl_cache_writer {
    uint8_t *bytes;
    size_t size, capacity;
    bool failed; /* out of memory: everything after that is dropped, and sl_cache_write_end() says so */
} sl_cache_writer;

void sl_cache_write_start(sl_cache_writer *writer, const sl_cache_header *header);
void sl_cache_write_u32(sl_cache_writer *writer, uint32_t value);
void sl_cache_write_u64(sl_cache_writer *writer, uint64_t value);
/* Floats, or integers of 32 bits, or a struct of such. */
void sl_cache_write_words(sl_cache_writer *writer, const void *words, size_t count);
sl_status sl_cache_write_end(sl_cache_writer *writer, const char *path, sl_error *error);

/* ---- reading ---- */

typedef struct sl_cache_reader {
    const char *path;
    uint8_t *bytes;
    size_t size, at;
    bool overrun; /* more was read than there is: the content is nonsense, whatever the checksum says */
} sl_cache_reader;

/* Reads the file and checks everything that does not depend on the method. On failure nothing is to be freed.
 */
sl_status sl_cache_read_start(sl_cache_reader *reader, const char *path, const sl_cache_header *header,
                              sl_error *error);
/* 0 past the end. */
uint32_t sl_cache_read_u32(sl_cache_reader *reader);
uint64_t sl_cache_read_u64(sl_cache_reader *reader);
void sl_cache_read_words(sl_cache_reader *reader, void *words, size_t count);
/* A number of things of at least `bytes_each` bytes; 0, and overrun, where the file is too short to hold
 * them. */
size_t sl_cache_read_count(sl_cache_reader *reader, size_t bytes_each);
/* Has everything been read, and no more? */
bool sl_cache_read_complete(const sl_cache_reader *reader);
void sl_cache_read_end(sl_cache_reader *reader);
/* "PATH: is damaged ..." */
sl_status sl_cache_damaged(const sl_cache_reader *reader, sl_error *error);

#endif
