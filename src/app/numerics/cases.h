/* Rooms that are hard to render, and the pictures that must come out of them. */
#pragma once

#include "softlux.h"

typedef struct sl_room sl_room;

/* Into how many triangles the walls of a room are cut, which ought to change nothing. */
typedef struct sl_room_cut {
    int columns, rows; /* of every wall */
    double skew;       /* 0: even; else the first column takes this share of the width, and so on */
} sl_room_cut;

typedef enum sl_expectation {
    SL_EXPECT_SAME,      /* the picture of the plain room, made by the same samples */
    SL_EXPECT_RESAMPLED, /* the same by other samples: what another seed changes counts */
    SL_EXPECT_MIRRORED,  /* likewise, left and right exchanged */
    SL_EXPECT_SCALED,    /* the same, times `factor` */
    SL_EXPECT_TRUE,      /* another picture, as near to the truth as that of the plain room */
    SL_EXPECT_SOUND /* finite, nowhere negative, the same bits with other threads: what every picture must be,
                       and here no more */
} sl_expectation;

/* Differences are relative RMSE. A method's error is that against the same light paths, path traced, in the
 * plain room; what is noise is taken off where a picture tells its own (the tracers, by the halves of their
 * samples). */
typedef struct sl_hard_case {
    const char *name;
    sl_expectation expectation;
    double most;                 /* may differ by that */
    double noises, errors;       /* or by so many times the method's noise, or its error */
    /* what is changed, where it is not 0 */
    void (*make)(sl_room *room); /* triangles and materials */
    double scale, by[3];         /* the room is that large, and elsewhere */
    sl_room_cut cut;             /* of its walls */
    sl_light_data light;         /* one more; size 0: none */
    double emission;             /* times that of the lamp */
    double reflects[3];          /* all surfaces: diffuse, specular, exponent */
    double eye[3], target[3], fov_deg;
    int size[2];
} sl_hard_case;

/* Loads the case's room; NULL: the plain one. */
sl_status sl_hard_case_load(const sl_hard_case *hard, sl_scene **scene, sl_error *error);

/* A case that a method is known not to master: another bound, or none, and why. */
typedef struct sl_known_limit {
    const char *method, *name;
    double bound; /* 0: none */
    const char *why;
} sl_known_limit;

extern const sl_hard_case sl_hard_cases[];
extern const size_t sl_hard_case_count;
extern const sl_known_limit sl_known_limits[]; /* ends with a NULL method */
