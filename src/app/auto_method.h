/* --method auto: which method a scene and a budget ask for, and why. */
#pragma once

#include "cache/frame/settings.h"

typedef struct sl_auto_budget {
    double error;        /* relative RMSE that is to be reached; 0: nothing said */
    double time_seconds; /* 0: no limit */
    sl_quality quality;
    bool things_move;    /* a series of pictures in which lights or objects move */
} sl_auto_budget;

typedef struct sl_auto_choice {
    const char *method;
    char why[400];       /* one line */
} sl_auto_choice;

/* settings: size, seed, threads and what is fixed whatever the method; its method is not looked at. A few
 * thousand paths are traced to see where the scene's light comes from: the same choice in every run and at
 * any number of threads. */
sl_status sl_auto_method(const sl_scene *scene, const sl_settings *settings, const sl_auto_budget *budget,
                         sl_auto_choice *choice, sl_error *error);
/* Replaces the method "auto" in the settings, and says why on stderr unless quiet; other methods stay. */
sl_status sl_auto_settle(const sl_scene *scene, const sl_auto_budget *budget, bool quiet,
                         sl_settings *settings, sl_error *error);
