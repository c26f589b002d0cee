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

bool sl_ranks_share_files(const char *folder, bool some) {
    (void)folder;
    return some;
}
