/* Lights of voxels from photons strewn by hand: what they say of the irradiance, on flat and tilted surfaces,
 * at edges, on thin walls, and where there is next to nothing to go by. */
#include "light_octree_photons.h"

#include "cache/light_octree/voxel_lights.h"

/* ---- lobes alone ---- */

enum { CLOUD = 6000 };

typedef struct cloud {
    float *floats;
    double *doubles;
    uint8_t *of;
    sl_lobe_photons photons;
    sl_vec3 normal;
} cloud;

static cloud new_cloud(void) {
    cloud c = {.floats = malloc(6 * CLOUD * sizeof *c.floats),
               .doubles = malloc(4 * CLOUD * sizeof *c.doubles),
               .of = malloc(CLOUD),
               .normal = {0, 0, 1}};
    float *f = c.floats;
    double *d = c.doubles;
    assert_true(f && d && c.of);
    c.photons = (sl_lobe_photons){
        0,         f, f + CLOUD,     f + 2 * CLOUD, {f + 3 * CLOUD, f + 4 * CLOUD, f + 5 * CLOUD}, d,
        d + CLOUD, d + 2 * CLOUD, d + 3 * CLOUD, c.of};
    return c;
}

static void end_cloud(cloud *c) {
    free(c->floats);
    free(c->doubles);
    free(c->of);
}

/* Two fields of light: an even hemisphere, or a lobe of the 20th power at 60 degrees. */
static cloud field(bool lobe) {
    cloud c = new_cloud();
    uint64_t key = sl_random_key(21, lobe), more = sl_random_key(22, lobe);
    sl_frame axis = sl_frame_from_normal(sl_normalize_or(sl_v3(0.8660254f, 0, 0.5f), c.normal));
    const float flux[3] = {1, 1, 1};
    for (uint64_t i = 0; c.photons.count < CLOUD; i++) {
        sl_vec3 d = cosine_about(c.normal, key, i);
        if (lobe) {
            float cosine = (float)pow((double)sl_random_unit(key, 2 * i), 1.0 / 21.0), s, t;
            sl_sincos_turnf(sl_random_unit(key, 2 * i + 1), &s, &t);
            float r = sqrtf(1.0f - cosine * cosine);
            d = sl_frame_to_world(&axis, sl_v3(r * t, r * s, cosine));
            if (!(sl_random_unit(more, i) < d.z)) continue;
        }
        sl_lobe_photons_add(&c.photons, d, c.normal, flux);
    }
    return c;
}

static double ratio_on_tilt(const cloud *c, const sl_light_octree_settings *o, double degrees) {
    sl_vec3d n = sl_v3d(sl_sin(degrees * SL_PI / 180.0), 0.0, sl_cos(degrees * SL_PI / 180.0));
    double exact = 0.0, sum = 0.0;
    for (size_t i = 0; i < c->photons.count; i++) {
        double cosine = n.x * (double)c->photons.x[i] + n.z * (double)c->photons.z[i];
        exact += cosine > 0.0 ? cosine / (double)c->photons.z[i] : 0.0;
    }
    sl_directional_light light[8] = {{{0}, 0}};
    sl_lobe_spread spread = {0};
    int count = sl_lobes_of_photons(&c->photons, o, 1.0, c->normal, false, o->lights, light, &spread);
    for (int j = 0; j < count; j++) {
        double cosine = sl_dotd(n, sl_to_double(sl_direction_unpack(light[j].packed)));
        sum += (double)light[j].color[0] * (o->lobes == SL_LOBES_SURFACE ? 1.0 : cosine > 0.0 ? cosine : 0.0);
    }
    return sum / exact;
}

static void tilted_surfaces_get_what_the_table_says(void **state) {
    cloud even = field(false), narrow = field(true);
    const struct {
        const cloud *field;
        double tilt, ratio[4]; /* surface; perpendicular with 1, 4, 8 lights */
    } rows[] = {{&even, 30, {1.07, 0.93, 0.93, 0.95}},
                {&even, 60, {1.33, 0.67, 0.87, 0.96}},
                {&narrow, 30, {0.58, 0.99, 0.99, 0.99}},
                {&narrow, -30, {5.7, 0.14, 0.93, 0.99}}};
    for (int r = 0; r < 4; r++) {
        for (int k = 0; k < 4; k++) {
            sl_light_octree_settings o = plain_options(k == 0 ? 4 : k == 1 ? 1 : k == 2 ? 4 : 8);
            o.lobes = k == 0 ? SL_LOBES_SURFACE : SL_LOBES_PERPENDICULAR;
            double ratio = ratio_on_tilt(rows[r].field, &o, rows[r].tilt), wanted = rows[r].ratio[k];
            /* One light, all but grazing: a degree of its direction is half of the irradiance. */
            double tolerance = r == 3 && k == 1 ? 0.08 : 0.03 * wanted + 0.025;
            if (fabs(ratio - wanted) > tolerance)
                fail_msg("row %d, column %d: %.3f, not %.2f", r, k, ratio, wanted);
        }
    }
    end_cloud(&even);
    end_cloud(&narrow);
}

