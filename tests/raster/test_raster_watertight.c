/* No hole and no double hit, in any layer, without another rasterizer to compare with. Along the line of
 * sight through a pixel a closed surface is entered as often as it is left: so the triangles that cover the
 * pixel, visible or hidden, are even in number seen from outside and odd from inside, where a sphere has
 * one. */
#include "tests/raster/plain.h"
#include "raster_support.h"

#include <math.h>
#include <stdio.h>

#include "raster_soup.h"

/* ---- meshes ---------------------------------------------------------------------------------- */

typedef struct mesh {
    size_t vertices, triangles;
    float *position[3];
    uint32_t *corner[3];
} mesh;

static mesh mesh_create(size_t vertices, size_t triangles) {
    mesh m = {.vertices = 0, .triangles = 0};
    for (int k = 0; k < 3; k++) {
        m.position[k] = calloc(vertices, sizeof *m.position[k]);
        m.corner[k] = calloc(triangles, sizeof *m.corner[k]);
        assert_true(m.position[k] != NULL && m.corner[k] != NULL);
    }
    return m;
}

static void mesh_destroy(mesh *m) {
    for (int k = 0; k < 3; k++) {
        free(m->position[k]);
        free(m->corner[k]);
    }
}

static uint32_t add_vertex(mesh *m, sl_vec3 p) {
    const float xyz[3] = {p.x, p.y, p.z};
    for (int k = 0; k < 3; k++) m->position[k][m->vertices] = xyz[k];
    return (uint32_t)m->vertices++;
}

static void add_triangle(mesh *m, uint32_t a, uint32_t b, uint32_t c) {
    const uint32_t corner[3] = {a, b, c};
    for (int k = 0; k < 3; k++) m->corner[k][m->triangles] = corner[k];
    m->triangles++;
}

static sl_vec3 vertex_of(const mesh *m, size_t v) {
    return sl_v3(m->position[0][v], m->position[1][v], m->position[2][v]);
}

/* An icosahedron whose faces are cut into n^2, pushed onto the unit sphere; shared corners are welded by
 * their edge's ends. */
