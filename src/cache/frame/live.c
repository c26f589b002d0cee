/* Two loops side by side: a thread updates the method, the caller's shows frames (the Shading Cache's section
 * on the system's components).
 *
 *   caller   move ── copy of the scene ── frame ── frame ── move ── frame ...   never waits for an update
 *                 ╲ asked             ╱ versions
 *   thread   follow: scene, edit ── update ── update ── follow ...              rests when all is refined
 *
 * They meet under one lock, held for a few assignments: where things are to be, and how far updates have
 * come. Shading goes from one to the other in the display's two copies (patches/display/window.c); of methods
 * without such a display, in pictures that are handed over whole. */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/thread.h"
#include "cache/frame/antialias.h"
#include "cache/frame/live.h"
#include "cache/frame/method.h"
#include "scene/animation.h"
#include "scene/copy.h"

/* A change that updates have not followed yet: the caller's, or where `told` names nothing a move. */
typedef struct waiting {
    sl_live_change told;
    sl_pose there;
} waiting;

/* A move that waits for its change to show: the first of those that do. */
typedef struct change {
    bool waits;
    double time;     /* the scene's */
    uint64_t frames; /* that were drawn before it */
} change;

enum { VISITS = 4 };
typedef struct visit {
    sl_live_visitor *visitor;
    void *context;
} visit;

struct sl_live {
    sl_live_opening *opening; /* of a show that follows */
    void *opening_context;
    sl_settings settings; /* as asked, then of the method */
    sl_scene *scene;   /* the thread's, while it runs; the caller's is the copy */
    sl_method *method; /* likewise */
    sl_thread thread;
    bool runs;
    atomic_bool ended; /* the updates have */

    sl_scene *scene_copy;
    const char *reduced; /* the method's */
    bool draws;         /* the method has a display, whose window may be still to come */
    bool follows;       /* the copy is the caller's, and so are all moves */
    sl_monitor drawing; /* held while a window draws, and while changes may take its method away */
    void *window;       /* NULL: the method has none */
    sl_image *frame;
    bool smooths;        /* edges: centres were not asked for */
    sl_antialias *edges; /* of frames, or of pictures; made with the first one */
    sl_pose shown;
    uint64_t told, seen; /* numbers of changes: of the newest; of the newest in the frame */
    sl_live_state state;
    sl_counters counters; /* of frames */
    sl_counters smoothing; /* of pictures: by the thread */

    sl_monitor meeting; /* guards what follows */
    bool stop;
    /* by moves that the thread has not taken yet; by what updates have made of those that it took */
    change moved, found;
    uint64_t changes_found;
    sl_progress progress;
    double error_levels, samples;
    sl_counters counted; /* by the method */
    double rate;         /* to be told of; 0: none is */
    sl_live_event *log;
    size_t events, log_room;
    waiting *waiting;
    size_t changes, change_room;
    sl_live_turn *turns;
    size_t turn_count, turn_room;
    uint64_t turn;
    uint64_t changed, picture_changed; /* the number of the newest change followed; the picture's */
    visit visits[VISITS]; /* that wait, in order */
    size_t visit_count;
    bool rest;
    bool blind;        /* the method's state is another one than the window's */
    sl_image *picture; /* the newest, not taken yet; NULL: none */
    double time, picture_time; /* of the move that updates are at; the picture's */
    uint64_t pictures;
    sl_error error;    /* of the thread: its status not SL_OK, it has ended */
};

/* ---- poses ----------------------------------------------------------------------------------- */

static bool same_camera(const sl_camera *a, const sl_camera *b) {
    return memcmp(a, b, sizeof *a) == 0; /* floats alone: no gaps */
}

sl_status sl_pose_take(const void *pose, sl_scene *scene, unsigned *changes, sl_error *error) {
    const sl_pose *p = pose;
    const sl_camera before = scene->camera;
    uint64_t version = scene->version, changed[SL_CHANGES];
    memcpy(changed, scene->changed, sizeof changed);
    *changes = 0;
    sl_status status = p->timed ? sl_scene_set_time(scene, p->time, changes, error) : SL_OK;
    if (status != SL_OK) return status;
    if (p->looks) scene->camera = p->camera;
    *changes &= ~(unsigned)SL_CHANGED_CAMERA;
    if (!same_camera(&before, &scene->camera)) *changes |= SL_CHANGED_CAMERA;
    /* keyframes may have moved a camera that nobody looks through */
    memcpy(scene->changed, changed, sizeof changed);
    scene->version = version;
    sl_scene_has_changed(scene, *changes);
    return SL_OK;
}

