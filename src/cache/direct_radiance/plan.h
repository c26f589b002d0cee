/* What Direct Radiance Mapping runs for a scene: settings completed, and the passes that it needs. */
#ifndef SL_CACHE_DIRECT_RADIANCE_PLAN_H
#define SL_CACHE_DIRECT_RADIANCE_PLAN_H

#include "cache/direct_radiance/lights.h"
#include "cache/frame/method.h"

typedef struct sl_radiance_plan {
    bool receivers;      /* some surface is diffuse or glossy */
    bool shadows;        /* pass 1: something can stand between a light and what it lights */
    bool map;            /* passes 2 and 3: some surface reflects a light */
    bool glossy;         /* some surface is: true colour instead of radiance, eye vectors */
    bool normals;        /* pass 2c */
    bool planar, curved; /* mirrors */
    bool tracer;         /* rays are needed */
    bool environment;
} sl_radiance_plan;

/* Replaces what is 0 in settings->radiance_map, or left to quality. */
void sl_radiance_complete(sl_settings *settings);
/* settings are complete. planar and curved: what mirrors the scene has. */
sl_radiance_plan sl_radiance_plan_make(const sl_scene *scene, const sl_settings *settings, bool planar, bool curved);
/* Of the plan's shadows alone: anew where lights have moved. */
bool sl_radiance_has_shadows(const sl_scene *scene, const sl_settings *settings);
void sl_radiance_transport(const sl_settings *settings, sl_transport *transport);
void sl_radiance_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer);

/* Whether a point of the scene's surface can hide another from a light, one of its own triangles among them. */
typedef enum sl_shadow_casters {
    SL_NO_SHADOWS,          /* all of it bounds one convex space, or one convex body, and no light without extent is beyond any of its planes */
    SL_SHADOWS_OF_WALLS,    /* convex, but a light shines from outside */
    SL_SHADOWS_OF_SURFACES  /* not convex, or so large that it would take long to find out */
} sl_shadow_casters;
sl_shadow_casters sl_scene_shadow_casters(const sl_scene *scene);

/* memory.c */
sl_memory_need sl_radiance_need(const sl_scene *scene, const sl_settings *settings);
extern const sl_concession sl_radiance_concessions[];

#endif
