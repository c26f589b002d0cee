/* The part of space, and of a surface, for which one sample of a light's picture stands: (12), (13), and what they should be. */
#ifndef SL_CACHE_DIRECT_RADIANCE_FOOTPRINT_H
#define SL_CACHE_DIRECT_RADIANCE_FOOTPRINT_H

/* Exact solid angle of the rectangle [x0,x1] x [y0,y1] of a picture plane at distance 1: atan(x y / sqrt(1 + x^2 + y^2)) at
 * its corners, with alternating signs. Those of a picture's parts add up
 * to 4 asin(sin^2(fov/2)), those of a cube's six faces to 4 pi. */
double sl_rectangle_solid_angle(double x0, double y0, double x1, double y1);
/* (12) as printed but with the number m of samples a side where the paper has its texels: (2 b tan(fov / 2m))^2. */
double sl_printed_footprint(double b, double fov, int m);
/* (13): A' / cos alpha; infinite at grazing incidence, 0 below. */
double sl_printed_tilted_footprint(double footprint, double cos_alpha);

#endif
