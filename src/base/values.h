/* Values as people write them in options, read with a decimal point whatever the locale. What is expected
 * otherwise is told in *error, for the caller to put the option's name before it. */
#pragma once


#include "softlux.h"

/* Bounds count where least < most. */
sl_status sl_value_real(const char *text, double least, double most, double *value, sl_error *error);
sl_status sl_value_count(const char *text, double least, double most, uint64_t *value, sl_error *error);
/* 512M, 2GiB, 900000000: K, M, G and T are powers of 1024. */
sl_status sl_value_bytes(const char *text, double least, double most, uint64_t *value, sl_error *error);
/* 640x480, each from 1 to `most`. */
sl_status sl_value_size(const char *text, int most, int size[2], sl_error *error);
/* Three numbers: 1,2.5,-3. */
sl_status sl_value_vector(const char *text, float vector[3], sl_error *error);
/* choices: "auto|rays|maps"; *index counts them from 0. */
sl_status sl_value_choice(const char *text, const char *choices, int *index, sl_error *error);
/* Writes choice number `index`; "" past the end. */
void sl_value_choice_name(const char *choices, int index, char *text, size_t room);

/* Tells whether a text ends so, as file names do: upper and lower case are the same. */
bool sl_ends_with(const char *text, const char *ending);

/* Returns the candidate nearest to a misspelt word: one that begins with it, or it with that, or by edit
 * distance, upper and lower case being the same; NULL if none is near. */
const char *sl_nearest_word(const char *word, const char *const *candidates, size_t count);