static void on_the_flat_nothing_is_lost(void **state) {
    cloud even = field(false), narrow = field(true);
    for (int n = 1; n <= 8; n++) {
        for (int k = 0; k < 4; k++) {
            const cloud *c = k & 1 ? &narrow : &even;
            sl_light_octree_settings o = plain_options(n);
            o.unit_weights = k & 2;
            double ratio = ratio_on_tilt(c, &o, 0.0);
            /* The clamp of grazing photons' weights costs 0.08 % of an even sky; packing is made up for. */
            assert_true(fabs(ratio - 1.0) < 6e-3);
        }
    }
    end_cloud(&even);
    end_cloud(&narrow);
}

/* An even sky over a fold: half of its photons lie on a face turned one way, half on one turned the other.
 * Where a whole voxel's mean normal is concerned, its lights make less; a set of one group of normals makes
 * all the light that its photons brought. */
static void a_bent_surface_makes_the_light_that_its_photons_brought(void **state) {
    cloud c = new_cloud();
    const float flux[3] = {1, 1, 1};
    uint64_t key = sl_random_key(23, 0);
    for (uint64_t i = 0; i < CLOUD; i++) {
        sl_vec3 face = sl_v3(i & 1 ? 0.6f : -0.6f, 0.0f, 0.8f);
        sl_lobe_photons_add(&c.photons, cosine_about(face, key, i), face, flux);
    }
    for (int n = 1; n <= 8; n++) {
        for (int split = 0; split < 2; split++) {
            sl_light_octree_settings o = plain_options(n);
            o.whole_voxels = !split;
            sl_directional_light light[8] = {{{0}, 0}};
            sl_lobe_spread spread = {0};
            double made = 0.0;
            int count =
                sl_lobes_of_photons(&c.photons, &o, 1.0 / CLOUD, sl_v3(0, 0, 1), false, n, light, &spread);
            for (int j = 0; j < count; j++)
                made += (double)light[j].color[0] * fmax(0.0, (double)sl_direction_unpack(light[j].packed).z);
            if (split) assert_true(fabs(made - 1.0) < 1e-5);
            else assert_true(made > 0.7 && made < 0.97);
        }
    }
    end_cloud(&c);
}

static void photons_that_carry_nothing_are_left_out(void **state) {
    cloud c = new_cloud();
    const float flux[8][3] = {{0, 0, 0},    {NAN, 1, 1},    {1, 1, 1},  {INFINITY, 0, 0},
                              {-1, -1, -1}, {0, 0, 1e-30f}, {1, -9, 1}, {2, 2, 2}};
    for (int i = 0; i < 8; i++)
        sl_lobe_photons_add(&c.photons, sl_v3(0, 0, 1), i == 7 ? sl_v3(NAN, 0, 0) : sl_v3(0, 0, 1), flux[i]);
    assert_int_equal(c.photons.count, 2);
    sl_directional_light light[4] = {{{0}, 0}};
    sl_lobe_spread spread = {0};
    sl_light_octree_settings o = plain_options(4);
    /* one direction, one light */
    assert_int_equal(sl_lobes_of_photons(&c.photons, &o, 2.0, sl_v3(0, 0, 1), false, 4, light, &spread), 1);
    assert_true(fabsf(light[0].color[0] - 2.0f) < 1e-5f && light[1].color[0] == 0.0f);
    assert_int_equal(
        sl_lobes_of_photons(&c.photons, &o, (double)INFINITY, sl_v3(0, 0, 1), false, 4, light, &spread), 0);
    c.photons.count = 0;
    assert_int_equal(sl_lobes_of_photons(&c.photons, &o, 2.0, sl_v3(0, 0, 1), false, 4, light, &spread), 0);
    end_cloud(&c);
}

/* ---- voxels ---- */

