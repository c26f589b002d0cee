/* The targets without a fuzzer: every file named, or in a folder named, is one input. */
#define _XOPEN_SOURCE 700
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>

#include "support.h"

static unsigned long inputs;

static int replay(const char *path, const struct stat *about, int kind, struct FTW *where) {
    if (kind != FTW_F) return 0;
    FILE *file = fopen(path, "rb");
    if (!file || fseek(file, 0, SEEK_END) != 0) fuzz_fail(path);
    size_t size = (size_t)ftell(file);
    rewind(file);
    uint8_t *data = malloc(size ? size : 1); /* its end is the input's end, for the address sanitizer */
    if (!data || fread(data, 1, size, file) != size) fuzz_fail(path);
    fclose(file);
    fprintf(stderr, "%s\n", path); /* the last one printed is the one that failed */
    LLVMFuzzerTestOneInput(data, size);
    free(data);
    inputs++;
    return 0;
}

int main(int argc, char **argv) {
    for (int i = 1; i < argc; i++) {
        if (nftw(argv[i], replay, 16, FTW_PHYS) != 0) fuzz_fail(argv[i]);
    }
    printf("%s: %lu inputs\n", argv[0], inputs);
    return inputs > 0 ? 0 : 1;
}
