/* A robed figure as a signed distance, and its surface as triangles. */
#pragma once

#include "mesh.h"

/* About the distance from p to the statue's surface, negative inside; the feet stand at y = 0, facing +z, 2.1
 * m tall. */
double gen_statue_distance(v3 p);
/* The statue's surface cut into cells of the given size: two triangles for each crossed edge of the grid. */
void gen_statue(mesh *m, double cell);
