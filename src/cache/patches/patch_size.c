/* The size of a patch in the picture: of its corners as the camera sees them, or of cells of a curved one. */
#include "cache/patches/patches.h"

static sl_clip_point seen_at(const sl_patches *p, const sl_view *view, uint32_t root, uint32_t u,
                             uint32_t v) {
    return sl_clip_point_of(view, sl_root_position(p->primitives, root, u, v));
}

static void add(const sl_view *view, sl_clip_point a, sl_clip_point b, sl_clip_point c,
                sl_screen_size *size) {
    sl_screen_size part = sl_screen_size_of(view, 3, (const sl_clip_point[3]){a, b, c});
    size->area += part.area;
    size->edge = fmaxf(size->edge, part.edge);
}

/* A curved patch may bulge out of what its corners span, or come back to where it began: four by four cells
 * of it, two triangles each. */
static sl_screen_size curved_size(const sl_patches *p, const sl_view *view, const sl_patch_place *place) {
    enum { CELLS = 4 };
    sl_clip_point grid[CELLS + 1][CELLS + 1];
    sl_screen_size size = {0.0f, 0.0f};
    uint32_t side_u = (uint32_t)(place->u[2] - place->u[0]), side_v = (uint32_t)(place->v[2] - place->v[0]);
    for (uint32_t j = 0; j <= CELLS; j++) {
        for (uint32_t i = 0; i <= CELLS; i++) {
            grid[j][i] = seen_at(p, view, place->root, place->u[0] + side_u * i / CELLS,
                                 place->v[0] + side_v * j / CELLS);
        }
    }
    for (int j = 0; j < CELLS; j++) {
        for (int i = 0; i < CELLS; i++) {
            add(view, grid[j][i], grid[j][i + 1], grid[j + 1][i + 1], &size);
            add(view, grid[j][i], grid[j + 1][i + 1], grid[j + 1][i], &size);
        }
    }
    size.edge *= (float)CELLS; /* the patch's: its cells' sides are a quarter of that */
    return size;
}

sl_screen_size sl_patch_projected(const sl_patches *p, const sl_patch_place *place, const sl_camera *camera,
                                  int width, int height) {
    sl_view view = sl_view_of_camera(p->primitives->scene, camera, width, height);
    if (p->primitives->kind[place->root / 2] == SL_PRIMITIVE_BICUBIC) return curved_size(p, &view, place);
    sl_clip_point corner[4];
    for (int c = 0; c < place->corners; c++)
        corner[c] = seen_at(p, &view, place->root, place->u[c], place->v[c]);
    return sl_screen_size_of(&view, place->corners, corner);
}
