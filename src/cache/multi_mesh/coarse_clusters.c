/* Small faces, those that are not cut (the pages of a book, the mesh of a scanned figure), need no samples of
 * their own: what a gather sees of them is the light on many at once. Corners all of whose faces are small
 * stand in clusters, one for each cell of a grid and each way that normals point; one corner of a cluster,
 * that with the largest faces about it, is sampled for all of them. Corners of larger faces stand for
 * themselves. */
#include <math.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/multi_mesh/coarse_tables.h"

typedef struct cluster_key {
    int32_t x, y, z, normal;
} cluster_key;

typedef struct cluster_table {
    const sl_coarse *coarse;
    double cell;
    float *area;               /* by site: of the faces about it; negative: it stands for itself */
    size_t slots;              /* a power of two, at most half full */
    /* by slot: the cluster's first site (SL_NO_INDEX: no cluster), and the one that stands for all */
    uint32_t *first, *chosen;
} cluster_table;

/* ---- which corners are in clusters ---- */

static void weigh_sites(cluster_table *table) {
    const sl_topology *t = table->coarse->topology;
    for (uint32_t face = 0; face < t->face_count; face++) {
        if (table->coarse->level[face] == SL_COARSE_ABSENT) continue;
        sl_vec3d p[3];
        for (int k = 0; k < 3; k++) p[k] = sl_to_double(t->site_position[t->site[k][face]]);
        bool small = table->coarse->level[face] == 0;
        float area = (float)(0.5 * sl_lengthd(sl_crossd(sl_subd(p[1], p[0]), sl_subd(p[2], p[0]))));
        for (int k = 0; k < 3; k++) {
            float *sum = &table->area[t->site[k][face]];
            *sum = small && *sum >= 0.0f ? *sum + area : -1.0f;
        }
    }
}

/* ---- clusters ---- */

static int32_t cell_of(double x, double cell) {
    double at = floor(x / cell);
    return fabs(at) < 1e9 ? (int32_t)at : 0; /* NaN: 0 */
}

/* Each component of the normal to the nearest half. */
static cluster_key key_of(const cluster_table *table, uint32_t site) {
    const sl_topology *t = table->coarse->topology;
    sl_vec3d p = sl_to_double(t->site_position[site]), n = sl_to_double(t->site_normal[site]);
    const double component[3] = {n.x, n.y, n.z};
    cluster_key key = {cell_of(p.x, table->cell), cell_of(p.y, table->cell), cell_of(p.z, table->cell), 0};
    for (int k = 0; k < 3; k++) key.normal = 5 * key.normal + cell_of(component[k] + 0.25, 0.5);
    return key;
}

static bool same_key(const cluster_key *a, const cluster_key *b) {
    return a->x == b->x && a->y == b->y && a->z == b->z && a->normal == b->normal;
}

static size_t slot_of(const cluster_table *table, uint32_t site) {
    cluster_key key = key_of(table, site);
    uint64_t xy = (uint64_t)(uint32_t)key.x << 32 | (uint32_t)key.y,
             zn = (uint64_t)(uint32_t)key.z << 32 | (uint32_t)key.normal;
    size_t i = (size_t)sl_hash64(sl_hash64(xy) ^ zn) & (table->slots - 1);
    for (; table->first[i] != SL_NO_INDEX; i = (i + 1) & (table->slots - 1)) {
        cluster_key other = key_of(table, table->first[i]);
        if (same_key(&other, &key)) break;
    }
    return i;
}

/* Sites in their order; of those with as large faces the first. */
static void choose(cluster_table *table, uint32_t *stand_in) {
    size_t sites = table->coarse->topology->site_count;
    for (uint32_t s = 0; s < sites; s++) {
        stand_in[s] = s;
        if (!(table->area[s] > 0.0f)) continue;
        size_t i = slot_of(table, s);
        if (table->first[i] == SL_NO_INDEX) table->first[i] = table->chosen[i] = s;
        else if (table->area[s] > table->area[table->chosen[i]]) table->chosen[i] = s;
    }
    for (uint32_t s = 0; s < sites; s++)
        if (table->area[s] > 0.0f) stand_in[s] = table->chosen[slot_of(table, s)];
}

sl_status sl_coarse_cluster(const sl_coarse *coarse, double cell, uint32_t *stand_in, sl_error *error) {
    size_t sites = coarse->topology->site_count;
    cluster_table table = {.coarse = coarse, .cell = cell, .slots = 16};
    while (table.slots < 2 * sites) table.slots *= 2;
    table.area = sl_allocate(sites, sizeof *table.area);
    table.first = sl_allocate(table.slots, sizeof *table.first);
    table.chosen = sl_allocate(table.slots, sizeof *table.chosen);
    bool good = table.area && table.first && table.chosen;
    for (size_t i = 0; good && i < table.slots; i++) table.first[i] = SL_NO_INDEX;
    if (good) {
        weigh_sites(&table);
        choose(&table, stand_in);
    }
    sl_free(table.area);
    sl_free(table.first);
    sl_free(table.chosen);
    return good ? SL_OK : sl_fail_memory(error, "the coarse mesh");
}
