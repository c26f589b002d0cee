#include "base/ranks.h"

sl_ranks sl_ranks_here(void) { return (sl_ranks){0, 1}; }

bool sl_ranks_share(void) { return false; }

const char *sl_ranks_begin(uint64_t scene) {
    (void)scene;
    return NULL;
}

void sl_ranks_exchange(const sl_batch_plane *planes, unsigned plane_count, size_t count,
                       sl_counters *counted) {
    (void)planes, (void)plane_count, (void)count, (void)counted;
}

bool sl_ranks_recall(const sl_batch_plane *planes, unsigned plane_count, size_t count, sl_counters *counted) {
    (void)planes, (void)plane_count, (void)count, (void)counted;
    return false;
}

void sl_ranks_tell(unsigned teller, void *bytes, size_t count) { (void)teller, (void)bytes, (void)count; }