/* The middle of a large floor: the mean is right, and each voxel is within what k photons can tell. */
static void an_even_floor_has_its_irradiance_in_every_voxel(void **state) {
    sl_scene *scene = floor_of_four();
    for (int area = 0; area < 3; area++) {
        sl_light_octree_settings o = plain_options(4);
        o.area = (sl_photon_area)area;
        sl_photon_list *list = even_floor(60000, 3.0f, 7);
        lit l = light_up(scene, 5, list, &o, 1);
        double sum = 0.0, square = 0.0, count = 0.0;
        for (size_t i = 0; i < l.octree->leaf_count; i++) {
            sl_vec3 c = l.lights->set[i].centroid;
            bool border = c.x < 0.3f || c.z < 0.3f || c.x > 3.7f || c.z > 3.7f;
            if (border && area != SL_PHOTON_AREA_CLIP) continue; /* a disc is empty beyond the edge */
            double e = irradiance_on(l.lights, i, sl_v3(0, 1, 0));
            assert_true(fabs(e / 3.0 - 1.0) < 6.0 / sqrt(50.0)); /* of a thousand; (k-1)/A has a long tail */
            sum += e;
            square += (e - 3.0) * (e - 3.0);
            count += 1.0;
        }
        assert_true(count > 700.0);
        if (fabs(sum / count / 3.0 - 1.0) > 0.01)
            fail_msg("area %d: %.4f on average, not 3", area, sum / count);
        double deviation = sqrt(square / count) / 3.0; /* 1 / sqrt(k) = 14 % */
        assert_true(deviation > 0.11 && deviation < 0.17);
        end_lit(&l);
    }
    sl_scene_destroy(scene);
}

/* k/A without (k-1)/k would be 2 % too much at k = 50. */
static void the_mean_over_many_voxels_has_no_bias(void **state) {
    sl_scene *scene = floor_of_four();
    double sum = 0.0, count = 0.0;
    for (uint64_t seed = 0; seed < 6; seed++) {
        sl_light_octree_settings o = plain_options(1);
        o.lobes = SL_LOBES_NONE;
        sl_photon_list *list = even_floor(100000, 3.0f, 100 + seed);
        lit l = light_up(scene, 5, list, &o, 2);
        for (size_t i = 0; i < l.octree->leaf_count; i++) {
            sum += (double)l.lights->light[i].color[0];
            count += 1.0;
        }
        end_lit(&l);
    }
    if (fabs(sum / count / 3.0 - 1.0) > 0.006) fail_msg("%.5f on average, not 3", sum / count);
    sl_scene_destroy(scene);
}

/* Three walls of a corner, each with its own irradiance: the clipped area knows where they end, the
 * acceptance cone which is which. */
static void corners_are_neither_dark_nor_bleed_where_voxels_are_split(void **state) {
    float xyz[54];
    sl_vec3 x = sl_v3(2, 0, 0), y = sl_v3(0, 2, 0), z = sl_v3(0, 0, 2), o = sl_v3(0, 0, 0);
    add_quad(xyz, 0, o, z, x);
    add_quad(xyz, 2, o, x, y);
    add_quad(xyz, 4, o, y, z);
    sl_scene *scene = scene_of_triangles(xyz, 6);
    sl_photon_list *list = new_list(90000);
    strew_evenly(list, 30000, o, z, x, sl_v3(0, 1, 0), 1.0f, 1);
    strew_evenly(list, 30000, o, x, y, sl_v3(0, 0, 1), 2.0f, 2);
    strew_evenly(list, 30000, o, y, z, sl_v3(1, 0, 0), 4.0f, 3);
    sl_light_octree_settings options = plain_options(2);
    options.neighbours = 200;
    options.whole_voxels = false;
    lit l = light_up(scene, 4, list, &options, 1);
    size_t split = 0;
    for (size_t i = 0; i < l.octree->leaf_count; i++) {
        uint32_t first = l.lights->first_set[i], end = l.lights->first_set[i + 1];
        split += end - first > 1;
        for (uint32_t s = first; s < end; s++) {
            sl_vec3 n = l.lights->set[s].normal;
            double truth = n.y > 0.9f ? 1.0 : n.z > 0.9f ? 2.0 : 4.0;
            assert_true(n.x > 0.99f || n.y > 0.99f || n.z > 0.99f);
            assert_true(fabs(irradiance_on(l.lights, s, n) / truth - 1.0) < 4.5 / sqrt(200.0));
        }
    }
    assert_true(split > 30);
    end_lit(&l);
    sl_scene_destroy(scene);
}

/* A sheet lit from both sides, a wall with two faces, and a sheet whose triangles turn either way: each side
 * has its own irradiance. */
