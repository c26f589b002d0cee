/* Gauss-Legendre quadrature, for tables that are computed once. */
#ifndef SL_CACHE_QUADRATURE_H
#define SL_CACHE_QUADRATURE_H

enum { SL_GAUSS_MAX = 128 };

/* Nodes (ascending) and weights on [0,1]: exact for polynomials up to degree 2 count - 1. 1 <= count <=
 * SL_GAUSS_MAX. */
void sl_gauss_legendre(int count, double *nodes, double *weights);

/* The same for integrands that behave like a root of the distance to an end: the nodes crowd there, so that a
 * root becomes a polynomial. x = v^2 (3 - 2v) has both ends so, x = 1 - (1 - v)^2 the upper end alone. */
void sl_gauss_both_ends(int count, double *nodes, double *weights);
void sl_gauss_upper_end(int count, double *nodes, double *weights);

#endif
