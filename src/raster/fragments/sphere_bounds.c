/* Bounds of a sphere on the screen: one axis at a time, in the plane of that axis and the viewing direction,
 * where the sphere is seen between the two tangents of its circle; where the near plane cuts a tangent's
 * point of contact away, the bound is that of the circle's section with the near plane. */
#include <math.h>

#include "base/math.h"
#include "raster/raster.h"

/* Tangent of the bound on one side; sign +1: the upper, -1: the lower. c, z: the centre sideways and forward.
 */
static double bound(double c, double z, double r, double near, double sign) {
    double d2 = c * c + z * z;
    if (d2 > r * r) {
        double d = sqrt(d2), l = sqrt(d2 - r * r);
        double contact = l * (c / d * l + sign * (z / d * r)) / d;
        double contact_z = l * (z / d * l - sign * (c / d * r)) / d;
        if (contact_z >= near) return contact / contact_z;
    }
    double h = near - z, half = r * r - h * h;
    return (c + sign * sqrt(half > 0.0 ? half : 0.0)) / near;
}

/* Pixel coordinate of a tangent, rounded outwards by a pixel and kept on the target; NaN counts as the outer
 * end. */
static int to_pixel(double tangent, double scale, int size, double sign) {
    double x = (tangent * scale + 1.0) * 0.5 * (double)size;
    double outward = sign > 0.0 ? ceil(x) + 1.0 : floor(x) - 1.0;
    if (sign > 0.0) return !(outward < (double)size) ? size : outward > 0.0 ? (int)outward : 0;
    return !(outward > 0.0) ? 0 : outward < (double)size ? (int)outward : size;
}

sl_splat_rect sl_sphere_bounds(const sl_camera *camera, int width, int height, float near, sl_vec3 centre,
                               float radius) {
    const sl_splat_rect screen = {0, 0, width, height}, empty = {0, 0, 0, 0};
    sl_vec3d q = sl_subd(sl_to_double(centre), sl_to_double(camera->eye));
    double x = sl_dotd(sl_to_double(camera->right), q), y = sl_dotd(sl_to_double(camera->up), q);
    double z = -sl_dotd(sl_to_double(camera->back), q), r = (double)radius, n = (double)near;
    if (z + r < n || r < 0.0) return empty;
    if (!(x * x + y * y + z * z > r * r)) return screen; /* the camera inside, or not a number */
    double scale_y = 1.0 / sl_tan(0.5 * (double)camera->vertical_fov),
           scale_x = scale_y * (double)height / (double)width;
    sl_splat_rect rect = {to_pixel(bound(x, z, r, n, -1.0), scale_x, width, -1.0),
                          to_pixel(bound(y, z, r, n, -1.0), scale_y, height, -1.0),
                          to_pixel(bound(x, z, r, n, 1.0), scale_x, width, 1.0),
                          to_pixel(bound(y, z, r, n, 1.0), scale_y, height, 1.0)};
    return rect.x0 < rect.x1 && rect.y0 < rect.y1 ? rect : empty;
}