/* ---- the thread ------------------------------------------------------------------------------ */

static sl_status note(sl_live *l, bool rate, double value, sl_error *error) {
    sl_monitor_enter(&l->meeting);
    bool fits = sl_make_room(&l->log, l->events, &l->log_room, sizeof *l->log);
    if (fits) l->log[l->events++] = (sl_live_event){l->method->progress.batches, rate, value};
    sl_monitor_leave(&l->meeting);
    return fits ? SL_OK : sl_fail_memory(error, "the log of a live show");
}

static sl_status take_rate(sl_live *l, sl_error *error) {
    sl_monitor_enter(&l->meeting);
    double rate = l->rate;
    l->rate = 0.0;
    sl_monitor_leave(&l->meeting);
    if (!(rate > 0.0)) return SL_OK;
    sl_status status = note(l, true, rate, error);
    return status == SL_OK ? sl_method_rate(l->method, rate, error) : status;
}

static bool rests(const sl_live *l) { return l->rest || (l->progress.done && !l->changes); }

/* Waits while there is nothing to do; false: it is to end. */
static bool next_turn(sl_live *l) {
    sl_monitor_enter(&l->meeting);
    while (!l->stop && l->error.status == SL_OK && (l->blind || (!l->visit_count && rests(l))))
        sl_monitor_wait(&l->meeting);
    bool goes_on = !l->stop && l->error.status == SL_OK;
    sl_monitor_leave(&l->meeting);
    return goes_on;
}

/* Takes the changes that wait, the caller's to free, and notes their turn. */
static sl_status take_changes(sl_live *l, waiting **taken, size_t *count, change *moved, sl_error *error) {
    sl_monitor_enter(&l->meeting);
    bool fits = true;
    *taken = l->waiting;
    *count = l->changes;
    if (!moved->waits) *moved = l->moved;
    l->moved.waits = false;
    l->progress.done = l->progress.done && !l->changes;
    l->turn += l->changes > 0;
    for (size_t i = 0; i < l->changes && fits; i++) {
        fits = sl_make_room(&l->turns, l->turn_count, &l->turn_room, sizeof *l->turns);
        l->changed = l->waiting[i].told.number;
        if (fits)
            l->turns[l->turn_count++] = (sl_live_turn){l->method->progress.batches, l->turn, l->changed};
    }
    l->waiting = NULL;
    l->changes = l->change_room = 0;
    sl_monitor_leave(&l->meeting);
    return fits ? SL_OK : sl_fail_memory(error, "the log of a live show");
}

/* *anew: the window must be made anew before the next update. */
static sl_status make_changes(sl_live *l, const waiting *taken, size_t count, bool *anew, sl_error *error) {
    const unsigned states = l->method->states;
    unsigned all = 0;
    sl_status status = SL_OK;
    for (const waiting *w = taken; status == SL_OK && w < taken + count; w++) {
        unsigned changes = 0;
        status = w->told.make(w->told.what ? w->told.what : &w->there, l->scene, &changes, error);
        l->time = w->there.time;
        all |= changes;
    }
    if (status == SL_OK && all && !l->follows) status = note(l, false, l->time, error);
    if (status == SL_OK && all) status = sl_method_edit(l->method, all, error);
    *anew = l->window && l->method->states != states;
    if (!*anew) return status;
    sl_monitor_enter(&l->meeting);
    l->blind = true;
    sl_monitor_leave(&l->meeting);
    return status;
}

/* *any: there were some. */
static sl_status follow_changes(sl_live *l, change *moved, bool *any, bool *anew, sl_error *error) {
    waiting *taken;
    size_t count;
    sl_status status = take_changes(l, &taken, &count, moved, error);
    *any = count > 0;
    if (*any && status == SL_OK) {
        if (l->follows) sl_monitor_enter(&l->drawing);
        status = make_changes(l, taken, count, anew, error);
        if (l->follows) sl_monitor_leave(&l->drawing);
    }
    sl_free(taken);
    return status;
}

