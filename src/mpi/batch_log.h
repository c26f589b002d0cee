/* batch_log.c */
#ifndef SL_MPI_BATCH_LOG_H
#define SL_MPI_BATCH_LOG_H

void sl_batch_log_open(void);
void sl_batch_log_close(void);

#endif
