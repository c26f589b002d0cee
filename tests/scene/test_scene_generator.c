/* The generator of the larger scenes: its files are promised to be the same with every compiler and on every
 * machine, so their hashes are written down here. SOFTLUX_GENERATE names the program (default
 * build/generate); without it the tests are skipped. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unit_test.h"

static char folder[64];

static const char *generator(void) {
    const char *named = getenv("SOFTLUX_GENERATE");
    const char *path = named && *named ? named : "build/generate";
    if (access(path, X_OK) == 0) return path;
    print_message("there is no %s; build it with: make build/generate\n", path);
    skip();
    return NULL;
}

/* The program's exit status; its output is thrown away. */
static int run(const char *arguments) {
    char command[512];
    snprintf(command, sizeof command, "'%s' %s >/dev/null 2>&1", generator(), arguments);
    int status = system(command);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/* FNV-1a, 64 bits; 0 where the file is missing. */
static uint64_t hash_of(const char *name) {
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    if (!file) return 0;
    uint64_t hash = 14695981039346656037u;
    for (int c; (c = fgetc(file)) != EOF;) hash = (hash ^ (uint64_t)c) * 1099511628211u;
    fclose(file);
    return hash;
}

static void the_files_are_the_same_as_ever(void **state) {
    (void)generator();
    static const struct { const char *file; uint64_t hash; } expected[] = {
        {"room.obj", 0x94f278d6b36aa0d2u},
        {"room.mtl", 0x1425b09c6fe8a2fdu},
        {"room.json", 0x773da255bc257968u},
        {"cave.obj", 0x4c1ffda541574287u},
        {"cave.mtl", 0x1b2237938912e28du},
        {"cave.json", 0x24989370a09fe8cdu},
        {"mirror-cave.obj", 0xba5a6e599581897bu},
        {"mirror-cave.mtl", 0x1c32e8281cc94d4fu},
        {"mirror-cave.json", 0xe90f9d9f1b646b91u},
        {"atrium.obj", 0x7ff32244c2256764u},
        {"atrium.mtl", 0xb5edb9032a54c3b9u},
        {"atrium.json", 0xbb5841fb28215817u},
        {"castle.obj", 0xdf2432bbedd18298u},
        {"castle.mtl", 0x070e1d0f0ead600cu},
        {"castle.json", 0xf2b8659a0436e6eeu},
        {"cathedral.obj", 0x2657a92c1a2627a3u},
        {"cathedral.mtl", 0x1f5514478c262c9bu},
        {"cathedral.json", 0xd98748536fd7a3c8u},
        {"study.obj", 0x96e834c70f9eb269u},
        {"study.json", 0x0e2b77b684648988u},
        {"study-chair.obj", 0x7c944b4733b6a21au},
        {"study-vase.bpt", 0x23d5b8c696fe0f9bu},
        {"study-cloth.bpt", 0x7930f4275d4b11aau},
        {"study-lamp.json", 0x2ce69b90720b0696u},
        {"loft.obj", 0x35b17fe8c7dc4fb1u},
        {"loft.json", 0x1ea85f50d8ab92a9u},
        {"pool.obj", 0x0aaedc468d1eaf82u},
        {"pool-ball.bpt", 0xc666c49083602929u},
        {"pool.json", 0xe495fa5d70012cdau},
        {"ring.obj", 0xbbed7a292f46820cu},
        {"ring-table.obj", 0xaee08c6fc638c67au},
        {"ring.json", 0xd5d0707b67adccfeu},
        {"castle-sky.pfm", 0x89e8dfdd487ee845u},
    };
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        uint64_t hash = hash_of(expected[i].file);
        if (hash != expected[i].hash)
            print_error("%s: 0x%016llx\n", expected[i].file, (unsigned long long)hash);
        assert_true(hash == expected[i].hash);
    }
}

static void an_unknown_scene_is_refused(void **state) {
    char arguments[128];
    snprintf(arguments, sizeof arguments, "%s nowhere", folder);
    assert_int_equal(run(arguments), 2);
    assert_int_equal(run(""), 2);
}

static int generate_once(void **state) {
    const char *named = getenv("SOFTLUX_GENERATE");
    snprintf(folder, sizeof folder, "/tmp/softlux-generator-XXXXXX");
    if (!mkdtemp(folder)) return -1;
    if (access(named && *named ? named : "build/generate", X_OK) != 0) return 0; /* every test then skips */
    char arguments[160];
    snprintf(arguments, sizeof arguments,
             "%s room cave mirror-cave atrium castle cathedral study loft pool ring", folder);
    return run(arguments) == 0 ? 0 : -1;
}

static int remove_all(void **state) {
    char command[128];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command) == 0 ? 0 : -1;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_files_are_the_same_as_ever),
        cmocka_unit_test(an_unknown_scene_is_refused),
    };
    return cmocka_run_group_tests(tests, generate_once, remove_all);
}
