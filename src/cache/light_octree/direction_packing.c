/* A direction in one float beside its light's colour: polar angle and azimuth in equal steps, a = columns * q_theta + q_phi.
 * The number of steps of theta is even, so that the six axes have codes of their own; an integer below 2^24 is exact in 32 bits. */
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/light_octree/lights.h"

static uint32_t columns_of(bool wide) { return wide ? 4096 : 256; }
static uint32_t steps_of(bool wide) { return wide ? 4094 : 254; } /* of theta, from pole to pole */

/* sin and cos of step / steps of a full turn; steps is a multiple of four or twice an odd number, quarter turns are exact. */
static void turn(uint32_t step, uint32_t steps, double *sine, double *cosine) {
    uint32_t quarters = 4 * step / steps;
    double angle = 2.0 * SL_PI * ((double)(4 * step - quarters * steps) / (4.0 * (double)steps)); /* in the quarter */
    double s = 4 * step == quarters * steps ? 0.0 : sl_sin(angle), c = 4 * step == quarters * steps ? 1.0 : sl_cos(angle);
    switch (quarters & 3) {
    case 0: *sine = s, *cosine = c; break;
    case 1: *sine = c, *cosine = -s; break;
    case 2: *sine = -s, *cosine = -c; break;
    default: *sine = -c, *cosine = s; break;
    }
}

float sl_direction_pack(sl_vec3d d, bool wide) {
    double columns = (double)columns_of(wide), steps = (double)steps_of(wide), length = sl_lengthd(d);
    if (!(length > 0.0 && length <= DBL_MAX)) return 0.0f; /* the pole */
    double theta = sl_acos(d.z / length), phi = sl_atan2(d.y, d.x);
    if (phi < 0.0) phi += 2.0 * SL_PI;
    double q_theta = floor(steps * theta / SL_PI + 0.5), q_phi = floor(columns * phi / (2.0 * SL_PI) + 0.5);
    return (float)(columns * q_theta + (q_phi < columns ? q_phi : 0.0));
}

static sl_vec3 compose(double sin_theta, double cos_theta, double sin_phi, double cos_phi) {
    return sl_v3((float)(sin_theta * cos_phi), (float)(sin_theta * sin_phi), (float)cos_theta);
}

/* What is no code counts as the nearest one. */
static uint32_t code_of(float packed, uint32_t columns, uint32_t steps) {
    uint32_t last = columns * steps + columns - 1;
    if (!(packed > 0.0f)) return 0;
    return packed < (float)last ? (uint32_t)packed : last;
}

sl_vec3 sl_direction_unpack(float packed, bool wide) {
    uint32_t columns = columns_of(wide), steps = steps_of(wide), code = code_of(packed, columns, steps);
    double sin_theta, cos_theta, sin_phi, cos_phi;
    turn(code / columns, 2 * steps, &sin_theta, &cos_theta);
    turn(code % columns, columns, &sin_phi, &cos_phi);
    return compose(sin_theta, cos_theta, sin_phi, cos_phi);
}

sl_status sl_direction_table_create(bool wide, sl_direction_table **result, sl_error *error) {
    *result = NULL;
    sl_direction_table *table = sl_allocate(1, sizeof *table);
    if (!table) return sl_fail_memory(error, "a table of directions");
    *table = (sl_direction_table){.columns = columns_of(wide), .rows = steps_of(wide) + 1};
    table->sin_theta = sl_allocate(2 * (size_t)(table->rows + table->columns), sizeof *table->sin_theta);
    if (!table->sin_theta) {
        sl_free(table);
        return sl_fail_memory(error, "a table of directions");
    }
    table->cos_theta = table->sin_theta + table->rows;
    table->sin_phi = table->cos_theta + table->rows;
    table->cos_phi = table->sin_phi + table->columns;
    for (uint32_t i = 0; i < table->rows; i++) turn(i, 2 * steps_of(wide), &table->sin_theta[i], &table->cos_theta[i]);
    for (uint32_t i = 0; i < table->columns; i++) turn(i, table->columns, &table->sin_phi[i], &table->cos_phi[i]);
    *result = table;
    return SL_OK;
}

void sl_direction_table_destroy(sl_direction_table *table) {
    if (!table) return;
    sl_free(table->sin_theta);
    sl_free(table);
}

sl_vec3 sl_direction_table_unpack(const sl_direction_table *table, float packed) {
    uint32_t code = code_of(packed, table->columns, table->rows - 1), row = code / table->columns, column = code % table->columns;
    return compose(table->sin_theta[row], table->cos_theta[row], table->sin_phi[column], table->cos_phi[column]);
}