static void be_visited(sl_live *l, sl_method *method) {
    visit taken[VISITS];
    sl_monitor_enter(&l->meeting);
    const size_t count = l->visit_count;
    memcpy(taken, l->visits, sizeof taken);
    l->visit_count = 0;
    sl_monitor_leave(&l->meeting);
    for (size_t i = 0; i < count; i++) taken[i].visitor(taken[i].context, method);
}

/* Tells whether a move's change of light shows: methods with a display count it themselves, others
 * show whole light when their picture is finished. */
static bool shows_change(const sl_live *l, uint64_t shown_before, const sl_progress *progress) {
    if (!l->window) return progress->frame_done;
    return sl_method_counters(l->method)->value[SL_COUNT_CHANGES_SHOWN] > shown_before;
}

/* A display shows what there is; pictures take its place where the method has none, and are shown whole. */
static bool shows(const sl_live *l, const sl_progress *progress) {
    if (l->window || progress->frame_done) return true;
    if (l->follows && l->method->class->any_transport) return true; /* noisy, and at once */
    return l->method->class->shows && l->method->class->shows(l->method->state);
}

/* Tells whether what is shown are the scene's triangles: neither a tracer's noise nor patches of curved
 * surfaces. */
static bool has_edges(const sl_method *m) {
    return !m->class->any_transport && !(m->class->window && m->scene->bicubic_count);
}

/* scene: that the window, or where there is none the method, shows. */
static sl_status smooth(sl_live *l, const sl_scene *scene, unsigned threads, sl_image *picture,
                        sl_counters *counters, sl_error *error) {
    const sl_method *m = l->method;
    if (!l->smooths || !has_edges(m)) return SL_OK;
    const sl_raster *raster = l->window ? NULL : sl_method_raster(m);
    const uint32_t *id = l->window ? m->class->window->ids(l->window)
                         : m->class->ids ? m->class->ids(m->state)
                                         : NULL;
    sl_status status =
        l->edges ? SL_OK : sl_antialias_create(picture->width, picture->height, &l->edges, error);
    if (status != SL_OK) return status;
    return sl_antialias_edges(l->edges, scene, raster, id, threads, picture, counters, error);
}

/* R, G, B alone: a picture's layers take several times that, and three pictures are there at a time. */
static sl_status resolve(sl_live *l, sl_image **frame, sl_error *error) {
    *frame = NULL;
    if (l->window) return SL_OK;
    sl_status status = sl_method_resolve_colours(l->method, frame, error);
    if (status == SL_OK && !l->method->class->window)
        status = smooth(l, l->scene, l->method->settings.threads, *frame, &l->smoothing, error);
    return status;
}

/* moved: what the update has brought; NULL: nothing of the kind. */
static void tell(sl_live *l, const change *moved, const sl_progress *progress, sl_image *picture,
                 sl_status status, const sl_error *error) {
    const sl_method_class *class = l->method->class;
    const void *state = l->method->state; /* NULL: an edit that was to make all anew has failed */
    double levels = state && class->error_levels ? class->error_levels(state) : -1.0;
    double samples = state && class->samples ? class->samples(state) : 0.0;
    sl_image *old = NULL;
    sl_monitor_enter(&l->meeting);
    l->progress = *progress;
    l->error_levels = levels;
    l->samples = samples;
    l->counted = *sl_method_counters(l->method);
    if (moved && !l->found.waits) l->found = *moved;
    if (moved) l->changes_found++;
    if (picture) {
        old = l->picture;
        l->picture = picture;
        l->picture_time = l->time;
        l->picture_changed = l->changed;
        l->pictures++;
    }
    if (status != SL_OK) l->error = *error;
    sl_monitor_leave(&l->meeting);
    sl_image_destroy(old);
}

/* Beside the method: the copy; the frame that is shown, the one that waits and the one that is made (a
 * display's is the method's picture); edges; and two of a byte a value for whoever writes them. */
static double bytes_of_show(const sl_scene *scene, const sl_settings *settings) {
    enum { FRAME = 12, WRITTEN = 6 };
    return (double)sl_scene_copy_bytes(scene) +
           (double)settings->width * (double)settings->height *
               (3 * FRAME + SL_ANTIALIAS_BYTES + WRITTEN);
}

