/* What is done to a room to make it hard, and what must come out of it. */
#ifndef SL_APP_NUMERICS_CASES_H
#define SL_APP_NUMERICS_CASES_H

#include "softlux.h"

/* ---- the room ---- */

typedef struct sl_room_material {
    const char *name;
    double diffuse[3], specular, exponent, mirror, emission[3];
} sl_room_material;

/* Materials that every room has; emission leaves the front. */
enum { SL_ROOM_WHITE, SL_ROOM_RED, SL_ROOM_GREEN, SL_ROOM_BOX, SL_ROOM_LAMP, SL_ROOM_MATERIALS };

typedef struct sl_room_triangle {
    size_t corner[3];
    int material;
} sl_room_triangle;

typedef struct sl_room {
    double (*vertex)[3];
    size_t vertex_count, vertex_room;
    sl_room_triangle *triangle;
    size_t triangle_count, triangle_room;
    sl_room_material material[SL_ROOM_MATERIALS];
    char lights[512];       /* JSON, between the brackets of "lights" */
    double eye[3], target[3], fov_deg;
    int width, height;
    bool failed;            /* for want of memory */
} sl_room;

/* How finely the walls of a room are cut, which ought to change nothing. */
typedef struct sl_room_cut {
    int columns, rows; /* of every wall */
    double skew;       /* 0: even; else the first column takes this share of the width, and so on */
} sl_room_cut;

/* A room of 4 x 3 x 5 with a box on its floor and a lamp of .8 x .8 under its ceiling, seen from its open
 * front. */
void sl_room_begin(sl_room *room, const sl_room_cut *cut);
void sl_room_end(sl_room *room);
/* Writes folder/room.obj, room.mtl and room.json; path receives the last one's name. */
sl_status sl_room_write(const sl_room *room, const char *folder, char *path, size_t size, sl_error *error);

/* ---- cases ---- */

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
    const char *lights;          /* JSON */
    double emission;             /* times that of the lamp */
    double reflects[3];          /* all surfaces: diffuse, specular, exponent */
    double eye[3], target[3], fov_deg;
    int size[2];
} sl_hard_case;

/* Makes the case's room. */
void sl_hard_case_make(const sl_hard_case *hard, sl_room *room);

/* What a method is known not to do: another bound, or none, and why. */
typedef struct sl_known_limit {
    const char *method, *name;
    double bound; /* 0: none */
    const char *why;
} sl_known_limit;

extern const sl_hard_case sl_hard_cases[];
extern const size_t sl_hard_case_count;
extern const sl_known_limit sl_known_limits[]; /* ends with a NULL method */

#endif
