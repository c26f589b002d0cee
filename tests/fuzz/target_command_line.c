/* The command line of every command. The first byte chooses the command, the rest are words, each behind a
 * zero byte or a line end.
 *
 * A command that gets as far as rendering does so with what it was asked for, but for the sizes, which are
 * put at the end as the least there are. Others are stopped short of their work: by a scene that does not
 * exist, or by one option too many. No word may name a folder. Scenes are a sound one, and some that cannot
 * be loaded. --memory is what it is but for the system's limit, which is for programs without sanitizers. */
#define _XOPEN_SOURCE 700
#include "support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/commands.h"

enum { WORDS_MAX = 48, WORD_MAX = 200, ENDS_MAX = 80 };

static const char scene[] = "{\"softlux\": 1, \"meshes\": [{\"file\": \"c.obj\"}], \"lights\": [{\"type\": "
                            "\"point\", \"position\": [0, 1, 0], \"intensity\": 1, "
                            "\"keyframes\": [{\"time\": 0}, {\"time\": 1, \"position\": [0.5, 1, 0]}]}], "
                            "\"camera\": {\"eye\": [0, 1, 3], \"target\": [0, 0, 0]}, "
                            "\"film\": {\"width\": 6, \"height\": 4}}";
static const char obj[] = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 4 3 2\nf 4 2 1\n";

static const char empty[] = "", no_mesh[] = "{\"softlux\": 1, \"meshes\": [{\"file\": \"none.obj\"}]}",
                  torn[] = "{\"softlux\": 1, \"meshes\": [{\"fi", no_triangle[] = "v 0 0 0\nv 1 0 0\n",
                  stray[] = "v 0 0 0\nf 1 2 3\n",
                  huge_header[] = "ply\nformat ascii 1.0\nelement vertex 4000000000\nend_header\n";
/* Scenes that words may name. */
static const struct {
    const char *name, *text;
} scenes[] = {{"c.json", scene},           {"c.obj", obj},       {"empty.json", empty},
              {"no-mesh.json", no_mesh},   {"torn.json", torn},  {"empty.obj", empty},
              {"points.obj", no_triangle}, {"stray.obj", stray}, {"huge.ply", huge_header}};
enum { SCENES = sizeof scenes / sizeof scenes[0] };

/* The end of a command that renders: last words win. Some only go with others. */
static const char *const least[] = {"--size",
                                    "3x2",
                                    "--threads",
                                    "1",
                                    "--spp",
                                    "1",
                                    "--photons",
                                    "2",
                                    "--depth",
                                    "2",
                                    "--stored-photons",
                                    "100",
                                    "--set",
                                    "gather-size=8",
                                    "--set",
                                    "direct-radiance.map-size=4",
                                    "--set",
                                    "direct-radiance.shadow-size=16",
                                    "--set",
                                    "shading-cache.points=20",
                                    "--set",
                                    "shading-cache.indirect-samples=2",
                                    "--set",
                                    "shading-cache.area-samples=4",
                                    "--quiet"};
static const char *const least_of_series[] = {"--frames", "1"}, *const least_of_others[] = {"--time", "0.05"},
                         *const least_without_error[] = {"--batches", "2"};

static size_t add_words(char *argv[], size_t argc, const char *const *words, size_t count) {
    static char ends[ENDS_MAX][40]; /* commands may write to their words */
    static size_t next;
    for (size_t i = 0; i < count; i++) argv[argc++] = strcpy(ends[next++ % ENDS_MAX], words[i]);
    return argc;
}

static bool has_option(char *argv[], size_t argc, const char *name) {
    size_t length = strlen(name);
    for (size_t i = 0; i < argc; i++) {
        if (strncmp(argv[i], name, length) == 0 && (argv[i][length] == 0 || argv[i][length] == '='))
            return true;
    }
    return false;
}

static size_t add_least(char *argv[], size_t argc) {
    const bool series = has_option(argv, argc, "--frames"), by_error = has_option(argv, argc, "--error");
    argc = add_words(argv, argc, least, sizeof least / sizeof least[0]);
    if (series) return add_words(argv, argc, least_of_series, 2);
    argc = add_words(argv, argc, least_of_others, 2);
    return by_error ? argc : add_words(argv, argc, least_without_error, 2);
}

