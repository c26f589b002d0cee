/* What pixels weigh in a gather: pi times the share of a uniform hemisphere's irradiance that comes through each, in closed form. */
#ifndef SL_MULTI_MESH_GATHER_WEIGHTS_H
#define SL_MULTI_MESH_GATHER_WEIGHTS_H

/* N x N pixels over [-t, t]^2 of the plane at unit distance above the point: pi Delta G. Symmetric: eight pixels have the same bits. */
void sl_mesh_gather_top_weights(int size, double t, float *weight);
/* width x height pixels over [-1, 1] x [0, v] of a plane that stands upright at unit distance from the point. Symmetric in the first. */
void sl_mesh_gather_side_weights(int width, int height, double v, float *weight);

#endif
