/* Edges: which faces lie along the same two sites. The faces' edges are brought into the order of (lower
 * site, higher site, face) by two stable counting sorts; equal neighbours are one edge, whose faces then lie
 * together, ascending. */
#include "base/error.h"
#include "base/memory.h"
#include "cache/patches/topology_parts.h"

/* order_out: order_in, stably sorted by key. start has room for limit + 1. */
static void counting_sort(const uint32_t *key, size_t count, size_t limit, const uint32_t *order_in,
                          uint32_t *order_out, uint32_t *start) {
    for (size_t k = 0; k <= limit; k++) start[k] = 0;
    for (size_t i = 0; i < count; i++) start[key[i] + 1]++;
    for (size_t k = 0; k < limit; k++) start[k + 1] += start[k];
    for (size_t i = 0; i < count; i++) {
        uint32_t item = order_in == NULL ? (uint32_t)i : order_in[i];
        order_out[start[key[item]]++] = item;
    }
}

/* Gives the order of pairs by (low, high), equal ones as they come; both are below `limit`. */
static sl_status order_pairs(const uint32_t *low, const uint32_t *high, size_t count, size_t limit,
                             uint32_t *order, sl_error *error) {
    uint32_t *start = sl_allocate(limit + 1, sizeof *start), *by_high = sl_allocate(count, sizeof *by_high);
    bool good = start != NULL && by_high != NULL;
    if (good) {
        counting_sort(high, count, limit, NULL, by_high, start);
        counting_sort(low, count, limit, by_high, order, start);
    }
    sl_free(start);
    sl_free(by_high);
    return good ? SL_OK : sl_fail_memory(error, "edges");
}

/* The two sites of each face's edges: edge c of face f, opposite to corner c, at 3 f + c. */
static void face_edges(const sl_topology *topology, uint32_t *low, uint32_t *high) {
    for (size_t f = 0; f < topology->face_count; f++)
        for (size_t c = 0; c < 3; c++) {
            uint32_t a = topology->site[(c + 1) % 3][f], b = topology->site[(c + 2) % 3][f];
            low[3 * f + c] = a < b ? a : b;
            high[3 * f + c] = a < b ? b : a;
        }
}

static bool begins_edge(const uint32_t *low, const uint32_t *high, const uint32_t *order, size_t i) {
    return i == 0 || low[order[i]] != low[order[i - 1]] || high[order[i]] != high[order[i - 1]];
}

/* Numbers the edges in their order and lists their faces. */
static void list_edges(sl_topology *topology, const uint32_t *low, const uint32_t *high,
                       const uint32_t *order, size_t count) {
    size_t e = 0;
    for (size_t i = 0; i < count; i++) {
        if (begins_edge(low, high, order, i)) {
            topology->edge_start[e] = (uint32_t)i;
            topology->edge_high[e] = high[order[i]];
            topology->edge_low[e] = low[order[i]];
            e++;
        }
        topology->edge[order[i] % 3][order[i] / 3] = (uint32_t)(e - 1);
        topology->edge_face[i] = order[i] / 3;
    }
    topology->edge_start[e] = (uint32_t)count;
}

static sl_status make_edges(sl_topology *topology, uint32_t *low, uint32_t *high, uint32_t *order,
                            sl_error *error) {
    size_t count = 3 * topology->face_count;
    face_edges(topology, low, high);
    sl_status status = order_pairs(low, high, count, topology->site_count, order, error);
    if (status != SL_OK) return status;
    for (size_t i = 0; i < count; i++) topology->edge_count += begins_edge(low, high, order, i);
    topology->edge_start = sl_allocate(topology->edge_count + 1, sizeof(uint32_t));
    topology->edge_high = sl_allocate(topology->edge_count, sizeof(uint32_t));
    topology->edge_face = sl_allocate(count, sizeof(uint32_t));
    topology->edge_low = sl_allocate(topology->edge_count, sizeof(uint32_t));
    if (topology->edge_start == NULL || topology->edge_high == NULL || topology->edge_face == NULL ||
        topology->edge_low == NULL)
        return sl_fail_memory(error, "edges");
    list_edges(topology, low, high, order, count);
    return SL_OK;
}

sl_status sl_edges_make(sl_topology *topology, sl_error *error) {
    size_t count = 3 * topology->face_count;
    uint32_t *low = sl_allocate(count, sizeof *low), *high = sl_allocate(count, sizeof *high),
             *order = sl_allocate(count, sizeof *order);
    sl_status status = SL_OK;
    if (low != NULL && high != NULL && order != NULL) status = make_edges(topology, low, high, order, error);
    else status = sl_fail_memory(error, "edges");
    sl_free(low);
    sl_free(high);
    sl_free(order);
    return status;
}
