/* OBJ and MTL text: that every spelling gives the scene of the plain one, or an error with its line. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "scene/scene.h"
#include "rendering.h"
#include "scene_files.h"

static uint64_t hash_of(const char *obj) {
    sl_scene *scene = load_scene(scene_file_text("a.obj", obj));
    uint64_t hash = sl_scene_hash(scene);
    sl_scene_destroy(scene);
    return hash;
}

static void expect_same(const char *obj, const char *plain) {
    if (hash_of(obj) != hash_of(plain)) fail_msg("other than its plain spelling:\n%s", obj);
}

static void refuse(const char *obj, const char *rest) {
    const char *path = scene_file_text("bad.obj", obj), *message = load_refused(path);
    assert_int_equal(strncmp(message, path, strlen(path)), 0);
    assert_string_equal(message + strlen(path), rest);
}

/* The first material of a library of one, which a triangle uses. */
static sl_material material_of(const char *mtl) {
    scene_file_text("m.mtl", mtl);
    sl_scene *scene = load_scene(scene_file_text(
        "m.obj",
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n"));
    for (size_t i = 0; i < scene->material_count; i++) {
        sl_material found = scene->materials[i];
        if (strcmp(found.name, "m") != 0) continue;
        found.name = NULL;
        sl_scene_destroy(scene);
        return found;
    }
    fail_msg("no material 'm'");
    return (sl_material){0};
}

/* ---- geometry -------------------------------------------------------------------------------- */

static const char plain_quad[] = "v -0.5 0 0\nv 0.5 0 0\nv 0.5 1 0.25\nv 0 1 0\nv 9 9 9\n"
                                 "vt 0 0\nvt 0.5 0\nvt 0.5 0.75\nvt 0.25 0\nvn 0 0.6 0.8\n"
                                 "o quad\nf 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1\n";

static void every_spelling_gives_the_scene_of_the_plain_one(void **state) {
    expect_same(
        "\xef\xbb\xbf  v -.5 0 0 # 1 2\n\tv .5 0 0#x\nv +.5 1 \\\n .25 1\nv 0 2 0 2 # w\nv 9 9 9 .1 .2 .3\n"
        " vt 0 0 # 1\nvt .5\nvt .5 .75 0\nvt .25 0\n  vn 0 .6 .8\t# up\n"
        " o quad \n  f 1/1/1 2/2/1\\\n3/3/1 # 4/4/1\n\tf +1/01/1 3/+3/1 4/4/01\n",
        plain_quad);
}

static void odd_triangles_are_those_of_the_plain_spelling(void **state) {
    static const char plain[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    static const char *const same[][2] = {
        {"v\\\n0 0 0\nv 1 0 0\nv 0 1 0\nfo 1 2 3\n", plain},
        {"mtllib empty.mtl\nv 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 .5 .5 .5\nvn 0 0 1\np\nl 1\np 1 2 3\nf 1 2 3\nl "
         "1//1 2\n",
         plain},
        {"v 0 0 0\nv 1. 0 0.# 1\nv 0 1 0.#c\nl 1 2 # 99\nf 1 2 3\n", plain},
        {"v 0 0 0\nv 99999999999999999999 0 0\nv 0 0000000000000000000001e+00000000000000000000000 0\nf 1 2 "
         "3\n",
         "v 0 0 0\nv 1e20 0 0\nv 0 1 0\nf 1 2 3\n"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 1 0 1\nf 1//1 2//1 3//1\nf 1/ 2/ 3/\\\n\nf 2// 3// 1//#c\nf "
         "3/1/ "
         "2/1/ 1/1/\n",
         "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 1 0 1\nf 1//1 2//1 3//1\nf 1 2 3\nf 2 3 1\nf 3/1 2/1 1/1\n"}};
    scene_file_text("empty.mtl", "");
    for (size_t i = 0; i < sizeof same / sizeof same[0]; i++) expect_same(same[i][0], same[i][1]);
}

static double area_of(const char *obj, size_t triangles) {
    sl_scene *scene = load_scene(scene_file_text("polygon.obj", obj));
    double area = 0.0;
    assert_int_equal(sl_scene_triangle_count(scene), triangles);
    for (uint32_t t = 0; t < triangles; t++) {
        const sl_vec3 a = sl_scene_position(scene, scene->vertex[0][t]),
                      normal = sl_cross(sl_sub(sl_scene_position(scene, scene->vertex[1][t]), a),
                                        sl_sub(sl_scene_position(scene, scene->vertex[2][t]), a));
        area += 0.5 * (double)normal.z;
    }
    sl_scene_destroy(scene);
    return area;
}

static void polygons_are_cut_within_their_outlines(void **state) {
    assert_true(area_of("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", 2) == 1.0);
    /* an arrow head, beginning at each of its corners; an L; a comb that no corner sees the whole of, three
     * of whose corners lie in a line */
    assert_true(area_of("v 0 0 0\nv 4 4 0\nv 0 2 0\nv -4 4 0\nf 1 2 3 4\n", 2) == 8.0);
    assert_true(area_of("v 0 0 0\nv 4 4 0\nv 0 2 0\nv -4 4 0\nf 2 3 4 1\n", 2) == 8.0);
    assert_true(area_of("v 0 0 0\nv 4 4 0\nv 0 2 0\nv -4 4 0\nf 4 1 2 3\n", 2) == 8.0);
    assert_true(area_of("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n", 4) == 3.0);
    assert_true(
        area_of("v 0 0 0\nv 5 0 0\nv 5 2 0\nv 4 2 0\nv 4 1 0\nv 3 1 0\nv 3 2 0\nv 2 2 0\nv 2 1 0\nv 1 1 "
                "0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6 7 8 9 10 11 12\n",
                9) == 8.0);
}

static void a_polygon_that_crosses_itself_and_one_of_many_corners_are_cut_somehow(void **state) {
    enum { CORNERS = 1000 };
    char text[64 * CORNERS];
    size_t size = 0;
    area_of("v 0 0 0\nv 3 2 0\nv 3 0 0\nv 0 1 0\nf 1 2 3 4\n", 2);
    for (int i = 0; i < CORNERS; i++)
        size += (size_t)snprintf(text + size, sizeof text - size, "v %d %d 0\n", i, i * (CORNERS - i));
    size += (size_t)snprintf(text + size, sizeof text - size, "f");
    for (int i = CORNERS; i > 0; i--) size += (size_t)snprintf(text + size, sizeof text - size, " %d", i);
    area_of(text, CORNERS - 2);
}

static void names_keep_what_elsewhere_is_a_comment(void **state) {
    scene_file_text("hash #1.mtl", "newmtl Material #25\nKd 0.1 0.2 0.3\n");
    sl_scene *scene = load_scene(scene_file_text(
        "named.obj", " mtllib hash #1.mtl \nv 0 0 0\nv 1 0 0\nv 0 1 0\n usemtl Material #25 \nf 1 2 3\n"));
    assert_true(scene->materials[scene->material_index[0]].diffuse.g == 0.2f);
    assert_string_equal(scene->materials[scene->material_index[0]].name, "Material #25");
    sl_scene_destroy(scene);
}

static void what_has_no_meaning_is_told_by_line(void **state) {
    static const char alike[] =
        ":5: expected face corners that all have the same, as in 1/1 2/2 3/3: corner ";
    static const struct {
        /* the lines of two vertices, those behind, and the message */
        const char *second, *third, *rest, *why;
    } cases[] = {
        {"v 1 0 0 0.5 0.5", "v 0 1 0", "", ":2: expected 3, 4 or 6 numbers for a vertex, got 5"},
        {"v 1 0 0 1 1 1 1 # alpha", "v 0 1 0", "", ":2: expected 3, 4 or 6 numbers for a vertex, got 7"},
        {"v 1 0 0 0.0", "v 0 1 0", "",
         ":2: expected the fourth number of a vertex to be other than 0: it divides"},
        {"v 1 0 0 b", "v 0 1 0", "", ":2: expected 3, 4 or 6 numbers for a vertex, got 'b'"},
        {"v none 0 0", "v 0 1 0", "", ":2: expected 3, 4 or 6 numbers for a vertex, got 'none'"},
        {"v 1 0", "v 0 1 0", "", ":2: expected 3, 4 or 6 numbers for a vertex, got 2"},
        {"v 1 0 0", "v 0 1 0", "vt 0 0 0 0\n",
         ":4: expected 1, 2 or 3 numbers for a texture coordinate, got 4"},
        {"v 1 0 0", "v 0 1 0", "vn 0 1\n", ":4: expected 3 numbers for a normal, got 2"},
        {"v 1 0 0", "v 0 1 0", "f 1 2 4\n", ":4: vertex index 4 is out of range: the file has 3 before it"},
        {"v 1 0 0", "v 0 1 0", "\nf 1 2 0\n",
         ":5: vertex index 0 is out of range: expected 1 or more, or -1 to -3"},
        {"v 1 0 0", "v 0 1 0", "f -1 -2 -4\n",
         ":4: vertex index -4 is out of range: expected 1 or more, or -1 to -3"},
        {"v 1 0 0\r", "v 0 1 0\r", "f 1//1 2//1 3//1\r\n",
         ":4: normal index 1 is out of range: the file has 0 before it"},
        {"v 1 0 0", "v 0 1 0", "f 1 2 x3\n", ":4: expected a vertex index, got 'x3'"},
        {"v 1 0 0", "v 0 1 0", "f 1 2 3;4\n",
         ":4: expected face corners like 1, 1/2, 1//3 or 1/2/3, got ';4'"},
        {"v 1 0 0", "v 0 1 0", "f 1 2 99999999999999999999\n",
         ":4: vertex index 9999999999999 is out of range: the file has 3 before it"},
        {"v 1 0 0", "v 0 1 0", "vt 0 0\nf 1/1 2/1 3\n", "3 has other indices than the first"},
        {"v 1 0 0", "v 0 1 0", "vn 0 0 1\nf 1 2//1 3//1\n", "2 has other indices than the first"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char obj[256], why[256];
        snprintf(obj, sizeof obj, "v 0 0 0\n%s\n%s\n%sf 1 2 3\n", cases[i].second, cases[i].third,
                 cases[i].rest);
        snprintf(why, sizeof why, "%s%s", cases[i].why[0] == ':' ? "" : alike, cases[i].why);
        refuse(obj, why);
    }
}

/* ---- materials ------------------------------------------------------------------------------- */

static void expect_grey(sl_rgb colour, float value) {
    assert_true(colour.r == value && colour.g == value && colour.b == value);
}

/* The diffuse red of the three triangles of a file, in the order of their least corners. */
static void expect_reds(const char *obj, float first, float second, float third) {
    scene_file_text("one.mtl", "newmtl one\nKd 0.25\n");
    scene_file_text("two.mtl", "newmtl two\nKd 0.5\n");
    sl_scene *scene = load_scene(scene_file_text("m.obj", obj));
    assert_int_equal(sl_scene_triangle_count(scene), 3);
    for (uint32_t t = 0; t < 3; t++) {
        int which = (int)scene->position_x[scene->vertex[0][t]];
        float expected = which == 0   ? first
                         : which == 1 ? second
                                      : third,
              found = scene->materials[scene->material_index[t]].diffuse.r;
        if (found != expected)
            fail_msg("face %d: Kd %g instead of %g of\n%s", which, (double)found, (double)expected, obj);
    }
    sl_scene_destroy(scene);
}

static void a_face_has_the_material_that_was_named_last_before_it(void **state) {
    static const char v[] =
        "v 0 0 0\nv 0 1 0\nv 0 0 1\nv 1 0 0\nv 1 1 0\nv 1 0 1\nv 2 0 0\nv 2 1 0\nv 2 0 1\n";
    static const char *const of_files[] = {
        /* how the two libraries, and faces, follow each other */
        "mtllib one.mtl\nmtllib two.mtl\n%sf 1 2 3\nusemtl one\nf 4 5 6\nusemtl two\nf 7 8 9\n",
        "mtllib one.mtl two.mtl # both\n%sf 1 2 3\nusemtl one\nf 4 5 6\nusemtl two\nf 7 8 9\n",
        "mtllib missing.mtl one.mtl \\\n two.mtl\n%sf 1 2 3\nusemtl one\nf 4 5 6\nusemtl two\nf 7 8 9\n",
        "%so all\nf 1 2 3\nmtllib one.mtl\nusemtl one\nmtllib two.mtl\nf 4 5 6\nusemtl two\nf 7 8 9\n",
        "o all\nmtllib one.mtl two.mtl\n%sf 1 2 3\nusemtl one\ng part\nf 4 5 6\no last\nusemtl two\nf 7 8 "
        "9\n"};
    for (size_t i = 0; i < sizeof of_files / sizeof of_files[0]; i++) {
        char obj[1024];
        const char *rest = strstr(of_files[i], "%s");
        snprintf(obj, sizeof obj, "%.*s%s%s", (int)(rest - of_files[i]), of_files[i], v, rest + 2);
        expect_reds(obj, 0.6f, 0.25f, 0.5f);
    }
}

static void write_picture(const char *name) {
    sl_image *image = blank_image(2, 1, 3);
    scene_file_text(name, "");
    assert_int_equal(sl_image_write(image, scene_file_path(name), NULL), SL_OK);
    sl_image_destroy(image);
}

static const char a_triangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";

/* The OBJ file m.obj, which names m.mtl, is refused for what that says. */
static void refuse_library(const char *mtl, const char *rest) {
    const char *library = scene_file_text("m.mtl", mtl);
    scene_file_text("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
    const char *message = load_refused(scene_file_path("m.obj"));
    assert_int_equal(strncmp(message, library, strlen(library)), 0);
    assert_string_equal(message + strlen(library), rest);
}

/* Counts a file's warnings that end like that. */
static size_t warnings(const char *obj, const char *end) {
    size_t found = 0;
    sl_scene *scene = load_scene(scene_file_text("m.obj", obj));
    for (size_t i = 0; i < sl_scene_warning_count(scene); i++) {
        const char *warning = sl_scene_warning(scene, i);
        found += strlen(warning) >= strlen(end) && strcmp(warning + strlen(warning) - strlen(end), end) == 0;
    }
    sl_scene_destroy(scene);
    return found;
}

static size_t library_warnings(const char *mtl, const char *end) {
    char obj[512];
    scene_file_text("m.mtl", mtl);
    snprintf(obj, sizeof obj, "mtllib m.mtl\n%susemtl m\nf 1/1 2/2 3/3\n", a_triangle);
    return warnings(obj, end);
}

static void values_of_materials_that_are_none_are_told_by_line(void **state) {
    static const char colour[] = "expected a colour: 1 or 3 numbers of at least 0, got ";
    static const struct {
        const char *library, *where, *what, *got;
    } cases[] = {
        {"Kd xyz\n", ":2: ", colour, "'xyz'"},
        {"\nKd .5 .5\n", ":3: ", colour, "2"},
        {"Ks # none\n", ":2: ", colour, "0"},
        {"Ke 1 1 -1\n", ":2: ", colour, "'-1'"},
        {"Ke 1 1 nan\n", ":2: ", colour, "'nan'"},
        {"Ke 1e39\n", ":2: ", colour, "'1e39'"},
        {"Kd 1 \\\r\n1 1\r\nKe 1e-\r\n", ":4: ", colour, "'1e-'"},
        {"Ns abc\n", ":2: ", "expected an exponent Ns: a number from 0 to 1000000, got ", "'abc'"},
        {"d 2\n", ":2: ", "expected an opacity d: a number from 0 to 1, got ", "'2'"},
        {"illum\n", ":2: ", "expected an illumination model illum: a number from 0 to 10, got ", "''"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char mtl[128], rest[256];
        snprintf(mtl, sizeof mtl, "newmtl m\n%s", cases[i].library);
        snprintf(rest, sizeof rest, "%s%s%s", cases[i].where, cases[i].what, cases[i].got);
        refuse_library(mtl, rest);
    }
}

static void a_material_is_what_its_statements_say_however_they_are_spelled(void **state) {
    sl_material m = material_of("\xef\xbb\xbf# C:\\models\\\nKd 1 0 0\nnewmtl m\nKd 0.5 \\\n 0.25 "
                                "\\\r\n0.125\nNs 0000000000000000000000020 # wide\\\nKa what\n"
                                "Ks 0.25 0.25 0.25 1\nd -halo 1\nKe 000 .5 1.e0");
    assert_true(m.diffuse.r == 0.5f && m.diffuse.g == 0.25f && m.diffuse.b == 0.125f);
    assert_true(m.emission.r == 0.0f && m.emission.g == 0.5f && m.emission.b == 1.0f);
    assert_true(m.exponent == 20.0f);
    expect_grey(m.specular, 0.25f);
}

static void a_texture_is_found_behind_its_options(void **state) {
    write_picture("t 1.png");
    scene_file_copy("scenes/bricks.png", "7");
    write_picture("t # 2.png");
    static const char *const names[] = {"t 1.png",
                                        "-s 2 t 1.png",
                                        "-s 2 2 t 1.png",
                                        "-o 1 2 3 t 1.png",
                                        "-blendu off -mm 0 1 -clamp on -t .5\tt 1.png",
                                        "7",
                                        "-s 2 7",
                                        "-s 1 2 3 7",
                                        "t 1.png # red",
                                        "t # 2.png",
                                        "-bm 2 \\\n t 1.png",
                                        "-imfchan r -texres 512 -type cube_top t 1.png"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char mtl[256];
        snprintf(mtl, sizeof mtl, "newmtl m\nKd 1 1 1\nmap_Kd %s\n", names[i]);
        if (material_of(mtl).texture == SL_NO_INDEX) fail_msg("no texture: map_Kd %s", names[i]);
    }
}

static void options_of_a_texture_that_change_it_are_told(void **state) {
    write_picture("t.png");
    assert_int_equal(library_warnings("newmtl m\nmap_Kd -s 2 2 2 -o 0 t.png\n",
                                      "m.mtl:2: the texture's option -s is not applied"),
                     1);
    assert_int_equal(library_warnings("newmtl m\nmap_Kd -s 2 2 2 -o 0 t.png\n", " is not applied"), 2);
    assert_int_equal(library_warnings("newmtl m\nmap_bump -bm 3 t.png\n\nmap_Kd -o 0 .5 -clamp on t.png\n",
                                      " is not applied"),
                     3);
}

static void a_material_that_no_library_has_is_told_once(void **state) {
    char obj[512];
    scene_file_text("m.mtl", "newmtl m\nKd 0.5\nnewmtl a b\nKd 0.25\n");
    snprintf(obj, sizeof obj,
             "%susemtl n\nf 1 2 3\nusemtl m\nf 1 2 3\nusemtl a b \nf 1 2 3\nusemtl n\nf 1 2 3\nusemtl a\nf 1 "
             "2 3\nmtllib m.mtl\n",
             a_triangle);
    assert_int_equal(warnings(obj, "m.obj:7: no material library has 'n'; it is grey"), 1);
    assert_int_equal(warnings(obj, "m.obj:15: no material library has 'a'; it is grey"), 1);
    assert_int_equal(warnings(obj, "it is grey"), 2);
}

static void of_very_many_warnings_the_first_hundred_are_told_and_the_others_counted(void **state) {
    enum { MANY = 150 };
    char obj[sizeof a_triangle + 64 + 32 * MANY];
    scene_file_text("m.mtl", "newmtl m\nKd 0.5\n");
    int at = snprintf(obj, sizeof obj, "mtllib m.mtl\n%s", a_triangle);
    const int first = 8; /* line */
    for (int i = 0; i < MANY; i++)
        at += snprintf(obj + at, sizeof obj - (size_t)at, "usemtl %c%d\nf 1 2 3\n", 'z' - i % 26, i);
    sl_scene *scene = load_scene(scene_file_text("m.obj", obj));
    size_t count = sl_scene_warning_count(scene);
    for (int i = 0; i < 100; i++) {
        char wanted[80];
        snprintf(wanted, sizeof wanted, "m.obj:%d: no material library has '%c%d'; it is grey", first + 2 * i,
                 'z' - i % 26, i);
        assert_non_null(strstr(sl_scene_warning(scene, (size_t)i), wanted));
    }
    assert_string_equal(sl_scene_warning(scene, count - 1), "and 50 more of such lines");
    assert_null(sl_scene_warning(scene, count));
    sl_scene_destroy(scene);
}

static void a_material_without_a_name_is_that_of_faces_that_name_none(void **state) {
    scene_file_text("m.mtl", "newmtl \nKd 0.25\nnewmtl m\nKd 0.5\n");
    sl_scene *scene = load_scene(scene_file_text(
        "m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\nusemtl \nf 1 2 3\n"));
    expect_grey(scene->materials[scene->material_index[1]].diffuse, 0.25f);
    sl_scene_destroy(scene);
}

static void bytes_of_zero_are_no_text(void **state) {
    static const char obj[] = "v 0 0 0\nv 1 0 0\n\0v 0 1 0\nf 1 2 3\n";
    const char *path = scene_file_write("zero.obj", obj, sizeof obj - 1);
    assert_string_equal(load_refused(path) + strlen(path), ":3: expected text, got a byte that is zero");
    static const char mtl[] = "newmtl m\r\nKd 0.5\0\r\n";
    path = scene_file_write("zero.mtl", mtl, sizeof mtl - 1);
    assert_string_equal(load_refused(scene_file_text("m.obj", "mtllib zero.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 "
                                                              "0\nf 1 2 3\n")) +
                            strlen(path),
                        ":2: expected text, got a byte that is zero");
}

static void faces_that_are_none_are_counted(void **state) {
    assert_int_equal(warnings("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 \\\n2\n",
                              "m.obj:5: a face of fewer than three corners is not drawn"),
                     1);
    assert_int_equal(warnings("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1\nf 1 2 3\nf 1 2\nf \n",
                              "m.obj:4: this face and 2 more of fewer than three corners are not drawn"),
                     1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_spelling_gives_the_scene_of_the_plain_one),
        cmocka_unit_test(odd_triangles_are_those_of_the_plain_spelling),
        cmocka_unit_test(polygons_are_cut_within_their_outlines),
        cmocka_unit_test(a_polygon_that_crosses_itself_and_one_of_many_corners_are_cut_somehow),
        cmocka_unit_test(names_keep_what_elsewhere_is_a_comment),
        cmocka_unit_test(what_has_no_meaning_is_told_by_line),
        cmocka_unit_test(a_face_has_the_material_that_was_named_last_before_it),
        cmocka_unit_test(values_of_materials_that_are_none_are_told_by_line),
        cmocka_unit_test(a_material_is_what_its_statements_say_however_they_are_spelled),
        cmocka_unit_test(a_texture_is_found_behind_its_options),
        cmocka_unit_test(options_of_a_texture_that_change_it_are_told),
        cmocka_unit_test(a_material_that_no_library_has_is_told_once),
        cmocka_unit_test(of_very_many_warnings_the_first_hundred_are_told_and_the_others_counted),
        cmocka_unit_test(a_material_without_a_name_is_that_of_faces_that_name_none),
        cmocka_unit_test(bytes_of_zero_are_no_text),
        cmocka_unit_test(faces_that_are_none_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
