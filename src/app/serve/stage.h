/* The stage: one scene, shown by one method or two side by side while they work on it, with all that viewers
 * do to it. No network is in it: messages come in, and packets go to the mail. */
#pragma once

#include "app/options.h"
#include "app/serve/mail.h"

typedef struct sl_stage sl_stage;

typedef struct sl_stage_options {
    const char *scene_path; /* the caller's, as all that is pointed to */
    const sl_reading *reading;
    sl_settings settings; /* of the method that is shown first, its size included */
    double at_seconds;
    const char *folder; /* where what is kept is written; made once it is needed */
    const char *token;  /* in addresses of what is kept */
} sl_stage_options;

/* The mail must outlive it. */
sl_status sl_stage_open(const sl_stage_options *options, sl_mail *mail, sl_stage **stage, sl_error *error);
void sl_stage_close(sl_stage *stage); /* NULL is allowed */
/* Takes a letter, whose message it deletes. */
void sl_stage_take(sl_stage *stage, sl_letter letter);
/* Draws and sends what is due, if anybody looks; returns after how many seconds there may be more. */
double sl_stage_step(sl_stage *stage);
/* Reads the mail and shows, until the mail is ended. */
void sl_stage_run(sl_stage *stage);

/* The picture of a log's show, the first (0) or second, which the caller destroys: that which lay beside the
 * log when it was kept, to the bit. */
sl_status sl_log_replay(const char *path, const char *scene, const sl_reading *reading, int show,
                        sl_image **picture, sl_error *error);
