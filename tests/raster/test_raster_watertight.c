/* No hole and no double hit, in any layer, without another rasterizer to compare with. Along the line of
 * sight through a pixel a closed surface is entered as often as it is left: so the triangles that cover the
 * pixel, visible or hidden, are even in number seen from outside and odd from inside; and front faces less
 * back faces are 0 from outside, which also rules out that two faults cancel. A triangulated plane has one
 * layer. */
#include "raster/plain.h"
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

/* A grid of nu x nv cells with random diagonals; columns (and rows) close upon themselves or not. `place`
 * gives the vertices. */
typedef sl_vec3 place_vertex(const void *context, uint64_t key, int i, int j);
static mesh grid_mesh(int nu, int nv, bool closed, uint64_t key, place_vertex *place, const void *context) {
    int columns = closed ? nu : nu + 1, rows = closed ? nv : nv + 1;
    mesh m = mesh_create((size_t)columns * (size_t)rows, 2 * (size_t)nu * (size_t)nv);
    for (int j = 0; j < rows; j++) {
        for (int i = 0; i < columns; i++) add_vertex(&m, place(context, key, i, j));
    }
    for (int j = 0; j < nv; j++) {
        for (int i = 0; i < nu; i++) {
            uint32_t at[2][2];
            for (int y = 0; y < 2; y++)
                for (int x = 0; x < 2; x++)
                    at[y][x] = (uint32_t)((j + y) % rows * columns + (i + x) % columns);
            if (sl_random_bits(key + 2, (uint64_t)(j * nu + i)) & 1) {
                add_triangle(&m, at[0][0], at[0][1], at[1][1]);
                add_triangle(&m, at[0][0], at[1][1], at[1][0]);
            } else {
                add_triangle(&m, at[0][0], at[0][1], at[1][0]);
                add_triangle(&m, at[0][1], at[1][1], at[1][0]);
            }
        }
    }
    return m;
}

static float jitter(uint64_t key, int i, int j, uint64_t which) {
    return sl_random_unit(key, ((uint64_t)(uint32_t)(j * 4096 + i)) * 4 + which) * 2.0f - 1.0f;
}

typedef struct torus {
    int nu, nv;
    float rough;
} torus;
static sl_vec3 on_torus(const void *context, uint64_t key, int i, int j) {
    const torus *t = context;
    double u = 6.283185307179586 * (i + 0.4 * (double)jitter(key, i, j, 0)) / t->nu,
           v = 6.283185307179586 * (j + 0.4 * (double)jitter(key, i, j, 1)) / t->nv;
    double r = 0.4 + (double)t->rough * (double)jitter(key, i, j, 2), d = 1.0 + r * cos(v);
    return sl_v3((float)(d * cos(u)), (float)(r * sin(v)), (float)(d * sin(u)));
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

/* Where the pipeline snaps a vertex to, in 1/256 pixel, of a triangle that is not clipped. */
static void snapped(const sl_view *view, sl_vec3 p, int64_t *u, int64_t *v) {
    float clip[4];
    sl_vec3 q = sl_sub(p, view->origin);
    for (int k = 0; k < 4; k++)
        clip[k] =
            ((view->clip[k][0] * q.x + view->clip[k][1] * q.y) + view->clip[k][2] * q.z) + view->clip[k][3];
    float over = 1.0f / clip[3], half_width = 0.5f * (float)view->width,
          half_height = 0.5f * (float)view->height;
    float x = fmaf(clip[0] * over, half_width, half_width),
          y = fmaf(clip[1] * over, half_height, half_height);
    *u = lrintf((x - 0.5f) * 256.0f);
    *v = lrintf((y - 0.5f) * 256.0f);
}

/* +1 counter-clockwise on the screen, -1 clockwise, by the snapped corners: a triangle seen nearly edge-on
 * may turn over when its corners are snapped, and is then part of the other side. */
static float side_of(const mesh *m, const sl_view *view, size_t t) {
    int64_t u[3], v[3];
    for (int k = 0; k < 3; k++) snapped(view, vertex_of(m, m->corner[k][t]), &u[k], &v[k]);
    int64_t area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]);
    return area > 0 ? 1.0f : area < 0 ? -1.0f : 0.0f;
}

typedef struct layers {
    int width, height;
    float *sides, *count; /* triangles that cover the pixel; front less back */
} layers;

/* Draws every triangle with (1, side); sides only where no triangle is clipped. */
static layers count_layers(const mesh *m, const sl_view *view, bool sides) {
    size_t pixels = (size_t)view->width * (size_t)view->height;
    layers l = {view->width, view->height, calloc(2 * pixels, sizeof(float)), NULL};
    float *side = calloc(m->triangles, sizeof *side);
    uint32_t *index = calloc(3 * m->triangles, sizeof *index);
    assert_true(l.sides != NULL && side != NULL && index != NULL);
    l.count = l.sides + pixels;
    for (size_t t = 0; t < m->triangles; t++) {
        side[t] = sides ? side_of(m, view, t) : 0.0f;
        for (size_t k = 0; k < 3; k++) index[k * m->triangles + t] = m->corner[k][t];
    }
    sl_raster_mesh drawn = {.vertex_count = m->vertices,
                            .triangle_count = m->triangles,
                            .x = m->position[0],
                            .y = m->position[1],
                            .z = m->position[2],
                            .vertex = {index, index + m->triangles, index + 2 * m->triangles}};
    sl_plain_layers(&drawn, view, view->width, view->height, side, l.sides);
    free(side), free(index);
    return l;
}

