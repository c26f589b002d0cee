/* What a show (sl_live, softlux.h) is beside its public functions: for a caller that has a scene of its own
 * to draw from, which it changes as it likes, and tells of every change. */
#pragma once

#include "scene/scene.h"

/* Where things are: all that it takes to put any copy of a scene there. */
typedef struct sl_pose {
    bool timed; /* false: as keyframes had them before */
    double time;
    bool looks; /* from a camera of its own, not the keyframes' */
    sl_camera camera;
} sl_pose;
/* Puts a copy there: sl_live_change.make, of an sl_pose. */
sl_status sl_pose_take(const void *pose, sl_scene *scene, unsigned *changes, sl_error *error);

/* A change as it is made to a scene: once by the caller to the one that is drawn, once by the updates to
 * theirs. */
typedef struct sl_live_change {
    sl_status (*make)(const void *what, sl_scene *scene, unsigned *changes, sl_error *error);
    const void *what; /* stays, and stays as it is, until the show has stopped */
    uint64_t number;  /* the caller's, above those before */
    /* takes the place of a change of the same kind that came last and that updates have not followed yet; 0:
     * of none */
    uint64_t kind;
} sl_live_change;

/* Gives the scene of the updates, which stands as the other did when the show was started. */
typedef sl_status sl_live_opening(void *context, sl_scene **scene, sl_error *error);
/* As sl_live_start(), without waiting for the method: the updating thread, which calls `opening` first, makes
 * it, and frames tell whether that has failed. The settings have the picture's size. `shown` is a
 * scene of its own; it must outlive the show, and between two calls it is the caller's. No frame waits: what
 * moves is sl_live_follow()'s, and sl_live_move() and sl_live_look() are not for it. */
sl_status sl_live_start_beside(sl_live_opening *opening, void *context, sl_scene *shown,
                               const sl_settings *settings, sl_live **live, sl_error *error);
/* The change has been made to `shown`, of which it changed so much; updates follow. */
sl_status sl_live_follow(sl_live *live, const sl_live_change *change, unsigned changes, sl_error *error);
/* The number of the newest change that the last frame shows, of light maybe not yet in full; 0: of none. */
uint64_t sl_live_shows(const sl_live *live);

/* The settings of a show's method, for the scene as it stands at the start. */
sl_status sl_live_choose(const sl_scene *scene, const sl_settings *asked, sl_settings *own, sl_error *error);

/* A change that updates have followed. */
typedef struct sl_live_turn {
    uint64_t updates; /* that were done before it */
    uint64_t turn;    /* those of one turn were followed together, by one sl_method_edit() */
    uint64_t number;  /* the change's */
} sl_live_turn;
/* Gives the first `room` of all of them so far, as sl_live_log() gives events, and in *updates (or NULL) how
 * many updates were done: a method that is led through them, and so far, has the show's picture, to the
 * bit. */
size_t sl_live_turns(sl_live *live, sl_live_turn *turns, size_t room, uint64_t *updates);

/* Has the updating thread call it once between two updates, soon. It may resolve the method and ask it for
 * explanations. Without a method: updates have ended before that. False: too many wait, or
 * updates have ended; it is not called. */
typedef void sl_live_visitor(void *context, sl_method *method);
bool sl_live_visit(sl_live *live, sl_live_visitor *visitor, void *context);
/* What the method had counted when its last update ended. */
void sl_live_counters(sl_live *live, sl_counters *counters);
/* Ends the updates, and waits for the one under way; frames and turns are still to be had. Returns the number
 * of the newest change that they have followed; 0: of none. */
uint64_t sl_live_halt(sl_live *live);
void sl_live_leave(sl_live *live);     /* the same, without waiting */
bool sl_live_has_ended(const sl_live *live); /* the updates have */
/* Lets updates rest, or go on. */
void sl_live_rest(sl_live *live, bool rest);
