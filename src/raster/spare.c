/* Buffers of earlier passes, kept for later ones: a pass over a large target would otherwise begin by having
 * a megabyte faulted in page by page and cleared. Passes run at the same time, so each takes what it needs
 * for itself alone and gives it back afterwards. */
#include <stdatomic.h>

#include "base/memory.h"
#include "raster/pipeline.h"

enum { SPARES = 8 };

struct sl_spares {
    _Atomic(sl_raster_scratch *) kept[SPARES];
};

struct sl_spares *sl_spares_create(void) { return sl_allocate(1, sizeof(struct sl_spares)); }

void sl_spares_destroy(struct sl_spares *spares) {
    for (int i = 0; spares && i < SPARES; i++) sl_raster_scratch_destroy(atomic_load(&spares->kept[i]));
    sl_free(spares);
}

sl_raster_scratch *sl_spare_take(const sl_raster *raster) {
    sl_raster_scratch *scratch = NULL;
    for (int i = 0; i < SPARES && !scratch; i++) scratch = atomic_exchange(&raster->spares->kept[i], NULL);
    if (!scratch && sl_raster_scratch_create(raster, 0, 0, &scratch, NULL) != SL_OK) return NULL;
    return scratch;
}

void sl_spare_give(const sl_raster *raster, sl_raster_scratch *scratch) {
    for (int i = 0; i < SPARES && scratch; i++) {
        sl_raster_scratch *none = NULL;
        if (atomic_compare_exchange_strong(&raster->spares->kept[i], &none, scratch)) return;
    }
    sl_raster_scratch_destroy(scratch);
}
