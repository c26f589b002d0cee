/* Which emitter a light sample goes to: chosen for every point by how much each can matter there. */
#ifndef SL_TRACE_EMITTER_TABLE_H
#define SL_TRACE_EMITTER_TABLE_H

#include "scene/scene.h"

enum { SL_EMITTER_CHOICES_MAX = 1024 }; /* more are not weighed for every point */

typedef struct sl_emitter_table {
    float *x, *y, *z;               /* centroid */
    float *normal_x, *normal_y, *normal_z;
    float *strength;                /* mean radiance times area */
    float *extent_squared;          /* largest squared distance of a corner from the centroid */
    float *two_sided;               /* 1 or 0 */
    float *block;                   /* holds all of the above */
    size_t count;
} sl_emitter_table;

typedef struct sl_emitter_choice {
    double sums[SL_EMITTER_CHOICES_MAX]; /* cumulative importances */
    size_t count;                        /* 0: no emitter can matter, or there are too many */
} sl_emitter_choice;

sl_status sl_emitter_table_create(const sl_scene *scene, sl_emitter_table *table, sl_error *error);
void sl_emitter_table_destroy(sl_emitter_table *table);
/* How much an emitter can matter at a point: strength, cosines and distance of its centroid, each kept from
 * vanishing where some part of the emitter may still contribute; 0 where none can. */
float sl_emitter_importance(const sl_emitter_table *table, size_t emitter, sl_vec3 position, sl_vec3 normal);
/* Importances of all at a point with a unit normal. */
void sl_emitters_weigh(const sl_emitter_table *table, sl_vec3 position, sl_vec3 normal,
                       sl_emitter_choice *choice);
/* The emitter that holds u, in [0,1), of the sum, and its probability. choice->count must not be 0. */
size_t sl_emitters_choose(const sl_emitter_choice *choice, float u, float *chance);

#endif
