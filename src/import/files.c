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
    (void)file, (void)from, (void)size, (void)count;
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

static bool is_allowed(sl_import_files *files, const char *path) {
    sl_error problem;
    if (files->status != SL_OK) return false;
    if (strcmp(path, files->path) == 0) return true;
    files->status = sl_model_may_read(files->model, path, &problem);
    if (files->status != SL_OK)
        sl_fail(files->error, files->status, "%s: names %s", files->path, problem.message);
    else files->status = sl_model_note_file(files->model, path, files->error);
    return files->status == SL_OK;
}

static struct aiFile *open_file(struct aiFileIO *procedures, const char *path, const char *mode) {
    sl_import_files *files = (sl_import_files *)(void *)procedures->UserData;
    if (mode[0] != 'r' || !sl_file_exists(path) || !is_allowed(files, path)) return NULL;
    struct aiFile *file = malloc(sizeof *file);
    FILE *stream = file ? fopen(path, "rb") : NULL;
    if (!stream) { /* what Assimp takes for a file that is not there */
        if (sl_status_of_errno(errno, SL_ERROR_INPUT) == SL_ERROR_RESOURCES)
            files->status = sl_fail_memory(files->error, files->path);
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

void sl_import_files_init(sl_import_files *files, const char *path, sl_model *model, sl_error *error) {
    *files = (sl_import_files){.path = path, .model = model, .error = error};
    files->procedures = (struct aiFileIO){open_file, close_file, (aiUserData)(void *)files};
}
