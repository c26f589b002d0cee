/* One emitter of many, chosen by how much it can matter at a point, in a few steps down a binary tree over
 * the emitters: every node knows their strength and a sphere around them, and the way goes left or right in
 * proportion to what each side can matter (Conty Estevez and Kulla 2018, "Importance sampling of many lights
 * with adaptive tree splitting", without the splitting). At a leaf the few emitters are weighed one by one.
 * The chance of the way taken is known, so samples stay unbiased; of stratified numbers every node sends each
 * side its share, so they stay stratified. */
#pragma once

#include "scene/scene.h"

typedef struct sl_light_tree sl_light_tree;

/* The scene has emitters, and must outlive the tree. */
sl_status sl_light_tree_create(const sl_scene *scene, sl_light_tree **tree, sl_error *error);
void sl_light_tree_destroy(sl_light_tree *tree);
/* The emitter that u in [0,1) leads to from a point with a unit normal, and how probable that was. False: the
 * way ends where no emitter can matter. */
bool sl_light_tree_choose(const sl_light_tree *tree, sl_vec3 position, sl_vec3 normal, float u,
                          uint32_t *emitter, float *chance);
