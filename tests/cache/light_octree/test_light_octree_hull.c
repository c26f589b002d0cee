/* The area that photons tell of by themselves: their convex hull, against a slow one, and against areas that
 * are known. */
#include "light_octree_photons.h"

#include "cache/light_octree/photon_area.h"

enum { MOST = 400 };

static float at(uint64_t stream, uint64_t i) { return sl_random_unit(sl_random_key(41, stream), i); }

/* Gift wrapping: from the leftmost point, always the one with all others to the left. */
static double slow_area(const sl_hull_points *p, size_t *corners) {
    size_t first = 0, here, next;
    double area = 0.0;
    *corners = 0;
    for (size_t i = 1; i < p->count; i++) {
        if (p->x[i] < p->x[first] || (p->x[i] == p->x[first] && p->y[i] < p->y[first])) first = i;
    }
    here = first;
    do {
        next = here == 0 ? 1 : 0;
        for (size_t i = 0; i < p->count; i++) {
            double ax = (double)p->x[next] - (double)p->x[here], ay = (double)p->y[next] - (double)p->y[here];
            double bx = (double)p->x[i] - (double)p->x[here], by = (double)p->y[i] - (double)p->y[here];
            double cross = ax * by - ay * bx;
            if (cross < 0.0 || (cross == 0.0 && bx * bx + by * by > ax * ax + ay * ay)) next = i;
        }
        area += 0.5 * ((double)p->x[here] * (double)p->y[next] - (double)p->y[here] * (double)p->x[next]);
        ++*corners;
        here = next;
    } while (here != first && *corners <= p->count);
    return area;
}

/* kind 0: a square; 1: a disc; 2: a circle, every point a corner; 3: a small grid, many points in one place
 * or in line; 4: a thin strip */
static void fill(sl_hull_points *p, size_t count, int kind, uint64_t seed) {
    p->count = count;
    for (size_t i = 0; i < count; i++) {
        float u = at(2 * seed, i), v = at(2 * seed + 1, i), sine, cosine, r = kind == 2 ? 1.0f : sqrtf(u);
        sl_sincos_turnf(v, &sine, &cosine);
        p->x[i] = kind == 0 ? u - 0.5f : kind == 3 ? floorf(5.0f * u) : kind == 4 ? u : r * cosine;
        p->y[i] = kind == 0 ? v - 0.5f : kind == 3 ? floorf(4.0f * v) : kind == 4 ? 1e-4f * v : r * sine;
    }
}

static void the_hull_is_that_of_a_slow_search_on_every_instruction_set(void **state) {
    (void)state;
    const char *isas[] = {"baseline", "avx2", "avx512"};
    sl_hull_points p;
    assert_int_equal(sl_hull_points_create(MOST, &p, NULL), SL_OK);
    for (uint64_t run = 0; run < 200; run++) {
        size_t count = run < 60 ? 3 + (size_t)run : MOST / (1 + (size_t)run % 7), corners;
        fill(&p, count, (int)(run % 5), run);
        sl_photon_hull first = sl_photon_hull_of(&p);
        double area = slow_area(&p, &corners);
        if (fabs(first.area - area) > 1e-9 + 1e-6 * area)
            fail_msg("run %d: %.9g, not %.9g", (int)run, first.area, area);
        if (first.area > 0.0) assert_int_equal(first.corners, corners);
        for (int isa = 0; isa < 3; isa++) {
            setenv("SOFTLUX_ISA", isas[isa], 1);
            sl_photon_hull other = sl_photon_hull_of(&p);
            assert_true(other.area == first.area && other.corners == first.corners);
        }
        unsetenv("SOFTLUX_ISA");
    }
    sl_hull_points_release(&p);
}

/* Of half of the surface, (N + 1) / (N - N_b + 1) |hull| is a half on the mean; the hull alone would be a
 * tenth to a third less. */
