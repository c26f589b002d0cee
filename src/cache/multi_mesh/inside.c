/* Whether a point lies inside a solid: rays leave a solid once more often than they enter it if they begin inside. */
#include <math.h>

#include "cache/multi_mesh/topology.h"

typedef struct box {
    sl_vec3 low, high;
} box;

static bool holds(const sl_topology *topology, uint32_t body, sl_vec3 p) {
    sl_vec3 low = topology->body_low[body], high = topology->body_high[body];
    return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y && p.z >= low.z && p.z <= high.z;
}

/* The box around all solids in whose boxes the point lies; false: there are none, as nearly always. */
static bool solids_around(const sl_topology *topology, sl_vec3 p, box *around) {
    bool found = false;
    for (uint32_t b = 0; b < topology->body_count; b++) {
        if (!holds(topology, b, p)) continue;
        sl_vec3 low = topology->body_low[b], high = topology->body_high[b];
        if (!found) *around = (box){low, high};
        around->low = sl_v3(fminf(around->low.x, low.x), fminf(around->low.y, low.y), fminf(around->low.z, low.z));
        around->high = sl_v3(fmaxf(around->high.x, high.x), fmaxf(around->high.y, high.y), fmaxf(around->high.z, high.z));
        found = true;
    }
    return found;
}

/* How far a ray goes before it has left the box, and a little more. */
static float way_out(const box *around, sl_vec3 p, sl_vec3 d, float slack) {
    float x = (d.x > 0.0f ? around->high.x - p.x : around->low.x - p.x) / d.x;
    float y = (d.y > 0.0f ? around->high.y - p.y : around->low.y - p.y) / d.y;
    float z = (d.z > 0.0f ? around->high.z - p.z : around->low.z - p.z) / d.z;
    return 1.001f * fminf(x, fminf(y, z)) + slack;
}

/* +1 where a ray leaves a solid around its beginning, -1 where it enters one, else 0. */
static int crossing(const sl_topology *topology, uint32_t triangle, sl_vec3 p, sl_vec3 d) {
    uint32_t body = topology->body[triangle];
    if (body == SL_NO_INDEX || !holds(topology, body, p)) return 0;
    double along = sl_dotd(sl_to_double(d), sl_to_double(sl_scene_geometric_normal(topology->scene, triangle)));
    if (topology->solid[triangle] == 1) along = -along; /* the front is the inner side */
    return along > 0.0 ? 1 : along < 0.0 ? -1 : 0;
}

/* Exits less entries along a ray. Solids that touch have triangles at the same distance: after each hit the ray goes on from just before it
 * without that triangle, and once another was found there, from behind. */
static int count_crossings(const sl_topology *topology, const sl_tracer *tracer, const box *around, sl_vec3 p, sl_vec3 d, sl_counters *counters) {
    enum { CROSSINGS_MAX = 4096 };
    sl_ray16 ray = {.origin_x = {p.x}, .origin_y = {p.y}, .origin_z = {p.z}, .direction_x = {d.x}, .direction_y = {d.y}, .direction_z = {d.z},
                    .far = {way_out(around, p, d, 1e-6f * topology->scene->scale)}, .skip = {SL_NO_INDEX}};
    float last = -1.0f;
    int sum = 0;
    for (int i = 0; i < CROSSINGS_MAX; i++) {
        sl_hit16 hit;
        sl_trace(tracer, &ray, 1, false, &hit, counters);
        if (hit.triangle[0] == SL_NO_INDEX) break;
        sum += crossing(topology, hit.triangle[0], p, d);
        ray.near[0] = hit.t[0] <= last ? last : nextafterf(hit.t[0], 0.0f);
        ray.skip[0] = hit.triangle[0];
        last = fmaxf(hit.t[0], last);
    }
    return sum;
}

/* Three directions, none of them along what people build, vote: a ray may meet an edge, which counts for two triangles or none. */
bool sl_topology_inside_solid(const sl_topology *topology, const sl_tracer *tracer, sl_vec3 p, sl_vec3 normal, sl_counters *counters) {
    static const sl_vec3 direction[3] = {{0.3713907f, 0.8155417f, 0.4438516f}, {-0.6838219f, 0.4172873f, -0.5985511f}, {0.5264831f, -0.6610997f, -0.5346203f}};
    sl_vec3 start = sl_mad(p, 1e-5f * topology->scene->scale, normal);
    box around;
    if (!solids_around(topology, start, &around)) return false;
    int inside = 0, outside = 0;
    for (int i = 0; i < 3 && inside < 2 && outside < 2; i++) {
        if (count_crossings(topology, tracer, &around, start, direction[i], counters) > 0) inside++;
        else outside++;
    }
    return inside > outside;
}
