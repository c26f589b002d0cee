/* The cost model's constants: least squares of the relative error, no constant negative, by coordinate descent on the normal equations. */
#include <stdio.h>
#include <string.h>

#include "base/math.h"
#include "gather_bench.h"

enum { TERMS = SL_GATHER_COST_TERMS, SWEEPS = 20000 };
typedef enum part { RASTER_SEES, RAYS_SEE, SHADING, PARTS } part;

typedef struct normal_equations {
    double matrix[TERMS][TERMS], right[TERMS], constants[TERMS];
} normal_equations;

/* Nanoseconds of a part in a row; 0 where the row has no such part. */
static double target(const gather_row *row, part p) {
    bool rays = row->kind == SL_GATHER_RAYS;
    if (!row->size || (p == RASTER_SEES && rays) || (p == RAYS_SEE && !rays)) return 0.0;
    return 1e6 * (p == SHADING ? row->gather_ms - row->see_ms : row->see_ms);
}

static void terms_of(const gather_row *row, part p, double terms[TERMS]) {
    sl_gather_terms t = sl_gather_cost_terms(row->kind, &row->counts);
    memcpy(terms, p == SHADING ? t.shade : t.see, sizeof t.see);
}

static void add_row(normal_equations *e, const gather_row *row, part p) {
    double terms[TERMS], y = target(row, p);
    if (!(y > 0.0)) return;
    terms_of(row, p, terms);
    for (int i = 0; i < TERMS; i++) {
        for (int j = 0; j < TERMS; j++) e->matrix[i][j] += terms[i] / y * terms[j] / y;
        e->right[i] += terms[i] / y;
    }
}

static void solve(normal_equations *e) {
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        for (int i = 0; i < TERMS; i++) {
            double rest = e->right[i];
            for (int j = 0; j < TERMS; j++) rest -= e->matrix[i][j] * e->constants[j];
            if (e->matrix[i][i] > 0.0) e->constants[i] = fmax(0.0, e->constants[i] + rest / e->matrix[i][i]);
        }
    }
}

/* Of all scenes but one (NULL: of all). */
static normal_equations fit(const gather_case *cases, int count, part p, const char *without) {
    normal_equations e = {0};
    for (int i = 0; i < count; i++) {
        if (without && !strcmp(without, cases[i].scene)) continue;
        for (int kind = 1; kind < 4; kind++) add_row(&e, &cases[i].at_size[kind], p);
    }
    solve(&e);
    return e;
}

static double prediction(const normal_equations *e, const gather_row *row, part p) {
    double terms[TERMS], sum = 0.0;
    terms_of(row, p, terms);
    for (int i = 0; i < TERMS; i++) sum += e->constants[i] * terms[i];
    return sum;
}

/* RMS of prediction / measurement - 1 over the rows of one scene (NULL: of all). */
static void add_errors(const normal_equations *e, const gather_case *cases, int count, part p, const char *scene, double *sum, double *used) {
    for (int i = 0; i < count; i++) {
        if (scene && strcmp(scene, cases[i].scene)) continue;
        for (int kind = 1; kind < 4; kind++) {
            double y = target(&cases[i].at_size[kind], p);
            if (!(y > 0.0)) continue;
            double error = prediction(e, &cases[i].at_size[kind], p) / y - 1.0;
            *sum += error * error;
            ++*used;
        }
    }
}

void gather_fit_table(const gather_case *cases, int count) {
    static const char *const names[PARTS] = {"raster_see", "ray_see", "any_shade"};
    printf("\nconstants, ns; RMS of the relative error over all rows; the same over every scene by the constants of all others\n");
    for (int p = 0; p < PARTS; p++) {
        normal_equations all = fit(cases, count, (part)p, NULL);
        double sum = 0, used = 0, left_sum = 0, left_used = 0;
        add_errors(&all, cases, count, (part)p, NULL, &sum, &used);
        for (int i = 0; i < count; i += SIZES) {
            normal_equations others = fit(cases, count, (part)p, cases[i].scene);
            add_errors(&others, cases, count, (part)p, cases[i].scene, &left_sum, &left_used);
        }
        printf("%-10s {", names[p]);
        for (int i = 0; i < TERMS; i++) printf("%s%.4g", i ? ", " : "", all.constants[i]);
        printf("}  %.1f %%  %.1f %%\n", 100.0 * sqrt(sum / used), 100.0 * sqrt(left_sum / left_used));
    }
}