static void both_sides_of_thin_things_have_their_own_light(void **state) {
    for (int kind = 0; kind < 3; kind++) {
        float xyz[36], gap = kind == 1 ? 0.01f : 0.0f;
        sl_vec3 a = sl_v3(0, 0, 4), b = sl_v3(4, 0, 0), low = sl_v3(0, -gap, 0), high = sl_v3(0, gap, 0);
        add_quad(xyz, 0, high, a, b);
        if (kind == 1) add_quad(xyz, 2, low, b, a);
        if (kind == 2) { /* the second triangle the other way */
            sl_vec3 p;
            memcpy(&p, &xyz[12], sizeof p);
            memmove(&xyz[12], &xyz[15], sizeof p);
            memcpy(&xyz[15], &p, sizeof p);
        }
        /* off the cells' faces */
        for (size_t i = 0; i < 3 * (kind == 1 ? 4u : 2u); i++) xyz[3 * i + 1] += 0.11f * xyz[3 * i];
        sl_scene *scene = scene_of_triangles(xyz, kind == 1 ? 4 : 2);
        sl_vec3 up = sl_normalize_or(sl_v3(-0.11f, 1, 0), sl_v3(0, 1, 0)), slope = sl_v3(4, 0.44f, 0);
        sl_photon_list *list = new_list(60000);
        strew_evenly(list, 40000, high, a, slope, up, 4.0f, 5);
        strew_evenly(list, 20000, low, a, slope, sl_neg(up), 1.0f, 6);
        sl_light_octree_settings o = plain_options(4);
        o.neighbours = 400;
        o.whole_voxels = kind != 1; /* the wall's voxels have no normal of their own */
        lit l = light_up(scene, 4, list, &o, 1);
        double sum[2] = {0.0}, count[2] = {0.0};
        for (size_t s = 0; s < l.lights->set_count; s++) {
            const sl_voxel_set *set = &l.lights->set[s];
            if (sl_length(set->normal) == 0.0f) continue; /* where the two windings of the third meet */
            /* faces of the wall in one voxel have a set each */
            assert_true(kind == 1 || !set->opposed);
            for (int side = 0; side < 2; side++) {
                double e = irradiance_on(l.lights, s, side ? sl_neg(up) : up);
                sum[side] += e;
                count[side] += e > 0.0;
            }
        }
        assert_true(count[0] > 100.0 && count[1] > 100.0);
        if (fabs(sum[0] / count[0] - 4.0) > 0.15 || fabs(sum[1] / count[1] - 1.0) > 0.08)
            fail_msg("kind %d: %.3f and %.3f", kind, sum[0] / count[0], sum[1] / count[1]);
        end_lit(&l);
        sl_scene_destroy(scene);
    }
}

/* ---- several surfaces in one voxel ---- */

/* Two faces of 4 x 4 at two heights, and photons of irradiance 3 on that side of the first on which `up` is.
 */
static lit light_two_faces(float first, float second, bool first_turned, bool second_turned, sl_vec3 up,
                           sl_scene **scene) {
    const sl_vec3 a = sl_v3(0, 0, 4), b = sl_v3(4, 0, 0);
    /* far above: so that one voxel holds both */
    const float outlier[9] = {0, 2.5f, 0, 0.01f, 2.5f, 0, 0, 2.5f, 0.01f};
    float xyz[9 * 5];
    memcpy(xyz + 36, outlier, sizeof outlier);
    add_quad(xyz, 0, sl_v3(0, first, 0), first_turned ? b : a, first_turned ? a : b);
    add_quad(xyz, 2, sl_v3(0, second, 0), second_turned ? b : a, second_turned ? a : b);
    *scene = scene_of_triangles(xyz, 5);
    sl_photon_list *list = new_list(60000);
    strew_evenly(list, 60000, sl_v3(0, first, 0), a, b, up, 3.0f, 7);
    sl_light_octree_settings o = plain_options(4);
    o.neighbours = 300;
    o.whole_voxels = false;
    return light_up(*scene, 1, list, &o, 1);
}

/* A pixel's irradiance, at the nearest voxel alone or filtered. */
static double seen_on(const lit *l, sl_vec3 at, sl_vec3 n, bool filtered) {
    sl_voxel_texture *texture = texture_of(l->octree, l->lights);
    float out[3];
    sl_octree_shading shading = {
        .texture = texture, .filter = filtered ? SL_VOXEL_TRILINEAR : SL_VOXEL_NEAREST, .facing = true};
    shade_point(&shading, at, n, out);
    sl_voxel_texture_destroy(texture);
    return (double)out[0];
}

/* A voxel may hold a floor and the ground below it: far enough apart for a gather between them to miss both,
 * each has a set of its own. The floor makes all the light that its photons brought. */
