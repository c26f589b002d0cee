/* What batches have brought, one record behind the other: a call that ended early is gone through again by
 * the next one, which takes from here what it would compute. */
#include "mpi/journal.h"

#include <errno.h>
#include <mpi.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "base/random.h"
#include "base/ranks.h"
#include "mpi/end.h"

static const char magic[8] = "sl-jour1";

/* Before the items of all planes. */
typedef struct record {
    uint64_t count, bytes; /* of the batch: items, bytes of one */
    uint64_t sum;          /* of what follows */
    sl_counters counted;
} record;

static struct {
    const char *path; /* NULL: none is kept */
    FILE *file;       /* the first rank's; NULL: it is no longer written */
    long end;         /* of the records that are to be recalled */
    bool recalls;
} journal;

void sl_ranks_journal_name(const char *path) { journal.path = path; }

bool sl_ranks_journal_is_kept(void) { return journal.path; }

static bool is_first(void) { return sl_ranks_here().rank == 0; }

/* ---- the file ---- */

static bool has_begin(FILE *file, uint64_t key) {
    char begin[sizeof magic];
    uint64_t own;
    return fread(begin, sizeof begin, 1, file) == 1 && memcmp(begin, magic, sizeof magic) == 0 &&
           fread(&own, sizeof own, 1, file) == 1 && own == key;
}

static bool put_begin(FILE *file, uint64_t key) {
    return fwrite(magic, sizeof magic, 1, file) == 1 && fwrite(&key, sizeof key, 1, file) == 1 &&
           fflush(file) == 0;
}

/* Returns how many whole records there are but for the last: the call that wrote it may have failed of what
 * it tells. journal.end: where that one begins. */
static unsigned long long find_end(FILE *file, long size) {
    unsigned long long count = 0;
    record r;
    journal.end = ftell(file);
    for (long next = journal.end; fseek(file, next, SEEK_SET) == 0 && fread(&r, sizeof r, 1, file) == 1;
         count++) {
        const long at = next, rest = size - at - (long)sizeof r;
        if (r.bytes && r.count > (uint64_t)rest / r.bytes) break;
        journal.end = at;
        next = at + (long)sizeof r + (long)(r.count * r.bytes);
    }
    return count ? count - 1 : 0;
}

static const char *go_on(FILE *file, uint64_t key, long size) {
    if (!has_begin(file, key)) return "the journal is of another scene or other options";
    const long begin = ftell(file);
    const unsigned long long records = find_end(file, size);
    if (ftruncate(fileno(file), journal.end) != 0) return "the journal cannot be written";
    fseek(file, begin, SEEK_SET);
    if (records)
        fprintf(stderr, "softlux-mpi: goes on from %s: %llu batches are there\n", journal.path, records);
    return NULL;
}

const char *sl_ranks_journal_open(uint64_t key) {
    if (!journal.path) return NULL;
    journal.recalls = true; /* until the first rank tells that there is nothing more */
    if (!is_first()) return NULL;
    FILE *file = journal.file = fopen(journal.path, "a+b");
    if (file) file = journal.file = freopen(journal.path, "r+b", file);
    if (!file) return "the journal cannot be written";
    if (flock(fileno(file), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return "another call writes the journal";
    fseek(file, 0, SEEK_END);
    const long size = ftell(file);
    rewind(file);
    if (size) return go_on(file, key, size);
    journal.end = 0;
    return put_begin(file, key) ? NULL : "the journal cannot be written";
}

void sl_ranks_journal_remove(void) {
    if (journal.file && is_first()) remove(journal.path);
}

/* ---- records ---- */

static uint64_t sum_of(uint64_t sum, const char *bytes, size_t count) {
    uint64_t word = 0;
    for (; count >= sizeof word; bytes += sizeof word, count -= sizeof word) {
        memcpy(&word, bytes, sizeof word);
        sum = (sum ^ word) * 0xd1342543de82ef95u;
        sum ^= sum >> 32;
    }
    word = 0;
    memcpy(&word, bytes, count);
    return sl_hash64(sum ^ word);
}

static uint64_t sum_of_planes(const sl_batch_plane *planes, unsigned plane_count, size_t count) {
    uint64_t sum = count;
    for (unsigned k = 0; k < plane_count; k++)
        if (planes[k].bytes) sum = sum_of(sum, planes[k].items, count * planes[k].bytes);
    return sum;
}

static size_t bytes_of(const sl_batch_plane *planes, unsigned plane_count) {
    size_t bytes = 0;
    for (unsigned k = 0; k < plane_count; k++) bytes += planes[k].bytes;
    return bytes;
}

/* Reads the next record. False: there is none; what is written from here on takes its place. */
static bool read_record(const sl_batch_plane *planes, unsigned plane_count, size_t count, record *r) {
    FILE *file = journal.file;
    const long at = ftell(file);
    bool there = at < journal.end && fread(r, sizeof *r, 1, file) == 1 && r->count == count &&
                 r->bytes == bytes_of(planes, plane_count);
    for (unsigned k = 0; there && k < plane_count; k++)
        there = !planes[k].bytes || fread(planes[k].items, planes[k].bytes, count, file) == count;
    there = there && r->sum == sum_of_planes(planes, plane_count, count);
    if (there) return true;
    fseek(file, at, SEEK_SET);
    if (ftruncate(fileno(file), at) != 0) sl_ranks_end(0, "cannot write the journal");
    return false;
}

bool sl_ranks_recall(const sl_batch_plane *planes, unsigned plane_count, size_t count, sl_counters *counted) {
    record r = {0};
    if (!journal.recalls) return false;
    int there = is_first() && read_record(planes, plane_count, count, &r);
    MPI_Bcast(&there, 1, MPI_INT, 0, MPI_COMM_WORLD);
    journal.recalls = there;
    if (!there) return false;
    sl_ranks_tell(0, &r, sizeof r);
    for (unsigned k = 0; k < plane_count; k++) sl_ranks_tell(0, planes[k].items, count * planes[k].bytes);
    *counted = r.counted;
    return true;
}

static bool write_record(FILE *file, const sl_batch_plane *planes, unsigned plane_count, size_t count,
                         const sl_counters *counted) {
    const record r = {count, bytes_of(planes, plane_count), sum_of_planes(planes, plane_count, count),
                      *counted};
    bool written = fwrite(&r, sizeof r, 1, file) == 1;
    for (unsigned k = 0; written && k < plane_count; k++)
        written = !planes[k].bytes || fwrite(planes[k].items, planes[k].bytes, count, file) == count;
    return written && fflush(file) == 0;
}

void sl_ranks_journal_note(const sl_batch_plane *planes, unsigned plane_count, size_t count,
                             const sl_counters *counted) {
    if (!journal.file || !is_first()) return;
    if (write_record(journal.file, planes, plane_count, count, counted)) return;
    fprintf(stderr, "softlux-mpi: cannot write %s: what is done from here on is not kept\n", journal.path);
    fclose(journal.file);
    journal.file = NULL;
}
