/* The parts of sl_topology_create(). */
#ifndef SL_PATCHES_TOPOLOGY_PARTS_H
#define SL_PATCHES_TOPOLOGY_PARTS_H

#include "cache/patches/topology.h"

/* sites.c */
sl_status sl_sites_make(sl_topology *topology, bool by_exponent, sl_error *error);
/* edges.c */
sl_status sl_edges_make(sl_topology *topology, sl_error *error);

#endif