static void the_estimate_has_no_bias(void **state) {
    (void)state;
    sl_hull_points p;
    assert_int_equal(sl_hull_points_create(MOST, &p, NULL), SL_OK);
    const size_t counts[] = {20, 75, 300};
    for (int kind = 0; kind < 2; kind++) {
        double truth = kind == 0 ? 1.0 : SL_PI;
        for (int k = 0; k < 3; k++) {
            enum { RUNS = 2000 };
            double sum = 0.0, bare = 0.0;
            for (uint64_t run = 0; run < RUNS; run++) {
                fill(&p, counts[k], kind, 1000 + run);
                sl_photon_hull hull = sl_photon_hull_of(&p);
                sum += sl_photon_hull_share(&hull, p.count, 4.0 * truth) * 4.0 / RUNS;
                bare += hull.area / truth / RUNS;
            }
            if (fabs(sum - 1.0) > 0.01) fail_msg("kind %d, %zu points: %.4f", kind, counts[k], sum);
            assert_true(bare < (counts[k] < 100 ? 0.9 : 0.96));
        }
    }
    sl_hull_points_release(&p);
}

/* Three standard deviations: where all of it is lit, photons hardly ever say otherwise. */
static void what_is_not_sure_is_left_as_it_is(void **state) {
    (void)state;
    sl_hull_points p;
    assert_int_equal(sl_hull_points_create(MOST, &p, NULL), SL_OK);
    for (int kind = 0; kind < 2; kind++) {
        int less = 0;
        double mean = 0.0;
        for (uint64_t run = 0; run < 2000; run++) {
            fill(&p, 150, kind, 5000 + run);
            sl_photon_hull hull = sl_photon_hull_of(&p);
            double share = sl_photon_hull_share(&hull, p.count, kind == 0 ? 1.0 : SL_PI);
            less += share < 1.0;
            mean += share / 2000.0;
        }
        if (less > 20 || !(mean > 0.999)) fail_msg("kind %d: %d of 2000, mean %.4f", kind, less, mean);
    }
    sl_hull_points_release(&p);
}

static void what_spans_no_area_says_nothing(void **state) {
    (void)state;
    sl_hull_points p;
    assert_int_equal(sl_hull_points_create(MOST, &p, NULL), SL_OK);
    for (int kind = 0; kind < 4; kind++) {
        p.count = kind == 3 ? 2 : 100;
        for (size_t i = 0; i < p.count; i++) {
            p.x[i] = kind == 0 ? 1.0f : (float)i;
            p.y[i] = kind == 0 ? 2.0f : kind == 1 ? 0.0f : (float)i;
        }
        sl_photon_hull hull = sl_photon_hull_of(&p);
        assert_true(hull.area == 0.0);
        assert_true(sl_photon_hull_share(&hull, p.count, 1.0) == 1.0);
    }
    p.count = 0;
    sl_photon_hull none = sl_photon_hull_of(&p);
    assert_true(none.area == 0.0 && sl_photon_hull_share(&none, 0, 1.0) == 1.0);
    sl_photon_hull tiny = {1e-6, 20};
    assert_true(sl_photon_hull_share(&tiny, 100, 1.0) == 0.1); /* no more than tenfold */
    assert_true(sl_photon_hull_share(&tiny, 7, 1.0) == 1.0 && sl_photon_hull_share(&tiny, 100, 0.0) == 1.0);
    assert_true(sl_photon_hull_share(&tiny, 100, (double)NAN) == 1.0);
    sl_hull_points_release(&p);
}

/* ---- voxels ---- */

/* A floor of which a box covers half: what is under the box no photon meets. Beside the box the floor is as
 * bright as elsewhere. */
