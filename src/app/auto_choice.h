/* What --method auto knows: scenes that were measured, and how soon each method reached an error in them.
 * Pure arithmetic: the same rule that chooses for a new scene can be tried on measured ones that were left
 * out (bench/bench_auto.c, which also writes auto_table.h). */
#ifndef SL_APP_AUTO_CHOICE_H
#define SL_APP_AUTO_CHOICE_H

#include <stdbool.h>
#include <stddef.h>

/* How small the error is to be. */
typedef enum sl_auto_class { SL_AUTO_ROUGH, SL_AUTO_MIDDLE, SL_AUTO_FINE, SL_AUTO_CLASSES } sl_auto_class;

typedef enum sl_auto_candidate {
    SL_AUTO_SPLATTING,
    SL_AUTO_SPLATTING_ON, /* with bounces */
    SL_AUTO_DIRECT_RADIANCE,
    SL_AUTO_LIGHT_OCTREE,
    SL_AUTO_MULTI_MESH,
    SL_AUTO_SHADING_CACHE,
    SL_AUTO_PATH,
    SL_AUTO_BIDIRECTIONAL,
    SL_AUTO_CANDIDATES
} sl_auto_candidate;

/* What a scene looks like from afar. */
typedef struct sl_auto_kind {
    /* shares of the mean radiance: straight from lights, by one surface, by more, thrown on surfaces by
     * mirrors; they sum to 1 */
    double direct, second, further, mirrored;
    bool lit, glossy, mirrors, open;          /* there is light; glossy surfaces; mirrors; a sky */
    double triangles, lights;                 /* numbers */
} sl_auto_kind;

typedef struct sl_auto_scene {
    const char *name;
    sl_auto_kind kind;
    double pixels;                                         /* of the pictures measured */
    /* processor time until the error against all light is that of the class */
    double seconds[SL_AUTO_CLASSES][SL_AUTO_CANDIDATES];
} sl_auto_scene;

typedef struct sl_auto_verdict {
    sl_auto_candidate best;
    /* expected, in units of the best; HUGE_VAL: it leaves out too much of the light */
    double cost[SL_AUTO_CANDIDATES];
    const sl_auto_scene *like;       /* of the measured scenes the most similar one */
} sl_auto_verdict;

/* 15, 5, 2 %: the errors of the classes. */
double sl_auto_error_of(sl_auto_class class);
/* Returns the curve of softlux bench that a candidate's times are from. */
const char *sl_auto_curve_of(sl_auto_candidate candidate);
/* Returns how unlike two scenes are; 0: the same. */
double sl_auto_distance(const sl_auto_kind *a, const sl_auto_kind *b);
/* Judges by the measured scenes, the similar ones counting most; `left_out` (or NULL) is as if it had not
 * been measured. error: what may be missing. */
sl_auto_verdict sl_auto_judge(const sl_auto_scene *measured, size_t count, const sl_auto_scene *left_out,
                              const sl_auto_kind *kind, double pixels, sl_auto_class class, double error);

#endif
