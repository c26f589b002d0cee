/* The insides of a stage, for its own files. */
#pragma once

#include "app/rate.h"
#include "app/serve/parse.h"
#include "app/show_files.h"
#include "app/serve/stage.h"
#include "app/serve/worker.h"
#include "app/serve/world.h"
#include "app/steps/marks.h"

enum { SL_SIDES = 2, SL_TIMES = 256 };

typedef struct sl_passes sl_passes;

typedef struct sl_side_show sl_side_show; /* side.c */

/* One method, shown live. */
typedef struct sl_side {
    sl_settings settings;
    bool wanted;                      /* a method is named */
    sl_side_show *show;               /* the newest, also where it is over; or NULL */
    uint64_t has;                     /* events that were made to the scene before the show began */
    sl_live *live;                    /* the show's; NULL: it is over */
    double began, drawn, moved, told; /* seconds by the clock: the show; the last frame, change, state */
    sl_live_state last;
    sl_rate rate;
    uint64_t shown; /* the newest event that the last frame shows */
    double drawing, encoding; /* seconds of the processor that the last frame took */
    double latency; /* seconds from that event to its frame */
    bool sent_still;
    uint64_t edit; /* the newest edit; changes and counters then */
    unsigned edit_changes;
    sl_counters before_edit;
    uint32_t frame; /* the number of the last */
    bool observed;  /* its passes are shown */
    sl_passes *passes;
} sl_side;

struct sl_stage {
    sl_stage_options options;
    sl_mail *mail;
    sl_world world;
    sl_side side[SL_SIDES];
    sl_tone tone;
    uint32_t frame; /* the newest number */
    unsigned viewers;
    unsigned client; /* whose message is taken */
    double times[SL_TIMES]; /* when the last events came, by number */
    bool plays;
    double play_began, play_from;
    bool things_move; /* by keyframes, since that was told */
    double motion_told;
    sl_worker *worker;
    bool reference, difference, error;
    struct {             /* keep.c */
        unsigned number; /* of the last file */
        double bytes;    /* that were kept */
        double told;     /* when the exact picture was told of last */
        int side;        /* of the exact picture */
        const char
            *what; /* is being made: "exact", "page", or what of an exact picture is kept; NULL: none */
        char scene_path[4096]; /* the newest that was written; "": none */
        uint64_t scene_event;  /* as the world stood then */
        sl_exact_job job;
        char command[8192];
        bool films;
        sl_show_files film;
        char film_path[4096];
        double film_began;
    } kept;
    sl_tracer *tracer; /* of the scene as it stands; NULL: nobody has asked for it */
};

/* ---- to viewers; client 0: to all ---- */
cJSON *sl_message(const char *is);
cJSON *sl_message_of_side(const char *is, int side);
cJSON *sl_refusal(const char *what, const sl_error *error);
void sl_say(sl_stage *stage, unsigned client, cJSON *message);
/* Shows a picture to all. */
void sl_show(sl_stage *stage, sl_frame_kind kind, unsigned index, const sl_image *picture, sl_tone *tone,
             uint64_t event, bool still);
void sl_add_numbers(cJSON *to, const char *name, const double *values, int count);
void sl_add_floats(cJSON *to, const char *name, const float *values, int count);

/* ---- side.c ---- */
/* The settings with which a side's method is shown: those left open are chosen for frames that follow a hand;
 * an exact picture has the side's own. */
sl_settings sl_side_shown(const sl_settings *settings);
/* Shows the method of side->settings, as the world stands now. */
sl_status sl_side_start(sl_stage *stage, int index, sl_error *error);
/* Ends the show, whose last update may still be under way: the next show waits for it. */
void sl_side_stop(sl_stage *stage, int index);
void sl_side_close(sl_stage *stage, int index);
/* The newest event of the world, which changed so much. */
sl_status sl_side_follow(sl_stage *stage, int index, unsigned changes, sl_error *error);
/* Draws what is due. */
void sl_side_step(sl_stage *stage, int index, double now);
const char *sl_side_name(int index);

/* ---- describe.c: messages about what there is ---- */
cJSON *sl_describe_hello(const sl_stage *stage);
cJSON *sl_describe_scene(const sl_stage *stage);
cJSON *sl_describe_camera(const sl_stage *stage);
cJSON *sl_describe_settings(const sl_settings *settings); /* those that are not as they are by default */
cJSON *sl_describe_changes(unsigned changes);

/* ---- pick.c ---- */
sl_status sl_take_pick(sl_stage *stage, sl_taking *t);
sl_status sl_stage_needs_tracer(sl_stage *stage, sl_error *error);
void sl_stage_forget_tracer(sl_stage *stage); /* things have moved */
sl_mark_view sl_stage_view(const sl_stage *stage);

/* ---- keep.c ---- */
sl_status sl_take_exact(sl_stage *stage, sl_taking *t);
sl_status sl_take_keep(sl_stage *stage, sl_taking *t);
/* One more frame of a film; a film that has become too long ends. */
void sl_film_frame(sl_stage *stage, const sl_image *frame);
void sl_film_end(sl_stage *stage, bool told);
/* Tells and shows what the worker has done. */
void sl_work_step(sl_stage *stage);

/* ---- log.c ---- */
/* Writes the events so far and what the shows made of them, and beside NAME.json the picture that each side's
 * method has then, NAME-a.exr. */
sl_status sl_log_write(sl_stage *stage, const char *path, sl_error *error);

/* ---- passes.c: of a side whose method is observed ---- */
/* NULL: no memory. The observer is given to the method, and told of passes until that is gone. */
sl_passes *sl_passes_create(const char *method);
void sl_passes_destroy(sl_passes *passes); /* NULL is allowed */
const sl_observer *sl_passes_observer(const sl_passes *passes);
/* The marks of which pass are shown, by a part of its name; "": none. */
void sl_passes_overlay(sl_passes *passes, const char *kind);
/* Has all sent once more: somebody else wants to see them. */
void sl_passes_again(sl_passes *passes);
/* Sends what is new, now and then. */
void sl_passes_step(sl_stage *stage, sl_passes *passes, int side, double now);

/* ---- story.c ---- */
sl_status sl_take_story(sl_stage *stage, sl_taking *t);
/* Adds a narrative's entry of a pass (or NULL): "title", "text", "equation", "function". */
void sl_add_told(cJSON *to, const cJSON *told);
