/* Indirect light before anything of it is known: rho Phi / A, mean reflectance times power of all lights over
 * area of all surfaces. In a closed cavity of one reflectance that is what one bounce brings on the average,
 * and in a sphere what it brings everywhere. The environment adds its mean over all directions, as if nothing
 * stood before it. */
#pragma once

#include "scene/scene.h"

/* Irradiance, W/m^2; finite. */
sl_rgb sl_ambient_irradiance(const sl_scene *scene);
/* rho Phi / (A (1 - rho)): of all bounces. */
sl_rgb sl_ambient_irradiance_of_all_bounces(const sl_scene *scene);

/* k_d, the mean over all surfaces of the channel of which it is the largest. */
double sl_mean_reflectance(const sl_scene *scene);

/* 0 where it is not finite. */
double sl_triangle_area(const sl_scene *scene, size_t triangle);
