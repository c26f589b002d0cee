/* The octree over the scene's geometry: which voxels it has, and what they say of the surfaces in them. */
#include "light_octree_support.h"

static void boxes_are_closed(void **state) {
    sl_vec3d low = {0, 0, 0}, high = {1, 1, 1};
    sl_cell_triangle corner = sl_cell_triangle_of(sl_v3d(1, 1, 1), sl_v3d(2, 1, 1), sl_v3d(1, 2, 1));
    sl_cell_triangle edge = sl_cell_triangle_of(sl_v3d(-1, 1, 1), sl_v3d(2, 1, 1), sl_v3d(0.5, 1.5, 1.5));
    sl_cell_triangle face = sl_cell_triangle_of(sl_v3d(-3, -3, 1), sl_v3d(6, -3, 1), sl_v3d(0, 6, 1));
    sl_cell_triangle near_miss =
        sl_cell_triangle_of(sl_v3d(-3, -3, 1.0000001), sl_v3d(6, -3, 1.0000001), sl_v3d(0, 6, 1.0000001));
    sl_triangle_part part;
    sl_triangle_in_box(&corner, low, high, &part);
    assert_int_equal(part.count, 1);
    sl_triangle_in_box(&edge, low, high, &part);
    assert_int_equal(part.count, 2);
    sl_triangle_in_box(&near_miss, low, high, &part);
    assert_int_equal(part.count, 0);
    sl_triangle_in_box(&face, low, high, &part);
    assert_true(fabs(part.area - 1.0) < 1e-14);
    assert_true(fabs(part.centroid.x - 0.5) < 1e-14 && fabs(part.centroid.y - 0.5) < 1e-14 &&
                part.centroid.z == 1.0);
}

static void morton_codes_come_back(void **state) {
    uint64_t key = sl_random_key(6, 0);
    for (uint64_t i = 0; i < 10000; i++) {
        uint32_t c[3] = {sl_random_bits(key, 3 * i) >> 11, sl_random_bits(key, 3 * i + 1) >> 11,
                         sl_random_bits(key, 3 * i + 2) >> 11},
                 d[3];
        sl_morton_decode(sl_morton_code(c[0], c[1], c[2]), d);
        assert_memory_equal(c, d, sizeof c);
    }
    assert_true(sl_morton_code(1, 0, 0) == 1 && sl_morton_code(0, 1, 0) == 2 &&
                sl_morton_code(0, 0, 1) == 4);
}

/* Of radius 0.47 of the root: 1,064, 4,304 and 17,072 cells meet it, by the distances of their corners. */
static void a_sphere_has_the_leaves_that_were_counted(void **state) {
    sl_scene *scene = sphere_in_a_root(150, 0.94f * 1.0001f);
    const size_t counts[] = {1064, 4304, 17072};
    for (int depth = 4; depth <= 6; depth++) {
        sl_octree *octree = octree_of(scene, depth, 2);
        if (octree->leaf_count != counts[depth - 4] + 2)
            fail_msg("depth %d: %zu leaves", depth, octree->leaf_count);
        sl_octree_destroy(octree);
    }
    sl_scene_destroy(scene);
}

static void check_samples(const sl_scene *scene, const sl_octree *octree, size_t samples) {
    uint64_t key = sl_random_key(9, 0);
    for (uint64_t i = 0; i < samples; i++) {
        uint32_t t = sl_random_bits(key, 3 * i) % (uint32_t)scene->triangle_count;
        float a = sl_random_unit(key, 3 * i + 1), b = sl_random_unit(key, 3 * i + 2);
        if (a + b > 1.0f) {
            a = 1.0f - a;
            b = 1.0f - b;
        }
        if (i % 5 == 0) b = 0.0f; /* on an edge */
        if (i % 7 == 0) a = 1.0f - b;
        sl_vec3 p0 = sl_scene_position(scene, scene->vertex[0][t]),
                p1 = sl_scene_position(scene, scene->vertex[1][t]),
                p2 = sl_scene_position(scene, scene->vertex[2][t]);
        sl_vec3 p = sl_add(sl_add(sl_scale(p0, 1.0f - a - b), sl_scale(p1, a)), sl_scale(p2, b));
        uint32_t leaf = leaf_at(octree, p);
        if (leaf == SL_NO_INDEX) fail_msg("no leaf at %.9g %.9g %.9g", (double)p.x, (double)p.y, (double)p.z);
        bool listed = octree->triangle_count == 0;
        for (uint32_t k = 0; k < octree->leaf[leaf].triangle_count; k++) {
            uint32_t here = octree->triangle[octree->leaf[leaf].first_triangle + k];
            listed |= here == t;
            assert_true(k == 0 || here > octree->triangle[octree->leaf[leaf].first_triangle + k - 1]);
        }
        assert_true(listed);
    }
}