static sl_status make_method(sl_live *l, sl_error *error) {
    sl_method *made;
    const sl_settings asked = l->settings;
    sl_status status = sl_live_choose(l->scene, &asked, &l->settings, error);
    if (status == SL_OK)
        status = sl_method_create_beside(l->scene, &l->settings, bytes_of_show(l->scene, &l->settings), &made,
                                         error);
    if (status != SL_OK) return status;
    sl_monitor_enter(&l->drawing);
    sl_monitor_enter(&l->meeting);
    l->method = made;
    l->blind = made->class->window != NULL;
    sl_monitor_leave(&l->meeting);
    sl_monitor_leave(&l->drawing);
    return SL_OK;
}

/* The method of a show that follows; false: there is none. */
static bool open_show(sl_live *l) {
    sl_error error = {0};
    sl_status status = l->opening(l->opening_context, &l->scene, &error);
    if (status == SL_OK) status = make_method(l, &error);
    if (status == SL_OK) return true;
    sl_monitor_enter(&l->meeting);
    l->error = error;
    sl_monitor_leave(&l->meeting);
    return false;
}

static void update_on_and_on(sl_live *l) {
    change moved = {.waits = false};
    sl_progress progress = {0};
    bool shown = true; /* some picture since the last change that was followed */
    while (next_turn(l)) {
        sl_error error = {0};
        sl_image *picture = NULL;
        uint64_t changes = sl_method_counters(l->method)->value[SL_COUNT_CHANGES_SHOWN];
        bool changed = false, anew = false;
        be_visited(l, l->method);
        sl_status status = shown ? follow_changes(l, &moved, &changed, &anew, &error) : SL_OK;
        shown = shown && !changed;
        if (status == SL_OK) status = take_rate(l, &error);
        if (status == SL_OK && anew) continue;
        if (status == SL_OK) status = sl_method_update(l->method, &progress, &error);
        if (status == SL_OK && shows(l, &progress)) {
            status = resolve(l, &picture, &error);
            shown = true;
        }
        bool brought = status == SL_OK && moved.waits && shows_change(l, changes, &progress);
        tell(l, brought ? &moved : NULL, &progress, picture, status, &error);
        if (status != SL_OK) return;
        if (brought || progress.done) moved.waits = false; /* or it has changed nothing that is seen */
    }
}

static void update_thread(void *context) {
    sl_live *l = context;
    if (!l->opening || open_show(l)) update_on_and_on(l);
    l->ended = true; /* whoever asks for a visit behind that is refused */
    be_visited(l, NULL);
}

/* ---- life ------------------------------------------------------------------------------------ */

void sl_live_leave(sl_live *l) {
    sl_monitor_enter(&l->meeting);
    l->stop = true;
    sl_monitor_signal(&l->meeting);
    sl_monitor_leave(&l->meeting);
}

bool sl_live_has_ended(const sl_live *l) { return l->ended; }

uint64_t sl_live_halt(sl_live *l) {
    if (l->runs) {
        sl_live_leave(l);
        sl_thread_join(&l->thread);
    }
    l->runs = false;
    return l->changed;
}

void sl_live_stop(sl_live *l, sl_counters *counters) {
    if (counters) *counters = (sl_counters){0};
    if (!l) return;
    sl_live_halt(l);
    if (counters && l->method) {
        *counters = *sl_method_counters(l->method);
        sl_counters_add(counters, &l->counters);
        sl_counters_add(counters, &l->smoothing);
    }
    sl_antialias_destroy(l->edges);
    if (l->window) l->method->class->window->destroy(l->window);
    sl_method_destroy(l->method);
    if (!l->follows) sl_scene_copy_destroy(l->scene_copy);
    sl_free(l->waiting);
    sl_free(l->turns);
    sl_image_destroy(l->frame);
    sl_image_destroy(l->picture);
    sl_free(l->log);
    sl_monitor_close(&l->drawing);
    sl_monitor_close(&l->meeting);
    sl_free(l);
}

/* Splatting shows what it has after so many new ones. */
enum { RECORDS_PER_FRAME = 256 };

