/* A folder that keeps what was dear to compute. */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/random.h"
#include "common.h"

/* ---- the folder ---- */

static const char folder[] = "build/references";

uint64_t bench_hash(uint64_t hash, const void *bytes, size_t size) {
    const unsigned char *p = bytes;
    for (size_t i = 0; i < size; i++) hash = sl_hash64(hash ^ p[i]);
    return hash;
}

static void file_name(char path[256], const char *word, uint64_t hash) {
    snprintf(path, 256, "%s/%s-%016llx.f32", folder, word, (unsigned long long)hash);
}

bool bench_store_load(const char *word, uint64_t hash, size_t count, float *values) {
    char path[256];
    file_name(path, word, hash);
    FILE *file = fopen(path, "rb");
    if (!file) return false;
    size_t got = fread(values, sizeof *values, count, file);
    bool whole = got == count && fgetc(file) == EOF;
    fclose(file);
    return whole;
}

/* Whole or not at all: written beside its name and renamed. */
void bench_store_save(const char *word, uint64_t hash, size_t count, const float *values) {
    char path[256], beside[300];
    mkdir("build", 0777);
    mkdir(folder, 0777);
    file_name(path, word, hash);
    snprintf(beside, sizeof beside, "%s.new", path);
    FILE *file = fopen(beside, "wb");
    bool good = file && fwrite(values, sizeof *values, count, file) == count;
    if (file && fclose(file) != 0) good = false;
    if (!good || rename(beside, path) != 0) fprintf(stderr, "warning: %s cannot be kept\n", path);
}
