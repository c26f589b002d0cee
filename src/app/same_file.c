#include "app/same_file.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

/* By name, or because it is there by both names. */
static bool are_same(const char *a, const char *b) {
    struct stat of_a, of_b;
    if (strcmp(a, b) == 0) return true;
    return stat(a, &of_a) == 0 && stat(b, &of_b) == 0 && S_ISREG(of_a.st_mode) && of_a.st_dev == of_b.st_dev && of_a.st_ino == of_b.st_ino;
}

bool sl_is_file_of_its_own(const char *option, const char *file, const char *const others[], int count) {
    for (int i = 0; file && i < count; i++) {
        if (!others[i] || !are_same(file, others[i])) continue;
        fprintf(stderr, "softlux: --%s: expected a file of its own, got '%s', which would take the place of %s\n", option, file, others[i]);
        return false;
    }
    return true;
}
