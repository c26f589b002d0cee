/* What is kept: exact pictures, scenes, logs, pages and films, in one folder. Nothing that viewers say names
 * a file. */
#include "app/serve/stage_parts.h"

#include "app/clock.h"
#include "app/same_file.h"
#include "app/steps/run.h"
#include "base/error.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const double film_rate = 25.0, film_seconds = 60.0, most_bytes = 0x1p31;

/* ---- names ---- */

/* A name in the folder that no file has; the folder is made. ending: "-%u.png" and the like. */
static sl_status new_name(sl_stage *s, const char *stem, const char *ending, char path[4096],
                          sl_error *error) {
    enum { MOST = 100000 };
    sl_status status = sl_make_folder(s->options.folder, "scene.json", error);
    if (status != SL_OK) return status;
    if (s->kept.bytes > most_bytes)
        return sl_fail(error, SL_ERROR_RESOURCES, "2 GiB have been kept, which is the most");
    do {
        s->kept.number++;
        snprintf(path, 4096, "%.3800s/%s-%u%s", s->options.folder, stem, s->kept.number, ending);
    } while (access(path, F_OK) == 0 && s->kept.number < MOST);
    return SL_OK;
}

static double bytes_of(const char *path) {
    struct stat found;
    return stat(path, &found) == 0 ? (double)found.st_size : 0.0;
}

/* Adds a file's address. */
static void add_address(sl_stage *s, cJSON *m, const char *name, const char *path) {
    char address[200];
    const size_t number = sl_mail_offer(s->mail, path);
    s->kept.bytes += bytes_of(path);
    if (number == SL_FILES) return;
    snprintf(address, sizeof address, "/kept/%s/%zu", s->options.token ? s->options.token : "", number);
    cJSON_AddStringToObject(m, name, address);
}

static void tell_kept(sl_stage *s, const char *what, const char *path) {
    cJSON *m = sl_message("kept");
    const char *slash = strrchr(path, '/');
    cJSON_AddStringToObject(m, "what", what);
    cJSON_AddStringToObject(m, "name", slash ? slash + 1 : path);
    cJSON_AddNumberToObject(m, "bytes", bytes_of(path));
    add_address(s, m, "href", path);
    sl_say(s, 0, m);
}

/* ---- the command line ---- */

/* As a shell wants it. */
static void put_word(FILE *out, const char *word) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./=,:+@";
    if (*word && strspn(word, plain) == strlen(word)) {
        fprintf(out, " %s", word);
        return;
    }
    fputs(" '", out);
    for (; *word; word++) fputs(*word == '\'' ? "'\\''" : (char[]){*word, '\0'}, out);
    fputc('\'', out);
}

static void put_settings(FILE *out, const sl_settings *settings) {
    cJSON *given = sl_describe_settings(settings), *item;
    cJSON_ArrayForEach(item, given) {
        char word[200];
        snprintf(word, sizeof word, "%s=%s", item->string, item->valuestring);
        if (strcmp(item->string, "quality") == 0) fprintf(out, " -q %s", item->valuestring);
        else fputs(" --set", out), put_word(out, word);
    }
    cJSON_Delete(given);
}

static void write_command(sl_stage *s) {
    const sl_exact_job *j = &s->kept.job;
    FILE *out = fmemopen(s->kept.command, sizeof s->kept.command, "w");
    if (!out) return;
    fputs("softlux render", out);
    put_word(out, j->scene_path);
    fprintf(out, " -m %s -s %dx%d", j->settings.method, j->settings.width, j->settings.height);
    put_settings(out, &j->settings);
    fputs(" -o", out);
    put_word(out, j->exr);
    fclose(out);
}

/* ---- exact pictures ---- */

/* The file is the scene's own as long as nothing has happened to it, and nothing but its name says how it is
 * read. */
