#include "app/bench/references.h"

#include "app/same_file.h"
#include "cache/frame/all_light.h"
#include "cache/frame/method.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- where they are ---- */

void sl_reference_default_folder(char path[SL_BENCH_PATH]) {
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    if (cache && cache[0] == '/') snprintf(path, SL_BENCH_PATH, "%s/softlux/references", cache);
    else if (home && home[0]) snprintf(path, SL_BENCH_PATH, "%s/.cache/softlux/references", home);
    else snprintf(path, SL_BENCH_PATH, "softlux-references");
}

/* The paths may be named with options that change them: "matched:splatting --bounces 2". */
static void arguments_of(const sl_bench_scene *s, const char *transport, char arguments[SL_BENCH_ARGUMENTS]) {
    snprintf(arguments, SL_BENCH_ARGUMENTS, "%s -m path --transport %s", s->base ? s->base : "", transport);
}

static const uint32_t as_many_as_matter = UINT32_MAX - 1;

/* Takes away what there is not in a scene, since no path of it can meet that. */
static bool transport_of(const sl_bench_scene *s, const char *name, sl_transport *t) {
    sl_settings settings;
    char arguments[SL_BENCH_ARGUMENTS];
    unsigned lobes = SL_LOBE_DIFFUSE | (s->glossy ? SL_LOBE_GLOSSY : 0u) | (s->mirrors ? SL_LOBE_MIRROR : 0u);
    arguments_of(s, name, arguments);
    if (!sl_trial_settings(arguments, &settings) || sl_method_transport(&settings, t, NULL) != SL_OK)
        return false;
    if (!settings.bounces && sl_has_bounces(&settings)) t->bounces = as_many_as_matter;
    t->direct_lobes &= lobes;
    t->receiver_lobes &= lobes;
    t->bounce_lobes &= lobes;
    t->eye_mirrors = t->eye_mirrors && s->mirrors;
    t->sky_light = t->sky_light && s->sky;
    return true;
}

bool sl_reference_is_same(const sl_bench_scene *s, const char *name, const char *other) {
    sl_transport a, b;
    if (!transport_of(s, name, &a) || !transport_of(s, other, &b)) return false;
    return a.emission == b.emission && a.eye_mirrors == b.eye_mirrors && a.direct_lobes == b.direct_lobes &&
           a.receiver_lobes == b.receiver_lobes && a.bounce_lobes == b.bounce_lobes &&
           a.bounces == b.bounces && a.direct_visibility == b.direct_visibility &&
           a.bounce_visibility == b.bounce_visibility && a.sky_light == b.sky_light;
}

void sl_reference_path(const char *folder, const sl_bench_scene *s, const char *transport,
                       char path[SL_BENCH_PATH]) {
    /* whose files stand for others' of the same paths */
    static const char *const plain[] = {"full", "one-bounce", "direct"};
    char name[SL_BENCH_PATHS];
    snprintf(name, sizeof name, "%s", transport);
    for (size_t i = sizeof plain / sizeof *plain; i-- > 0;) {
        if (sl_reference_is_same(s, plain[i], transport)) snprintf(name, sizeof name, "%s", plain[i]);
    }
    if (s->base) snprintf(name + strlen(name), sizeof name - strlen(name), " %s", s->base);
    for (char *c = name; *c; c++) {
        if (*c == ':' || *c == ' ' || *c == '/') *c = '-';
    }
    snprintf(path, SL_BENCH_PATH, "%s/%s-%dx%d-%s-halves-%s.exr", folder, s->hash, s->width, s->height, name,
             SL_VERSION);
}

sl_status sl_reference_make(const sl_bench_options *o, const sl_bench_scene *s, uint64_t samples,
                            sl_bench_reference *r, sl_error *error) {
    enum { SEED = 24301 }; /* none that a trial has */
    const sl_child_limits limits = {0.0, 0, sl_interrupted};
    char arguments[SL_BENCH_ARGUMENTS], all[SL_BENCH_ARGUMENTS + 64];
    sl_child_end end;
    arguments_of(s, r->transport, arguments);
    snprintf(all, sizeof all, "%s --spp %" PRIu64 " --seed %d", arguments, samples, SEED);
    sl_trial_run run = {.arguments = all,
                        .scene_path = s->path,
                        .width = s->width,
                        .height = s->height,
                        .threads = (unsigned)o->reference_threads,
                        .picture = r->file,
                        .load = o->load};
    sl_status status = sl_make_folder(o->references, "reference.exr", error);
    if (status == SL_OK) status = sl_child_run(sl_trial_work, &run, &limits, &end, error);
    if (status != SL_OK) return status;
    snprintf(r->trouble, sizeof r->trouble, "%s", end.why);
    free(end.text);
    return SL_OK;
}
