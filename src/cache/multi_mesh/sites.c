/* Sites: the corners that faces share. Corners at the same position (equal bits) form a chain of sites; a corner takes the first site of the chain
 * whose normal is no further than 1e-4 radians from its own, or starts another. A site keeps the normal of the corner that started it, and
 * corners come in the order of faces, so the outcome depends on nothing but the scene. */
#include <math.h>

#include "base/error.h"
#include "base/random.h"
#include "base/math.h"
#include "cache/multi_mesh/grow.h"
#include "cache/multi_mesh/topology_parts.h"

typedef struct site {
    sl_vec3 position, normal;
    float exponent;
    uint32_t face;
    uint32_t first, next; /* of the chain */
    uint8_t shared;
} site;

typedef struct site_table {
    site *site;
    size_t count, capacity;
    uint32_t *slot; /* first sites of chains, by position; at most half full */
    size_t slots;
} site_table;

static bool same_bits(sl_vec3 a, sl_vec3 b) {
    return sl_float_bits(a.x) == sl_float_bits(b.x) && sl_float_bits(a.y) == sl_float_bits(b.y) && sl_float_bits(a.z) == sl_float_bits(b.z);
}

/* Where the chain of a position begins in the table, or would. */
static uint32_t *find_chain(const site_table *table, sl_vec3 p) {
    uint64_t xy = (uint64_t)sl_float_bits(p.x) << 32 | sl_float_bits(p.y);
    size_t i = (size_t)sl_hash64(sl_hash64(xy) ^ sl_float_bits(p.z)) & (table->slots - 1);
    while (table->slot[i] != SL_NO_INDEX && !same_bits(table->site[table->slot[i]].position, p)) i = (i + 1) & (table->slots - 1);
    return &table->slot[i];
}

/* The chord between unit vectors stands for their angle: cosines near 1 cannot tell 1e-4 radians from 0 in float. */
static bool same_direction(sl_vec3 a, sl_vec3 b) {
    sl_vec3d d = sl_subd(sl_to_double(a), sl_to_double(b));
    return sl_dotd(d, d) <= 1e-4 * 1e-4;
}

static bool matches(const site *s, const site *corner) {
    return same_direction(s->normal, corner->normal) && sl_float_bits(s->exponent) == sl_float_bits(corner->exponent);
}

/* The site of a corner; SL_NO_INDEX: memory ended. */
static uint32_t site_of(site_table *table, const site *corner) {
    uint32_t *chain = find_chain(table, corner->position), last = SL_NO_INDEX;
    for (uint32_t s = *chain; s != SL_NO_INDEX; s = table->site[s].next) {
        if (matches(&table->site[s], corner)) {
            table->site[s].shared |= table->site[s].face != corner->face;
            return s;
        }
        last = s;
    }
    if (table->count == table->capacity) {
        size_t capacity = sl_grown_capacity(table->capacity, table->count + 1024);
        if (table->count >= SL_NO_INDEX || !sl_regrow((void **)&table->site, table->count, capacity, sizeof *table->site)) return SL_NO_INDEX;
        table->capacity = capacity;
    }
    uint32_t fresh = (uint32_t)table->count++;
    table->site[fresh] = *corner;
    table->site[fresh].first = *chain == SL_NO_INDEX ? fresh : *chain;
    if (last == SL_NO_INDEX) *chain = fresh;
    else table->site[last].next = fresh;
    return fresh;
}

/* The shading normal, turned to the face's side; the geometric one where that has no side. */
static sl_vec3 corner_normal(const sl_scene *scene, uint32_t face, uint32_t vertex) {
    sl_vec3 side = sl_face_normal(scene, face), n = sl_scene_normal(scene, vertex);
    double dot = sl_dotd(sl_to_double(n), sl_to_double(side));
    if (dot > 0.0) return n;
    return dot < 0.0 ? sl_v3(-n.x, -n.y, -n.z) : side;
}

static bool find_sites(sl_topology *topology, bool by_exponent, site_table *table) {
    const sl_scene *scene = topology->scene;
    for (uint32_t face = 0; face < topology->face_count; face++) {
        uint32_t t = face / 2;
        float exponent = by_exponent ? scene->materials[scene->material_index[t]].exponent : 0.0f;
        for (int c = 0; c < 3; c++) {
            sl_vec3 p = sl_scene_position(scene, scene->vertex[c][t]);
            site corner = {.position = sl_v3(p.x + 0.0f, p.y + 0.0f, p.z + 0.0f), /* -0 is 0 */
                           .normal = corner_normal(scene, face, scene->vertex[c][t]),
                           .exponent = exponent, .face = face, .next = SL_NO_INDEX};
            topology->site[c][face] = site_of(table, &corner);
            if (topology->site[c][face] == SL_NO_INDEX) return false;
        }
    }
    return true;
}

static bool keep_sites(sl_topology *topology, const site_table *table, uint32_t *first_there) {
    topology->site_count = table->count;
    topology->site_position = sl_allocate(table->count, sizeof(sl_vec3));
    topology->site_normal = sl_allocate(table->count, sizeof(sl_vec3));
    topology->site_face = sl_allocate(table->count, sizeof(uint32_t));
    topology->site_shared = sl_allocate(table->count, 1);
    if (topology->site_position == NULL || topology->site_normal == NULL || topology->site_face == NULL || topology->site_shared == NULL) return false;
    for (size_t s = 0; s < table->count; s++) {
        topology->site_position[s] = table->site[s].position;
        topology->site_normal[s] = table->site[s].normal;
        topology->site_face[s] = table->site[s].face;
        topology->site_shared[s] = table->site[s].shared;
        first_there[s] = table->site[s].first;
    }
    return true;
}

sl_status sl_sites_make(sl_topology *topology, bool by_exponent, uint32_t **first_there, sl_error *error) {
    site_table table = {.slots = 16};
    *first_there = NULL;
    while (table.slots < 2 * topology->scene->vertex_count) table.slots *= 2;
    table.slot = sl_allocate(table.slots, sizeof *table.slot);
    bool good = table.slot != NULL;
    for (size_t i = 0; good && i < table.slots; i++) table.slot[i] = SL_NO_INDEX;
    good = good && find_sites(topology, by_exponent, &table);
    if (good) *first_there = sl_allocate(table.count, sizeof **first_there);
    good = good && *first_there != NULL && keep_sites(topology, &table, *first_there);
    sl_free(table.site);
    sl_free(table.slot);
    return good ? SL_OK : sl_fail_memory(error, "shared corners");
}
