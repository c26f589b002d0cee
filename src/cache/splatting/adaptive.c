/* Adaptive caching (Krivanek, Bouatouch, Pattanaik, Zara 2006): where two records reach a pixel and what they
 * say of it differs by more than an eye would forgive, the farther one reached too far. Its radius shrinks
 * until the pixel is no longer its own; what that uncovers gets records in the second visit. */
#include "base/error.h"
#include "base/memory.h"
#include "cache/splatting/record_weight.h"
#include "cache/splatting/splatting.h"

static const float tolerated = 0.1f; /* of the larger one */

/* The mean of the channels that a record tells a pixel. */
static float said(const sl_record_pass *pass, const sl_record *record, size_t pixel) {
    const sl_splat_receivers *p = &pass->receivers;
    const sl_record_terms k = sl_record_terms_of(record, &pass->weights);
    const sl_record_offsets o =
        sl_record_offsets_at(&k, p->position_x[pixel], p->position_y[pixel], p->position_z[pixel],
                             p->normal_x[pixel], p->normal_y[pixel], p->normal_z[pixel]);
    float turn = sl_record_turn(&o), sum = 0.0f;
    for (int c = 0; c < 3; c++) sum += sl_record_extrapolate(&k, c, &o, turn);
    return sum * (1.0f / 3.0f);
}

/* Per pixel the weight of the record that counts most there, and what it says. */
typedef struct {
    const sl_record_pass *pass;
    float *weight, *light;
} nearest_record;

static void find_nearest(const nearest_record *n, const sl_record *record) {
    sl_splat_rect rect = sl_record_bounds(n->pass, record);
    for (int y = rect.y0; y < rect.y1; y++) {
        for (int x = rect.x0; x < rect.x1; x++) {
            size_t pixel = (size_t)y * (size_t)n->pass->receivers.width + (size_t)x;
            float w = sl_record_weight(n->pass, record, pixel);
            if (!(w > n->weight[pixel])) continue;
            n->weight[pixel] = w;
            n->light[pixel] = said(n->pass, record, pixel);
        }
    }
}

/* The distance, as a radius, to the nearest pixel of which the record says something else than the nearest
 * record there. */
static float agreed_radius(const nearest_record *n, const sl_record *record) {
    const sl_splat_receivers *p = &n->pass->receivers;
    sl_splat_rect rect = sl_record_bounds(n->pass, record);
    float radius = record->radius;
    for (int y = rect.y0; y < rect.y1; y++) {
        for (int x = rect.x0; x < rect.x1; x++) {
            size_t pixel = (size_t)y * (size_t)p->width + (size_t)x;
            float w = sl_record_weight(n->pass, record, pixel);
            if (!(w > 0.0f && w < n->weight[pixel])) continue;
            float here = said(n->pass, record, pixel), there = n->light[pixel],
                  most = here > there ? here : there;
            if (!(fabsf(here - there) > tolerated * most)) continue;
            sl_vec3 d = sl_sub(sl_v3(p->position_x[pixel], p->position_y[pixel], p->position_z[pixel]),
                               record->position);
            float limit = 0.999f * sl_length(d) / n->pass->weights.accuracy;
            radius = limit < radius ? limit : radius;
        }
    }
    return radius > record->minimum_radius ? radius : record->minimum_radius;
}

sl_status sl_adapt_radii(const sl_record_pass *pass, sl_record_list *list, bool *shrunk, sl_error *error) {
    size_t pixels = (size_t)pass->receivers.width * (size_t)pass->receivers.height;
    float *planes = sl_allocate(2 * pixels + list->count, sizeof *planes);
    if (!planes) return sl_fail_memory(error, "records' disagreements");
    const nearest_record nearest = {pass, planes, planes + pixels};
    float *radii = planes + 2 * pixels;
    for (size_t i = 0; i < list->count; i++) find_nearest(&nearest, &list->records[i]);
    for (size_t i = 0; i < list->count; i++) radii[i] = agreed_radius(&nearest, &list->records[i]);
    for (size_t i = 0; i < list->count; i++) {
        if (!(radii[i] < list->records[i].radius)) continue;
        list->records[i].own_radius = radii[i];
        sl_record_set_radius(&list->records[i], radii[i]);
        *shrunk = true;
    }
    sl_free(planes);
    return SL_OK;
}