static sl_status choose_scene(sl_stage *s, sl_exact_job *j, sl_error *error) {
    const sl_world *w = &s->world;
    const sl_reading *r = w->reading;
    if (!w->count && w->first_time == 0.0 && !r->load.view && !r->load.allow_outside && !r->load.up_axis) {
        snprintf(j->scene_path, sizeof j->scene_path, "%s", w->path);
        return SL_OK;
    }
    const bool written = *s->kept.scene_path && s->kept.scene_event == w->count;
    sl_status status = written ? SL_OK : new_name(s, "scene", ".json", s->kept.scene_path, error);
    if (status == SL_OK && !written) status = sl_scene_write(w->scene, s->kept.scene_path, error);
    if (status != SL_OK) s->kept.scene_path[0] = '\0';
    s->kept.scene_event = w->count;
    memcpy(j->scene_path, s->kept.scene_path, sizeof j->scene_path);
    return status;
}

static sl_status begin(sl_stage *s, int side, const char *what, sl_error *error) {
    sl_exact_job *j = &s->kept.job;
    *j = (sl_exact_job){.settings = s->side[side].settings};
    sl_status status = choose_scene(s, j, error);
    if (status == SL_OK && strcmp(what, "page") == 0) {
        status = new_name(s, "page", ".html", j->page, error);
        j->settings.filter = SL_FILTER_CENTRE;
        sl_steps_size(j->settings.width, j->settings.height, &j->settings);
    } else if (status == SL_OK) {
        status = new_name(s, "exact", ".exr", j->exr, error);
        snprintf(j->png, sizeof j->png, "%.*s.png", (int)strlen(j->exr) - 4, j->exr);
    }
    if (status != SL_OK) return status;
    s->kept.side = side;
    s->kept.what = what;
    s->kept.command[0] = '\0';
    if (*j->exr) write_command(s);
    sl_worker_exact(s->worker, j);
    return SL_OK;
}

sl_status sl_take_exact(sl_stage *s, sl_taking *t) {
    const int side = sl_take_side(t);
    const bool on = sl_take_flag(t, "on", true);
    if (t->status != SL_OK) return t->status;
    if (on && !s->side[side].wanted)
        return sl_fail(t->error, SL_ERROR_USAGE, "exact: that side shows nothing");
    if (on) return begin(s, side, "exact", t->error);
    s->kept.what = NULL;
    sl_worker_exact(s->worker, NULL);
    return SL_OK;
}

static void tell_exact(sl_stage *s, const sl_work_done *done) {
    cJSON *m = sl_message_of_side("exact", s->kept.side);
    cJSON_AddNumberToObject(m, "fraction", done->fraction);
    cJSON_AddBoolToObject(m, "done", done->exact_done);
    cJSON_AddStringToObject(m, "command", s->kept.command);
    if (done->exact) {
        add_address(s, m, "exr", s->kept.job.exr);
        add_address(s, m, "png", s->kept.job.png);
    }
    sl_say(s, 0, m);
}

static void finish_exact(sl_stage *s, const sl_work_done *done) {
    const sl_exact_job *j = &s->kept.job;
    if (done->exact) {
        sl_tone tone = s->tone;
        sl_show(s, SL_FRAME_EXACT, (unsigned)s->kept.side, done->exact, &tone, s->world.count, true);
    }
    if (strcmp(s->kept.what, "exact") != 0)
        tell_kept(s, s->kept.what, *j->page ? j->page : strcmp(s->kept.what, "png") == 0 ? j->png : j->exr);
    s->kept.what = NULL;
}

static void take_exact(sl_stage *s, const sl_work_done *done) {
    const double now = sl_seconds_now();
    if (!s->kept.what || (!done->exact_done && !done->exact_error.status && now - s->kept.told < 0.2)) return;
    s->kept.told = now;
    if (done->exact_error.status) {
        sl_say(s, 0, sl_refusal(s->kept.what, &done->exact_error));
        s->kept.what = NULL;
        return;
    }
    tell_exact(s, done);
    if (done->exact_done) finish_exact(s, done);
}

/* ---- what else the worker does ---- */

static void show_reference(sl_stage *s, const sl_work_done *done) {
    sl_tone tone = s->tone;
    if (!done->reference || !s->reference) return;
    sl_show(s, SL_FRAME_REFERENCE, 0, done->reference, &tone, s->world.count, done->reference_done);
    cJSON *m = sl_message("reference");
    cJSON_AddNumberToObject(m, "samples", (double)done->samples);
    cJSON_AddBoolToObject(m, "done", done->reference_done);
    sl_say(s, 0, m);
}

