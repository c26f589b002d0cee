/* Why photons flash, and what is done about it.
 *
 * While the light moves, the scene's edges slide over the texels of its pictures, and a texel whose middle an edge passes changes from one
 * surface to another between two frames. With point samples that is a whole photon, 1/m^2 of a face. With groups (photon_groups.c) it is one
 * texel's share of a photon, so that what remains are three things, each with its remedy:
 *
 *   Edges pass whole rows of texels at once. A cube map's faces have the world's axes, and so has most of what people build:
 *   an edge is parallel to the rows, and a box seen from a gliding light changes a row a time. A point light's cube may as well have any
 *   other axes: turned by angles that no building has, edges cross the rows, and pass their texels one by one.
 *   Pictures of other lights roll about the way they look.
 *
 *   Texels are coarse. Twice as many each way make each a quarter; the rasterizer does not notice.
 *
 *   Slivers. A group of a single texel has a tiny area A, and receivers beside it get its radiance in full, as if they touched it:
 *   E <= pi L_o. It comes and goes. With the area of the whole block, as if all of the block were on its surface, the bound is the
 *   group's share of pi L_o, and so grows with each texel that joins. Its price is light that receivers very near to edges lose.
 *
 * Measured: the room of tests/cache/direct_radiance/test_direct_radiance_steady.c, but 100 steps, m = 4, and 244 receivers, some of them on the box; the difference
 * between the irradiance's change in a frame and that of 38,400 photons (at most 0.087), and that of the irradiance itself, of its mean:
 *
 *                              largest flash     root mean square     error
 *     point samples                0.48               0.029           0.145
 *     groups                       0.18               0.015           0.090
 *     + turned                     0.17               0.009           0.084
 *     + twice the texels           0.17               0.0065          0.083
 *     + whole blocks' areas        0.053              0.0056          0.108   (m = 8: 0.046, 0.0049, 0.041; without 0.061, 0.0052, 0.031)
 *
 * Whole blocks' areas have the error that flux photons have next to surfaces anyway, a third more of it, and it stands still: of what moves,
 * the eye sees the rest. With areas of at least half a block the numbers were 0.090, 0.0061, 0.089.
 *
 * Not taken: blocks that overlap, texels shared by four of them with bilinear weights. It makes more slivers, of smaller shares: 0.59 and
 * 0.0090 where groups, turned, with twice the texels had 0.17 and 0.0065, with 1.4 times as many photons. Nor a history of which texel was in
 * which group: a frame would depend on those before it. */
#include "cache/direct_radiance/steady.h"

/* Two turns, of 36 and 27 degrees: no edge of a room, of its diagonals or of a roof of 30 or 45 degrees has these axes. */
#define COS_36 0.80901699f
#define SIN_36 0.58778525f
#define COS_27 0.89100652f
#define SIN_27 0.45399050f

static sl_vec3 turn(sl_vec3 a) {
    sl_vec3 b = sl_v3(COS_36 * a.x + SIN_36 * a.z, a.y, COS_36 * a.z - SIN_36 * a.x);
    return sl_v3(b.x, COS_27 * b.y - SIN_27 * b.z, SIN_27 * b.y + COS_27 * b.z);
}

sl_frame sl_steady_cube_frame(sl_frame frame) { return (sl_frame){turn(frame.x), turn(frame.y), turn(frame.z)}; }

sl_frame sl_steady_roll(sl_frame picture) {
    return (sl_frame){sl_mad(sl_scale(picture.x, COS_27), SIN_27, picture.y), sl_mad(sl_scale(picture.y, COS_27), -SIN_27, picture.x),
                      picture.z};
}

int sl_steady_map_size(int size) { return size <= 512 ? 2 * size : size; }

double sl_steady_area(double area, double of_block) { return area / of_block; }
