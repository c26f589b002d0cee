#define _XOPEN_SOURCE 700
#include "scene_files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char folder[64];

const char *scene_file_path(const char *name) {
    static char paths[64][256];
    static int next;
    char *path = paths[next++ % 64];
    if (!folder[0]) {
        strcpy(folder, "/tmp/softlux-test-XXXXXX");
        if (!mkdtemp(folder)) abort();
    }
    snprintf(path, sizeof paths[0], "%.60s/%.180s", folder, name);
    return path;
}

const char *scene_file_write(const char *name, const void *data, size_t size) {
    const char *path = scene_file_path(name);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file) != 0) abort();
    return path;
}

const char *scene_file_text(const char *name, const char *text) {
    return scene_file_write(name, text, strlen(text));
}

const char *scene_file_copy(const char *from, const char *name) {
    static char bytes[1 << 20];
    FILE *in = fopen(from, "rb");
    if (!in) abort();
    size_t size = fread(bytes, 1, sizeof bytes, in);
    fclose(in);
    return scene_file_write(name, bytes, size);
}

int scene_files_remove(void) {
    char line[80];
    snprintf(line, sizeof line, "rm -rf '%s'", folder);
    int status = folder[0] ? system(line) : 0;
    folder[0] = 0;
    return status;
}

int scene_files_teardown(void **state) {
    return scene_files_remove();
}
