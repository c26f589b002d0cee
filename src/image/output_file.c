#define _GNU_SOURCE /* realpath() */
#include "image/output_file.h"

#include "base/error.h"
#include "base/ranks.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static sl_status fail_writing(const char *name, int reason, sl_error *error) {
    return sl_fail(error, sl_status_of_errno(reason, SL_ERROR_OUTPUT), "cannot write %s: %s", name,
                   strerror(reason));
}

static void release(sl_output_file *file) {
    free(file->name);
    free(file->target);
    free(file->temporary);
    free(file->memory);
    memset(file, 0, sizeof *file);
    file->descriptor = -1;
}

/* Makes the file under a name beside the target that nobody has. Not by mkstemp(), whose files nobody else
 * may read whatever the umask says. */
static int create_beside(sl_output_file *file) {
    enum { ATTEMPTS = 1000 };
    size_t room = strlen(file->target) + 64;
    int reason = EEXIST;
    file->temporary = malloc(room);
    if (!file->temporary) return ENOMEM;
    for (int attempt = 0; attempt < ATTEMPTS && reason == EEXIST; attempt++) {
        snprintf(file->temporary, room, "%s.%ld-%d.part", file->target, (long)getpid(), attempt);
        file->descriptor = open(file->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        reason = file->descriptor >= 0 ? 0 : errno;
    }
    if (reason) {
        free(file->temporary);
        file->temporary = NULL; /* that of somebody else is not to be removed */
    }
    return reason;
}

static int open_target(sl_output_file *file, const char *path) {
    file->name = strdup(path);
    file->target = realpath(path, NULL); /* fails where the file is new */
    if (!file->target) file->target = strdup(path);
    if (!file->name || !file->target) return ENOMEM;
    struct stat status;
    bool exists = stat(file->target, &status) == 0;
    if (!exists || S_ISREG(status.st_mode)) {
        int reason = create_beside(file);
        if (reason == 0 && exists) (void)fchmod(file->descriptor, status.st_mode & 07777);
        return reason;
    }
    /* renaming onto /dev/null would replace it */
    file->descriptor = open(file->target, O_WRONLY | O_CLOEXEC);
    return file->descriptor < 0 ? errno : 0;
}

sl_status sl_output_open(sl_output_file *file, const char *path, sl_error *error) {
    memset(file, 0, sizeof *file);
    file->descriptor = -1;
    int reason = path[0] ? open_target(file, path) : ENOENT;
    if (reason == 0) return SL_OK;
    sl_status status = fail_writing(path, reason, error);
    release(file);
    return status;
}

sl_status sl_output_check(const char *path, sl_error *error) {
    struct stat status;
    sl_output_file file;
    if (stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode))
        return access(path, W_OK) == 0 ? SL_OK : fail_writing(path, errno, error);
    sl_status opened = sl_output_open(&file, path, error);
    if (opened == SL_OK) sl_output_discard(&file);
    return opened;
}

void sl_output_open_memory(sl_output_file *file) {
    memset(file, 0, sizeof *file);
    file->descriptor = -1;
    file->in_memory = true;
}

static sl_status keep(sl_output_file *file, const void *data, size_t bytes, sl_error *error) {
    if (file->room - file->size < bytes) {
        uint64_t room = 2 * file->room + bytes + 4096;
        uint8_t *more = realloc(file->memory, room);
        if (!more) return sl_fail_memory(error, "a file's bytes");
        file->memory = more;
        file->room = room;
    }
    memcpy(file->memory + file->size, data, bytes);
    file->size += bytes;
    return SL_OK;
}

/* At an offset, or in sequence where it is NULL: a pipe has no other way. */
static sl_status write_all(const sl_output_file *file, const char *from, size_t bytes, const uint64_t *offset,
                           sl_error *error) {
    for (size_t done = 0; done < bytes;) {
        const ssize_t written =
            offset ? pwrite(file->descriptor, from + done, bytes - done, (off_t)(*offset + done))
                   : write(file->descriptor, from + done, bytes - done);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return fail_writing(file->name, written < 0 ? errno : EIO, error);
        done += (size_t)written;
    }
    return SL_OK;
}

sl_status sl_output_write(sl_output_file *file, const void *data, size_t bytes, sl_error *error) {
    if (file->in_memory) return keep(file, data, bytes, error);
    return write_all(file, data, bytes, NULL, error);
}

sl_status sl_output_write_at(sl_output_file *file, const void *data, size_t bytes, uint64_t offset,
                             sl_error *error) {
    return write_all(file, data, bytes, &offset, error);
}

static sl_status commit(sl_output_file *file, sl_error *error) {
    int reason = file->temporary && fsync(file->descriptor) != 0 ? errno : 0;
    if (close(file->descriptor) != 0 && reason == 0) reason = errno;
    file->descriptor = -1;
    if (reason == 0 && file->temporary && rename(file->temporary, file->target) != 0) reason = errno;
    sl_status status = reason ? fail_writing(file->name, reason, error) : SL_OK;
    if (reason && file->temporary) unlink(file->temporary);
    release(file);
    return status;
}

void sl_output_discard(sl_output_file *file) {
    if (file->descriptor >= 0) close(file->descriptor);
    if (file->temporary) unlink(file->temporary);
    release(file);
}

sl_status sl_output_close(sl_output_file *file, sl_status written, sl_error *error) {
    const bool writes = sl_ranks_here().rank == 0 || sl_batch_is_own_work();
    if (written == SL_OK && writes) return commit(file, error);
    sl_output_discard(file);
    return written;
}

sl_status sl_output_whole(const char *path, const void *data, size_t bytes, sl_error *error) {
    sl_output_file file;
    sl_status status = sl_output_open(&file, path, error);
    if (status != SL_OK) return status;
    return sl_output_close(&file, sl_output_write(&file, data, bytes, error), error);
}
