/* How many photons a voxel should take, by an estimate of the error (section 8): the more, the less noise and the more blur. Noise is known: a
 * density of n photons scatters by E / sqrt(n). Blur is not, but it shows: where more photons give another density than fewer ones did, and
 * noise does not explain it, the surroundings differ. So k grows as long as the confidence intervals of all densities so far have a value in
 * common (Goldenshluger and Nemirovski 1997, "On spatially adaptive estimation of nonparametric regression": intersection of confidence
 * intervals), from a quarter of the k that was asked for. Not from fewer: where surfaces lie close together the nearest few photons are those of
 * the surface under the voxel's centre alone, and their area is the least certain of all. */
#include <stdlib.h>

#include "cache/light_octree/voxel_work.h"

enum { CANDIDATES = 3, LEAST = 20 }; /* k / 4, k / 2, k */

/* Intervals of so many standard deviations. */
static const double confidence = 2.0;

typedef struct ranked_photon {
    double distance;
    uint32_t place;
    float luminance;
} ranked_photon;

size_t sl_voxel_ranking_bytes(void) { return sizeof(ranked_photon); }

static int by_distance(const void *a, const void *b) {
    const ranked_photon *p = a, *q = b;
    if (p->distance != q->distance) return p->distance < q->distance ? -1 : 1;
    return (p->place > q->place) - (p->place < q->place);
}

size_t sl_voxel_most_neighbours(const sl_voxel_light_options *o) {
    return o->neighbours < SL_NEIGHBOURS_MAX ? o->neighbours : SL_NEIGHBOURS_MAX;
}

static void rank_photons(const sl_voxel_work *work, const sl_gathered_photons *gathered, ranked_photon *ranked) {
    const sl_photon_list *list = sl_photon_tree_list(work->tree);
    for (size_t i = 0; i < gathered->count; i++) {
        const sl_photon *p = &list->photon[gathered->place[i]];
        sl_rgb flux = {p->flux[0], p->flux[1], p->flux[2]};
        ranked[i] = (ranked_photon){gathered->distance[i], gathered->place[i], sl_luminance(flux)};
    }
    qsort(ranked, gathered->count, sizeof *ranked, by_distance);
}

/* Density of the nearest `count` photons, and what it scatters by. */
static double density_of(const sl_voxel_work *work, const sl_voxel_light_options *o, const sl_voxel_gather *gather, size_t count, double sum,
                         double squares, double radius, sl_voxel_worker *w, double *scatter) {
    double sides[2];
    sl_voxel_gather nearer = *gather;
    nearer.ellipsoid.radius = radius;
    double area = sl_voxel_areas(work, o, &nearer, w, sides);
    double kappa = count > 1 ? (double)(count - 1) / (double)count : 1.0, density = kappa * sum / area;
    *scatter = sum > 0.0 ? density * sqrt(squares) / sum : 0.0;
    return density;
}

size_t sl_voxel_estimated_neighbours(const sl_voxel_work *work, const sl_voxel_light_options *o, const sl_photon_query *query,
                                     sl_voxel_worker *w) {
    sl_photon_query widest = *query;
    widest.neighbours = sl_voxel_most_neighbours(o);
    sl_voxel_gather gather = sl_voxel_gather_photons(work, &widest, w);
    double low = 0.0, high = INFINITY, sum = 0.0, squares = 0.0;
    size_t most = widest.neighbours, quarter = most / 4, chosen = quarter > LEAST ? quarter : most < LEAST ? most : LEAST, count = chosen, taken = 0;
    rank_photons(work, &w->gathered, w->ranked);
    for (int k = 0; k < CANDIDATES && count <= gather.found && count <= most; k++, count *= 2) {
        for (; taken < count; taken++) {
            double luminance = (double)w->ranked[taken].luminance;
            sum += luminance;
            squares += luminance * luminance;
        }
        double scatter, radius = sqrt(w->ranked[count - 1].distance);
        if (radius < query->minimum) radius = query->minimum;
        double density = density_of(work, o, &gather, count, sum, squares, radius, w, &scatter);
        low = density - confidence * scatter > low ? density - confidence * scatter : low;
        high = density + confidence * scatter < high ? density + confidence * scatter : high;
        if (low > high) return chosen;
        chosen = count;
    }
    return most; /* no two disagree: all there are */
}