static void a_floor_above_dark_ground_keeps_its_light(void **state) {
    const float below[] = {0.1f, 0.2f, 0.3f, 0.45f, 0.55f, 0.7f};
    const sl_vec3 up = sl_v3(0, 1, 0);
    for (int k = 0; k < 6; k++) {
        sl_scene *scene;
        lit l = light_two_faces(0.8f, 0.8f - below[k], false, false, up, &scene);
        for (int filtered = 0; filtered < 2; filtered++) {
            double on_floor = seen_on(&l, sl_v3(1.7f, 0.8f, 1.9f), up, filtered),
                   on_ground = seen_on(&l, sl_v3(1.7f, 0.8f - below[k], 1.9f), up, filtered);
            if (fabs(on_floor / 3.0 - 1.0) > 0.25)
                fail_msg("ground %g below: %.3f, not 3", (double)below[k], on_floor);
            if (below[k] > 0.5f && on_ground > 0.1)
                fail_msg("%.3f on the ground %g below", on_ground, (double)below[k]);
        }
        end_lit(&l);
        sl_scene_destroy(scene);
    }
}

/* Where a voxel holds both faces of a wall, each has the light of its own side: what reaches through from the
 * lit one must not turn the other face's normal to it, and then stand for it. */
static void the_dark_face_of_a_wall_does_not_stand_for_the_lit_one(void **state) {
    const sl_vec3 down = sl_v3(0, -1, 0);
    for (int k = 0; k < 6; k++) {
        float thick = 0.05f + 0.05f * (float)k;
        sl_scene *scene;
        lit l = light_two_faces(0.5f, 0.5f + thick, true, false, down, &scene);
        for (int filtered = 0; filtered < 2; filtered++) {
            double inside = seen_on(&l, sl_v3(1.7f, 0.5f, 1.9f), down, filtered),
                   outside = seen_on(&l, sl_v3(1.7f, 0.5f + thick, 1.9f), sl_neg(down), filtered);
            if (fabs(inside / 3.0 - 1.0) > 0.25 || outside != 0.0)
                fail_msg("%g thick: %.3f and %.3f, not 3 and 0", (double)thick, inside, outside);
        }
        size_t opposed = 0;
        for (size_t s = 0; s < l.lights->set_count; s++)
            opposed += l.lights->set[s].opposed;
        assert_int_equal(opposed, 8); /* of four voxels */
        end_lit(&l);
        sl_scene_destroy(scene);
    }
}

/* A sheet's n lights go to its sides by their irradiances; each side that is lit has one at least. */
static void the_brighter_side_of_a_sheet_has_more_of_the_lights(void **state) {
    const struct {
        float front, back;
        int lights, in_front, behind;
    } cases[] = {{7, 1, 8, 7, 1}, {1, 7, 8, 1, 7},   {1, 1, 8, 4, 4}, {300, 1, 8, 7, 1}, {1, 300, 8, 1, 7},
                 {3, 1, 4, 3, 1}, {1, 300, 2, 1, 1}, {3, 1, 1, 1, 0}, {1, 3, 1, 0, 1}};
    const sl_vec3 o = sl_v3(0, 0, 0), a = sl_v3(0, 0, 4), b = sl_v3(4, 0, 0), up = sl_v3(0, 1, 0);
    float xyz[18];
    add_quad(xyz, 0, o, a, b);
    sl_scene *scene = scene_of_triangles(xyz, 2);
    for (int k = 0; k < 9; k++) {
        sl_photon_list *list = new_list(40000);
        strew_evenly(list, 20000, o, a, b, up, cases[k].front, 5);
        strew_evenly(list, 20000, o, a, b, sl_neg(up), cases[k].back, 6);
        sl_light_octree_settings options = plain_options(cases[k].lights);
        options.neighbours = 2000;
        lit l = light_up(scene, 1, list, &options, 1);
        for (size_t s = 0; s < l.lights->set_count; s++) {
            int sides[2] = {0, 0};
            for (int j = 0; j < l.lights->set[s].lights; j++) {
                sides[sl_direction_unpack(l.lights->light[s * (size_t)l.lights->texels + (size_t)j].packed)
                          .y < 0.0f]++;
            }
            if (sides[0] != cases[k].in_front || sides[1] != cases[k].behind)
                fail_msg("case %d: %d and %d lights", k, sides[0], sides[1]);
            for (int side = 0; side < 2; side++) {
                double truth = (double)(side ? cases[k].back : cases[k].front),
                       e = irradiance_on(l.lights, s, side ? sl_neg(up) : up);
                if (sides[side] > 0) assert_true(fabs(e / truth - 1.0) < 0.2);
                else assert_true(e == 0.0);
            }
        }
        end_lit(&l);
    }
    sl_scene_destroy(scene);
}

/* ---- windings ---- */