sl_status sl_live_choose(const sl_scene *scene, const sl_settings *asked, sl_settings *own, sl_error *error) {
    sl_transport ignored;
    sl_status status = sl_method_choose(scene, asked, own, &ignored, NULL, error);
    own->shading_cache.frames_per_update = 1; /* the schedule that frames and updates have without a clock */
    /* as long as anything is above the stop size */
    if (!asked->shading_cache.updates) own->shading_cache.updates = 1000000000;
    own->filter = SL_FILTER_CENTRE; /* frames are drawn beside updates, once each */
    if (!own->records_per_frame) own->records_per_frame = RECORDS_PER_FRAME;
    return status;
}

/* Frames beside updates are the calling thread's alone, but where somebody waits for them. */
static unsigned drawers(const sl_live *l) {
    const unsigned threads = sl_thread_count(l->method->settings.threads);
    return l->follows && threads > 1 ? 2 : 1;
}

/* The method's state was made anew, and no update is under way. */
static sl_status renew_window(sl_live *l, sl_error *error) {
    if (l->window) l->method->class->window->destroy(l->window);
    l->window = NULL;
    sl_status status =
        l->method->class->window->create(l->method->state, l->scene_copy, drawers(l), &l->window, error);
    sl_monitor_enter(&l->meeting);
    l->blind = false;
    if (status != SL_OK) l->error = *error;
    sl_monitor_signal(&l->meeting);
    sl_monitor_leave(&l->meeting);
    return status;
}

static sl_status begin_at_once(sl_live *l, sl_error *error) {
    sl_status status = make_method(l, error);
    if (status == SL_OK) status = sl_scene_copy(l->scene, &l->scene_copy, error);
    if (status != SL_OK) return status;
    const sl_settings *own = &l->method->settings;
    l->reduced = l->method->reduced;
    l->settings.width = own->width, l->settings.height = own->height;
    return l->blind ? renew_window(l, error) : SL_OK;
}

static sl_status begin(sl_live *l, const sl_settings *settings, sl_error *error) {
    l->settings = *settings;
    l->smooths = settings->filter != SL_FILTER_CENTRE;
    sl_status status = l->follows ? SL_OK : begin_at_once(l, error);
    if (status == SL_OK)
        status = sl_image_create(l->settings.width, l->settings.height, 3, NULL, &l->frame, error);
    if (status != SL_OK) return status;
    l->runs = sl_thread_start(&l->thread, update_thread, l);
    return l->runs ? SL_OK : sl_fail(error, SL_ERROR_RESOURCES, "no thread could be had for updates");
}

/* as: its scenes, and who opens it. */
static sl_status start(const sl_live *as, const sl_settings *settings, sl_live **live, sl_error *error) {
    if (!live) return sl_fail_null(error, "a place for a live show");
    *live = NULL;
    if (!(as->scene || as->scene_copy) || !settings) return sl_fail_null(error, "a scene and settings");
    sl_live *l = sl_copy_of(as, 1, sizeof *l);
    if (!l) return sl_fail_memory(error, "a live show");
    const bool meets = sl_monitor_open(&l->meeting), draws = meets && sl_monitor_open(&l->drawing);
    if (!draws) {
        if (meets) sl_monitor_close(&l->meeting);
        sl_free(l);
        return sl_fail(error, SL_ERROR_RESOURCES, "no lock could be had for a live show");
    }
    l->reduced = "";
    l->error_levels = -1.0;
    sl_status status = begin(l, settings, error);
    if (status == SL_OK) *live = l;
    else sl_live_stop(l, NULL);
    return status;
}

sl_status sl_live_start(sl_scene *scene, const sl_settings *settings, sl_live **live, sl_error *error) {
    return start(&(sl_live){.scene = scene}, settings, live, error);
}

sl_status sl_live_start_beside(sl_live_opening *opening, void *context, sl_scene *shown,
                               const sl_settings *settings, sl_live **live, sl_error *error) {
    const sl_live as = {
        .opening = opening, .opening_context = context, .scene_copy = shown, .follows = true};
    return start(&as, settings, live, error);
}

const char *sl_live_reduction(const sl_live *l) { return l->reduced; }

/* ---- moves, and other changes ---------------------------------------------------------------- */

