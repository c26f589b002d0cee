/* How many photons a voxel should take, by an estimate of the error (section 8): the more, the less noise and the more blur. Noise is known: a
 * density of n photons scatters by E / sqrt(n). Blur is not, but it shows: where more photons give another density than fewer ones did, and
 * noise does not explain it, the surroundings differ. So k grows as long as the confidence intervals of all densities so far have a value in
 * common (Goldenshluger and Nemirovski 1997, "On spatially adaptive estimation of nonparametric regression": intersection of confidence
 * intervals), from a quarter of the k that was asked for. Not from fewer: where surfaces lie close together the nearest few photons are those of
 * the surface under the voxel's centre alone, and their area is the least certain of all. */
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

static bool is_nearer(const ranked_photon *a, const ranked_photon *b) {
    return a->distance != b->distance ? a->distance < b->distance : a->place < b->place;
}

/* Moves the nearest `wanted` to the front, the farthest of them last (Hoare 1961, "Find"). */
static void select_nearest(ranked_photon *p, size_t count, size_t wanted) {
    size_t low = 0, high = count;
    while (high - low > 1) {
        ranked_photon pivot = p[low + (high - low) / 2];
        size_t i = low, j = high - 1;
        for (;;) {
            while (is_nearer(&p[i], &pivot)) i++;
            while (is_nearer(&pivot, &p[j])) j--;
            if (i >= j) break;
            ranked_photon swapped = p[i];
            p[i++] = p[j];
            p[j--] = swapped;
        }
        if (wanted <= i) high = i;
        else low = i;
    }
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

sl_voxel_gather sl_voxel_gather_estimated(const sl_voxel_work *work, const sl_voxel_light_options *o, const sl_photon_query *query,
                                          sl_voxel_worker *w) {
    sl_voxel_gather widest = sl_voxel_gather_photons(work, query, w);
    double low = 0.0, high = INFINITY;
    size_t most = query->neighbours, quarter = most / 4, count = quarter > LEAST ? quarter : LEAST, chosen = count;
    rank_photons(work, &w->gathered, w->ranked);
    for (int k = 0; k < CANDIDATES && count <= widest.found && count <= most; k++, count *= 2) {
        double sum = 0.0, squares = 0.0, scatter, radius = 0.0;
        select_nearest(w->ranked, widest.found, count);
        for (size_t i = 0; i < count; i++) {
            double luminance = (double)w->ranked[i].luminance;
            sum += luminance;
            squares += luminance * luminance;
            radius = w->ranked[i].distance > radius ? w->ranked[i].distance : radius;
        }
        radius = sqrt(radius) > query->minimum ? sqrt(radius) : query->minimum;
        double density = density_of(work, o, &widest, count, sum, squares, radius, w, &scatter);
        low = density - confidence * scatter > low ? density - confidence * scatter : low;
        high = density + confidence * scatter < high ? density + confidence * scatter : high;
        if (low > high) {
            sl_photon_query nearer = *query;
            nearer.neighbours = chosen;
            return sl_voxel_gather_photons(work, &nearer, w);
        }
        chosen = count;
    }
    return widest; /* no two disagree */
}
