/* The Shading Cache: lazily evaluated shading on one patch hierarchy, in scenes where things move. Read in this order:
 *
 *   plan.c             what a scene needs
 *   state.h            what a cache consists of; shading_cache.c: made, edited, shown
 *   update.c           one update: id map, priorities, selection, work, samples, commit, ageing, display             U1 to U10
 *   cache/patches      triangles, quadrilaterals and bicubic patches, and the hierarchy on them
 *   priority.c         display levels, interpolation error, age, normalisation                                        U2, U3
 *   selection.c        hit-and-test; systematic.c: instead of it; flood.c: from hits to what is beside them               U4
 *   work.c             requests: evaluate or split; patch_size.c: how large a patch is in the picture                  U5, U6
 *   samples.c          samples asked for, and committed                                                               U7, U8
 *   renderers.h        direct light, bidirectional paths, caustics                                                    U7
 *   fade.c             values that come in slowly                                                                     U8
 *   change.c           change detection, resolution drop                                                              U8
 *   display.h          arrays, tessellation, drawing                                                                  U10
 *   live.c             frames beside updates; story.c: what made a pixel
 */
#ifndef SL_SHADING_CACHE_SHADING_CACHE_H
#define SL_SHADING_CACHE_SHADING_CACHE_H

#include "cache/frame/method.h"

#endif
