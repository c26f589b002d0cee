/* softlux serve: a scene in a browser, to move in and to take apart. */
#include "app/auto_method.h"
#include "app/clock.h"
#include "app/commands.h"
#include "app/memory_limit.h"
#include "app/options.h"
#include "app/page.h"
#include "app/same_file.h"
#include "app/serve/network.h"
#include "app/serve/stage.h"
#include "base/error.h"
#include "base/thread.h"
#include "scene/features.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct serve_command {
    sl_stage_options stage;
    sl_network_options network;
    sl_reading reading;
    uint64_t port;
    const char *replay;
    bool quiet;
} serve_command;

static bool parse(int argc, char **argv, serve_command *c, int *status) {
    bool quality_given = false;
    *c = (serve_command){.network.host = "127.0.0.1", .stage.settings = sl_settings_default()};
    c->stage.settings.method = "shading-cache";
    c->stage.folder = "softlux-kept";
    const sl_option options[] = {
        SL_TEXT("output", 'o', &c->stage.folder, "DIR", "where what is kept is written [softlux-kept]"),
        SL_TEXT(
            "host", 0, &c->network.host, "ADDRESS",
            "an address of this machine to listen at; nothing is encrypted [127.0.0.1: this machine alone]"),
        SL_NUMBER("port", 0, &c->port, "N", 0, 65535, "to listen at; 0: any [0]"),
        SL_REAL("at", &c->stage.at_seconds, NULL, "SECONDS", -1e9, 1e9,
                "time of the scene to begin with [0]"),
        SL_TEXT("replay", 0, &c->replay, "LOG",
                "write the pictures of a log that was kept into DIR, as its shows had them, and end"),
        SL_FLAG("quiet", &c->quiet, "no warnings"),
        {.name = NULL}};
    const sl_command_line line = {
        "softlux serve SCENE [-m METHOD] [-o DIR] [options]",
        "Serves one page on this machine: a scene to move in, to change, to compare methods on and to take "
        "apart.",
        "Prints the page's address, which opens it to whoever has it. Ctrl-C ends the server.\n"
        "The method is the shading cache, and the quality draft, where no others are named.\n\n"
        "example: softlux serve scenes/cornell.json",
        options,
        1,
        1,
        &c->reading,
        &c->stage.settings,
        &quality_given};
    int operands;
    if (!sl_options_parse(&line, argc, argv, &c->stage.scene_path, &operands, status)) return false;
    if (!quality_given) c->stage.settings.quality = SL_QUALITY_DRAFT;
    c->network.port = (int)c->port;
    c->stage.reading = &c->reading;
    return true;
}

/* replay-1.exr and, where two methods were shown, replay-2.exr. */
static sl_status replay(const serve_command *c, sl_error *error) {
    sl_status status = SL_OK;
    for (int i = 0; i < 2; i++) {
        char name[4096];
        sl_image *picture;
        snprintf(name, sizeof name, "%.4000s/replay-%d.exr", c->stage.folder, i + 1);
        sl_status one = sl_log_replay(c->replay, c->stage.scene_path, &c->reading, i, &picture, error);
        if (i == 0 || one == SL_OK) status = one;
        if (one == SL_OK) status = sl_make_folder(c->stage.folder, "replay-1.exr", error);
        if (one == SL_OK && status == SL_OK) status = sl_image_write(picture, name, error);
        sl_image_destroy(picture);
    }
    return status;
}

#ifndef SL_HAVE_WEBSOCKETS
int sl_command_serve(int argc, char **argv) {
    serve_command c;
    int status;
    sl_error error;
    if (!parse(argc, argv, &c, &status)) return status;
    if (c.replay) return replay(&c, &error) == SL_OK ? 0 : sl_complain(&error);
    fprintf(stderr,
            "softlux: serve: this program was built without libwebsockets (Debian's libwebsockets-dev); "
            "./setup.sh installs it, then make builds it anew\n");
    return SL_ERROR_USAGE;
}
#else

