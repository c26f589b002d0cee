/* Names of files are bytes, JSON is UTF-8. */
#ifndef SL_APP_UTF8_H
#define SL_APP_UTF8_H

/* Puts a question mark in place of each byte that belongs to no character of UTF-8. Returns the text; NULL is
 * allowed. */
char *sl_utf8_mend(char *text);

#endif