static void check_leaves(const sl_scene *scene, const sl_octree *octree) {
    sl_cell_space space = sl_cell_space_of(scene, octree->origin, octree->edge, octree->depth);
    sl_voxel_lights *lights = whole_voxels(scene, octree, 1);
    double area = 0.0, truth = 0.0, g = space.tolerance;
    size_t listed = 0;
    for (size_t i = 0; i < octree->leaf_count; i++) {
        const sl_octree_leaf *leaf = &octree->leaf[i];
        assert_true(leaf->triangle_count > 0 && leaf->first_triangle == listed);
        assert_true(i == 0 || octree->leaf[i - 1].morton < leaf->morton);
        listed += leaf->triangle_count;
        area += (double)lights->set[i].surface;
        uint32_t cell[3];
        sl_morton_decode(leaf->morton, cell);
        sl_vec3d low = sl_v3d(cell[0], cell[1], cell[2]),
                 c = sl_scaled(sl_subd(sl_to_double(lights->set[i].centroid), octree->origin), space.scale);
        assert_true(c.x >= low.x - 2 * g && c.x <= low.x + 1 + 2 * g && c.y >= low.y - 2 * g &&
                    c.y <= low.y + 1 + 2 * g && c.z >= low.z - 2 * g && c.z <= low.z + 1 + 2 * g);
        for (uint32_t k = 0; k < leaf->triangle_count; k++) {
            sl_cell_triangle t = sl_cell_space_triangle(&space, octree->triangle[leaf->first_triangle + k]);
            sl_triangle_part part;
            sl_triangle_in_box(&t, sl_subd(low, sl_v3d(2 * g, 2 * g, 2 * g)),
                               sl_addd(low, sl_v3d(1 + 2 * g, 1 + 2 * g, 1 + 2 * g)), &part);
            assert_true(part.count > 0);
        }
        double length = (double)sl_length(lights->set[i].normal);
        assert_true(length == 0.0 || fabs(length - 1.0) < 1e-6);
    }
    assert_true(listed == octree->triangle_count && lights->set_count == octree->leaf_count);
    sl_voxel_lights_destroy(lights);
    for (uint32_t i = 0; i < scene->triangle_count; i++)
        truth += 0.5 * sl_lengthd(sl_cell_space_triangle(&space, i).normal);
    truth /= space.scale * space.scale;
    if (!(fabs(area - truth) <= truth * (1e-6 + 20.0 * g)))
        fail_msg("areas of leaves add up to %.9g, triangles to %.9g", area, truth);
}

static void every_surface_sample_has_a_leaf_and_every_leaf_a_triangle(void **state) {
    sl_scene *scene = furnished_room(12, 10);
    for (int depth = 1; depth <= 7; depth += 2) {
        sl_octree *octree = octree_of(scene, depth, 2);
        check_leaves(scene, octree);
        check_samples(scene, octree, 20000);
        sl_octree_destroy(octree);
    }
    sl_scene_destroy(scene);
}

/* Coordinates of a million, where floats are 1/16 apart, and a thousandth of the room in one corner. */
static void huge_coordinates_and_tiny_detail_keep_every_sample_in_a_leaf(void **state) {
    float *xyz = malloc(9 * 2000 * sizeof *xyz);
    assert_non_null(xyz);
    ball shape = {sl_v3(1000020, 20, -999980), 9};
    size_t count = add_box(xyz, 0, sl_v3(1000000, 0, -1000000), sl_v3(1000040, 40, -999960), 2, NULL, NULL);
    count +=
        add_box(xyz, count, sl_v3(1000019, 19, -999981), sl_v3(1000021, 21, -999979), 6, onto_ball, &shape);
    sl_scene *scene = scene_of_triangles(xyz, count);
    sl_octree *octree = octree_of(scene, 6, 2);
    check_samples(scene, octree, 20000);
    sl_octree_destroy(octree);
    sl_scene_destroy(scene);
    ball tiny = {sl_v3(0.0123f, 0.0456f, 0.0789f), 0.004f};
    count = add_box(xyz, 0, sl_v3(0, 0, 0), sl_v3(4, 4, 4), 1, NULL, NULL);
    count += add_box(xyz, count, sl_v3(0.0113f, 0.0446f, 0.0779f), sl_v3(0.0133f, 0.0466f, 0.0799f), 6,
                     onto_ball, &tiny);
    scene = scene_of_triangles(xyz, count);
    octree = octree_of(scene, 6, 2);
    check_leaves(scene, octree);
    check_samples(scene, octree, 20000);
    sl_octree_destroy(octree);
    sl_scene_destroy(scene);
    free(xyz);
}