/* Triangles wound away from the light are as bright as others. */
static void the_winding_does_not_matter(void **state) {
    float xyz[18];
    add_quad(xyz, 0, sl_v3(0, 0, 0), sl_v3(4, 0, 0), sl_v3(0, 0, 4)); /* normal -y */
    sl_scene *scene = scene_of_triangles(xyz, 2);
    sl_photon_list *list = new_list(30000);
    strew_evenly(list, 30000, sl_v3(0, 0, 0), sl_v3(4, 0, 0), sl_v3(0, 0, 4), sl_v3(0, 1, 0), 2.0f, 9);
    sl_light_octree_settings o = plain_options(4);
    lit l = light_up(scene, 3, list, &o, 1);
    for (size_t i = 0; i < l.octree->leaf_count; i++) {
        assert_true(fabs(irradiance_on(l.lights, i, sl_v3(0, 1, 0)) / 2.0 - 1.0) < 0.85);
        assert_true(irradiance_on(l.lights, i, sl_v3(0, -1, 0)) == 0.0);
        assert_true(l.lights->set[i].normal.y == 1.0f); /* turned to the photons */
    }
    end_lit(&l);
    sl_scene_destroy(scene);
}

static void next_to_nothing_gives_finite_lights_or_none(void **state) {
    sl_scene *scene = floor_of_four();
    for (int kind = 0; kind < 4; kind++) {
        sl_photon_list *list = new_list(1000);
        if (kind == 1) strew(list, sl_v3(2, 0, 2), sl_v3(0, 1, 0), sl_v3(0, 1, 0), 1.0f); /* a single one */
        /* all at one place */
        for (int i = 0; kind == 2 && i < 1000; i++)
            strew(list, sl_v3(2, 0, 2), sl_v3(0, 1, 0), sl_v3(0, 1, 0), 1e-3f);
        /* few */
        if (kind == 3)
            strew_evenly(list, 60, sl_v3(0, 0, 0), sl_v3(0, 0, 4), sl_v3(4, 0, 0), sl_v3(0, 1, 0), 2.0f, 3);
        sl_light_octree_settings o = plain_options(4);
        o.radius = kind == 3 ? 0.5 : 0.3;
        lit l = light_up(scene, 4, list, &o, 1);
        const sl_voxel_statistics s = sl_voxel_lights_statistics(l.lights);
        size_t dark = 0;
        for (size_t i = 0; i < l.octree->leaf_count; i++) {
            double e = irradiance_on(l.lights, i, sl_v3(0, 1, 0));
            assert_true(isfinite(e) && e >= 0.0 && isfinite(l.lights->set[i].rms_angle));
            dark += l.lights->set[i].lights == 0;
            const bool has_photons = l.lights->set[i].photons > 0;
            /* at one place they may tell nothing */
            assert_true(kind == 2 ? e == 0.0 || has_photons : (e > 0.0) == has_photons);
        }
        assert_true(l.counters.value[SL_COUNT_LEAVES] == l.octree->leaf_count &&
                    l.counters.value[SL_COUNT_LEAVES_WITHOUT_PHOTONS] == dark);
        assert_true(s.sets == l.octree->leaf_count && s.lit == s.sets - dark);
        if (kind == 0) assert_true(dark == l.octree->leaf_count);
        if (kind == 1) assert_true(dark > 0 && s.lit >= 4);
        if (kind == 3) {
            double sum = 0.0;
            for (size_t i = 0; i < s.sets; i++) sum += irradiance_on(l.lights, i, sl_v3(0, 1, 0));
            assert_true(fabs(sum / (double)s.sets / 2.0 - 1.0) < 0.4);
        }
        end_lit(&l);
    }
    sl_scene_destroy(scene);
}

/* An even sky's spread over the number of lights, voxel by voxel; and energies. */
static void statistics_tell_spread_and_flux(void **state) {
    sl_scene *scene = floor_of_four();
    double before = 180.0;
    for (int n = 1; n <= 8; n *= 2) {
        sl_photon_list *list = even_floor(40000, 1.0f, 3);
        sl_light_octree_settings o = plain_options(n);
        o.neighbours = 300;
        o.unit_weights = true;
        lit l = light_up(scene, 3, list, &o, 1);
        const sl_voxel_statistics s = sl_voxel_lights_statistics(l.lights);
        double degrees = s.rms_angle * 180.0 / SL_PI, wanted = n == 1   ? 47.1
                                                               : n == 2 ? 35.5
                                                               : n == 4 ? 25.1
                                                                        : 18.0;
        assert_true(fabs(degrees - wanted) < 0.05 * wanted && degrees < before);
        double luminance = 0.2126 + 0.5 * 0.7152 + 0.25 * 0.0722; /* strew()'s colours */
        assert_true(fabs(s.flux / (16.0 * luminance) - 1.0) < 0.05);
        assert_true(s.mean_photons == 300.0 && s.lights == s.lit * (uint64_t)n);
        /* R = sqrt(k A / (pi N)), more at the rim */
        assert_true(fabs(s.mean_radius / sqrt(300.0 * 16.0 / (SL_PI * 40000.0)) - 1.0) < 0.15);
        before = degrees;
        end_lit(&l);
    }
    sl_scene_destroy(scene);
}

