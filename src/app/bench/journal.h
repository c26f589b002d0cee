/* Measurements, one JSON object a line, appended as soon as it is known: whatever ends the program,
 * this is kept, and the next run goes on from here. An entry counts for the very same work only: its key
 * holds the scene's hash, the size, the threads, the arguments and the program's own fingerprint. */
#pragma once

#include "softlux.h"

#include <cjson/cJSON.h>

typedef struct sl_journal sl_journal;

/* Reads what there is; a line that was cut off is passed over. The file need not exist. */
sl_status sl_journal_open(const char *path, sl_journal **journal, sl_error *error);
void sl_journal_close(sl_journal *journal);
/* Returns the last entry with this "key", or NULL. The journal owns it. */
const cJSON *sl_journal_find(const sl_journal *journal, const char *key);
/* Hands out all entries, in order; NULL past the end. */
const cJSON *sl_journal_at(const sl_journal *journal, size_t index);
/* Takes the entry, which has a "key", and appends it to the file. */
sl_status sl_journal_add(sl_journal *journal, cJSON *entry, sl_error *error);
/* Writes, of the program that runs, 16 hexadecimal digits of the content of its file. */
void sl_program_fingerprint(char text[17]);
