#include "import/files.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "scene/file.h"

/* ---- one file ------------------------------------------------------------------------------------------ */

static size_t read_file(struct aiFile *file, char *to, size_t size, size_t count) {
    return fread(to, size, count, (FILE *)file->UserData);
}

static size_t write_file(struct aiFile *file, const char *from, size_t size, size_t count) {
    (void)file;
    (void)from;
    (void)size;
    (void)count;
    return 0;
}

static size_t tell(struct aiFile *file) {
    long position = ftell((FILE *)file->UserData);
    return position < 0 ? 0 : (size_t)position;
}

static size_t size_of(struct aiFile *file) {
    FILE *stream = (FILE *)file->UserData;
    long position = ftell(stream), size = 0;
    if (position >= 0 && fseek(stream, 0, SEEK_END) == 0) size = ftell(stream);
    if (position >= 0) fseek(stream, position, SEEK_SET);
    return size < 0 ? 0 : (size_t)size;
}

static enum aiReturn seek(struct aiFile *file, size_t offset, enum aiOrigin origin) {
    int whence = origin == aiOrigin_SET ? SEEK_SET : origin == aiOrigin_CUR ? SEEK_CUR : SEEK_END;
    return fseek((FILE *)file->UserData, (long)offset, whence) == 0 ? aiReturn_SUCCESS : aiReturn_FAILURE;
}

static void flush(struct aiFile *file) { (void)file; }

/* ---- opening ------------------------------------------------------------------------------------------- */

static char *copy_of(const char *text) {
    char *copy = malloc(strlen(text) + 1);
    return copy ? strcpy(copy, text) : NULL;
}

static bool is_allowed(sl_import_files *files, const char *path) {
    if (strcmp(path, files->path) == 0 || sl_file_is_below(files->folder, path)) return true;
    if (!files->refused) files->refused = copy_of(path);
    return false;
}

static bool note(sl_import_files *files, const char *path) {
    char **more = realloc(files->opened, (files->opened_count + 1) * sizeof *more);
    if (!more) return false;
    files->opened = more;
    more[files->opened_count] = copy_of(path);
    return more[files->opened_count] && ++files->opened_count;
}

static struct aiFile *open_file(struct aiFileIO *procedures, const char *path, const char *mode) {
    sl_import_files *files = (sl_import_files *)(void *)procedures->UserData;
    if (mode[0] != 'r' || !sl_file_exists(path) || !is_allowed(files, path)) return NULL;
    struct aiFile *file = malloc(sizeof *file);
    FILE *stream = file && note(files, path) ? fopen(path, "rb") : NULL;
    if (!stream) {
        files->starved |= sl_status_of_errno(errno, SL_ERROR_INPUT) == SL_ERROR_RESOURCES;
        free(file);
        return NULL;
    }
    *file = (struct aiFile){read_file, write_file, tell, size_of, seek, flush, (aiUserData)(void *)stream};
    return file;
}

static void close_file(struct aiFileIO *procedures, struct aiFile *file) {
    (void)procedures;
    fclose((FILE *)file->UserData);
    free(file);
}

void sl_import_files_init(sl_import_files *files, const char *path, const char *folder) {
    *files = (sl_import_files){.path = path, .folder = folder};
    files->procedures = (struct aiFileIO){open_file, close_file, (aiUserData)(void *)files};
}
