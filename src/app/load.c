#define _XOPEN_SOURCE 700 /* sigaltstack() */
#include "app/load.h"

#include <signal.h>
#include <string.h>
#include <unistd.h>

/* Sanitizers tell of crashes themselves, and more. */
#if defined(__has_feature)
#define SL_SANITIZED (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SL_SANITIZED 1
#else
#define SL_SANITIZED 0
#endif

enum { CRASHES = 5, STACK_BYTES = 1 << 16 };
static const int crashes[CRASHES] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

static const char *volatile being_read; /* handlers get no context */

static void say(const char *text) {
    if (write(STDERR_FILENO, text, strlen(text)) < 0) _exit(SL_ERROR_INPUT);
}

static void on_crash(int signal_number) {
    (void)signal_number;
    say("softlux: ");
    say(being_read);
    say(": cannot be read: its reader crashed, as the importer of mesh files does on some damaged ones; expected a sound file\n");
    _exit(SL_ERROR_INPUT);
}

sl_status sl_load_scene(const char *path, const sl_load_options *options, sl_scene **scene, sl_error *error) {
    static char stack[STACK_BYTES]; /* what was read may have been nested so deep that the process's own is full */
    const stack_t apart = {.ss_sp = stack, .ss_size = sizeof stack};
    struct sigaction before[CRASHES], action = {.sa_handler = on_crash, .sa_flags = (int)(SA_ONSTACK | SA_RESETHAND)};
    sigemptyset(&action.sa_mask);
    being_read = path;
    bool watched = !SL_SANITIZED && sigaltstack(&apart, NULL) == 0;
    for (int i = 0; watched && i < CRASHES; i++) sigaction(crashes[i], &action, &before[i]);
    sl_status status = sl_scene_load_with(path, options, scene, error);
    for (int i = 0; watched && i < CRASHES; i++) sigaction(crashes[i], &before[i], NULL);
    return status;
}
