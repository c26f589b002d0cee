#define _XOPEN_SOURCE 700 /* nftw(), mkdtemp() */
#include "app/files_of_ranks.h"

#include "base/error.h"
#include "base/ranks.h"

#include <errno.h>
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

sl_status sl_own_folder(char folder[SL_RANKS_FOLDER], sl_error *error) {
    const char *place = getenv("TMPDIR");
    if (!place || !*place) place = "/tmp";
    const int used = snprintf(folder, SL_RANKS_FOLDER, "%s/softlux-XXXXXX", place);
    if (used < SL_RANKS_FOLDER && mkdtemp(folder)) return SL_OK;
    return sl_fail(error, SL_ERROR_OUTPUT, "cannot make a folder in %.400s: %s", place, strerror(errno));
}

static int remove_it(const char *path, const struct stat *about, int kind, struct FTW *where) {
    (void)about, (void)kind, (void)where;
    return remove(path);
}

void sl_own_folder_remove(const char *folder) { nftw(folder, remove_it, 16, FTW_DEPTH | FTW_PHYS); }

static sl_status fail(const char *what, const char *path, sl_error *error) {
    return sl_fail(error, SL_ERROR_OUTPUT, "cannot %s %.900s, which ranks share: %s", what, path,
                   strerror(errno));
}

/* Returns 0 where a file cannot be read to its end. */
static uint64_t size_of(FILE *file) {
    const bool there = file && fseek(file, 0, SEEK_END) == 0;
    const long size = there ? ftell(file) : 0;
    if (there) rewind(file);
    return size > 0 ? (uint64_t)size : 0;
}

static bool share_bytes(unsigned giver, FILE *file, uint64_t size) {
    enum { PIECE = 1 << 20 };
    const bool gives = sl_ranks_here().rank == giver;
    bool well = true;
    char *bytes = malloc(PIECE);
    for (uint64_t at = 0; bytes && well && at < size; at += PIECE) {
        const size_t some = size - at < PIECE ? (size_t)(size - at) : PIECE;
        if (gives) well = fread(bytes, 1, some, file) == some;
        if (well) sl_ranks_tell(giver, bytes, some);
        if (!gives && file) well = fwrite(bytes, 1, some, file) == some;
    }
    free(bytes);
    return bytes && well;
}

sl_status sl_share_file(unsigned giver, const char *from, const char *to, sl_error *error) {
    const bool gives = sl_ranks_here().rank == giver;
    const char *path = gives ? from : to, *what = gives ? "read" : "write";
    FILE *file = path ? fopen(path, gives ? "rb" : "wb") : NULL;
    if (path && !file) return fail(what, path, error);
    uint64_t size = gives ? size_of(file) : 0;
    sl_ranks_tell(giver, &size, sizeof size);
    bool well = share_bytes(giver, file, size);
    if (file && fclose(file) != 0) well = false;
    return well ? SL_OK : fail(what, path ? path : "files", error);
}
