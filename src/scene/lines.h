/* Text files line by line, and the words and numbers of a line. */
#pragma once

#include "softlux.h"

typedef struct sl_lines {
    const char *path;
    char *at, *end;           /* what is left of the text, which is cut into lines in place */
    char *rest;               /* of the line at hand, where values may stand in any line; NULL: it ended */
    unsigned long line, next; /* numbers of the line at hand and of the one behind it */
    sl_error *error;
} sl_lines;

/* Reads a file whose lines are in *text then, to be freed. A byte that is zero is an input error. */
sl_status sl_lines_open(const char *path, char **text, sl_lines *lines, sl_error *error);
/* Returns the next line that is not empty, without blanks at its ends, or NULL. An end behind a backslash is
 * a blank, but for that of a comment, where a path of Windows may stand. */
char *sl_lines_next(sl_lines *lines);
/* Fails with the line at hand, what was expected there and the word that is there instead; NULL: the file
 * ends. */
sl_status sl_lines_fail(const sl_lines *lines, const char *expected, const char *got);

/* For values that may stand in any line. Goes on to the next one with a value in it, if none is left in that
 * at hand; false at the end of the file. */
bool sl_lines_more(sl_lines *lines);
/* Reads the next value, a decimal number, or a whole one from low to high; fails where it is another. */
sl_status sl_lines_decimal(sl_lines *lines, const char *expected, double *value);
sl_status sl_lines_whole(sl_lines *lines, const char *expected, double low, double high, uint32_t *value);

char *sl_word_end(char *at);
char *sl_word_after(char *at); /* the beginning of the next one */
/* Compares the word at hand; upper and lower case are the same. */
bool sl_word_is(const char *at, const char *word);
/* Returns whether nothing or a comment is left of the line. */
bool sl_is_line_end(const char *at);

/* Reads the float nearest to a decimal number, or one that is not finite, in the C locale. Returns what
 * stands behind it and its blanks; NULL where there is none. */
char *sl_read_number(char *at, float *value);
/* Writes a finite number with as few digits, six at least, as read back to the same bits; returns text. */
enum { SL_NUMBER_ROOM = 32 };
const char *sl_write_number(float value, char text[SL_NUMBER_ROOM]);
