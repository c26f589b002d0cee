#include "app/bench/journal.h"

#include "app/bench/child.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/random.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct sl_journal {
    char *path;
    size_t count, room;
    cJSON **entries;
    bool torn; /* the file does not end with a line's end */
};

static sl_status fail(sl_error *error, const char *path, const char *what) {
    return sl_fail(error, sl_status_of_errno(errno, SL_ERROR_OUTPUT), "cannot %s %s: %s", what, path,
                   strerror(errno));
}

static bool keep(sl_journal *j, cJSON *entry) {
    if (!sl_make_room(&j->entries, j->count, &j->room, sizeof *j->entries)) return false;
    j->entries[j->count++] = entry;
    return true;
}

static bool read_entries(sl_journal *j, FILE *in) {
    char *line = NULL;
    size_t size = 0;
    bool kept = true;
    for (ssize_t length; kept && (length = getline(&line, &size, in)) > 0;) {
        j->torn = line[length - 1] != '\n';
        cJSON *entry = j->torn ? NULL : cJSON_Parse(line);
        if (!cJSON_IsString(cJSON_GetObjectItem(entry, "key"))) cJSON_Delete(entry);
        else if (!keep(j, entry)) kept = (cJSON_Delete(entry), false);
    }
    free(line);
    return kept;
}

sl_status sl_journal_open(const char *path, sl_journal **journal, sl_error *error) {
    sl_journal *j = calloc(1, sizeof *j);
    *journal = NULL;
    if (!j || !(j->path = strdup(path))) {
        free(j);
        return fail(error, path, "read");
    }
    FILE *in = fopen(path, "r");
    bool kept = !in ? errno == ENOENT : read_entries(j, in);
    sl_status status = kept ? SL_OK : fail(error, path, "read");
    if (in) fclose(in);
    if (kept) *journal = j;
    else sl_journal_close(j);
    return status;
}

void sl_journal_close(sl_journal *j) {
    if (!j) return;
    for (size_t i = 0; i < j->count; i++) cJSON_Delete(j->entries[i]);
    sl_free(j->entries);
    free(j->path);
    free(j);
}

const cJSON *sl_journal_find(const sl_journal *j, const char *key) {
    for (size_t i = j->count; i-- > 0;) {
        if (strcmp(cJSON_GetObjectItem(j->entries[i], "key")->valuestring, key) == 0) return j->entries[i];
    }
    return NULL;
}

const cJSON *sl_journal_at(const sl_journal *j, size_t index) {
    return index < j->count ? j->entries[index] : NULL;
}

/* Appends a line in one write, so that two programs cannot mix theirs; where that fails the line is torn, and
 * the next begins anew. */
static bool append(sl_journal *j, const char *text) {
    char *line = malloc(strlen(text) + 3);
    int file = open(j->path, O_WRONLY | O_APPEND | O_CREAT, 0666), reason = errno;
    bool well = line && file >= 0;
    if (well) {
        sprintf(line, "%s%s\n", j->torn ? "\n" : "", text);
        well = sl_write_all(file, line, strlen(line));
        reason = errno;
        j->torn = !well;
    }
    if (file >= 0 && close(file) != 0 && well) well = false, reason = errno;
    free(line);
    errno = reason;
    return well;
}

sl_status sl_journal_add(sl_journal *j, cJSON *entry, sl_error *error) {
    char *text = cJSON_PrintUnformatted(entry);
    bool well = text && append(j, text);
    cJSON_free(text);
    if (well && keep(j, entry)) return SL_OK;
    cJSON_Delete(entry);
    return fail(error, j->path, "write");
}

void sl_program_fingerprint(char text[17]) {
    uint64_t hash = 0;
    FILE *in = fopen("/proc/self/exe", "rb");
    unsigned char bytes[16384];
    for (size_t n; in && (n = fread(bytes, 1, sizeof bytes, in)) > 0;)
        hash = sl_hash_bytes(hash, bytes, n);
    if (in) fclose(in);
    snprintf(text, 17, "%016" PRIx64, hash);
}
