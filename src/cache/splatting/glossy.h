/* Radiance records (Krivanek et al. 2005; Gautron et al. 2005): what the light that a record gathered, as
 * coefficients of hemispherical harmonics, sends from a pixel to the eye by way of a Phong lobe.
 * Interpolation goes as follows (9):
 *
 *     translate   lambda(p) = lambda + dx d/dx lambda + dy d/dy lambda, where the gradients live: in the
 *                 record's frame
 *     rotate      into the pixel's frame; that is, the pixel's lobe is moved into the record's
 *     reflect     L_o = sum of c_lm(omega_o) lambda_lm
 */
#pragma once

#include "cache/hemisphere/harmonics.h"
#include "cache/splatting/record.h"
#include "scene/scene.h"

/* The lobes of a scene's materials. Immutable after creation. */
typedef struct sl_glossy sl_glossy;

sl_status sl_glossy_create(const sl_scene *scene, int order, sl_glossy **glossy, sl_error *error);
void sl_glossy_destroy(sl_glossy *glossy);
size_t sl_glossy_bytes(const sl_glossy *glossy);
/* The least order that holds every glossy lobe of the scene to 5 % at 45 degrees, at most SL_HSH_ORDER_MAX; 1
 * without glossy materials. */
int sl_glossy_order_for(const sl_scene *scene);
/* Returns what an order leaves out of the scene's sharpest lobe: relative L2 error at 45 degrees, and its
 * exponent. 0 without glossy materials. */
double sl_glossy_truncation(const sl_scene *scene, int order, double *exponent);

/* A view's pixels for the glossy part of the fragment program. */
typedef struct sl_glossy_view {
    const sl_glossy *glossy;
    const sl_splat_receivers *receivers;
    const uint32_t *material; /* of every pixel */
    sl_vec3 eye;
    const sl_gbuffer *gbuffer; /* whose seen_from, if it has any, tells better; or NULL */
} sl_glossy_view;

/* One record with its coefficients. */
typedef struct sl_glossy_record {
    sl_vec3 position;
    sl_frame frame;
    const float *coefficients; /* 9 padded vectors: lambda, d/dx, d/dy of R, G, B */
} sl_glossy_record;

/* sum of c lambda for one pixel, W/(m^2 sr) per unit ks: may be slightly negative, as finite orders ring. */
SL_KERNELS(void, sl_glossy_radiance,
           (const sl_glossy_view *view, const sl_glossy_record *record, size_t pixel, float radiance[3]));

struct sl_glossy {
    int order;
    size_t even, stride;       /* floats of the even part, and of a whole padded vector */
    size_t material_count;
    sl_moved_lobe **lobe;      /* of every material; NULL: not glossy. Equal exponents share one. */
    sl_moved_lobe **made;      /* each of them once */
    size_t made_count;
};