/* A plane through the middle of the scene's box lies in the faces between voxels at every depth. */
static void geometry_in_cell_faces_is_in_both_voxels_and_counted_once(void **state) {
    float xyz[9 * 200];
    size_t count = add_box(xyz, 0, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), 1, NULL, NULL);
    const float middle[18] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0};
    memcpy(xyz + 9 * count, middle, sizeof middle);
    sl_scene *scene = scene_of_triangles(xyz, count + 2);
    sl_octree *octree = octree_of(scene, 4, 1);
    sl_voxel_lights *lights = whole_voxels(scene, octree, 1);
    check_leaves(scene, octree);
    for (int i = -7; i <= 7; i += 2) {
        float x = (float)i / 8.0f * 0.9f;
        uint32_t above = leaf_at(octree, sl_v3(x, 0.07f, 1e-3f));
        uint32_t below = leaf_at(octree, sl_v3(x, 0.07f, -1e-3f));
        assert_true(above != SL_NO_INDEX && below != SL_NO_INDEX && above != below);
        assert_true(lights->set[above].normal.z == 1.0f && lights->set[below].normal.z == 1.0f);
        assert_true(fabsf(lights->set[above].centroid.z) < 1e-6f);
    }
    destroy_octree(scene, octree, lights, NULL);
}

static void normals_and_centroids_do_not_depend_on_tessellation(void **state) {
    float *coarse = malloc(9 * 12 * sizeof *coarse), *fine = malloc(9 * 6 * 2 * 11 * 11 * sizeof *fine);
    assert_true(coarse && fine);
    size_t few = add_box(coarse, 0, sl_v3(0, 0, 0), sl_v3(3.7f, 2.9f, 4.3f), 1, NULL, NULL);
    size_t many = add_box(fine, 0, sl_v3(0, 0, 0), sl_v3(3.7f, 2.9f, 4.3f), 11, NULL, NULL);
    sl_scene *a_scene = scene_of_triangles(coarse, few), *b_scene = scene_of_triangles(fine, many);
    for (int depth = 3; depth <= 6; depth++) {
        sl_octree *a = octree_of(a_scene, depth, 1), *b = octree_of(b_scene, depth, 2);
        assert_true(a->leaf_count == b->leaf_count && a->triangle_count != b->triangle_count);
        sl_voxel_lights *la = whole_voxels(a_scene, a, 1), *lb = whole_voxels(b_scene, b, 1);
        double voxel = sl_octree_voxel(a);
        for (size_t i = 0; i < a->leaf_count; i++) {
            assert_true(a->leaf[i].morton == b->leaf[i].morton);
            assert_true(fabs((double)la->set[i].surface - (double)lb->set[i].surface) < 1e-5 * voxel * voxel);
            assert_true((double)sl_length(sl_sub(la->set[i].centroid, lb->set[i].centroid)) < 1e-5 * voxel);
            assert_true(sl_length(sl_sub(la->set[i].normal, lb->set[i].normal)) < 1e-5f);
        }
        sl_voxel_lights_destroy(la);
        sl_voxel_lights_destroy(lb);
        sl_octree_destroy(a);
        sl_octree_destroy(b);
    }
    sl_scene_destroy(a_scene);
    sl_scene_destroy(b_scene);
    free(coarse);
    free(fine);
}

/* Two sheets that face away from each other, thin against a voxel, sloping by `slope`: how many voxels they
 * have, and how many without a normal. */
static size_t leaves_of_slab(float slope, size_t *without) {
    float xyz[36];
    for (int side = 0; side < 2; side++) {
        for (int k = 0; k < 6; k++) {
            const int x[2][6] = {{0, 1, 1, 0, 1, 0}, {0, 1, 1, 0, 0, 1}},
                      y[2][6] = {{0, 0, 1, 0, 1, 1}, {0, 1, 0, 0, 1, 1}};
            float *p = xyz + 18 * side + 3 * k;
            p[0] = (float)x[side][k];
            p[1] = (float)y[side][k];
            p[2] = slope * p[0] + (side ? -1e-4f : 1e-4f);
        }
    }
    sl_scene *scene = scene_of_triangles(xyz, 4);
    sl_octree *octree = octree_of(scene, 3, 1);
    sl_voxel_lights *lights = whole_voxels(scene, octree, 1);
    size_t leaves = octree->leaf_count;
    *without = 0;
    for (size_t i = 0; i < leaves; i++) *without += sl_length(lights->set[i].normal) == 0.0f;
    destroy_octree(scene, octree, lights, NULL);
    return leaves;
}