static bool add_change(sl_live *l, const waiting *more) {
    waiting *last = l->changes ? &l->waiting[l->changes - 1] : NULL;
    if (last && more->told.kind && last->told.kind == more->told.kind) {
        *last = *more;
        return true;
    }
    if (!sl_make_room(&l->waiting, l->changes, &l->change_room, sizeof *more)) return false;
    l->waiting[l->changes++] = *more;
    return true;
}

/* A window that is another state's will be made anew with the next frame. */
static sl_status move_window(sl_live *l, sl_error *error) {
    sl_monitor_enter(&l->drawing);
    sl_status status = l->blind ? SL_OK : l->method->class->window->move(l->window, error);
    sl_monitor_leave(&l->drawing);
    return status;
}

/* Tells the window, and the thread, of what has been done to the copy; or why there is no use in going on: a
 * window that could not follow shows nothing any more. */
static sl_status hand_on(sl_live *l, const waiting *w, unsigned changes, sl_error *error) {
    /* a display follows the eye itself */
    const bool shades = changes & ~(l->follows || l->window ? (unsigned)SL_CHANGED_CAMERA : 0u);
    sl_error why = {0};
    sl_status status =
        l->window && (changes & (SL_CHANGED_OBJECTS | SL_CHANGED_KINDS)) ? move_window(l, &why) : SL_OK;
    l->told = w->told.number;
    sl_monitor_enter(&l->meeting);
    if (!add_change(l, w) && status == SL_OK) status = sl_fail_memory(&why, "changes of a live show");
    if (shades && !l->moved.waits) l->moved = (change){true, w->there.time, l->state.frames};
    if (l->error.status == SL_OK && status != SL_OK) l->error = why;
    sl_monitor_signal(&l->meeting);
    sl_monitor_leave(&l->meeting);
    if (status != SL_OK && error) *error = why;
    return status;
}

sl_status sl_live_follow(sl_live *l, const sl_live_change *c, unsigned changes, sl_error *error) {
    if (!l || !c) return sl_fail_null(error, "a live show and a change");
    return hand_on(l, &(waiting){.told = *c}, changes, error);
}

/* The copy follows at once. A later move takes the place of one that waits. */
static sl_status go(sl_live *l, const sl_pose *there, sl_error *error) {
    enum { MOVE = 1 };
    unsigned changes = 0;
    sl_status status = sl_pose_take(there, l->scene_copy, &changes, error);
    if (status != SL_OK) return status;
    l->shown = *there;
    return hand_on(l, &(waiting){{sl_pose_take, NULL, l->told + 1, MOVE}, *there}, changes, error);
}

sl_status sl_live_move(sl_live *l, double time_seconds, sl_error *error) {
    if (!l) return sl_fail_null(error, "a live show");
    sl_status status = sl_scene_check_time(l->scene_copy, time_seconds, error);
    if (status != SL_OK) return status;
    sl_pose there = l->shown;
    there.timed = true;
    there.time = time_seconds;
    return go(l, &there, error);
}

sl_status sl_live_look(sl_live *l, const float eye[3], const float target[3], const float up[3],
                       float vertical_fov_rad, sl_error *error) {
    if (!l || !eye || !target || !up) return sl_fail_null(error, "a live show and three vectors");
    sl_camera camera = l->scene_copy->camera;
    sl_status status = sl_camera_take(&camera, eye, target, up, vertical_fov_rad, error);
    if (status != SL_OK) return status;
    sl_pose there = l->shown;
    there.looks = true;
    there.camera = camera;
    return go(l, &there, error);
}

sl_status sl_live_rate(sl_live *l, double samples_a_second, sl_error *error) {
    if (!l) return sl_fail_null(error, "a live show");
    sl_status status = sl_rate_check(samples_a_second, error);
    if (status != SL_OK) return status;
    sl_monitor_enter(&l->meeting);
    l->rate = samples_a_second;
    sl_monitor_leave(&l->meeting);
    return SL_OK;
}

/* Gives the first `room` things of a list, and returns how many there are. */
static size_t give(void *to, size_t room, const void *list, size_t count, size_t size) {
    const size_t given = count < room ? count : room;
    if (to && given) memcpy(to, list, given * size);
    return count;
}

