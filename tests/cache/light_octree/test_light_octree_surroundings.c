/* How much of a scene's surface ellipsoids hold, where fine triangles count as points. */
#include "light_octree_support.h"

#include "cache/light_octree/surroundings.h"
#include "trace_scenes.h"

enum { TRIALS = 24, RADII = 3 };

static const double least_cosine = 0.5;

/* A sphere of fine triangles over a floor of two. */
static sl_scene *ball_over_a_floor(unsigned rings) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t white = trace_mesh_material(&mesh, 0.5f, 0, 0, 0, 0);
    uint32_t corner[4];
    for (int k = 0; k < 4; k++)
        corner[k] = trace_mesh_vertex(&mesh, k & 1 ? 2.0f : -2.0f, -1.05f, k & 2 ? 2.0f : -2.0f);
    trace_mesh_triangle(&mesh, corner[0], corner[2], corner[1], white);
    trace_mesh_triangle(&mesh, corner[1], corner[2], corner[3], white);
    trace_mesh_sphere(&mesh, sl_v3(0, 0, 0), 1.0f, rings, 0.0f, false, white);
    return trace_mesh_build(&mesh);
}

typedef struct world {
    sl_scene *scene;
    sl_octree *octree;
    sl_surroundings *surroundings;
    sl_surroundings_marks marks;
} world;

static world world_of(unsigned rings, double small_edge) {
    world w = {.scene = ball_over_a_floor(rings)};
    w.octree = octree_of(w.scene, 5, 1);
    assert_int_equal(sl_surroundings_create(w.scene, w.octree, small_edge, 1, &w.surroundings, NULL), SL_OK);
    w.marks.mark = calloc(w.scene->triangle_count, sizeof *w.marks.mark);
    return w;
}

static void forget(world *w) {
    free(w->marks.mark);
    sl_surroundings_destroy(w->surroundings);
    sl_octree_destroy(w->octree);
    sl_scene_destroy(w->scene);
}

/* Three ellipsoids about a point near the surface, the largest first. */
static void ellipsoids(const world *w, uint64_t i, sl_ellipsoid e[RADII]) {
    static const double radius[RADII] = {0.7, 0.45, 0.2};
    uint32_t triangle;
    sl_vec3 p = random_on(w->scene, sl_random_key(77, 0), i, &triangle),
            n = sl_scene_geometric_normal(w->scene, triangle);
    p = sl_add(p, sl_scale(n, 0.02f * (float)(i % 3)));
    for (int k = 0; k < RADII; k++)
        e[k] = (sl_ellipsoid){sl_to_double(p), sl_to_double(n), 0.25, radius[k]};
}

/* Every triangle, cut. */
static void cut_all(const world *w, const sl_ellipsoid *e, double area[2]) {
    area[0] = area[1] = 0.0;
    for (uint32_t t = 0; t < w->scene->triangle_count; t++) {
        sl_vec3d corner[3];
        double cosine = sl_dotd(sl_to_double(sl_scene_geometric_normal(w->scene, t)), e->normal);
        for (int k = 0; k < 3; k++)
            corner[k] = sl_to_double(sl_scene_position(w->scene, w->scene->vertex[k][t]));
        if (fabs(cosine) >= least_cosine)
            area[cosine < 0.0] += sl_triangle_in_ellipsoid(e, corner[0], corner[1], corner[2]);
    }
}

/* Large ones are cut: with no small ones among them the sums are exact, but for layers that hide each other.
 */
static void fine_triangles_count_as_points_and_make_the_same_area(void **state) {
    (void)state;
    const double small_edges[2] = {0.0, 0.09};
    for (int fine = 0; fine < 2; fine++) {
        world w = world_of(100, small_edges[fine]);
        double most[RADII] = {0};
        for (uint64_t i = 0; i < TRIALS; i++) {
            sl_ellipsoid e[RADII];
            ellipsoids(&w, i, e);
            for (int k = 0; k < RADII; k++) {
                double cut[2], disc = sl_disc_area(&e[k]);
                cut_all(&w, &e[k], cut);
                if (cut[0] > 0.95 * disc) continue; /* of layers one counts */
                sl_strewn_area found = sl_surroundings_area(w.surroundings, &e[k], least_cosine, &w.marks);
                most[k] = fmax(most[k], fabs(found.front - cut[0]) / disc);
            }
        }
        assert_true((w.surroundings->surfel_count > 0) == (fine == 1));
        for (int k = 0; k < RADII; k++) {
            print_message("%s, R %d: %.2g of the disc\n", fine ? "fine" : "cut", k, most[k]);
            /* the smallest is thinner than they are */
            if (fine && k < 2) assert_true(most[k] > 1e-6 && most[k] < 0.05);
            else assert_true(most[k] < 1e-9);
        }
        forget(&w);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fine_triangles_count_as_points_and_make_the_same_area),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
