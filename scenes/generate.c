/* Makes the larger scenes: `generate DIR [SCENE...]` writes OBJ, MTL and JSON files of every scene, or of
 * those named.
 *
 * The files are the same, byte for byte, on every machine and with every compiler. A scene is a file in
 * generate/; read room.c first, and generate/mesh.h for the shapes that all of them are built of. */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "generate/mesh.h"

static const struct {
    const char *name;
    void (*make)(const char *folder);
} scenes[] = {
    {"room", gen_room},
    {"cave", gen_cave},
    {"mirror-cave", gen_mirror_cave},
    {"atrium", gen_atrium},
    {"castle", gen_castle},
    {"cathedral", gen_cathedral},
    {"figure", gen_figure},
    {"study", gen_study},
    {"loft", gen_loft},
    {"pool", gen_pool},
    {"ring", gen_ring},
    {"parlour", gen_parlour},
    {"metals", gen_metals},
};
enum { SCENES = sizeof scenes / sizeof scenes[0] };

static int usage(void) {
    fprintf(stderr, "usage: generate DIR [SCENE...]; the scenes are");
    for (int i = 0; i < SCENES; i++) fprintf(stderr, " %s", scenes[i].name);
    fprintf(stderr, "\n");
    return 2;
}

static bool is_wanted(const char *name, int count, char **names) {
    for (int i = 0; i < count; i++)
        if (strcmp(names[i], name) == 0) return true;
    return count == 0;
}

int main(int argc, char **argv) {
    if (argc < 2 || argv[1][0] == '-') return usage();
    for (int a = 2; a < argc; a++) {
        bool known = false;
        for (int i = 0; i < SCENES; i++) known |= strcmp(argv[a], scenes[i].name) == 0;
        if (!known) {
            fprintf(stderr, "generate: no scene is called '%s'\n", argv[a]);
            return usage();
        }
    }
    if (mkdir(argv[1], 0777) != 0 && errno != EEXIST) {
        fprintf(stderr, "generate: cannot make the folder %s: %s\n", argv[1], strerror(errno));
        return 4;
    }
    for (int i = 0; i < SCENES; i++)
        if (is_wanted(scenes[i].name, argc - 2, argv + 2)) scenes[i].make(argv[1]);
    return 0;
}
