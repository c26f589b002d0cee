/* How quiet the machine is: a fixed amount of arithmetic, done again and again between the trials. What
 * varies is the machine. */
#ifndef SL_APP_BENCH_CALIBRATION_H
#define SL_APP_BENCH_CALIBRATION_H

typedef struct sl_calibration {
    double wall, cpu; /* seconds */
} sl_calibration;

sl_calibration sl_calibrate(void);

#endif
