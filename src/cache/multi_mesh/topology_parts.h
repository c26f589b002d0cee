/* What sl_topology_create() is made of. */
#ifndef SL_MULTI_MESH_TOPOLOGY_PARTS_H
#define SL_MULTI_MESH_TOPOLOGY_PARTS_H

#include "cache/multi_mesh/topology.h"

/* sites.c. *first_there gets by site the lowest site at the same position, whatever its normal: it names the position. */
sl_status sl_sites_make(sl_topology *topology, bool by_exponent, uint32_t **first_there, sl_error *error);
/* edges.c */
sl_status sl_edges_make(sl_topology *topology, sl_error *error);
/* The order of `count` pairs by (low, high), equal ones as they come; both are below `limit`. */
sl_status sl_order_pairs(const uint32_t *low, const uint32_t *high, size_t count, size_t limit, uint32_t *order, sl_error *error);
/* solids.c; first_there: what sl_sites_make() gave. */
sl_status sl_solids_find(sl_topology *topology, const uint32_t *first_there, sl_error *error);

#endif