/* Words at the ends of the commands are no mistake: else none would get as far as its work. */
static void try_sound_commands(void) {
    static const char *const sound[][6] = {{"c.json", "-o", "out.exr"},
                                           {"c.json", "-o", "out%d.exr", "--frames", "1"},
                                           {"c.json", "-o", "out.exr", "--memory", "1G"}};
    for (size_t i = 0; i < sizeof sound / sizeof sound[0]; i++) {
        char *argv[WORDS_MAX + ENDS_MAX + 1];
        size_t argc = 0;
        while (argc < 6 && sound[i][argc]) argc++;
        argc = add_words(argv, 0, sound[i], argc);
        argc = add_least(argv, argc);
        argv[argc] = NULL;
        if (sl_command_render((int)argc, argv) != 0) fuzz_fail("a sound command fails");
    }
    remove("out.exr");
    remove("out0.exr");
}

static void make_folder(void) {
    char start[256];
    snprintf(start, sizeof start, "%s", fuzz_path("."));
    for (int i = 0; i < SCENES; i++) fuzz_write(scenes[i].name, scenes[i].text, strlen(scenes[i].text));
    sl_image *image = NULL;
    sl_error error;
    if (sl_image_create(12, 11, 3, NULL, &image, &error) != SL_OK) fuzz_fail(error.message);
    for (int i = 0; i < 3 * 12 * 11; i++) image->planes[i] = (float)(i % 7) * 0.2f;
    static const char *const names[] = {"a.exr", "b.pfm", "c.png"};
    for (int i = 0; i < 3; i++) {
        fuzz_write(names[i], "", 0);
        if (sl_image_write(image, fuzz_path(names[i]), &error) != SL_OK) fuzz_fail(error.message);
    }
    sl_image_destroy(image);
    if (chdir(start) != 0) fuzz_fail("cannot enter the folder");
}

static size_t split(const uint8_t *data, size_t size, char words[WORDS_MAX][WORD_MAX]) {
    size_t count = 0, length = 0;
    for (size_t i = 0; i < size && count < WORDS_MAX; i++) {
        bool end = data[i] == 0 || data[i] == '\n';
        if (!end && length + 1 < WORD_MAX) words[count][length++] = data[i] == '/' ? '|' : (char)data[i];
        if (!end && i + 1 < size) continue;
        words[count][length] = 0;
        count++;
        length = 0;
    }
    return count;
}

/* Pictures that were asked for go away again; those that compare reads stay. */
static void remove_outputs(char words[WORDS_MAX][WORD_MAX], size_t count) {
    static const char *const kept[] = {"a.exr", "b.pfm", "c.png"};
    for (size_t i = 0; i < count; i++) {
        bool keep = false;
        const char *name = words[i], *value = strchr(name, '=');
        if (name[0] == '-' && value) name = value + 1;
        for (size_t k = 0; k < sizeof kept / sizeof kept[0]; k++) keep |= strcmp(name, kept[k]) == 0;
        for (int k = 0; k < SCENES; k++) keep |= strcmp(name, scenes[k].name) == 0;
        if (!keep && name[0]) remove(name);
    }
    remove("out.exr");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static int (*const commands[])(int, char **) = {
        sl_command_render, sl_command_compare, sl_command_info,          sl_command_live,
        sl_command_bench,  sl_command_steps,   sl_command_check_numerics};
    static char words[WORDS_MAX][WORD_MAX];
    static bool ready;
    if (!ready) make_folder(), try_sound_commands();
    ready = true;
    if (size < 1) return 0;
    unsigned command = data[0] % 7;
    bool works = data[0] / 7 % 4 == 0, renders = command == 0 && works,
         reads = command == 1 || (command == 2 && works);
    size_t count = split(data + 1, size - 1, words), argc = 0;
    char *argv[WORDS_MAX + ENDS_MAX + 1];
    for (size_t i = 0; i < count; i++) {
        /* behind it no word is an option */
        bool hides_the_end = !renders && !reads && strcmp(words[i], "--") == 0;
        if (!hides_the_end) argv[argc++] = words[i];
    }
    /* the first may be the value of what is before it */
    static const char *const too_many[] = {"--no-such-option", "--no-such-option"};
    if (renders) argc = add_least(argv, argc);
    else if (!reads) argc = add_words(argv, argc, too_many, 2);
    argv[argc] = NULL;
    int status = commands[command]((int)argc, argv);
    if (status < 0 || status > 5) fuzz_fail("an exit status that is none of ours");
    remove_outputs(words, count);
    return 0;
}
