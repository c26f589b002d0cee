/* The table of options as help pages show it. */
#ifndef SL_APP_SETTINGS_TEXT_H
#define SL_APP_SETTINGS_TEXT_H

#include "cache/frame/settings.h"

/* The last part of a setting's name: what the command line calls it. */
const char *sl_setting_flag(const sl_setting *setting);
/* The setting that it calls so; NULL where there is none. */
const sl_setting *sl_setting_of_flag(const char *flag);
/* Its line of help, with the default in brackets. */
void sl_setting_help(const sl_setting *setting, char *text, size_t room);
/* Prints all of them, method by method. */
void sl_print_settings(void);

#endif