/* Every pixel: count is low..high and odd or even (parity 1 or 0; 2: either), sides sum up to `sides`.
 * Returns the layers seen. */
static double check_layers(layers l, float low, float high, int parity, float sides) {
    double seen = 0;
    for (int i = 0; i < l.width * l.height; i++) {
        float n = l.count[i];
        if (!(n >= low && n <= high && n == floorf(n) && l.sides[i] == sides) ||
            (parity < 2 && (int)n % 2 != parity)) {
            fail_msg("%g layers, sides %g, at pixel (%d, %d) of %dx%d", (double)n, (double)l.sides[i],
                     i % l.width, i / l.width, l.width, l.height);
        }
        seen += (double)n;
    }
    free(l.sides);
    return seen;
}

/* ---- views ----------------------------------------------------------------------------------- */

static const int sizes[][2] = {{257, 193}, {64, 64}, {640, 31}, {400, 400}};

static sl_view view_from(sl_vec3 eye, sl_vec3 target, float fov, uint64_t which, float near) {
    sl_camera camera;
    assert_true(sl_camera_look_at(&camera, eye, target, sl_v3(0.1f, 1, 0.2f), fov));
    return sl_view_camera(&camera, sizes[which % 4][0], sizes[which % 4][1], near, 100.0f);
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
    (void)state;
    double seen = 0;
    for (uint64_t seed = 0; seed < soup_share(60); seed++) {
        uint64_t key = sl_random_key(51, seed);
        torus shape = {(int)(6 + seed % 50), (int)(5 + seed % 31), seed % 3 ? 0.1f : 0.0f};
        mesh m = seed % 2 ? grid_mesh(shape.nu, shape.nv, true, key, on_torus, &shape)
                          : icosphere((int)(1 + seed % 40), seed % 4 ? 0.2f : 0.9f, key);
        for (uint64_t n = 0; n < 4; n++) {
            sl_view view = view_of_all(key, n);
            seen += check_layers(count_layers(&m, &view, true), 0.0f, 1e6f, 0, 0.0f);
        }
        mesh_destroy(&m);
    }
    assert_true(seen > 1e4);
}

/* Vertices behind the eye all around. */
static void meshes_around_the_eye_cover_every_pixel_an_odd_number_of_times(void **state) {
    (void)state;
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
            check_layers(count_layers(&m, &pyramid, false), 1.0f, rough > 0.0f ? 1e6f : 1.0f, 1, 0.0f);
            check_layers(count_layers(&m, &camera, false), 1.0f, rough > 0.0f ? 1e6f : 1.0f, 1, 0.0f);
        }
        mesh_destroy(&m);
    }
}

/* ---- one layer ------------------------------------------------------------------------------- */

typedef struct field {
    int nu, nv;
    float width, depth, height;
} field;
static sl_vec3 on_field(const void *context, uint64_t key, int i, int j) {
    const field *f = context;
    float u = ((float)i + 0.3f * jitter(key, i, j, 0)) / (float)f->nu - 0.5f,
          v = ((float)j + 0.3f * jitter(key, i, j, 1)) / (float)f->nv - 0.5f;
    return sl_v3(u * f->width, f->height * jitter(key, i, j, 2), v * f->depth);
}

static void planar_triangulations_cover_each_pixel_exactly_once(void **state) {
    (void)state;
    for (uint64_t seed = 0; seed < soup_share(40); seed++) {
        uint64_t key = sl_random_key(55, seed);
        const int *size = sizes[seed % 4];
        /* cells of 2 to 200 pixels; the screen is -1..1 */
        field f = {(int)(2 + seed * seed % 200) * size[0] / 300 + 4,
                   (int)(2 + seed * 7 % 200) * size[1] / 300 + 4, 5.0f, 5.0f, 0.0f};
        mesh m = grid_mesh(f.nu, f.nv, false, key, on_field, &f);
        sl_view view = {
            .width = size[0], .height = size[1], .depth = SL_DEPTH_WINDOW, .skip_triangle = SL_NO_INDEX};
        view.clip[0][0] = view.clip[1][2] = view.clip[2][1] = view.clip[3][3] = 1.0f;
        check_layers(count_layers(&m, &view, false), 1.0f, 1.0f, 1, 0.0f);
        float angle = 6.0f * sl_random_unit(key, 1);
        view.clip[0][0] = view.clip[1][2] = cosf(angle);
        view.clip[0][2] = sinf(angle);
        view.clip[1][0] = -sinf(angle);
        check_layers(count_layers(&m, &view, false), 1.0f, 1.0f, 1, 0.0f);
        mesh_destroy(&m);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_meshes_seen_from_outside_are_entered_as_often_as_left),
        cmocka_unit_test(meshes_around_the_eye_cover_every_pixel_an_odd_number_of_times),
        cmocka_unit_test(planar_triangulations_cover_each_pixel_exactly_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
