/* A method draws a picture's sub-frames one after the other; ranks (base/ranks.h) share out those that only
 * show what is there, since each of them can be drawn by itself. */
#include "cache/frame/method.h"

#include "base/batch.h"
#include "base/counters.h"
#include "base/math.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/ranks.h"

/* Shows the class the scene as it stands, by a sub-frame. */
static void look(sl_method *m, sl_sub_frame at) {
    m->seen = *m->scene;
    m->seen.sub_frame = at;
}

void sl_expose_anew(sl_method *m, bool objects_moved) {
    sl_sub_frame first = {0};
    m->looks_elsewhere = false;
    if (!m->film) return;
    sl_film_begin(m->film, objects_moved);
    sl_film_next(m->film, &first);
    look(m, first);
}

/* Tells the class of the sub-frame that it is shown. */
static sl_status tell(sl_method *m, sl_error *error) {
    m->looks_elsewhere = false;
    return m->class->edit(m->state, SL_CHANGED_CAMERA, error);
}

/* Goes on to the film's next sub-frame; *whole: there is none. */
static void go_on(sl_method *m, bool *whole) {
    sl_sub_frame next;
    *whole = !sl_film_next(m->film, &next);
    if (*whole) return;
    look(m, next);
    m->looks_elsewhere = true;
}

/* Has the class show its sub-frame, in the picture of the one before. */
static sl_status show(sl_method *m, sl_error *error) {
    sl_image *picture = m->sub_frame;
    sl_status status = m->class->resolve(m->state, &picture, error);
    if (picture != m->sub_frame) sl_image_destroy(m->sub_frame);
    m->sub_frame = picture;
    return status;
}

/* ---- one after the other ---- */

static sl_status expose_one(sl_method *m, sl_progress *now, sl_error *error) {
    sl_status status = m->looks_elsewhere ? tell(m, error) : SL_OK;
    if (status == SL_OK) status = m->class->update(m->state, now, error);
    const double part = now->fraction;
    const bool drawn = now->done, shows = !m->class->asks || m->seen.sub_frame.purpose == SL_SUB_FRAME_SHOWS;
    now->done = now->frame_done = false;
    now->fraction = sl_film_share(m->film);
    if (!drawn && now->fraction == 0.0) now->fraction = 0.5 * part;
    if (status != SL_OK || !drawn) return status;
    if (shows) status = show(m, error);
    if (status == SL_OK)
        status = sl_film_add(m->film, sl_method_raster(m), shows ? m->sub_frame : NULL, error);
    if (status == SL_OK) go_on(m, &now->done);
    return status;
}

/* ---- shared out ---- */

/* As many at once, in so much memory; where that holds few, each is shared out. */
enum { TOGETHER = 64, AT_LEAST = 16, TOGETHER_BYTES = 256 << 20 };

/* The next sub-frames of the film: what they show, the updates that they took, why they failed. */
typedef struct exposure {
    sl_method *method;
    unsigned first;       /* of them */
    size_t count, floats; /* of one */
    float *packed;
    uint64_t *updates;
    sl_error *errors;
    sl_counters own; /* counted by the class here */
} exposure;

static sl_status draw(sl_method *m, uint64_t *updates, sl_error *error) {
    sl_progress now = {0};
    sl_status status = tell(m, error);
    for (; status == SL_OK && !now.done; (*updates)++) status = m->class->update(m->state, &now, error);
    return status == SL_OK ? show(m, error) : status;
}

static void draw_item(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    (void)worker;
    exposure *x = context;
    sl_method *m = x->method;
    const sl_counters before = *sl_method_own_counters(m);
    look(m, sl_film_at(m->film, (unsigned)index));
    if (draw(m, &x->updates[index], &x->errors[index]) != SL_OK) return;
    sl_film_pack(m->film, x->first, m->sub_frame, result);
    sl_counters counted = *sl_method_own_counters(m);
    sl_counters_subtract(&counted, &before);
    sl_counters_add(&x->own, &counted);
    sl_counters_add(counters, &counted);
}

/* Hands what all have drawn to the film, in the order of the sub-frames. */
static sl_status add_all(exposure *x, sl_progress *now, sl_error *error) {
    sl_method *m = x->method;
    sl_image *picture = NULL;
    sl_status status = sl_film_picture(m->film, &picture, error);
    for (size_t i = 0; status == SL_OK && i < x->count; i++) {
        if (x->errors[i].status == SL_OK) continue;
        *error = x->errors[i];
        status = error->status;
    }
    const float *packed = x->packed;
    for (size_t i = 0; status == SL_OK && i < x->count; i++, packed += x->floats) {
        now->batches += x->updates[i] - (i == 0);
        sl_film_unpack(m->film, x->first, packed, picture);
        look(m, sl_film_at(m->film, 0));
        status = sl_film_add(m->film, sl_method_raster(m), picture, error);
    }
    sl_image_destroy(picture);
    return status;
}

static sl_status expose_all(exposure *x, sl_progress *now, sl_error *error) {
    const sl_batch_plane planes[] = {{x->updates, sizeof *x->updates}, {x->errors, sizeof *x->errors}};
    sl_counters counted = {{0}};
    if (!x->packed || !x->updates || !x->errors) return sl_fail_memory(error, "sub-frames");
    sl_batch_run(&(sl_batch){.count = x->count, .work = draw_item, .context = x, .results = x->packed,
                             .result_bytes = x->floats * sizeof *x->packed, .shared = true, .planes = planes,
                             .plane_count = 2},
                 1, &counted);
    sl_counters_subtract(&counted, &x->own); /* the class has them */
    sl_film_count(x->method->film, &counted);
    sl_status status = add_all(x, now, error);
    if (status == SL_OK) go_on(x->method, &now->done);
    return status;
}

/* Finds how many sub-frames ranks are to share out; 0: they share out what each one takes. */
static void find_together(exposure *x) {
    const size_t ahead = sl_film_ahead(x->method->film, &x->first), most = sl_fewer(ahead, TOGETHER);
    if (!sl_ranks_share() || x->method->batch_by_batch || !x->method->looks_elsewhere || most < 2)
        return;
    x->floats = sl_film_pack(x->method->film, x->first, NULL, NULL);
    const size_t room = TOGETHER_BYTES / (x->floats * sizeof(float) + 1);
    x->count = room >= most ? most : room >= AT_LEAST ? room : 0;
}

sl_status sl_expose(sl_method *m, sl_progress *now, sl_error *error) {
    exposure x = {.method = m};
    find_together(&x);
    if (!x.count) return expose_one(m, now, error);
    x.packed = sl_allocate_unset(x.count, x.floats * sizeof *x.packed);
    x.updates = sl_allocate(x.count, sizeof *x.updates);
    x.errors = sl_allocate(x.count, sizeof *x.errors);
    sl_status status = expose_all(&x, now, error);
    SL_FREE_ALL(x.packed, x.updates, x.errors);
    now->fraction = sl_film_share(m->film);
    return status;
}
