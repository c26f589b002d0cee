#include "cache/light_octree/direct_photons.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "trace/bsdf.h"

enum { POINTS_A_TASK = 64 };
/* a grazing photon is weighed no more than that: epsilon in 1 / max(n_i . omega_i, epsilon) */
static const double cosine_least = 0.05;

typedef struct direct_job {
    const sl_direct_photons *photons;
    size_t count, neighbours;
    const sl_surface *surfaces;
    const sl_vec3 *to_viewer;
    sl_rgb *radiance, *irradiance;
    uint64_t *found;   /* by each task */
    uint32_t *places;  /* neighbours a worker */
    double *distances;
    uint64_t *keys;    /* sl_photon_keys() of neighbours a worker */
} direct_job;

typedef struct rgb_sum {
    double r, g, b;
} rgb_sum;

static void add(rgb_sum *sum, sl_rgb reflected, const float flux[3], double scale) {
    sum->r += (double)reflected.r * (double)flux[0] * scale;
    sum->g += (double)reflected.g * (double)flux[1] * scale;
    sum->b += (double)reflected.b * (double)flux[2] * scale;
}

static sl_rgb scaled_sum(const rgb_sum *sum, double scale) {
    sl_rgb c = {(float)(sum->r * scale), (float)(sum->g * scale), (float)(sum->b * scale)};
    return sl_rgb_is_finite(c) ? c : sl_grey(0.0f);
}

/* kappa / A; kappa = (k - 1) / k where the k-th photon set the radius. */
static double density_scale(const sl_direct_photons *photons, const sl_surface *surface,
                            const sl_gathered_photons *g, unsigned worker) {
    sl_ellipsoid e = {sl_to_double(surface->position), sl_to_double(surface->geometric_normal),
                      photons->flatness, g->radius};
    double area = photons->area ? photons->area(photons->area_context, &e, worker) : sl_disc_area(&e);
    double kappa = g->full ? ((double)g->count - 1.0) / (double)g->count : 1.0;
    return area > 0.0 ? kappa / area : 0.0;
}

static void light_point(const direct_job *job, size_t point, sl_gathered_photons *g, unsigned worker) {
    const sl_direct_photons *photons = job->photons;
    const sl_surface *surface = &job->surfaces[point];
    sl_photon_query query = {.centre = surface->position,
                             .normal = surface->geometric_normal,
                             .flatness = photons->flatness,
                             .radius = photons->radius,
                             .minimum = 1e-3 * photons->radius,
                             .cos_acceptance = photons->cos_acceptance,
                             .neighbours = job->neighbours};
    sl_photon_tree_gather(photons->tree, &query, g);
    const sl_photon *photon = sl_photon_tree_list(photons->tree)->photon;
    sl_bsdf bsdf = sl_bsdf_make(surface, job->to_viewer[point], SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY);
    rgb_sum reflected = {0.0, 0.0, 0.0}, arriving = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < g->count; i++) {
        const sl_photon *p = &photon[g->place[i]];
        sl_vec3 to_light = sl_octahedral_decode(p->direction);
        double cosine = fmax((double)sl_dot(to_light, sl_octahedral_decode(p->normal)), cosine_least);
        add(&reflected, sl_bsdf_reflect(&bsdf, to_light, SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY), p->flux,
            1.0 / cosine);
        add(&arriving, sl_grey(1.0f), p->flux, 1.0);
    }
    double scale = density_scale(photons, surface, g, worker);
    job->radiance[point] = scaled_sum(&reflected, scale);
    if (job->irradiance) job->irradiance[point] = scaled_sum(&arriving, scale);
}

static void light_points(void *context, size_t task, unsigned worker) {
    const direct_job *job = context;
    sl_gathered_photons g = {.place = job->places + worker * job->neighbours,
                             .distance = job->distances + worker * job->neighbours,
                             .keys = job->keys + worker * sl_photon_keys(job->neighbours)};
    size_t end = (task + 1) * POINTS_A_TASK < job->count ? (task + 1) * POINTS_A_TASK : job->count;
    for (size_t point = task * POINTS_A_TASK; point < end; point++) {
        job->radiance[point] = sl_grey(0.0f);
        if (job->irradiance) job->irradiance[point] = sl_grey(0.0f);
        if (sl_material_is_mirror(job->surfaces[point].material)) continue;
        light_point(job, point, &g, worker);
        job->found[task] += g.count;
    }
}

sl_status sl_direct_photons_radiance(const sl_direct_photons *photons, size_t count,
                                     const sl_surface *surfaces, const sl_vec3 *to_viewer, sl_rgb *radiance,
                                     sl_rgb *irradiance, sl_counters *counters, sl_error *error) {
    unsigned threads = sl_thread_count(photons->threads);
    size_t tasks = (count + POINTS_A_TASK - 1) / POINTS_A_TASK;
    direct_job job = {.photons = photons,
                      .count = count,
                      .surfaces = surfaces,
                      .to_viewer = to_viewer,
                      .radiance = radiance,
                      .irradiance = irradiance};
    job.neighbours = photons->neighbours < SL_NEIGHBOURS_MAX ? photons->neighbours : SL_NEIGHBOURS_MAX;
    job.found = sl_allocate(tasks, sizeof *job.found);
    job.places = sl_allocate(threads * job.neighbours, sizeof *job.places);
    job.distances = sl_allocate(threads * job.neighbours, sizeof *job.distances);
    job.keys = sl_allocate(threads * sl_photon_keys(job.neighbours), sizeof *job.keys);
    bool ready = job.found && job.places && job.distances && job.keys;
    if (ready) sl_parallel_for(threads, tasks, light_points, &job);
    for (size_t i = 0; ready && i < tasks; i++) sl_count(counters, SL_COUNT_PHOTONS_GATHERED, job.found[i]);
    sl_free(job.found);
    sl_free(job.places);
    sl_free(job.distances);
    sl_free(job.keys);
    return ready ? SL_OK : sl_fail_memory(error, "photon gathers");
}