static void opposite_surfaces_leave_a_voxel_without_a_normal(void **state) {
    size_t without, leaves = leaves_of_slab(0.0f, &without);
    /* a cell's face is between them */
    assert_true(leaves == 2 * 64 && without == 0);
    leaves = leaves_of_slab(0.3f, &without);
    assert_true(without > leaves / 2);
}

static void grown_voxels_are_more(void **state) {
    sl_scene *scene = sphere_in_a_root(20, 0.9f);
    sl_octree *plain = octree_of(scene, 4, 1), *grown = NULL;
    sl_octree_root root = sl_octree_root_of_all(scene);
    assert_int_equal(sl_octree_create(scene, &root, 4, 0.25, 1, &grown, NULL), SL_OK);
    assert_true(grown->leaf_count > plain->leaf_count * 5 / 4);
    for (size_t i = 0; i < plain->leaf_count; i++)
        assert_true(leaf_of(grown, plain->leaf[i].morton) != SL_NO_INDEX);
    sl_octree_destroy(grown);
    sl_octree_destroy(plain);
    sl_scene_destroy(scene);
}

static void any_number_of_threads_builds_the_same_octree(void **state) {
    sl_scene *scene = furnished_room(10, 12);
    sl_octree *one = octree_of(scene, 6, 1);
    for (unsigned threads = 2; threads <= 3; threads++) {
        sl_octree *other = octree_of(scene, 6, threads);
        assert_true(one->leaf_count == other->leaf_count && one->triangle_count == other->triangle_count);
        assert_memory_equal(one->leaf, other->leaf, one->leaf_count * sizeof *one->leaf);
        assert_memory_equal(one->triangle, other->triangle, one->triangle_count * sizeof *one->triangle);
        sl_octree_destroy(other);
    }
    sl_octree_destroy(one);
    sl_scene_destroy(scene);
}

/* A white floor y = 0 of 4 x 4 whose right half has a sheet of that material just above it, and a second such
 * sheet high up. */
static sl_scene *floor_under_sheets(float mirror, float diffuse) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t white = trace_mesh_diffuse(&mesh, 0.5f),
             sheet = trace_mesh_material(&mesh, diffuse, 0, 0, mirror, 0);
    trace_mesh_quad(&mesh, sl_v3(-2, 0, -2), sl_v3(0, 0, 4), sl_v3(4, 0, 0), white);
    trace_mesh_quad(&mesh, sl_v3(0, 0.001f, -2), sl_v3(0, 0, 4), sl_v3(2, 0, 0), sheet);
    trace_mesh_quad(&mesh, sl_v3(-2, 3, -2), sl_v3(0, 0, 4), sl_v3(4, 0, 0), sheet);
    return trace_mesh_build(&mesh);
}

static void cells_with_black_or_mirroring_surfaces_alone_are_no_leaves(void **state) {
    const float materials[3][2] = {{0, 0.5f}, {0, 0}, {0.9f, 0}};
    for (int k = 0; k < 3; k++) {
        sl_scene *scene = floor_under_sheets(materials[k][0], materials[k][1]);
        sl_octree *octree = octree_of(scene, 4, 2);
        sl_voxel_lights *lights = whole_voxels(scene, octree, 1);
        double area = 0.0, highest = -1.0;
        for (size_t i = 0; i < octree->leaf_count; i++) {
            area += (double)lights->set[i].surface;
            highest = fmax(highest, (double)lights->set[i].centroid.y);
        }
        assert_true(k == 0 ? highest > 2.9 : highest < 0.1);
        assert_true(fabs(area - (k == 0 ? 40.0 : 16.0)) < 0.01);
        destroy_octree(scene, octree, lights, NULL);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_are_closed),
        cmocka_unit_test(morton_codes_come_back),
        cmocka_unit_test(a_sphere_has_the_leaves_that_were_counted),
        cmocka_unit_test(every_surface_sample_has_a_leaf_and_every_leaf_a_triangle),
        cmocka_unit_test(huge_coordinates_and_tiny_detail_keep_every_sample_in_a_leaf),
        cmocka_unit_test(geometry_in_cell_faces_is_in_both_voxels_and_counted_once),
        cmocka_unit_test(normals_and_centroids_do_not_depend_on_tessellation),
        cmocka_unit_test(opposite_surfaces_leave_a_voxel_without_a_normal),
        cmocka_unit_test(grown_voxels_are_more),
        cmocka_unit_test(any_number_of_threads_builds_the_same_octree),
        cmocka_unit_test(cells_with_black_or_mirroring_surfaces_alone_are_no_leaves),
    };
    return cmocka_run_group_tests_name("light octree: octree", tests, NULL, NULL);
}
