/* Photon tracing: L (D|S)+ from every light of the scene (point, spot, directional, emissive triangles,
 * environment), by Embree; and the list of hits that it leaves. */
#pragma once

#include "trace/trace.h"

/* 36 bytes. */
typedef struct sl_photon {
    float position[3];
    float flux[3];      /* W: divided by emitted photons */
    uint32_t direction; /* towards where the light came from: octahedral, 16 + 16 bits */
    uint32_t normal;    /* geometric, on that side: octahedral, 16 + 16 bits */
    uint32_t flags;     /* bits 0-7: bounces before this hit; SL_PHOTON_CAUSTIC */
} sl_photon;

/* SL_PHOTON_CAUSTIC: specular surfaces alone lie between the light and here. */
enum { SL_PHOTON_BOUNCES = 0xff, SL_PHOTON_CAUSTIC = 0x100 };

/* Returns whether a caustic passes: mirrors, and from the exponent `polished` on (0: none) lobes without a
 * diffuse part. */
static inline bool sl_is_specular(const sl_material *m, float polished) {
    return sl_material_is_mirror(m) || (polished > 0.0f && sl_material_is_glossy(m) &&
                                        !sl_material_is_diffuse(m) && m->exponent >= polished);
}

/* Where photons are stored. */
static inline bool sl_takes_photons(const sl_material *m) {
    return !sl_material_is_mirror(m) && (sl_material_is_diffuse(m) || sl_material_is_glossy(m));
}

uint32_t sl_octahedral_encode(sl_vec3 unit); /* 16 + 16 bits; decoded, off by at most 6.5e-5 rad */
sl_vec3 sl_octahedral_decode(uint32_t code); /* unit */

typedef struct sl_photon_options {
    uint64_t stored;          /* stop at the end of the chunk in which so many are stored */
    uint64_t emitted_at_most; /* 0: 8 times stored, and at least 2^20: a scene that stores few must end too */
    sl_photon_store store;
    float polished;           /* what is specular for SL_STORE_CAUSTIC: sl_is_specular() */
    /* part of the environment; with SL_STORE_INDIRECT its first hits are stored too, with its share of their
     * flux. NULL: none */
    const sl_environment *sky;
    uint64_t seed;
    uint64_t first;           /* so many paths are passed over: whole chunks */
    unsigned threads;
} sl_photon_options;

typedef struct sl_photon_list {
    size_t count;
    size_t capacity;          /* room in `photon`: the tracing's affair, as are */
    sl_light_sampler *lights; /* while not all is there; else NULL */
    sl_photon *photon;        /* in order of path, then bounce: a photon's id is its place here */
    uint64_t emitted;         /* paths */
    double cut_flux;          /* luminance W, of paths that ended at 64 bounces */
    /* luminance W, of all lights; parallel light counts what enters the scene's box */
    double emitted_flux;
} sl_photon_list;

enum { SL_PHOTON_CHUNK = 4096 };

/* Paths in chunks of SL_PHOTON_CHUNK, each a pure function of (seed, path); the same list at any number of
 * threads and however it is cut into calls. `*list` (NULL at first) grows until it holds options->stored;
 * each call traces at most `chunks` chunks more, *done tells whether all is there. Fluxes are divided by the
 * emitted paths when all is there, not before: dividing anew with every call would round differently. In
 * every chunk a light gets its share of paths, rounded up or down so that over the chunks nothing is lost,
 * however weak the light. Without light, or where nothing could be stored, the list is empty and done at
 * once. */
sl_status sl_photons_trace(const sl_scene *scene, const sl_tracer *tracer, const sl_photon_options *options,
                           size_t chunks, sl_photon_list **list, bool *done, sl_counters *counters,
                           sl_error *error);
void sl_photon_list_destroy(sl_photon_list *list);