static mesh icosphere(int n, float rough, uint64_t key) {
    static const double g = 1.618033988749895;
    const double corner[12][3] = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                  {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    static const int face[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                    {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                    {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                    {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    enum { MOST = 64 };
    assert_true(n <= MOST);
    mesh m = mesh_create((size_t)(12 + 30 * n + 20 * n * n), (size_t)(20 * n * n));
    uint32_t ends[12], inner[12][12][MOST + 1];
    memset(inner, 0xff, sizeof inner);
    for (int c = 0; c < 12; c++)
        ends[c] = add_vertex(&m, sl_v3((float)corner[c][0], (float)corner[c][1], (float)corner[c][2]));
    for (int f = 0; f < 20; f++) {
        uint32_t grid[MOST + 1][MOST + 1]; /* [i][j]: i steps to corner 1, j to corner 2 */
        for (int i = 0; i <= n; i++) {
            for (int j = 0; i + j <= n; j++) {
                const int step[3] = {n - i - j, i, j};
                double p[3] = {0};
                for (int k = 0; k < 3; k++)
                    for (int c = 0; c < 3; c++) p[k] += corner[face[f][c]][k] * step[c] / n;
                uint32_t *shared = NULL;
                /* on the edge from corner a to corner b, `step` from the lower of the two */
                for (int c = 0; c < 3; c++) {
                    int a = face[f][c], b = face[f][(c + 1) % 3], from = a < b ? step[(c + 1) % 3] : step[c];
                    if (step[(c + 2) % 3] == 0) shared = &inner[a < b ? a : b][a < b ? b : a][from];
                }
                for (int c = 0; c < 3; c++) if (step[c] == n) shared = &ends[face[f][c]];
                if (shared && *shared != UINT32_MAX) grid[i][j] = *shared;
                else grid[i][j] = add_vertex(&m, sl_v3((float)p[0], (float)p[1], (float)p[2]));
                if (shared) *shared = grid[i][j];
            }
        }
        for (int i = 0; i < n; i++) {
            for (int j = 0; i + j < n; j++) {
                add_triangle(&m, grid[i][j], grid[i + 1][j], grid[i][j + 1]);
                if (i + j + 2 <= n) add_triangle(&m, grid[i + 1][j], grid[i + 1][j + 1], grid[i][j + 1]);
            }
        }
    }
    for (size_t v = 0; v < m.vertices; v++) {
        sl_vec3 p = sl_scale(sl_normalize_or(vertex_of(&m, v), sl_v3(0, 0, 1)),
                             1.0f + rough * (2.0f * sl_random_unit(key, v) - 1.0f));
        m.position[0][v] = p.x, m.position[1][v] = p.y, m.position[2][v] = p.z;
    }
    return m;
}

/* ---- counting -------------------------------------------------------------------------------- */

/* Checks that every pixel is covered by 0 to `most` triangles, by an odd number or (parity 0) an even one.
 * Returns the layers seen. */
static double check_layers(const mesh *m, const sl_view *view, float most, int parity) {
    const size_t pixels = (size_t)view->width * (size_t)view->height;
    float *sums = calloc(2 * pixels, sizeof *sums), *unused = calloc(m->triangles, sizeof *unused);
    assert_true(sums != NULL && unused != NULL);
    const sl_raster_mesh drawn = {.vertex_count = m->vertices,
                                  .triangle_count = m->triangles,
                                  .x = m->position[0],
                                  .y = m->position[1],
                                  .z = m->position[2],
                                  .vertex = {m->corner[0], m->corner[1], m->corner[2]}};
    sl_plain_layers(&drawn, view, view->width, view->height, unused, sums);
    double seen = 0;
    for (size_t i = 0; i < pixels; i++) {
        float n = sums[pixels + i];
        if (!(n >= 0.0f && n <= most && n == floorf(n)) || (int)n % 2 != parity)
            fail_msg("%g layers at pixel %zu of %dx%d", (double)n, i, view->width, view->height);
        seen += (double)n;
    }
    free(sums), free(unused);
    return seen;
}

/* ---- views ----------------------------------------------------------------------------------- */

static const int sizes[][2] = {{257, 193}, {64, 64}, {640, 31}, {400, 400}};

static sl_view view_from(sl_vec3 eye, sl_vec3 target, float fov, uint64_t which, float near) {
    sl_camera camera;
    assert_true(sl_camera_look_at(&camera, eye, target, sl_v3(0.1f, 1, 0.2f), fov));
    return camera_view(&camera, sizes[which % 4][0], sizes[which % 4][1], near, 100.0f);
}

/* Far enough away that the whole mesh (within radius 2) is in view, whatever the picture's shape. */
static sl_view view_of_all(uint64_t key, uint64_t n) {
    sl_vec3 away = random_direction(key, n);
    const int *size = sizes[n % 4];
    float aspect = (float)size[0] / (float)size[1], distance = 6.0f + 6.0f * sl_random_unit(key, 9000 + n);
    float tangent = 2.4f / distance / (aspect < 1.0f ? aspect : 1.0f);
    return view_from(sl_scale(away, distance), sl_scale(random_direction(key, n + 50), 0.1f),
                     2.0f * atanf(tangent), n, 0.1f);
}

static void closed_meshes_seen_from_outside_are_entered_as_often_as_left(void **state) {
    double seen = 0;
    for (uint64_t seed = 0; seed < soup_share(60); seed++) {
        uint64_t key = sl_random_key(51, seed);
        mesh m = icosphere((int)(1 + seed % 40), seed % 4 ? 0.2f : 0.9f, key);
        for (uint64_t n = 0; n < 4; n++) {
            sl_view view = view_of_all(key, n);
            seen += check_layers(&m, &view, 1e6f, 0);
        }
        mesh_destroy(&m);
    }
    assert_true(seen > 1e4);
}

/* Vertices behind the eye all around. */
static void meshes_around_the_eye_cover_every_pixel_an_odd_number_of_times(void **state) {
    for (uint64_t seed = 0; seed < soup_share(40); seed++) {
        uint64_t key = sl_random_key(54, seed);
        float rough = seed % 2 ? 0.0f : 0.5f;
        mesh m = icosphere(1 + (int)(seed % 30), rough, key);
        for (uint64_t n = 0; n < 6; n++) {
            /* the coarsest has radius 0.79 */
            sl_vec3 eye = sl_scale(random_direction(key, n),
                                   (rough > 0.0f ? 0.35f : 0.7f) * sl_random_unit(key, 800 + n));
            sl_frame frame = sl_frame_from_normal(random_direction(key, 30 + n));
            float tangent = n % 3 ? 1.0f : 2.7474774f;
            int size = sizes[n % 4][1];
            sl_view pyramid =
                sl_view_pyramid(&frame, eye, -tangent, tangent, -tangent, tangent, size, size, 1e-4f);
            sl_view camera = view_from(eye, sl_add(eye, random_direction(key, 70 + n)),
                                       2.0f * sl_random_unit(key, 700 + n) + 0.1f, n, 1e-3f);
            check_layers(&m, &pyramid, rough > 0.0f ? 1e6f : 1.0f, 1);
            check_layers(&m, &camera, rough > 0.0f ? 1e6f : 1.0f, 1);
        }
        mesh_destroy(&m);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_meshes_seen_from_outside_are_entered_as_often_as_left),
        cmocka_unit_test(meshes_around_the_eye_cover_every_pixel_an_odd_number_of_times),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
