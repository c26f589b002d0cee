/* The error of a picture against a reference that is itself a little noisy. */
#pragma once

#include "app/bench/results.h"

/* Relative RMSE over all pixels, without the reference's noise: with A and B its independent halves,
 * E[(x-A)(x-B)] = (x-truth)^2. difference (may be NULL) receives false colours, which the caller destroys.
 * Fails where the picture has no R, G, B or another size. */
sl_status sl_judge(const sl_image *picture, const sl_image *reference, sl_bench_error *result,
                   sl_image **difference, sl_error *error);
/* Does the same without what needs neighbours: rel_rmse, doubt, noise and lost alone. */
sl_status sl_judge_quickly(const sl_image *picture, const sl_image *reference, sl_bench_error *result,
                           sl_error *error);
/* Finds the reference's own noise, and its mean. */
sl_status sl_judge_noise(const sl_image *reference, double *noise, double *mean, sl_error *error);
