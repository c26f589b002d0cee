/* A thread that runs beside the caller's, and the lock under which the two meet: for what goes on at its own
 * pace, as samples do beside the display. Loops over data are parallel.h's. POSIX threads rather than those
 * of C11: the thread sanitizer sees through these alone. */
#pragma once

#include <pthread.h>
#include <stdbool.h>

/* A lock, held for a few assignments at a time, and a signal that what it guards has changed. */
typedef struct sl_monitor {
    pthread_mutex_t lock;
    pthread_cond_t changed;
} sl_monitor;

bool sl_monitor_open(sl_monitor *monitor); /* false: the machine has no more of them */
void sl_monitor_close(sl_monitor *monitor);
static inline void sl_monitor_enter(sl_monitor *m) { pthread_mutex_lock(&m->lock); }
static inline void sl_monitor_leave(sl_monitor *m) { pthread_mutex_unlock(&m->lock); }
/* Inside. Gives the lock away until another thread has signalled: to be called again until what is waited for
 * is so. */
static inline void sl_monitor_wait(sl_monitor *m) { pthread_cond_wait(&m->changed, &m->lock); }
/* The same, but for so many seconds at most, of which one is the most. */
void sl_monitor_wait_for(sl_monitor *monitor, double seconds);
static inline void sl_monitor_signal(sl_monitor *m) { pthread_cond_broadcast(&m->changed); }

typedef struct sl_thread {
    pthread_t handle;
    void (*run)(void *context);
    void *context;
} sl_thread;

/* The thread stays where it is until it is joined. False: no thread could be had. */
bool sl_thread_start(sl_thread *thread, void (*run)(void *context), void *context);
void sl_thread_join(sl_thread *thread); /* waits for its end */