size_t sl_live_log(sl_live *l, sl_live_event *events, size_t room) {
    if (!l) return 0;
    sl_monitor_enter(&l->meeting);
    const size_t count = give(events, room, l->log, l->events, sizeof *events);
    sl_monitor_leave(&l->meeting);
    return count;
}

uint64_t sl_live_shows(const sl_live *l) { return l->seen; }

size_t sl_live_turns(sl_live *l, sl_live_turn *turns, size_t room, uint64_t *updates) {
    sl_monitor_enter(&l->meeting);
    if (updates) *updates = l->progress.batches;
    const size_t count = give(turns, room, l->turns, l->turn_count, sizeof *turns);
    sl_monitor_leave(&l->meeting);
    return count;
}

bool sl_live_visit(sl_live *l, sl_live_visitor *visitor, void *context) {
    sl_monitor_enter(&l->meeting);
    const bool fits = l->visit_count < VISITS && !l->ended;
    if (fits) l->visits[l->visit_count++] = (visit){visitor, context};
    if (fits) sl_monitor_signal(&l->meeting);
    sl_monitor_leave(&l->meeting);
    return fits;
}

void sl_live_counters(sl_live *l, sl_counters *counters) {
    sl_monitor_enter(&l->meeting);
    *counters = l->counted;
    sl_monitor_leave(&l->meeting);
}

void sl_live_rest(sl_live *l, bool rest) {
    sl_monitor_enter(&l->meeting);
    l->rest = rest;
    sl_monitor_signal(&l->meeting);
    sl_monitor_leave(&l->meeting);
}

/* ---- frames ---------------------------------------------------------------------------------- */

/* Reads how far updates have come, and takes the newest picture, where they leave pictures. */
static sl_status look_up(sl_live *l, sl_image **picture, double *picture_time, sl_error *error) {
    sl_monitor_enter(&l->meeting);
    if (l->method) l->reduced = l->method->reduced;
    l->draws = l->method && l->method->class->window;
    l->state.updates = l->progress.batches;
    l->state.error_levels = l->error_levels;
    l->state.samples = l->samples;
    l->state.done = l->progress.done && !l->changes;
    sl_status status = l->error.status;
    *picture = status == SL_OK ? l->picture : NULL; /* else nobody would take it */
    *picture_time = l->picture_time;
    if (*picture) {
        l->picture = NULL;
        l->seen = l->picture_changed;
        l->state.versions = l->pictures;
    }
    l->state.changes_shown = l->changes_found;
    if (l->found.waits) {
        l->state.change_seconds = l->found.time;
        l->state.change_frames = l->state.frames - l->found.frames;
    }
    l->found.waits = false;
    if (status != SL_OK && error) *error = l->error;
    sl_monitor_leave(&l->meeting);
    return status;
}

static sl_status draw_window(sl_live *l, sl_error *error) {
    sl_error why;
    sl_monitor_enter(&l->drawing);
    sl_status status = l->blind ? renew_window(l, &why) : SL_OK;
    if (status == SL_OK)
        status = l->method->class->window->draw(l->window, l->frame, &l->state.versions, &l->counters, &why);
    if (status == SL_OK)
        status = smooth(l, l->scene_copy, drawers(l), l->frame, &l->counters, &why);
    sl_monitor_leave(&l->drawing);
    if (status != SL_OK && error) *error = why;
    return status;
}

sl_status sl_live_frame(sl_live *l, const sl_image **frame, sl_live_state *state, sl_error *error) {
    if (!frame) return sl_fail_null(error, "a place for a frame");
    *frame = NULL;
    if (state) *state = (sl_live_state){0};
    if (!l) return sl_fail_null(error, "a live show");
    sl_image *picture;
    double picture_time;
    sl_status status = look_up(l, &picture, &picture_time, error);
    if (status != SL_OK) return status;
    if (l->draws) {
        status = draw_window(l, error);
        l->seen = l->told;
        l->state.time_seconds = l->shown.time;
    } else if (picture) {
        sl_image_destroy(l->frame);
        l->frame = picture;
        l->state.time_seconds = picture_time;
    }
    if (status != SL_OK) return status;
    l->state.frames++;
    sl_count(&l->counters, SL_COUNT_FRAMES_DISPLAYED, 1);
    *frame = l->frame;
    if (state) *state = l->state;
    return SL_OK;
}