static void tell_error(sl_stage *s, int side, const sl_work_done *done) {
    cJSON *m = sl_message_of_side("error", side);
    cJSON_AddNumberToObject(m, "seconds", sl_seconds_now() - s->side[side].began);
    cJSON_AddNumberToObject(m, "error", done->side[side].error);
    sl_say(s, 0, m);
}

void sl_work_step(sl_stage *s) {
    sl_work_done done;
    sl_tone plain = {SL_TONE_CLIP, 0.0f, false};
    if (!sl_worker_take(s->worker, &done)) return;
    if (done.exact_news) take_exact(s, &done);
    show_reference(s, &done);
    for (int i = 0; i < SL_SIDES; i++) {
        const struct sl_work_side *d = &done.side[i];
        if (d->difference && s->difference)
            sl_show(s, SL_FRAME_DIFFERENCE, (unsigned)i, d->difference, &plain, s->side[i].shown, true);
        if (d->map && s->error)
            sl_show(s, SL_FRAME_ERROR, (unsigned)i, d->map, &plain, s->side[i].shown, true);
        if (d->judged && (s->error || s->difference)) tell_error(s, i, &done);
    }
    sl_work_forget(&done);
}

/* ---- films ---- */

static sl_status begin_film(sl_stage *s, sl_error *error) {
    const sl_settings *o = &s->side[0].settings;
    sl_status status = new_name(s, "film", ".y4m", s->kept.film_path, error);
    if (status == SL_OK)
        status = sl_show_files_open(&s->kept.film, s->kept.film_path, o->width, o->height, film_rate, error);
    s->kept.films = status == SL_OK;
    s->kept.film_began = sl_seconds_now();
    return status;
}

void sl_film_end(sl_stage *s, bool told) {
    sl_error error;
    if (!s->kept.films) return;
    s->kept.films = false;
    const bool well = s->kept.film.written > 0;
    const sl_status status = sl_show_files_close(&s->kept.film, well, &error);
    if (status == SL_OK && well && told) tell_kept(s, "film", s->kept.film_path);
}

/* Each is shown until the next one comes. */
void sl_film_frame(sl_stage *s, const sl_image *frame) {
    sl_error error;
    if (!s->kept.films) return;
    const double took = sl_seconds_now() - s->kept.film_began;
    const uint64_t due = 1 + (uint64_t)(took * film_rate), written = s->kept.film.written;
    sl_tone tone = s->tone;
    if (due > written &&
        sl_show_files_write(&s->kept.film, frame, &tone, false, due - written, &error) != SL_OK)
        sl_film_end(s, false);
    if (took > film_seconds) sl_film_end(s, true);
}

/* ---- keep ---- */

/* "scene" or "log". */
static sl_status keep_text(sl_stage *s, const char *what, sl_error *error) {
    char path[4096];
    sl_status status = new_name(s, what, ".json", path, error);
    if (status == SL_OK)
        status = strcmp(what, "scene") == 0 ? sl_scene_write(s->world.scene, path, error)
                                            : sl_log_write(s, path, error);
    if (status == SL_OK) tell_kept(s, what, path);
    return status;
}

static sl_status keep_film(sl_stage *s, sl_error *error) {
    if (!s->kept.films) return begin_film(s, error);
    sl_film_end(s, true);
    return SL_OK;
}

static sl_status keep_exact(sl_stage *s, const char *what, sl_error *error) {
    if (s->kept.what) return sl_fail(error, SL_ERROR_USAGE, "keep: %s is being made", s->kept.what);
    return begin(s, 0, what, error);
}

sl_status sl_take_keep(sl_stage *s, sl_taking *t) {
    static const char *const made[] = {"png", "exr", "page"};
    const char *what = sl_take_text(t, "what", "");
    if (t->status != SL_OK) return t->status;
    if (strcmp(what, "scene") == 0 || strcmp(what, "log") == 0) return keep_text(s, what, t->error);
    if (strcmp(what, "film") == 0) return keep_film(s, t->error);
    for (size_t i = 0; i < sizeof made / sizeof made[0]; i++)
        if (strcmp(what, made[i]) == 0) return keep_exact(s, made[i], t->error);
    return sl_take_all(t, false, "what", "png, exr, scene, log, page or film");
}
