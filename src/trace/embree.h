/* The one file that knows which Embree there is: 3 (contexts) or 4 (argument structures; the Makefile defines
 * SL_EMBREE4). A query carries a pointer of ours to the callbacks. */
#pragma once

#ifdef SL_EMBREE4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

typedef struct sl_embree_query {
#ifdef SL_EMBREE4
    struct RTCRayQueryContext context; /* must be first: the callbacks get its address */
#else
    struct RTCIntersectContext context;
#endif
    void *state;
} sl_embree_query;

static inline void *sl_embree_state(const void *callback_context) {
    return ((const sl_embree_query *)callback_context)->state;
}

/* Returns the copy of a mesh that is met; RTC_INVALID_GEOMETRY_ID: none. */
static inline unsigned sl_embree_instance(const void *callback_context) {
    return ((const sl_embree_query *)callback_context)->context.instID[0];
}

/* The callbacks' rays: structures of n-element arrays in the order of struct RTCRay (a hit record starts with
 * its ray). */
static inline float *sl_embree_tfar(void *rays, unsigned n) { return (float *)rays + 8 * n; }
static inline const unsigned *sl_embree_id(const void *rays, unsigned n) {
    return (const unsigned *)rays + 10 * n;
}

#ifdef SL_EMBREE4

static inline void sl_embree_begin(sl_embree_query *query, void *state) {
    rtcInitRayQueryContext(&query->context);
    query->state = state;
}

static inline void sl_embree_intersect16(RTCScene scene, sl_embree_query *query, const int *valid,
                                         struct RTCRayHit16 *rays) {
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &query->context;
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcIntersect16(valid, scene, rays, &arguments);
}

static inline void sl_embree_intersect1(RTCScene scene, sl_embree_query *query, struct RTCRayHit *ray) {
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &query->context;
    rtcIntersect1(scene, ray, &arguments);
}

static inline void sl_embree_occluded1(RTCScene scene, sl_embree_query *query, struct RTCRay *ray) {
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &query->context;
    rtcOccluded1(scene, ray, &arguments);
}

static inline void sl_embree_occluded16(RTCScene scene, sl_embree_query *query, const int *valid,
                                        struct RTCRay16 *rays) {
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &query->context;
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcOccluded16(valid, scene, rays, &arguments);
}

#else

static inline void sl_embree_begin(sl_embree_query *query, void *state) {
    rtcInitIntersectContext(&query->context);
    query->state = state;
}

static inline void sl_embree_intersect16(RTCScene scene, sl_embree_query *query, const int *valid,
                                         struct RTCRayHit16 *rays) {
    query->context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, scene, &query->context, rays);
}

static inline void sl_embree_intersect1(RTCScene scene, sl_embree_query *query, struct RTCRayHit *ray) {
    rtcIntersect1(scene, &query->context, ray);
}

static inline void sl_embree_occluded1(RTCScene scene, sl_embree_query *query, struct RTCRay *ray) {
    rtcOccluded1(scene, &query->context, ray);
}

static inline void sl_embree_occluded16(RTCScene scene, sl_embree_query *query, const int *valid,
                                        struct RTCRay16 *rays) {
    query->context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcOccluded16(valid, scene, &query->context, rays);
}

#endif
