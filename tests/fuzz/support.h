/* Shared by the targets: a folder of small files, bytes as numbers, and what a scene that loads must stand.
 *
 * A target is a function LLVMFuzzerTestOneInput() in a file of its own. `make fuzz` links it with libFuzzer;
 * `make check` with replay.c, which hands it the files of tests/fuzz/corpus. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "scene/scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Says what is wrong and aborts, which is a find. */
_Noreturn void fuzz_fail(const char *what);

/* A file in a folder that is this process's own, made on first use and removed at the end; valid until the
 * next call but three. */
const char *fuzz_path(const char *name);
void fuzz_write(const char *name, const void *data, size_t size);

/* The input read as numbers; behind its end all is 0. */
typedef struct fuzz_bytes {
    const uint8_t *at, *end;
} fuzz_bytes;

uint32_t fuzz_take(fuzz_bytes *bytes, unsigned count); /* 1 to 4 bytes */
/* Mostly small and plain; one in eight any bits, NaN and infinity among them. */
float fuzz_take_float(fuzz_bytes *bytes);

uint32_t fuzz_hash(const uint8_t *data, size_t size);

/* Fails unless an error is one line that says something. */
void fuzz_check_error(const sl_error *error);
/* A loaded scene holds what the rest of the program relies on. Small ones are planned, moved, and drawn by
 * the method that `choice` names, 4 pixels square: no pixel may be negative, and where lights and sizes are
 * within reason none may be NaN or infinite. */
void fuzz_check_scene(sl_scene *scene, uint32_t choice);