static void floors_are_not_dark_beside_what_stands_on_them(void **state) {
    (void)state;
    float xyz[9 * 8];
    add_quad(xyz, 0, sl_v3(0, 0, 0), sl_v3(0, 0, 4), sl_v3(4, 0, 0));
    add_quad(xyz, 2, sl_v3(2, 0, 0), sl_v3(0, 0, 4), sl_v3(0, 2, 0));
    add_quad(xyz, 4, sl_v3(2, 2, 0), sl_v3(0, 0, 4), sl_v3(2, 0, 0));
    add_quad(xyz, 6, sl_v3(4, 0, 0), sl_v3(0, 2, 0), sl_v3(0, 0, 4));
    sl_scene *scene = scene_of_triangles(xyz, 8);
    sl_photon_list *list = new_list(40000);
    strew_evenly(list, 40000, sl_v3(0, 0, 0), sl_v3(0, 0, 4), sl_v3(2, 0, 0), sl_v3(0, 1, 0), 3.0f, 7);
    sl_voxel_light_options o = plain_options(4);
    o.neighbours = 300;
    o.acceptance = 35.0 / 180.0 * SL_PI;
    o.split_by_normal = true;
    lit l = light_up(scene, 5, list, &o, 1);
    double count[2] = {0.0, 0.0}, sum[2] = {0.0, 0.0};
    for (size_t s = 0; s < l.lights->set_count; s++) {
        sl_vec3 c = l.lights->set[s].centroid;
        bool floor_set =
                 fabsf(l.lights->set[s].normal.y) > 0.9f && c.y < 0.01f && c.x<2.0f, near = c.x> 1.85f,
             middle = c.x > 0.5f && c.x < 1.5f;
        if (!floor_set || !(near || middle)) continue;
        sum[middle] += irradiance_on(l.lights, s, sl_v3(0, 1, 0));
        count[middle] += 1.0;
    }
    assert_true(count[0] > 20.0 && count[1] > 100.0);
    double beside = sum[0] / count[0] / 3.0, far = sum[1] / count[1] / 3.0;
    end_lit(&l);
    assert_true(fabs(far - 1.0) < 0.02 && fabs(beside - 1.0) < 0.05);
    sl_scene_destroy(scene);
}

/* A floor modelled twice, and once more the other way up, is no larger. */
static void a_floor_modelled_thrice_is_as_bright_as_one(void **state) {
    (void)state;
    float xyz[9 * 6];
    for (size_t k = 0; k < 2; k++) add_quad(xyz, 2 * k, sl_v3(0, 0, 0), sl_v3(0, 0, 4), sl_v3(4, 0, 0));
    add_quad(xyz, 4, sl_v3(0, 0, 0), sl_v3(4, 0, 0), sl_v3(0, 0, 4));
    sl_scene *scene = scene_of_triangles(xyz, 6);
    sl_voxel_light_options o = plain_options(4);
    o.neighbours = 300;
    o.split_by_normal = true;
    lit l = light_up(scene, 4, even_floor(40000, 3.0f, 9), &o, 1);
    double count[2] = {0.0, 0.0}, sum[2] = {0.0, 0.0};
    for (size_t s = 0; s < l.lights->set_count; s++) {
        sl_vec3 c = l.lights->set[s].centroid;
        bool edge = c.x < 0.2f || c.z < 0.2f || c.x > 3.8f || c.z > 3.8f;
        if (l.lights->set[s].lights == 0) continue;
        sum[edge] += irradiance_on(l.lights, s, sl_v3(0, 1, 0)) / 3.0;
        count[edge] += 1.0;
    }
    end_lit(&l);
    assert_true(count[0] > 100.0 && count[1] > 40.0);
    assert_true(fabs(sum[0] / count[0] - 1.0) < 0.02 && fabs(sum[1] / count[1] - 1.0) < 0.05);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_hull_is_that_of_a_slow_search_on_every_instruction_set),
        cmocka_unit_test(the_estimate_has_no_bias),
        cmocka_unit_test(what_is_not_sure_is_left_as_it_is),
        cmocka_unit_test(what_spans_no_area_says_nothing),
        cmocka_unit_test(floors_are_not_dark_beside_what_stands_on_them),
        cmocka_unit_test(a_floor_modelled_thrice_is_as_bright_as_one),
    };
    return cmocka_run_group_tests_name("light octree: the hull of photons", tests, NULL, NULL);
}
