/* The journal of a call, in a file of the first rank's: what its batches have brought (base/batch.h), so that
 * a call that was ended can be gone on with, by as many ranks as there are then. */
#pragma once

#include <stdint.h>

#include "base/batch.h"

/* All ranks say whether there is one; the path stays the caller's. */
void sl_ranks_journal_name(const char *path);
bool sl_ranks_journal_is_kept(void);
/* Opens it, or begins one; key: of all that results depend on. Returns why it cannot; NULL: it can. */
const char *sl_ranks_journal_open(uint64_t key);
/* Adds a batch that all ranks have the results of. A journal that cannot be written is given up, with a
 * line. */
void sl_ranks_journal_note(const sl_batch_plane *planes, unsigned plane_count, size_t count,
                             const sl_counters *counted);
/* When the call is done. */
void sl_ranks_journal_remove(void);
