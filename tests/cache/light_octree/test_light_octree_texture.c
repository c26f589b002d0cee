/* The octree and its lights in textures: descent, addresses, bytes. */
#include "light_octree_support.h"

#include "base/memory.h"

static void the_descent_ends_where_the_sorted_leaves_say(void **state) {
    sl_scene *scene = furnished_room(10, 6);
    for (int depth = 1; depth <= 6; depth++) {
        sl_octree *octree = octree_of(scene, depth, 2);
        sl_voxel_lights *lights = whole_voxels(scene, octree, 3);
        for (size_t i = 0; i < octree->leaf_count; i++) {
            if (i % 4) set_light(lights, i, 0, sl_v3d(0, 0, 1), (float)i, 1, 2); /* every fourth is dark */
        }
        sl_voxel_texture *texture = texture_of(octree, lights);
        uint64_t key = sl_random_key(1, (uint64_t)depth), fetches = 0, leaves = 0;
        for (uint64_t i = 0; i < 100000; i++) {
            int32_t cell[3];
            for (uint64_t d = 0; d < 3; d++)
                cell[d] = (int32_t)(sl_random_unit(key, 3 * i + d) * (float)(1 << depth));
            uint32_t leaf = leaf_of(
                octree, sl_morton_code((uint32_t)cell[0], (uint32_t)cell[1], (uint32_t)cell[2]));
            uint64_t before = fetches;
            size_t place = sl_voxel_texture_find(texture, cell, &fetches);
            assert_true(fetches - before >= 1 && fetches - before <= (uint64_t)depth);
            assert_true((place == SIZE_MAX) == (leaf == SL_NO_INDEX));
            if (leaf == SL_NO_INDEX) continue;
            leaves++;
            assert_true(fetches - before == (uint64_t)depth);
            assert_int_equal(sl_voxel_texture_set(texture, place).lights, leaf % 4 != 0);
            if (leaf % 4) assert_true(texture->light[place + 1].color[0] == (float)leaf);
        }
        assert_true(leaves > 100);
        const int32_t outside[3][3] = {{-1, 0, 0}, {0, 1 << depth, 0}, {INT32_MIN, 0, INT32_MAX}};
        fetches = 0;
        for (int k = 0; k < 3; k++)
            assert_true(sl_voxel_texture_find(texture, outside[k], &fetches) == SIZE_MAX && fetches == 0);
        sl_voxel_texture_destroy(texture);
        sl_voxel_lights_destroy(lights);
        sl_octree_destroy(octree);
    }
    sl_scene_destroy(scene);
}

/* A flat sheet of 2^d x 2^d cells and more, each with its own number. */
static sl_octree *made_octree(int depth, size_t leaves) {
    sl_octree *octree = sl_allocate(1, sizeof *octree);
    assert_non_null(octree);
    *octree = (sl_octree){.depth = depth, .edge = 1.0, .leaf_count = leaves};
    octree->leaf = sl_allocate(leaves, sizeof *octree->leaf);
    octree->triangle = sl_allocate(0, 1);
    assert_true(octree->leaf && octree->triangle);
    for (size_t i = 0; i < leaves; i++)
        octree->leaf[i] = (sl_octree_leaf){.morton = i};
    return octree;
}

/* 5,705 bricks for the sphere of 17,072 leaves; two outliers in the corners of the root add six bricks each
 * at most. */
static void bricks_and_bytes_are_those_that_were_counted(void **state) {
    sl_scene *scene = sphere_in_a_root(150, 0.94f * 1.0001f);
    sl_octree *octree = octree_of(scene, 6, 2);
    sl_voxel_lights *lights = whole_voxels(scene, octree, 4);
    for (size_t i = 0; i < octree->leaf_count; i++) set_light(lights, i, 0, sl_v3d(0, 0, 1), 1, 1, 1);
    sl_voxel_texture *texture = texture_of(octree, lights);
    assert_int_equal(octree->leaf_count, 17074);
    size_t bricks =
        4 * (size_t)texture->bricks->width * (size_t)texture->bricks->height * (size_t)texture->bricks->depth;
    /* 178 KiB */
    assert_true(bricks >= 32 * 5705 && bricks < 32 * (5705 + 12 + 64));
    assert_true(sl_voxel_texture_bytes(texture) - bricks >= 17074 * 32 &&
                sl_voxel_texture_bytes(texture) - bricks < 17074 * 32 + 65536); /* a head and a light */
    destroy_octree(scene, octree, lights, texture);
}