/* Any lobes, any threads, any batches. */
static void batches_and_threads_give_the_same_bits(void **state) {
    sl_scene *scene = furnished_room(4, 5);
    const sl_voxel_lobes lobes[] = {SL_LOBES_PERPENDICULAR, SL_LOBES_SURFACE, SL_LOBES_NONE};
    for (int k = 0; k < 4; k++) {
        sl_light_octree_settings o = plain_options(4);
        o.lobes = lobes[k % 3];
        o.radius = 0.6;
        o.whole_voxels = k != 3;
        sl_photon_list *list[4];
        for (int c = 0; c < 4; c++) {
            uint64_t key = sl_random_key(2, 2), more = sl_random_key(2, 3);
            list[c] = new_list(30000);
            for (uint64_t i = 0; i < 30000; i++) {
                uint32_t triangle;
                sl_vec3 at = random_on(scene, key, i, &triangle),
                        n = sl_scene_geometric_normal(scene, triangle);
                strew(list[c], at, cosine_about(i % 3 ? n : sl_neg(n), more, i), i % 3 ? n : sl_neg(n),
                      1e-3f * sl_random_unit(more, 7 * i));
            }
        }
        lit first = light_up(scene, 5, list[0], &o, 1);
        for (unsigned threads = 2; threads <= 3; threads++) {
            lit other = light_up(scene, 5, list[threads - 1], &o, threads);
            assert_same_lights(first.lights, other.lights);
            assert_memory_equal(&first.counters, &other.counters, sizeof first.counters);
            end_lit(&other);
        }
        const char *isas[] = {"baseline", "avx2", "avx512"};
        for (int isa = 0; isa < 3; isa++) {
            assert_int_equal(setenv("SOFTLUX_ISA", isas[isa], 1), 0);
            sl_voxel_lights *other = NULL;
            sl_counters counters = {{0}};
            assert_int_equal(
                sl_voxel_lights_create(scene, first.octree, first.tree, &o, 2, &other, NULL),
                SL_OK);
            sl_voxel_lights_compute(other, 0, SIZE_MAX, 2, &counters);
            assert_same_lights(first.lights, other);
            sl_voxel_lights_destroy(other);
        }
        unsetenv("SOFTLUX_ISA");
        sl_voxel_lights *piecewise = NULL;
        assert_int_equal(
            sl_voxel_lights_create(scene, first.octree, first.tree, &o, 2, &piecewise, NULL),
            SL_OK);
        sl_counters counters = {{0}};
        for (size_t at = 0, step; at < first.octree->leaf_count; at += step) {
            step = 1 + at % 777;
            sl_voxel_lights_compute(piecewise, at, step, 2, &counters);
        }
        assert_same_lights(first.lights, piecewise);
        assert_memory_equal(&first.counters, &counters, sizeof counters);
        sl_voxel_lights_destroy(piecewise);
        sl_photon_list_destroy(list[3]);
        end_lit(&first);
    }
    sl_scene_destroy(scene);
}

/* Boards that lie on it hide a floor: it is met by no photon, and must not dilute theirs. */
static void what_lies_under_a_surface_takes_none_of_its_light(void **state) {
    float xyz[36];
    add_quad(xyz, 0, sl_v3(0, 0, 0), sl_v3(0, 0, 4), sl_v3(4, 0, 0));
    add_quad(xyz, 2, sl_v3(0, -0.01f, 0), sl_v3(0, 0, 4), sl_v3(4, 0, 0));
    sl_scene *scene = scene_of_triangles(xyz, 4);
    sl_photon_list *list = even_floor(60000, 3.0f, 7);
    sl_light_octree_settings o = plain_options(4);
    o.neighbours = 300;
    lit l = light_up(scene, 4, list, &o, 1);
    double sum = 0.0, count = 0.0;
    for (size_t i = 0; i < l.octree->leaf_count; i++) {
        sl_vec3 c = l.lights->set[i].centroid;
        if (c.x < 0.5f || c.z < 0.5f || c.x > 3.5f || c.z > 3.5f) continue;
        sum += irradiance_on(l.lights, i, sl_v3(0, 1, 0));
        count += 1.0;
    }
    assert_true(count > 50.0);
    /* the boards are above the centre */
    if (fabs(sum / count / 3.0 - 1.0) > 0.05) fail_msg("%.4f on average, not 3", sum / count);
    end_lit(&l);
    sl_scene_destroy(scene);
}