static void tell_address(const serve_command *c, const sl_network *network) {
    const bool numbers = strchr(c->network.host, ':') != NULL;
    printf("http://%s%s%s:%d/#%s\n", numbers ? "[" : "", c->network.host, numbers ? "]" : "",
           sl_network_port(network), c->network.token);
    fflush(stdout);
    if (strncmp(c->network.host, "127.", 4) != 0 && strcmp(c->network.host, "localhost") != 0 &&
        strcmp(c->network.host, "::1") != 0)
        fprintf(stderr, "softlux: warning: the page can be reached from other machines, and nothing is "
                        "encrypted\n");
}

/* Threads that wait for each other leave the processor to frames, to the network and to a browser; OpenMP
 * takes note of that before main() alone. */
static void wait_quietly(char **words) {
    if (getenv("OMP_WAIT_POLICY")) return;
    setenv("OMP_WAIT_POLICY", "passive", 1);
    execv("/proc/self/exe", words); /* where it fails all goes on, with less grace */
}

static void run_stage(void *stage) { sl_stage_run(stage); }

static sl_status serve(const serve_command *c, sl_stage *stage, sl_mail *mail, sl_error *error) {
    sl_network *network = NULL;
    sl_thread thread;
    sl_status status = sl_network_open(&c->network, mail, &network, error);
    if (status != SL_OK) return status;
    tell_address(c, network);
    if (sl_thread_start(&thread, run_stage, stage)) {
        sl_network_run(network);
        sl_mail_end(mail);
        sl_thread_join(&thread);
    } else {
        status = sl_fail(error, SL_ERROR_RESOURCES, "no thread could be had");
    }
    sl_network_close(network);
    return status;
}

/* The size is one that can be shown; the method is known before the page is. */
static sl_status settle(serve_command *c, const sl_scene *scene, sl_error *error) {
    sl_settings *o = &c->stage.settings;
    const sl_auto_budget budget = {.quality = o->quality, .things_move = sl_scene_features(scene).animated};
    if (!o->width) sl_scene_film(scene, &o->width, &o->height);
    const int longer = o->width > o->height ? o->width : o->height;
    if (longer > SL_LARGEST_SIDE) {
        o->width = o->width * SL_LARGEST_SIDE / longer;
        o->height = o->height * SL_LARGEST_SIDE / longer;
    }
    if (o->width < SL_SMALLEST_SIDE) o->width = SL_SMALLEST_SIDE;
    if (o->height < SL_SMALLEST_SIDE) o->height = SL_SMALLEST_SIDE;
    return sl_auto_settle(scene, &budget, c->quiet, o, error);
}

/* Loads the scene for its warnings, and what follows from it; the stage has copies of its own. */
static sl_status look_at_scene(serve_command *c, sl_error *error) {
    sl_scene *scene = NULL;
    sl_status status =
        sl_load_within_memory(c->stage.scene_path, &c->reading.load, &c->stage.settings, &scene, error);
    if (status == SL_OK) sl_tell_warnings(scene, c->quiet);
    if (status == SL_OK) status = settle(c, scene, error);
    sl_scene_destroy(scene);
    return status;
}

int sl_command_serve(int argc, char **argv) {
    serve_command c;
    sl_mail mail;
    int exit_status;
    if (!parse(argc, argv, &c, &exit_status)) return exit_status;
    sl_error error;
    if (c.replay) return replay(&c, &error) == SL_OK ? 0 : sl_complain(&error);
    sl_keep_freed_memory(&c.stage.settings);
    wait_quietly(argv - 2); /* "softlux serve" */
    sl_stage *stage = NULL;
    c.stage.token = c.network.token;
    sl_status status = look_at_scene(&c, &error);
    if (status == SL_OK) status = sl_network_token(c.network.token, &error);
    if (status == SL_OK && !sl_mail_open(&mail))
        status = sl_fail(&error, SL_ERROR_RESOURCES, "no lock could be had");
    if (status != SL_OK) return sl_complain(&error);
    sl_watch_for_interrupt();
    status = sl_stage_open(&c.stage, &mail, &stage, &error);
    if (status == SL_OK) status = serve(&c, stage, &mail, &error);
    sl_stage_close(stage);
    sl_mail_close(&mail);
    return status == SL_OK ? 0 : sl_complain(&error);
}
#endif
