/* The plan: settings completed, the paths, and which parts a scene needs (what is not needed does not
 * run). */
#pragma once

#include "cache/frame/method.h"

typedef struct sl_shading_plan {
    bool direct;        /* some light can be sampled */
    bool indirect;      /* some surface reflects light to another */
    bool caustics;      /* asked for, and something is a mirror */
    bool radiance;      /* some surface is not diffuse: exitant radiance is cached, too */
    bool ageing;        /* something may move, or is not diffuse */
    bool layers;        /* direct and indirect light are renewed apart */
    bool curved;        /* bicubic surfaces are tessellated */
} sl_shading_plan;

/* Replaces what is 0 in settings->shading_cache, or left to quality. */
void sl_shading_complete(sl_settings *settings);
/* Patches beyond which those go that were not used for long, roots not counted; of complete settings. */
double sl_shading_patch_limit(const sl_settings *settings);
sl_shading_plan sl_shading_plan_make(const sl_scene *scene, const sl_settings *settings);
void sl_shading_transport(const sl_settings *settings, sl_transport *transport);
void sl_shading_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer);

sl_memory_need sl_shading_need(const sl_scene *scene, const sl_settings *settings);
