/* How many photons a voxel should take, by an estimate of the error: the more, the less noise and the more
 * blur. Noise is known: a density of n photons scatters by E / sqrt(n). Blur is not, but it shows: where more
 * photons give another density than fewer ones did, and noise does not explain it, the surroundings differ.
 * So k grows as long as the confidence intervals of all densities so far have a value in common
 * (Goldenshluger and Nemirovski 1997, "On spatially adaptive estimation of nonparametric regression":
 * intersection of confidence intervals), from a quarter of the k that was asked for. Not from fewer: where
 * surfaces lie close together the nearest few photons are those of the surface under the voxel's centre
 * alone, and their area is the least certain of all. */
#include "cache/light_octree/voxel_work.h"

enum { CANDIDATES = SL_ELLIPSOIDS_MAX, LEAST = 20 }; /* k / 4, k / 2, k */

/* Intervals of so many standard deviations. */
static const double confidence = 2.0;
/* Of the disc: in a corner the smallest ellipsoid holds a quarter of it. One that holds less cuts surfaces
 * that lie off its centre, and what few photons tell by so little area makes bright outliers. It is believed
 * unless it tells of more than so many times the density of all k. */
static const double area_least = 0.25, believed_most = 2.0;

typedef struct ranked_photon {
    double distance;
    uint32_t at;                  /* among the gathered: in order of ids */
    float luminance;
} ranked_photon;

size_t sl_voxel_ranking_bytes(void) { return sizeof(ranked_photon); }

static bool is_nearer(const ranked_photon *a, const ranked_photon *b) {
    return a->distance != b->distance ? a->distance < b->distance : a->at < b->at;
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

static void rank_photons(const sl_voxel_work *work, const sl_gathered_photons *gathered,
                         ranked_photon *ranked) {
    const sl_photon_list *list = sl_photon_tree_list(work->tree);
    for (size_t i = 0; i < gathered->count; i++) {
        const sl_photon *p = &list->photon[gathered->place[i]];
        sl_rgb flux = {p->flux[0], p->flux[1], p->flux[2]};
        ranked[i] = (ranked_photon){gathered->distance[i], (uint32_t)i, sl_luminance(flux)};
    }
}

/* The nearest `count` photons. */
typedef struct candidate {
    size_t count;
    ranked_photon farthest;
    double radius, sum, squares;  /* of luminance */
    double density, scatter;
    sl_voxel_area area;
    bool little_area;
} candidate;

/* Largest first, as what lies around them is looked at. Returns how many there are. */
static int find_candidates(const sl_photon_query *query, size_t found, ranked_photon *ranked,
                           candidate *candidates) {
    size_t quarter = query->neighbours / 4, count = quarter > LEAST ? quarter : LEAST;
    int candidate_count = 0;
    for (; candidate_count < CANDIDATES && count <= found && count <= query->neighbours; count *= 2) {
        select_nearest(ranked, found, count);
        candidate c = {.count = count, .farthest = ranked[0]};
        for (size_t i = 0; i < count; i++) {
            double luminance = (double)ranked[i].luminance;
            c.sum += luminance;
            c.squares += luminance * luminance;
            if (is_nearer(&c.farthest, &ranked[i])) c.farthest = ranked[i];
        }
        c.radius = fmax(sqrt(c.farthest.distance), query->minimum);
        candidates[CANDIDATES - ++candidate_count] = c;
    }
    return candidate_count;
}

static void look_around(const sl_voxel_work *work, const sl_voxel_gather *gather, const candidate *candidates,
                        int count, sl_voxel_worker *w) {
    sl_ellipsoid ellipsoid[CANDIDATES];
    for (int k = 0; k < count; k++) {
        ellipsoid[k] = gather->ellipsoid;
        ellipsoid[k].radius = candidates[k].radius;
    }
    sl_voxel_look_around(work, ellipsoid, count, w);
}

/* A candidate's density, and what it scatters by. */
static double density_of(const sl_voxel_work *work, const sl_voxel_light_options *o,
                         const sl_voxel_gather *gather, candidate *c, sl_voxel_worker *w) {
    sl_voxel_gather nearer = *gather;
    nearer.ellipsoid.radius = c->radius;
    c->area = sl_voxel_areas(work, o, &nearer, w);
    double area = c->area.all;
    double kappa = c->count > 1 ? (double)(c->count - 1) / (double)c->count : 1.0,
           density = kappa * c->sum / area;
    c->scatter = c->sum > 0.0 ? density * sqrt(c->squares) / c->sum : 0.0;
    c->little_area = area < area_least * sl_disc_area(&nearer.ellipsoid);
    return density;
}

/* As if no more had been asked for. */
static sl_voxel_gather keep_nearest(const sl_voxel_work *work, const sl_photon_query *query,
                                    const candidate *c, sl_voxel_worker *w) {
    sl_gathered_photons *g = &w->gathered;
    size_t kept = 0;
    for (uint32_t i = 0; i < g->count; i++) {
        ranked_photon p = {g->distance[i], i, 0.0f};
        if (is_nearer(&c->farthest, &p)) continue;
        g->place[kept] = g->place[i];
        g->distance[kept++] = g->distance[i];
    }
    g->count = kept;
    g->radius = c->radius;
    g->full = true;
    sl_voxel_gather gather = sl_voxel_of_gathered(work, query, w);
    gather.area = c->area;
    return gather;
}

sl_voxel_gather sl_voxel_gather_estimated(const sl_voxel_work *work, const sl_voxel_light_options *o,
                                          const sl_photon_query *query, sl_voxel_worker *w) {
    sl_voxel_gather widest = sl_voxel_gather_photons(work, query, w);
    candidate candidates[CANDIDATES];
    double low = 0.0, high = INFINITY;
    rank_photons(work, &w->gathered, w->ranked);
    int count = find_candidates(query, widest.found, w->ranked, candidates);
    look_around(work, &widest, &candidates[CANDIDATES - count], count, w);
    int largest = CANDIDATES - count;
    for (int k = CANDIDATES - 1; k >= largest; k--)
        candidates[k].density = density_of(work, o, &widest, &candidates[k], w);
    const candidate *chosen = NULL;
    for (int k = CANDIDATES - 1; k >= largest; k--) {
        const candidate *c = &candidates[k];
        if (c->little_area && c->density > believed_most * candidates[largest].density) continue;
        low = fmax(low, c->density - confidence * c->scatter);
        high = fmin(high, c->density + confidence * c->scatter);
        if (chosen && low > high) return keep_nearest(work, query, chosen, w);
        chosen = c;
    }
    if (count > 0 && widest.ellipsoid.radius == candidates[largest].radius)
        widest.area = candidates[largest].area;
    return widest; /* no two disagree */
}
