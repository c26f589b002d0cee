#include "base/ranks.h"

sl_ranks sl_ranks_here(void) { return (sl_ranks){0, 1}; }

bool sl_ranks_agree(uint64_t number) {
    (void)number;
    return true;
}

void sl_ranks_exchange(void *items, size_t count, size_t bytes, sl_counters *counted) {
    (void)items, (void)count, (void)bytes, (void)counted;
}
