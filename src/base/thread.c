#include "base/thread.h"

bool sl_monitor_open(sl_monitor *m) {
    if (pthread_mutex_init(&m->lock, NULL) != 0) return false;
    if (pthread_cond_init(&m->changed, NULL) == 0) return true;
    pthread_mutex_destroy(&m->lock);
    return false;
}

void sl_monitor_close(sl_monitor *m) {
    pthread_cond_destroy(&m->changed);
    pthread_mutex_destroy(&m->lock);
}

static void *run(void *argument) {
    const sl_thread *thread = argument;
    thread->run(thread->context);
    return NULL;
}

bool sl_thread_start(sl_thread *thread, void (*run_this)(void *context), void *context) {
    thread->run = run_this;
    thread->context = context;
    return pthread_create(&thread->handle, NULL, run, thread) == 0;
}

void sl_thread_join(sl_thread *thread) { pthread_join(thread->handle, NULL); }
