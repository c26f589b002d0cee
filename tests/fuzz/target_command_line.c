/* The command line of every command. The first byte chooses the command, the rest are words, each behind a zero byte or a line end.
 *
 * A command that gets as far as rendering does so with what it was asked for, but for the sizes, which are put at the end as the least there
 * are. Others are stopped short of their work: by a scene that does not exist, or by one option too many. No word may name a folder. */
#define _XOPEN_SOURCE 700
#include "support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/commands.h"

enum { WORDS_MAX = 48, WORD_MAX = 200, ENDS_MAX = 80 };

static const char scene[] = "{\"softlux\": 1, \"meshes\": [{\"file\": \"c.obj\"}], \"lights\": [{\"type\": \"point\", \"position\": [0, 1, 0], \"intensity\": 1, "
                            "\"keyframes\": [{\"time\": 0}, {\"time\": 1, \"position\": [0.5, 1, 0]}]}], \"camera\": {\"eye\": [0, 1, 3], \"target\": [0, 0, 0]}, "
                            "\"film\": {\"width\": 6, \"height\": 4}}";
static const char obj[] = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 4 3 2\nf 4 2 1\n";

/* What ends a command that renders: last words win. */
static const char *const least[] = {"--size", "3x2", "--threads", "1", "--spp", "1", "--batches", "2", "--frames", "1", "--gather-size", "8", "--photons", "50",
                                    "--depth", "2", "--map-samples", "2", "--points", "20", "--stored-photons", "100", "--indirect-samples", "2", "--area-samples", "4", "--time", "0.05", "--quiet"};

static void make_folder(void) {
    char start[256];
    snprintf(start, sizeof start, "%s", fuzz_path("."));
    fuzz_write("c.json", scene, strlen(scene));
    fuzz_write("c.obj", obj, strlen(obj));
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
    static const char *const kept[] = {"a.exr", "b.pfm", "c.png", "c.json", "c.obj"};
    for (size_t i = 0; i < count; i++) {
        bool keep = false;
        const char *name = words[i], *value = strchr(name, '=');
        if (name[0] == '-' && value) name = value + 1;
        for (size_t k = 0; k < sizeof kept / sizeof kept[0]; k++) keep |= strcmp(name, kept[k]) == 0;
        if (!keep && name[0]) remove(name);
    }
    remove("out.exr");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static int (*const commands[])(int, char **) = {sl_command_render, sl_command_compare, sl_command_info, sl_command_live,
                                                    sl_command_bench, sl_command_steps, sl_command_check_numerics};
    static char words[WORDS_MAX][WORD_MAX], ends[ENDS_MAX][32];
    static bool ready;
    if (!ready) make_folder();
    ready = true;
    if (size < 1) return 0;
    unsigned command = data[0] % 7;
    bool works = data[0] / 7 % 4 == 0, renders = command == 0 && works, reads = command == 1 || (command == 2 && works);
    size_t count = split(data + 1, size - 1, words), argc = 0, end_count = 0;
    char *argv[WORDS_MAX + ENDS_MAX + 1];
    for (size_t i = 0; i < count; i++) {
        bool hides_the_end = !renders && !reads && strcmp(words[i], "--") == 0; /* behind it no word is an option */
        if (!hides_the_end) argv[argc++] = words[i];
    }
    if (renders) {
        for (size_t i = 0; i < sizeof least / sizeof least[0]; i++) strcpy(ends[end_count++], least[i]);
    } else if (!reads) {
        for (int i = 0; i < 2; i++) strcpy(ends[end_count++], "--no-such-option"); /* the first may be the value of what is before it */
    }
    for (size_t i = 0; i < end_count; i++) argv[argc++] = ends[i];
    argv[argc] = NULL;
    int status = commands[command]((int)argc, argv);
    if (status < 0 || status > 5) fuzz_fail("an exit status that is none of ours");
    remove_outputs(words, count);
    return 0;
}
