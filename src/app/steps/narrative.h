/* What a page says about a method: its paper, and for each pass that the method announces a title, two or
 * three sentences, the equation, and the function that computes it. */
#ifndef SL_APP_STEPS_NARRATIVE_H
#define SL_APP_STEPS_NARRATIVE_H

#include <stddef.h>

/* How a pass's buffer becomes a picture. */
typedef enum sl_show {
    SL_SHOW_LIGHT,     /* radiance or irradiance, tone-mapped */
    SL_SHOW_COLOUR,    /* reflectances, as they are */
    SL_SHOW_SCALAR,    /* from dark to bright between the least and the greatest value */
    SL_SHOW_NORMALS,   /* (n + 1) / 2 */
    SL_SHOW_POSITIONS, /* scaled into the box of what is seen */
    SL_SHOW_IDS        /* distinct colours */
} sl_show;

typedef struct sl_narrative_pass {
    const char *pass;     /* the name that the method announces, or its beginning */
    const char *title;
    const char *text;     /* HTML */
    const char *equation; /* MathML between <math> and </math>, or NULL */
    const char *code;     /* "sl_function(), src/folder/file.c" */
    /* of the picture, that this pass makes: without it the error would be another; or NULL */
    const char *layer;
    sl_show show;
} sl_narrative_pass;

typedef struct sl_narrative {
    const char *method;
    const char *paper;        /* HTML */
    const char *introduction; /* HTML: the idea in a paragraph */
    const sl_narrative_pass *passes; /* in the order of the paper; ends with a NULL name */
} sl_narrative;

extern const sl_narrative sl_splatting_narrative, sl_direct_radiance_narrative, sl_shading_cache_narrative,
    sl_multi_mesh_narrative, sl_light_octree_narrative;

/* NULL: there is none. */
const sl_narrative *sl_narrative_of(const char *method);
/* The entry for a pass, or NULL; *place gets its place in the order of the paper. */
const sl_narrative_pass *sl_narrative_find(const sl_narrative *narrative, const char *pass, size_t *place);

#endif
