/* Does the cost model pick right? Three questions a row, one row a scene and N; costs are predicted from counts alone and
 * held against clocks:
 *   V   visibility alone, plane or rays at the same N
 *   L   with light, plane or rays at the same N (both shade N^2 cells, so they often tie)
 *   H   visibility alone, hemicube or rays at the same N, where they err about the same
 *   A   what `--gather auto` picks: at equal expected error, with light; rays at N, hemicube and plane at their sizes
 * A pick within a tenth of the cheapest is right: clocks are no better than that. */
#include <stdio.h>

#include "base/math.h"
#include "gather_bench.h"

static const char *const names[4] = {"auto", "plane", "hemicube", "rays"};

static double predicted_ms(const gather_row *row, bool light) {
    if (!row->size) return INFINITY;
    return 1e-6 * (sl_gather_see_cost(row->kind, &row->counts) + (light ? sl_gather_shade_cost(row->kind, &row->counts) : 0.0));
}

static double measured_ms(const gather_row *row, bool light) {
    return !row->size ? INFINITY : light ? row->gather_ms : row->see_ms;
}

typedef struct tally {
    int rows, right;
    double worst, sum; /* of what wrong picks cost above the cheapest, as shares */
} tally;

/* Among rows[first], [first + step] ... [3], which costs least by the model; how much more than the cheapest it was measured to cost. */
static int pick(const gather_row rows[4], int first, int step, bool light) {
    int best = 3;
    for (int kind = first; kind < 3; kind += step) {
        if (predicted_ms(&rows[kind], light) < predicted_ms(&rows[best], light)) best = kind;
    }
    return best;
}

static double loss(const gather_row rows[4], int first, int step, bool light, int chosen) {
    double least = measured_ms(&rows[3], light);
    for (int kind = first; kind < 3; kind += step) least = fmin(least, measured_ms(&rows[kind], light));
    return measured_ms(&rows[chosen], light) / least - 1.0;
}

static void print_verdict(tally *t, int chosen, double lost) {
    char text[32];
    bool right = lost <= 0.1;
    t->rows++;
    t->right += right;
    if (!right) {
        t->sum += lost;
        t->worst = fmax(t->worst, lost);
    }
    if (right) snprintf(text, sizeof text, "right");
    else snprintf(text, sizeof text, "wrong by %.0f %%", 100.0 * lost);
    printf(" %8s %-14s", names[chosen], text);
}

static void print_costs(const gather_row rows[4], bool light) {
    for (int kind = 1; kind < 4; kind++) printf(" %8.3f", measured_ms(&rows[kind], light));
    printf(" |");
    for (int kind = 1; kind < 4; kind++) printf(" %8.3f", predicted_ms(&rows[kind], light));
    printf(" |");
}

static void print_head(const char *title) {
    printf("\n%s\n%-15s %4s | %26s | %26s |\n%-15s %4s | %8s %8s %8s | %8s %8s %8s |\n", title, "", "", "measured ms", "predicted ms", "scene", "N",
           "plane", "hemicube", "rays", "plane", "hemicube", "rays");
}

static void print_tally(const char *question, const tally *t) {
    printf("%-58s %d of %d right", question, t->right, t->rows);
    if (t->right < t->rows) {
        printf("; where wrong, dearer by %.0f %% in the mean, %.0f %% at worst", 100.0 * t->sum / (t->rows - t->right), 100.0 * t->worst);
    }
    printf("\n");
}

void gather_auto_table(const gather_case *cases, int count) {
    tally see = {0}, cube = {0}, lit = {0}, whole = {0};
    print_head("visibility alone, at the same N: pick of plane and rays, of hemicube and rays");
    for (int i = 0; i < count; i++) {
        const gather_row *rows = cases[i].at_size;
        printf("%-15s %4d |", cases[i].scene, cases[i].size);
        print_costs(rows, false);
        int plane = pick(rows, 1, 2, false), hemicube = pick(rows, 2, 1, false);
        print_verdict(&see, plane, loss(rows, 1, 2, false, plane));
        print_verdict(&cube, hemicube, loss(rows, 2, 1, false, hemicube));
        printf("\n");
    }
    print_head("with light, at the same N: pick of plane and rays");
    for (int i = 0; i < count; i++) {
        const gather_row *rows = cases[i].at_size;
        printf("%-15s %4d |", cases[i].scene, cases[i].size);
        print_costs(rows, true);
        int chosen = pick(rows, 1, 2, true);
        print_verdict(&lit, chosen, loss(rows, 1, 2, true, chosen));
        printf("\n");
    }
    print_head("with light, at the expected error of N x N rays (inf: never reached): what auto picks");
    for (int i = 0; i < count; i++) {
        const gather_row *rows = cases[i].as_good;
        printf("%-15s %4d |", cases[i].scene, cases[i].size);
        print_costs(rows, true);
        print_verdict(&whole, (int)cases[i].choice, loss(rows, 1, 1, true, (int)cases[i].choice));
        printf("\n");
    }
    printf("\nright: within 10 %% of the cheapest\n");
    print_tally("visibility, plane or rays at the same N:", &see);
    print_tally("visibility, hemicube or rays at the same N:", &cube);
    print_tally("with light, plane or rays at the same N:", &lit);
    print_tally("with light, at equal expected error (auto):", &whole);
}

/* ---- errors ---- */

/* Measured, and as the model expects them; geometric means, since scenes differ by orders of magnitude. */
void gather_error_table(const gather_case *cases, int count) {
    double tangent = sl_tan(0.5 * (double)sl_gather_defaults().plane_fov);
    printf("\nrelative RMS error, geometric mean over the scenes (expected by the model)\n%4s", "N");
    for (int kind = 1; kind < 4; kind++) printf(" %19s", names[kind]);
    printf("\n");
    for (int s = 0; s < SIZES; s++) {
        printf("%4d", gather_sizes[s]);
        for (int kind = 1; kind < 4; kind++) {
            double sum = 0.0, used = 0.0;
            for (int i = s; i < count; i += SIZES) {
                if (!(cases[i].at_size[3].rms > 0.0) || !(cases[i].at_size[kind].rms > 0.0)) continue;
                sum += sl_log(cases[i].at_size[kind].rms);
                used++;
            }
            printf("  %7.2f %% (%5.2f %%)", used > 0.0 ? 100.0 * sl_exp(sum / used) : 0.0,
                   100.0 * sl_gather_expected_error((sl_gather_kind)kind, gather_sizes[s], tangent));
        }
        printf("\n");
    }
}
