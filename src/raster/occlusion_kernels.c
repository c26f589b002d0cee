/* Occlusion: whether all that a rectangle of pixels shows already is nearer than a bound, so that nothing
 * behind the bound can be seen (Greene, Kass and Miller 1993, "Hierarchical Z-buffer visibility", without the
 * hierarchy: a cluster covers few blocks, and the first of them that has a gap ends the search). */
#include "raster/block.h"
#include "raster/tile.h"

/* Pixels, numbered from the tile's first, within [first, last] in one direction. */
static inline sl_lanes_ints within(sl_lanes_ints i, int first, int last) {
    return (i >= first) & (i <= last);
}

/* Hidden means strictly behind: at equal depth the lower triangle index wins. */
static inline sl_lanes_ints open_pixels(const float *depth, sl_lanes_floats nearest, bool larger_is_nearer) {
    const sl_lanes_floats drawn = sl_lanes_load_floats(depth);
    return larger_is_nearer ? nearest >= drawn : nearest <= drawn;
}

/* Pixels are numbered from the tile's first. Row by row of blocks; only the outer blocks need masks. */
static inline bool shows(const sl_tile *tile, const sl_rectangle *r, float bound, bool larger_is_nearer) {
    const int bx0 = r->x0 / SL_BLOCK, bx1 = r->x1 / SL_BLOCK;
    const sl_lanes_floats nearest = sl_lanes_float(bound);
    const sl_lanes_ints left = within(bx0 * SL_BLOCK + sl_part_x(), r->x0, r->x1);
    const sl_lanes_ints right = within(bx1 * SL_BLOCK + sl_part_x(), r->x0, r->x1);
    for (int by = r->y0 / SL_BLOCK; by <= r->y1 / SL_BLOCK; by++) {
        for (int part = 0; part < SL_PARTS; part++) {
            const float *depth =
                tile->depth + (size_t)(by * tile->blocks_x + bx0) * SL_LANES + part * SL_WIDTH;
            sl_lanes_ints shown = open_pixels(depth, nearest, larger_is_nearer) & left;
            for (int bx = bx0 + 1; bx < bx1; bx++) {
                depth += SL_LANES;
                shown |= open_pixels(depth, nearest, larger_is_nearer);
            }
            if (bx1 > bx0) shown |= open_pixels(depth + SL_LANES, nearest, larger_is_nearer) & right;
            if (sl_lanes_negative(shown &
                                 within(by * SL_BLOCK + part * SL_PART_ROWS + sl_part_y(), r->y0, r->y1)))
                return true;
        }
    }
    return false;
}

bool SL_KERNEL(sl_raster_occluded)(const sl_pass_view *view, const sl_tile *tile, sl_rectangle pixels,
                                   float nearest) {
    sl_rectangle r = {pixels.x0 - tile->left, pixels.y0 - tile->low, pixels.x1 - tile->left,
                      pixels.y1 - tile->low};
    return view->inverse_w ? !shows(tile, &r, nearest, true) : !shows(tile, &r, nearest, false);
}
