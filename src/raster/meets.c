/* Whether a view has anything to draw, before anything is cleared for it. */
#include "raster/pipeline.h"

/* The bounds reach across the plane, or lie before it; with room for rounding, as culling has it. NaN counts
 * as inside. */
static bool reaches(const sl_raster *r, const sl_pass_view *view, const float plane[4], size_t c) {
    float x = plane[0] * (r->centre_x[c] - view->origin[0]),
          y = plane[1] * (r->centre_y[c] - view->origin[1]);
    float z = plane[2] * (r->centre_z[c] - view->origin[2]);
    float reach =
        fabsf(plane[0]) * r->half_x[c] + fabsf(plane[1]) * r->half_y[c] + fabsf(plane[2]) * r->half_z[c];
    float slack = 1e-5f * (fabsf(x) + fabsf(y) + fabsf(z) + fabsf(plane[3]) + reach) + 1e-37f;
    return !(x + y + z + plane[3] < -(reach + slack));
}

bool sl_raster_meets(const sl_raster *raster, const sl_view *view) {
    const sl_pass_view pass = sl_pass_view_make(view, view->x + view->width, view->y + view->height);
    for (size_t c = 0; c < raster->cluster_count; c++) {
        int k = 0;
        while (k < pass.planes && reaches(raster, &pass, pass.plane[k], c)) k++;
        if (k == pass.planes) return true;
    }
    return false;
}
