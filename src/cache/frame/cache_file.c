#include "cache/frame/cache_file.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/random.h"
#include "image/output_file.h"

enum { FORMAT = 1, MAGIC_BYTES = 8, VERSION_BYTES = 16, SIZE_AT = 28, CHECKSUM_BYTES = 8 };
static const char magic[MAGIC_BYTES + 1] = "SLCACHE\n";

static uint64_t bits_of(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* ---- integers in bytes, the lowest first ---- */

static void store(uint8_t *to, uint64_t value, size_t bytes) {
    for (size_t i = 0; i < bytes; i++) to[i] = (uint8_t)(value >> (8 * i));
}

static uint64_t fetch(const uint8_t *from, size_t bytes) {
    uint64_t value = 0;
    for (size_t i = 0; i < bytes; i++) value |= (uint64_t)from[i] << (8 * i);
    return value;
}

static uint64_t checksum(const uint8_t *bytes, size_t size) {
    uint64_t hash = size;
    for (size_t i = 0; i < size; i += 8)
        hash = sl_hash64(hash ^ fetch(bytes + i, size - i < 8 ? size - i : 8));
    return hash;
}

/* ---- writing ---- */

static uint8_t *room_for(sl_cache_writer *w, size_t bytes) {
    if (w->failed) return NULL;
    if (bytes > w->capacity - w->size) {
        size_t capacity = w->capacity + bytes + w->capacity / 2 + 4096;
        uint8_t *grown = capacity > w->capacity ? sl_allocate(capacity, 1) : NULL;
        if (!grown) {
            w->failed = true;
            return NULL;
        }
        if (w->size) memcpy(grown, w->bytes, w->size);
        sl_free(w->bytes);
        w->bytes = grown;
        w->capacity = capacity;
    }
    uint8_t *room = w->bytes + w->size;
    w->size += bytes;
    return room;
}

static void write_integer(sl_cache_writer *w, uint64_t value, size_t bytes) {
    uint8_t *room = room_for(w, bytes);
    if (room) store(room, value, bytes);
}

void sl_cache_write_u32(sl_cache_writer *writer, uint32_t value) { write_integer(writer, value, 4); }
void sl_cache_write_u64(sl_cache_writer *writer, uint64_t value) { write_integer(writer, value, 8); }

void sl_cache_write_words(sl_cache_writer *writer, const void *words, size_t count) {
    if (count > SIZE_MAX / 4) writer->failed = true;
    uint8_t *room = count && !writer->failed ? room_for(writer, 4 * count) : NULL;
    for (size_t i = 0; room && i < count; i++) {
        uint32_t word;
        memcpy(&word, (const uint8_t *)words + 4 * i, 4);
        store(room + 4 * i, word, 4);
    }
}

void sl_cache_write_start(sl_cache_writer *writer, const sl_cache_header *header) {
    *writer = (sl_cache_writer){0};
    uint8_t *start = room_for(writer, SIZE_AT + 8); /* the size comes at the end */
    if (start) {
        memcpy(start, magic, MAGIC_BYTES);
        store(start + MAGIC_BYTES, FORMAT, 4);
        memcpy(start + MAGIC_BYTES + 4, SL_VERSION,
               sizeof SL_VERSION <= VERSION_BYTES ? sizeof SL_VERSION : (size_t)VERSION_BYTES);
    }
    sl_cache_write_u64(writer, header->scene);
    sl_cache_write_u32(writer, (uint32_t)header->setting_count);
    for (size_t i = 0; i < header->setting_count; i++)
        sl_cache_write_u64(writer, bits_of(header->settings[i].value));
}

sl_status sl_cache_write_end(sl_cache_writer *writer, const char *path, sl_error *error) {
    sl_status status;
    if (!writer->failed) {
        store(writer->bytes + SIZE_AT, writer->size + CHECKSUM_BYTES, 8);
        sl_cache_write_u64(writer, checksum(writer->bytes, writer->size));
    }
    if (writer->failed) status = sl_fail_memory(error, "a cache file");
    else status = sl_output_whole(path, writer->bytes, writer->size, error);
    sl_free(writer->bytes);
    *writer = (sl_cache_writer){0};
    return status;
}

/* ---- reading ---- */

static uint64_t read_integer(sl_cache_reader *r, size_t bytes) {
    if (r->overrun || bytes > r->size - r->at) {
        r->overrun = true;
        return 0;
    }
    r->at += bytes;
    return fetch(r->bytes + r->at - bytes, bytes);
}

uint32_t sl_cache_read_u32(sl_cache_reader *reader) { return (uint32_t)read_integer(reader, 4); }
uint64_t sl_cache_read_u64(sl_cache_reader *reader) { return read_integer(reader, 8); }

void sl_cache_read_words(sl_cache_reader *reader, void *words, size_t count) {
    for (size_t i = 0; i < count; i++) {
        uint32_t word = sl_cache_read_u32(reader);
        memcpy((uint8_t *)words + 4 * i, &word, 4);
    }
}

size_t sl_cache_read_count(sl_cache_reader *reader, size_t bytes_each) {
    uint64_t count = sl_cache_read_u64(reader);
    if (count <= (reader->size - reader->at) / bytes_each) return (size_t)count;
    reader->overrun = true;
    return 0;
}

bool sl_cache_read_complete(const sl_cache_reader *reader) {
    return !reader->overrun && reader->at == reader->size;
}

void sl_cache_read_end(sl_cache_reader *reader) {
    sl_free(reader->bytes);
    *reader = (sl_cache_reader){0};
}

sl_status sl_cache_damaged(const sl_cache_reader *reader, sl_error *error) {
    return sl_fail(error, SL_ERROR_INPUT, "%s: is damaged; make the cache anew", reader->path);
}

static sl_status fail_reading(const char *path, int reason, sl_error *error) {
    return sl_fail(error, SL_ERROR_INPUT, "cannot read %s: %s", path, strerror(reason));
}

static sl_status load_bytes(sl_cache_reader *r, int descriptor, sl_error *error) {
    struct stat status;
    if (fstat(descriptor, &status) != 0) return fail_reading(r->path, errno, error);
    if (!S_ISREG(status.st_mode)) return sl_fail(error, SL_ERROR_INPUT, "%s: is not a file", r->path);
    r->size = (size_t)status.st_size;
    r->bytes = sl_allocate(r->size, 1);
    if (!r->bytes) return sl_fail_memory(error, "a cache file");
    for (size_t got = 0; got < r->size;) {
        ssize_t n = read(descriptor, r->bytes + got, r->size - got);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return fail_reading(r->path, errno, error);
        if (n == 0) r->size = got; /* it has become shorter meanwhile */
        got += (size_t)n;
    }
    return SL_OK;
}

/* Whose file is it, is it whole, and does it say what was written? */
static sl_status check_envelope(sl_cache_reader *r, sl_error *error) {
    if (r->size < MAGIC_BYTES || memcmp(r->bytes, magic, MAGIC_BYTES) != 0)
        return sl_fail(error, SL_ERROR_INPUT, "%s: is not a cache of softlux", r->path);
    if (r->size < SIZE_AT + 8)
        return sl_fail(error, SL_ERROR_INPUT, "%s: is cut short; make the cache anew", r->path);
    char version[VERSION_BYTES + 1] = {0}, ours[VERSION_BYTES + 1] = {0};
    memcpy(version, r->bytes + MAGIC_BYTES + 4, VERSION_BYTES);
    memcpy(ours, SL_VERSION, sizeof SL_VERSION <= VERSION_BYTES ? sizeof SL_VERSION : (size_t)VERSION_BYTES);
    for (char *c = version; *c; c++) {
        if (*c < ' ' || *c > '~') *c = '?';
    }
    uint64_t format = fetch(r->bytes + MAGIC_BYTES, 4);
    if (format != FORMAT || memcmp(version, ours, VERSION_BYTES) != 0)
        return sl_fail(error, SL_ERROR_INPUT,
                       "%s: was written by version %s (format %" PRIu64
                       "), this is %s (format %d); make the cache anew",
                       r->path, version, format, SL_VERSION, FORMAT);
    uint64_t size = fetch(r->bytes + SIZE_AT, 8);
    if (r->size < size)
        return sl_fail(error, SL_ERROR_INPUT, "%s: is cut short; make the cache anew", r->path);
    if (r->size > size || size < SIZE_AT + 8 + CHECKSUM_BYTES) return sl_cache_damaged(r, error);
    r->size -= CHECKSUM_BYTES;
    if (fetch(r->bytes + r->size, CHECKSUM_BYTES) != checksum(r->bytes, r->size))
        return sl_cache_damaged(r, error);
    r->at = SIZE_AT + 8;
    return SL_OK;
}

static sl_status check_origin(sl_cache_reader *r, const sl_cache_header *header, sl_error *error) {
    if (sl_cache_read_u64(r) != header->scene)
        return sl_fail(error, SL_ERROR_INPUT,
                       "%s: was made for another scene (geometry, materials, lights or environment differ)",
                       r->path);
    if (sl_cache_read_u32(r) != header->setting_count) return sl_cache_damaged(r, error);
    for (size_t i = 0; i < header->setting_count; i++) {
        const sl_cache_setting *s = &header->settings[i];
        uint64_t value = sl_cache_read_u64(r);
        if (r->overrun) return sl_cache_damaged(r, error);
        if (value != bits_of(s->value))
            return sl_fail(error, SL_ERROR_INPUT, "%s: was made with another %s", r->path, s->name);
    }
    return SL_OK;
}

sl_status sl_cache_read_start(sl_cache_reader *reader, const char *path, const sl_cache_header *header,
                              sl_error *error) {
    *reader = (sl_cache_reader){.path = path};
    /* does not wait for whoever writes a pipe */
    int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0) return fail_reading(path, errno, error);
    sl_status status = load_bytes(reader, descriptor, error);
    close(descriptor);
    if (status == SL_OK) status = check_envelope(reader, error);
    if (status == SL_OK) status = check_origin(reader, header, error);
    if (status != SL_OK) sl_cache_read_end(reader);
    return status;
}
