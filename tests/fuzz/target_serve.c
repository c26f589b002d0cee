/* Messages of a viewer of `softlux serve`, a line each, as they come over the wire, to a stage that shows a
 * small room. Those that would write files or begin long work are left out. */
#include "support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/serve/network.h"
#include "app/serve/stage.h"

static const char scene[] =
    "{\"softlux\": 1, \"meshes\": [{\"file\": \"s.obj\"}], \"lights\": [{\"type\": \"point\", \"position\": "
    "[0, 1, 0], "
    "\"intensity\": 1}, {\"type\": \"directional\", \"direction\": [0, -1, 0], \"irradiance\": 1}], "
    "\"environment\": {\"radiance\": 0.1}, \"camera\": {\"eye\": [0, 1, 3], \"target\": [0, 0, 0]}}";
static const char obj[] = "o floor\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 4 3 2\nf 4 2 1\n";

enum { LIVES = 500 }; /* inputs, until the stage is made anew */

typedef struct theatre {
    sl_mail mail;
    sl_reading reading;
    sl_stage *stage;
    char path[4096];
} theatre;

static void open_stage(theatre *t) {
    sl_error error;
    sl_stage_options o = {.scene_path = t->path, .reading = &t->reading, .settings = sl_settings_default()};
    o.folder = "/nonexistent";
    o.settings.method = "direct-radiance";
    o.settings.quality = SL_QUALITY_DRAFT;
    o.settings.width = o.settings.height = 16;
    o.settings.threads = 1;
    if (!sl_mail_open(&t->mail)) fuzz_fail("no lock");
    if (sl_stage_open(&o, &t->mail, &t->stage, &error) != SL_OK) fuzz_fail(error.message);
    sl_stage_take(t->stage, (sl_letter){1, SL_LETTER_JOINED, NULL});
}

static void close_stage(theatre *t) {
    sl_stage_close(t->stage);
    sl_mail_close(&t->mail);
}

/* What is written for viewers must be sound JSON, and name its kind. */
static void look_at_packets(theatre *t) {
    for (sl_packet *p = sl_mail_collect(&t->mail), *next; p; p = next) {
        next = p->next;
        if (p->slot < 0 && !p->ends) {
            cJSON *m = cJSON_ParseWithLength((const char *)p->bytes + SL_PACKET_ROOM, p->size);
            if (!cJSON_IsString(cJSON_GetObjectItem(m, "is"))) fuzz_fail("a message without its kind");
            cJSON_Delete(m);
        }
        free(p);
    }
}

static bool is_long_work(const char *what) {
    static const char *const left_out[] = {"keep",      "exact",      "method", "size",
                                           "reference", "difference", "error",  "passes"};
    for (size_t i = 0; i < sizeof left_out / sizeof left_out[0]; i++)
        if (strcmp(what, left_out[i]) == 0) return true;
    return false;
}

static void take_line(theatre *t, const char *line, size_t length) {
    const char *reason;
    char *text = malloc(length + 1); /* of that length alone, so that a read behind it is seen */
    if (!text) return;
    memcpy(text, line, length);
    text[length] = '\0';
    sl_host_is_ours(text, "127.0.0.1", 80);
    cJSON *message = sl_message_parse(text, length, &reason);
    if (!message && !reason) fuzz_fail("no message and no reason");
    if (message && !is_long_work(cJSON_GetObjectItem(message, "do")->valuestring))
        sl_stage_take(t->stage, (sl_letter){1, SL_LETTER_MESSAGE, message});
    else cJSON_Delete(message);
    free(text);
    look_at_packets(t);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static theatre t;
    static int lives;
    if (!t.path[0]) {
        fuzz_write("s.json", scene, strlen(scene));
        fuzz_write("s.obj", obj, strlen(obj));
        snprintf(t.path, sizeof t.path, "%s", fuzz_path("s.json"));
    }
    if (lives++ % LIVES == 0) open_stage(&t);
    for (size_t at = 0, end; at < size; at = end + 1) {
        for (end = at; end < size && data[end] != '\n';) end++;
        take_line(&t, (const char *)data + at, end - at);
    }
    sl_stage_step(t.stage);
    look_at_packets(&t);
    if (lives % LIVES == 0) close_stage(&t);
    return 0;
}