/* A matt wall has one shading normal: a light along it makes the irradiance that four would. Gloss and bent
 * normals want directions. */
static void flat_matt_surfaces_have_one_light_along_their_normal(void **state) {
    enum { MATT, GLOSSY, BENT, KINDS };
    for (int kind = 0; kind < KINDS; kind++) {
        trace_mesh mesh = trace_mesh_begin();
        uint32_t material = trace_mesh_material(&mesh, 0.5f, kind == GLOSSY ? 0.3f : 0.0f, 20, 0, 0),
                 corner[4];
        for (int k = 0; k < 4; k++)
            corner[k] = trace_mesh_vertex(&mesh, k & 1 ? 4.0f : 0.0f, 0.0f, k & 2 ? 4.0f : 0.0f);
        trace_mesh_triangle(&mesh, corner[0], corner[2], corner[1], material);
        trace_mesh_triangle(&mesh, corner[1], corner[2], corner[3], material);
        sl_scene *scene = trace_mesh_build(&mesh);
        for (int k = 0; k < 4 && kind == BENT; k++) {
            scene->normal_x[k] = k & 1 ? 0.6f : -0.6f;
            scene->normal_y[k] = 0.8f;
        }
        sl_octree *octree = octree_of(scene, 4, 1);
        sl_photon_list *list = even_floor(20000, 1.0f, 3);
        sl_photon_tree *tree = NULL;
        assert_int_equal(sl_photon_tree_create(list, 1, &tree, NULL), SL_OK);
        double irradiance[2][4096];
        for (int split = 0; split < 2; split++) {
            sl_light_octree_settings o = plain_options(4);
            o.whole_voxels = !split;
            sl_voxel_lights *lights = NULL;
            sl_counters counters = {{0}};
            assert_int_equal(sl_voxel_lights_create(scene, octree, tree, &o, 1, &lights, NULL),
                             SL_OK);
            sl_voxel_lights_compute(lights, 0, SIZE_MAX, 1, &counters);
            assert_true(lights->set_count == octree->leaf_count && lights->set_count < 4096);
            for (size_t s = 0; s < lights->set_count; s++) {
                irradiance[split][s] = irradiance_on(lights, s, sl_v3(0, 1, 0));
                assert_int_equal(lights->set[s].lights, split && kind == MATT ? 1 : 4);
                if (split && kind == MATT)
                    assert_true(sl_direction_unpack(lights->light[s * 4].packed).y == 1.0f);
            }
            double sum[2] = {0.0};
            /* of four lights grazing photons lose some */
            for (size_t s = 0; split && s < lights->set_count; s++) {
                assert_true(irradiance[0][s] > 0.5 && fabs(irradiance[1][s] / irradiance[0][s] - 1.0) < 0.1);
                sum[0] += irradiance[0][s];
                sum[1] += irradiance[1][s];
            }
            assert_true(!split || fabs(sum[1] / sum[0] - 1.0) < 0.005);
            sl_voxel_lights_destroy(lights);
        }
        sl_photon_tree_destroy(tree);
        sl_octree_destroy(octree);
        sl_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tilted_surfaces_get_what_the_table_says),
        cmocka_unit_test(on_the_flat_nothing_is_lost),
        cmocka_unit_test(a_bent_surface_makes_the_light_that_its_photons_brought),
        cmocka_unit_test(photons_that_carry_nothing_are_left_out),
        cmocka_unit_test(an_even_floor_has_its_irradiance_in_every_voxel),
        cmocka_unit_test(the_mean_over_many_voxels_has_no_bias),
        cmocka_unit_test(corners_are_neither_dark_nor_bleed_where_voxels_are_split),
        cmocka_unit_test(both_sides_of_thin_things_have_their_own_light),
        cmocka_unit_test(a_floor_above_dark_ground_keeps_its_light),
        cmocka_unit_test(the_dark_face_of_a_wall_does_not_stand_for_the_lit_one),
        cmocka_unit_test(the_brighter_side_of_a_sheet_has_more_of_the_lights),
        cmocka_unit_test(the_winding_does_not_matter),
        cmocka_unit_test(next_to_nothing_gives_finite_lights_or_none),
        cmocka_unit_test(statistics_tell_spread_and_flux),
        cmocka_unit_test(batches_and_threads_give_the_same_bits),
        cmocka_unit_test(what_lies_under_a_surface_takes_none_of_its_light),
        cmocka_unit_test(flat_matt_surfaces_have_one_light_along_their_normal),
    };
    return cmocka_run_group_tests_name("light octree: lights of voxels", tests, NULL, NULL);
}
