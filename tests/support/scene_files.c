#define _XOPEN_SOURCE 700
#include "scene_files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MOST_FILES = 200 };
static char folder[64];
static char names[MOST_FILES][64];
static int count;

const char *scene_file_path(const char *name) {
    static char paths[4][256];
    static int next;
    char *path = paths[next++ % 4];
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
    for (int i = 0; i < count; i++) {
        if (strcmp(names[i], name) == 0) return path;
    }
    if (count < MOST_FILES) snprintf(names[count++], sizeof names[0], "%s", name);
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

void scene_files_remove(void) {
    for (int i = 0; i < count; i++) unlink(scene_file_path(names[i]));
    if (folder[0]) rmdir(folder);
    count = 0;
    folder[0] = 0;
}

int scene_files_teardown(void **state) {
    (void)state;
    scene_files_remove();
    return 0;
}