/* As many lights as it has, those of one voxel in one row. */
static void sets_of_every_length_come_back_from_their_address(void **state) {
    sl_scene *scene = furnished_room(10, 6);
    sl_octree *octree = octree_of(scene, 5, 1);
    sl_light_octree_settings options = plain_options(8);
    options.whole_voxels = false;
    sl_voxel_lights *lights = lights_of(scene, octree, &options);
    size_t wanted = 1, several = 0;
    for (size_t s = 0; s < lights->set_count; s++) {
        for (size_t j = 0; j < s * 7 % 9; j++)
            set_light(lights, s, (int)j, sl_v3d(0, 0, 1), (float)(s * 8 + j), 1, 1);
    }
    sl_voxel_texture *texture = texture_of(octree, lights);
    for (size_t i = 0; i < octree->leaf_count; i++) {
        uint32_t cell[3], first = lights->first_set[i], end = lights->first_set[i + 1], used = 0;
        uint64_t fetches = 0;
        sl_morton_decode(octree->leaf[i].morton, cell);
        const int32_t here[3] = {(int32_t)cell[0], (int32_t)cell[1], (int32_t)cell[2]};
        size_t at = sl_voxel_texture_find(texture, here, &fetches), begin = at;
        for (uint32_t s = first; s < end; s++) used += lights->set[s].lights;
        if (used == 0) {
            assert_int_equal(sl_voxel_texture_set(texture, at).lights, 0);
            continue;
        }
        for (uint32_t s = first; s < end; s++) {
            sl_shade_set head = sl_voxel_texture_set(texture, at);
            sl_vec3 n = lights->set[s].normal;
            assert_int_equal(head.lights, lights->set[s].lights);
            assert_true(head.more == (s + 1 < end) && sl_dot(head.normal, n) >= 0.9999f * sl_dot(n, n));
            at++;
            for (int j = 0; j < head.lights; j++, at++) {
                assert_true(texture->light[at].color[0] == (float)(s * 8 + (size_t)j));
                assert_true(texture->light[at].direction[2] == 1.0f);
            }
        }
        several += end > first + 1;
        wanted += at - begin;
        assert_true(begin / SL_LIGHT_TEXTURE_SIZE == (at - 1) / SL_LIGHT_TEXTURE_SIZE);
    }
    assert_true(several > 20 && texture->texel_count > SL_LIGHT_TEXTURE_SIZE);
    assert_true(texture->texel_count >= wanted && texture->texel_count < wanted + wanted / 50);
    destroy_octree(scene, octree, lights, texture);
}

/* A sheet's normal stands for both of its sides; where a voxel holds both faces of a wall, each for its own
 * alone. */
static void the_normal_of_a_sheet_turns_and_that_of_a_walls_face_does_not(void **state) {
    /* far above: so that one voxel holds both */
    const float xyz[9 * 5] = {0, 1.5f, 0, 0.01f, 1.5f, 0, 0, 1.5f, 0.01f,
                              /* up */
                              0, 0, 0, 0, 0, 4, 4, 0, 4, 0, 0, 0, 4, 0, 4, 4, 0, 0,
                              /* down */
                              0, 0.1f, 0, 4, 0.1f, 0, 4, 0.1f, 4, 0, 0.1f, 0, 4, 0.1f, 4, 0, 0.1f, 4};
    for (int faces = 1; faces <= 2; faces++) {
        sl_scene *scene = scene_of_triangles(xyz, 1 + 2 * (size_t)faces);
        sl_octree *octree = octree_of(scene, 3, 1);
        sl_light_octree_settings options = plain_options(1);
        options.whole_voxels = false;
        sl_voxel_lights *lights = lights_of(scene, octree, &options);
        for (size_t i = 0; i < lights->set_count; i++)
            set_light(lights, i, 0, sl_to_double(lights->set[i].normal), 1, 1, 1);
        sl_voxel_texture *texture = texture_of(octree, lights);
        uint64_t fetches = 0;
        size_t place = find_at(texture, sl_v3d(1.3, 0.05, 1.2), &fetches);
        assert_true(place != SIZE_MAX);
        sl_shade_set head = sl_voxel_texture_set(texture, place);
        assert_true(head.turn == (faces == 1) && head.more == (faces == 2) && head.lights == 1);
        destroy_octree(scene, octree, lights, texture);
    }
}

static void dark_leaves_share_one_texel(void **state) {
    sl_scene *scene = furnished_room(1, 1);
    sl_octree *octree = made_octree(5, 5000);
    sl_voxel_lights *lights = whole_voxels(scene, octree, 4);
    for (size_t i = 0; i < 5000; i += 50) set_light(lights, i, 0, sl_v3d(1, 0, 0), 1, 1, 1);
    sl_voxel_texture *texture = texture_of(octree, lights);
    assert_true(texture->set_count == 101);
    destroy_octree(scene, octree, lights, texture);
}

static void more_sets_than_addresses_are_refused_with_their_number(void **state) {
    sl_scene *scene = furnished_room(1, 1);
    size_t most = 512 * 4096; /* sets of 8 lights */
    sl_octree *octree = made_octree(7, most + 1);
    sl_voxel_lights *lights = whole_voxels(scene, octree, 8);
    for (size_t i = 0; i <= most; i++) lights->set[i].lights = 8;
    sl_voxel_texture *texture = NULL;
    sl_error error;
    assert_int_equal(sl_voxel_texture_create(octree, lights, &texture, &error), SL_ERROR_RESOURCES);
    assert_null(texture);
    assert_non_null(strstr(error.message, "2097153 sets"));
    destroy_octree(scene, octree, lights, NULL);
}

static void an_octree_without_leaves_is_void(void **state) {
    sl_scene *scene = furnished_room(1, 1);
    sl_octree *octree = made_octree(4, 0);
    sl_voxel_lights *lights = whole_voxels(scene, octree, 4);
    sl_voxel_texture *texture = texture_of(octree, lights);
    const int32_t cell[3] = {1, 2, 3};
    uint64_t fetches = 0;
    assert_true(sl_voxel_texture_find(texture, cell, &fetches) == SIZE_MAX && fetches == 1);
    destroy_octree(scene, octree, lights, texture);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_descent_ends_where_the_sorted_leaves_say),
        cmocka_unit_test(bricks_and_bytes_are_those_that_were_counted),
        cmocka_unit_test(sets_of_every_length_come_back_from_their_address),
        cmocka_unit_test(dark_leaves_share_one_texel),
        cmocka_unit_test(the_normal_of_a_sheet_turns_and_that_of_a_walls_face_does_not),
        cmocka_unit_test(more_sets_than_addresses_are_refused_with_their_number),
        cmocka_unit_test(an_octree_without_leaves_is_void),
    };
    return cmocka_run_group_tests_name("light octree: textures", tests, NULL, NULL);
}
