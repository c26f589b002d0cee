/* Which light paths a method models. A method declares it once; the reference tracers take the same
 * declaration, so the two cannot drift apart. In Heckbert's notation with D Lambertian, G glossy (Phong
 * lobe), S perfect mirror:
 *
 *     direct     L E,  L (D|G) S* E
 *     one-bounce direct, and L D (D|G) S* E: exactly one diffuse bounce more
 *     full       everything, caustics and longer chains included
 *
 * Vertices are named from the eye: x1 is the first surface that is not a mirror (or, if eye_mirrors is off,
 * the first surface), x2 the next, and so on to the light. */
#pragma once

#include "base/choices.h"
#include "softlux.h"

enum { SL_LOBE_DIFFUSE = 1, SL_LOBE_GLOSSY = 2, SL_LOBE_MIRROR = 4, SL_LOBE_ALL = 7 };
#define SL_BOUNCES_UNLIMITED UINT32_MAX

typedef struct sl_transport {
    bool emission;              /* L S* E: lights, emissive surfaces and the environment as seen */
    /* the environment lights surfaces; otherwise it is seen alone, directly and in mirrors */
    bool sky_light;
    bool eye_mirrors;           /* mirrors between the eye and x1 are followed; otherwise a mirror is black */
    unsigned direct_lobes;      /* lobes at x1 that reflect direct light; 0: no direct light */
    unsigned receiver_lobes;    /* lobes at x1 that reflect indirect light; 0: no indirect light */
    /* lobes at x2, x3, ...; with SL_LOBE_MIRROR mirrors there are followed (caustics, L S D) */
    unsigned bounce_lobes;
    /* how many surfaces between x1 and the light, at most (mirrors not counted) */
    uint32_t bounces;
    bool direct_visibility;     /* shadows between x1 and the light */
    bool bounce_visibility; /* between x1 and x2 (off: direct radiance mapping without indirect shadows; the
                               reference then gathers from every surface along the ray). x2, x3, ... and the
                               light always have to see each other: no method counts light through walls there
                             */
    sl_pixel_filter filter;     /* not SL_FILTER_METHOD */
    double filter_radius;       /* of SL_FILTER_BLACKMAN_HARRIS, in pixels */
} sl_transport;

/* "direct", "one-bounce", "full": true if known. */
bool sl_transport_named(const char *name, sl_transport *transport);
