/* Sites: the corners that faces share. A corner takes the first site at its position (equal bits) whose
 * normal is no further than 1e-4 radians from its own, or starts another. A site keeps the normal of the
 * corner that started it, and corners come in the order of faces, so the outcome depends on nothing but the
 * scene. Sites are found by position and by the cell of a grid over normals, so that the tip of a cone, where
 * thousands of normals meet, takes no longer than as many corners elsewhere. */
#include <math.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/patches/topology_parts.h"

#define SAME_NORMAL 1e-4  /* radians */
#define NORMAL_CELLS                                                                                  \
    512.0 /* a unit length: a cell is far wider than SAME_NORMAL, so that few corners have to look in \
             several */

typedef struct normal_cell {
    int16_t x, y, z;
} normal_cell;

typedef struct site {
    sl_vec3 position, normal;
    float exponent;
    uint32_t face;
    uint32_t next;    /* at this position with a normal in the same cell */
    normal_cell cell;
    bool shared;
} site;

typedef struct site_table {
    site *site;
    size_t count, capacity;
    size_t slots;
    uint32_t *in_cell;       /* the last site of each position and cell; at most half full */
} site_table;

static bool same_bits(sl_vec3 a, sl_vec3 b) {
    return sl_float_bits(a.x) == sl_float_bits(b.x) && sl_float_bits(a.y) == sl_float_bits(b.y) &&
           sl_float_bits(a.z) == sl_float_bits(b.z);
}

static uint64_t hash_position(sl_vec3 p) {
    uint64_t xy = (uint64_t)sl_float_bits(p.x) << 32 | sl_float_bits(p.y);
    return sl_hash64(sl_hash64(xy) ^ sl_float_bits(p.z));
}

static uint32_t *find_cell(const site_table *table, sl_vec3 p, normal_cell cell) {
    uint64_t packed = (uint64_t)(uint16_t)cell.x << 32 | (uint64_t)(uint16_t)cell.y << 16 | (uint16_t)cell.z;
    size_t i = (size_t)sl_hash64(hash_position(p) ^ packed) & (table->slots - 1);
    for (; table->in_cell[i] != SL_NO_INDEX; i = (i + 1) & (table->slots - 1)) {
        const site *s = &table->site[table->in_cell[i]];
        if (same_bits(s->position, p) && s->cell.x == cell.x && s->cell.y == cell.y && s->cell.z == cell.z)
            break;
    }
    return &table->in_cell[i];
}

static int16_t cell_of(double normal) {
    double cell = floor(normal * NORMAL_CELLS);
    return (int16_t)(fabs(cell) < 1e4 ? cell : 0.0); /* NaN: 0 */
}

/* The chord between unit vectors stands for their angle: cosines near 1 cannot tell 1e-4 radians from 0 in
 * float. */
static bool same_direction(sl_vec3 a, sl_vec3 b) {
    sl_vec3d d = sl_subd(sl_to_double(a), sl_to_double(b));
    return sl_dotd(d, d) <= SAME_NORMAL * SAME_NORMAL;
}

/* The lowest site that a corner may take, looked for in all cells that its normal is near to. */
static uint32_t find_site(const site_table *table, const site *corner) {
    uint32_t found = SL_NO_INDEX;
    sl_vec3d n = sl_to_double(corner->normal);
    for (int x = cell_of(n.x - SAME_NORMAL); x <= cell_of(n.x + SAME_NORMAL); x++)
        for (int y = cell_of(n.y - SAME_NORMAL); y <= cell_of(n.y + SAME_NORMAL); y++)
            for (int z = cell_of(n.z - SAME_NORMAL); z <= cell_of(n.z + SAME_NORMAL); z++) {
                normal_cell cell = {(int16_t)x, (int16_t)y, (int16_t)z};
                for (uint32_t s = *find_cell(table, corner->position, cell); s != SL_NO_INDEX;
                     s = table->site[s].next)
                    if (s < found && same_direction(table->site[s].normal, corner->normal) &&
                        sl_float_bits(table->site[s].exponent) == sl_float_bits(corner->exponent))
                        found = s;
            }
    return found;
}

/* The site of a corner; SL_NO_INDEX: memory ended. */
static uint32_t site_of(site_table *table, const site *corner) {
    uint32_t found = find_site(table, corner);
    if (found != SL_NO_INDEX) {
        table->site[found].shared |= table->site[found].face != corner->face;
        return found;
    }
    if (table->count == table->capacity) {
        size_t capacity = sl_grown_capacity(table->capacity, table->count + 1024);
        if (!sl_regrow(&table->site, table->count, capacity, sizeof *table->site)) return SL_NO_INDEX;
        table->capacity = capacity;
    }
    uint32_t fresh = (uint32_t)table->count;
    uint32_t *in_cell = find_cell(table, corner->position, corner->cell);
    table->site[fresh] = *corner;
    table->site[fresh].next = *in_cell;
    *in_cell = fresh;
    table->count++;
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
                           .exponent = exponent, .face = face};
            corner.cell = (normal_cell){cell_of((double)corner.normal.x), cell_of((double)corner.normal.y),
                                        cell_of((double)corner.normal.z)};
            topology->site[c][face] = site_of(table, &corner);
            if (topology->site[c][face] == SL_NO_INDEX) return false;
        }
    }
    return true;
}

static bool keep_sites(sl_topology *topology, const site_table *table) {
    topology->site_count = table->count;
    topology->site_position = sl_allocate(table->count, sizeof(sl_vec3));
    topology->site_normal = sl_allocate(table->count, sizeof(sl_vec3));
    topology->site_face = sl_allocate(table->count, sizeof(uint32_t));
    topology->site_shared = sl_allocate(table->count, 1);
    if (topology->site_position == NULL || topology->site_normal == NULL || topology->site_face == NULL ||
        topology->site_shared == NULL)
        return false;
    for (size_t s = 0; s < table->count; s++) {
        topology->site_position[s] = table->site[s].position;
        topology->site_normal[s] = table->site[s].normal;
        topology->site_face[s] = table->site[s].face;
        topology->site_shared[s] = table->site[s].shared;
    }
    return true;
}

sl_status sl_sites_make(sl_topology *topology, bool by_exponent, sl_error *error) {
    site_table table = {.slots = 16};
    while (table.slots < 6 * topology->face_count) table.slots *= 2; /* sites: at most 3 a face */
    table.in_cell = sl_allocate_unset(table.slots, sizeof *table.in_cell);
    bool good = table.in_cell != NULL;
    for (size_t i = 0; good && i < table.slots; i++) table.in_cell[i] = SL_NO_INDEX;
    good = good && find_sites(topology, by_exponent, &table) && keep_sites(topology, &table);
    sl_free(table.site);
    sl_free(table.in_cell);
    return good ? SL_OK : sl_fail_memory(error, "shared corners");
}
