/* Files that appear whole or not at all: the bytes go to a file beside the target, NAME.PROCESS-NUMBER.part,
 * which takes the target's name only when everything is on the disk. A failure, at any point, leaves what was
 * there before and nothing else; a process that is killed leaves the part too, in nobody's way. */
#pragma once

#include "softlux.h"

typedef struct sl_output_file {
    int descriptor;
    char *name;       /* as the caller wrote it, for messages */
    char *target;     /* with symbolic links resolved */
    /* the name it has until it takes the target's, or NULL; devices and pipes are written directly */
    char *temporary;
    bool in_memory;   /* no file at all: the bytes stay here */
    uint8_t *memory;
    uint64_t size, room;
} sl_output_file;

/* All failures are SL_ERROR_OUTPUT (or SL_ERROR_RESOURCES for want of memory), "cannot write PATH: reason".
 * After a failed open nothing is to be undone; after a successful one exactly one of close and discard must
 * follow. */
sl_status sl_output_open(sl_output_file *file, const char *path, sl_error *error);
/* Fails as opening would, so that it is known before the work; leaves no trace. Devices and pipes are not
 * opened. */
sl_status sl_output_check(const char *path, sl_error *error);
/* Keeps in memory what is written in sequence; sl_output_discard() ends that. */
void sl_output_open_memory(sl_output_file *file);
sl_status sl_output_write(sl_output_file *file, const void *data, size_t bytes, sl_error *error);
/* For formats whose writer goes back; independent of the sequence. */
sl_status sl_output_write_at(sl_output_file *file, const void *data, size_t bytes, uint64_t offset,
                             sl_error *error);
/* Gives the file its name if all was `written`, or discards it; returns what came of it. */
sl_status sl_output_close(sl_output_file *file, sl_status written, sl_error *error);
void sl_output_discard(sl_output_file *file);
/* Writes a file of these bytes. */
sl_status sl_output_whole(const char *path, const void *data, size_t bytes, sl_error *error);
