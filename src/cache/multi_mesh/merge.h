/* The material pass (image pass 2) and the merge (image pass 4): L = k_d (U_dd + E_i / pi) + k_s U_ds + L_e.
 */
#ifndef SL_MULTI_MESH_MERGE_H
#define SL_MULTI_MESH_MERGE_H

#include "raster/raster.h"

/* The view's materials, whatever the light: planes of the picture's size, bottom row first. */
typedef struct sl_materials_seen {
    int width, height;
    float *planes;             /* behind all of these */
    float *diffuse[3];         /* k_d with its texture */
    float *specular[3];        /* k_s; NULL where no triangle in the scene has any */
    /* L_e of lamps seen from where they shine, the environment behind everything; NULL: none */
    float *emission[3];
} sl_materials_seen;

typedef struct sl_materials_wanted {
    bool specular, emission;
} sl_materials_wanted;

/* From an id plane of the view: two render targets in one pass. */
sl_status sl_materials_resolve(const sl_scene *scene, const sl_raster *raster, const sl_view *view,
                               const uint32_t *id, sl_materials_wanted wanted, unsigned threads,
                               sl_materials_seen **materials, sl_counters *counters, sl_error *error);
void sl_materials_destroy(sl_materials_seen *materials);
/* Returns the share of the picture's pixels whose lobe reflects more than their diffuse part does. */
double sl_materials_glossy_share(const sl_materials_seen *materials);

typedef struct sl_merge {
    const sl_materials_seen *materials;
    /* U_dd, U_ds, E_i; NULL: there is none */
    const float *direct_diffuse[3], *direct_specular[3], *indirect[3];
    unsigned threads;
} sl_merge;

/* The picture: R, G, B, which are the sums of the layers direct, specular, indirect and emission; kd and ks
 * beside them. */
sl_status sl_merge_picture(const sl_merge *merge, sl_image **image, sl_error *error);

#endif
