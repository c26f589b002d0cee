/* The text of a page about a method (narratives.json): its paper, and for each pass that the method announces
 * a title, two or three sentences, the equation, and the function that computes it. */
#ifndef SL_APP_STEPS_NARRATIVE_H
#define SL_APP_STEPS_NARRATIVE_H

#include <cjson/cJSON.h>
#include <stddef.h>

/* The ways in which a pass's buffer becomes a picture: the words of "show", in their order. */
typedef enum sl_show {
    SL_SHOW_LIGHT,     /* radiance or irradiance, tone-mapped */
    SL_SHOW_COLOUR,    /* reflectances, as they are */
    SL_SHOW_SCALAR,    /* from dark to bright between the least and the greatest value */
    SL_SHOW_NORMALS,   /* (n + 1) / 2 */
    SL_SHOW_POSITIONS, /* scaled into the box of what is seen */
    SL_SHOW_IDS        /* distinct colours */
} sl_show;

/* Returns the narrative of a method, which the caller deletes; NULL: there is none. */
cJSON *sl_narrative_of(const char *method);
/* Returns the entry for a pass, or NULL; *place gets its place in the order of the paper. */
const cJSON *sl_narrative_find(const cJSON *narrative, const char *pass, size_t *place);
sl_show sl_narrative_show(const cJSON *pass);

#endif
