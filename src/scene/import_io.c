#define _XOPEN_SOURCE 700 /* fmemopen() */
#include "scene/import_io.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/file.h"
#include "scene/mtl_text.h"

typedef struct opened {
    struct aiFile file; /* comes first: the importer hands this back */
    sl_text text;       /* what the stream reads, where it is not the file */
} opened;

/* ---- one file ---------------------------------------------------------------------------------------------------------- */

static size_t read_file(struct aiFile *file, char *to, size_t size, size_t count) { return fread(to, size, count, (FILE *)file->UserData); }

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

/* ---- opening ------------------------------------------------------------------------------------------------------------- */

static bool is_allowed(sl_import_io *io, const char *path) {
    if (strcmp(path, io->path) == 0 || sl_file_is_below(io->model->folder, path)) return true;
    if (!io->refused[0]) snprintf(io->refused, sizeof io->refused, "%s", path);
    return false;
}

static FILE *or_starve(sl_import_io *io, FILE *stream) {
    if (!stream) io->starved |= sl_status_of_errno(errno, SL_ERROR_INPUT) == SL_ERROR_RESOURCES;
    return stream;
}

static FILE *open_library(sl_import_io *io, const char *path, sl_text *text) {
    sl_status status = sl_mtl_text_read(path, NULL, text, NULL);
    io->starved |= status == SL_ERROR_RESOURCES;
    if (status != SL_OK) return NULL;
    return or_starve(io, text->size ? fmemopen(text->data, text->size, "r") : fopen(path, "rb"));
}

static FILE *open_stream(sl_import_io *io, const char *path, sl_text *text) {
    if (!io->plain || !io->plain->size) return or_starve(io, fopen(path, "rb"));
    if (strcmp(path, io->path) == 0) return or_starve(io, fmemopen(io->plain->data, io->plain->size, "r"));
    return open_library(io, path, text);
}

static void release(opened *file) {
    if (file) sl_text_release(&file->text);
    sl_free(file);
}

static struct aiFile *open_file(struct aiFileIO *procedures, const char *path, const char *mode) {
    sl_import_io *io = (sl_import_io *)(void *)procedures->UserData;
    if (mode[0] != 'r' || !sl_file_exists(path) || !is_allowed(io, path)) return NULL;
    if (sl_model_note_file(io->model, path, NULL) != SL_OK) {
        io->starved = true;
        return NULL;
    }
    opened *file = sl_allocate(1, sizeof *file);
    FILE *stream = file ? open_stream(io, path, &file->text) : NULL;
    if (!file) io->starved = true;
    if (stream) file->file = (struct aiFile){read_file, write_file, tell, size_of, seek, flush, (aiUserData)(void *)stream};
    else release(file);
    return stream ? &file->file : NULL;
}

static void close_file(struct aiFileIO *procedures, struct aiFile *file) {
    (void)procedures;
    fclose((FILE *)file->UserData);
    release((opened *)(void *)file);
}

void sl_import_io_init(sl_import_io *io, const char *path, sl_model *model, const sl_text *plain) {
    *io = (sl_import_io){.path = path, .model = model, .plain = plain};
    io->procedures = (struct aiFileIO){open_file, close_file, (aiUserData)(void *)io};
}
