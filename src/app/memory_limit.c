#include "app/memory_limit.h"

#include "base/error.h"
#include "base/sanitized.h"

#include <malloc.h>
#include <math.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

/* Code and tables of libraries are resident, and no data. */
static const double of_files = 16.0 * 0x1p20;
/* Once threads run: stacks, and what allocators and Embree reserve without using it; Embree's first device
 * alone 128 MB. */
static const double reserve = 192.0 * 0x1p20, reserve_of_thread = 24.0 * 0x1p20;

static void limit_data(double most) {
    struct rlimit limit;
    if (SL_SANITIZED || getrlimit(RLIMIT_DATA, &limit) != 0) return;
    limit.rlim_cur =
        limit.rlim_max == RLIM_INFINITY || most < (double)limit.rlim_max ? (rlim_t)most : limit.rlim_max;
    setrlimit(RLIMIT_DATA, &limit); /* where it fails there is the method's own account */
}

static double while_rendering(const sl_settings *settings) {
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    const double threads = settings->threads ? (double)settings->threads
                           : processors > 0  ? (double)processors
                                             : 1.0;
    return (double)settings->memory_bytes + reserve + reserve_of_thread * threads;
}

/* Else glibc gives no block back that is as large as one that was freed before, and what is free between
 * those in use is taken all the same. */
static void return_freed_memory(void) {
    enum { OF_ITS_OWN = 1 << 20 }; /* bytes */
    mallopt(M_MMAP_THRESHOLD, OF_ITS_OWN);
}

sl_status sl_load_within_memory(const char *path, const sl_load_options *load, const sl_settings *settings,
                                sl_scene **scene, sl_error *error) {
    if (settings->memory_bytes) {
        return_freed_memory();
        limit_data(fmax((double)settings->memory_bytes - of_files, of_files));
    }
    sl_status status = sl_scene_load_with(path, load, scene, error);
    if (settings->memory_bytes) limit_data(while_rendering(settings));
    bool by_reader =
        status == SL_ERROR_INPUT && (strstr(error->message, "bad_alloc") ||
                                     strstr(error->message, "llocation") || strstr(error->message, "memory"));
    if (!settings->memory_bytes || (status != SL_ERROR_RESOURCES && !by_reader)) return status;
    return sl_fail(error, SL_ERROR_RESOURCES,
                   "%s: %.0fM of memory are not enough to load it; give more memory", path,
                   (double)settings->memory_bytes / 0x1p20);
}

/* Heaps of single threads go back to the system as soon as they are empty, whatever is to be kept: all
 * threads use one. */
void sl_keep_freed_memory(const sl_settings *settings) {
    enum { KEPT = 512 << 20, FROM_HEAP = 32 << 20 };
    if (settings->memory_bytes) return;
    mallopt(M_ARENA_MAX, 1);
    mallopt(M_TRIM_THRESHOLD, KEPT);
    mallopt(M_MMAP_THRESHOLD, FROM_HEAP);
}
