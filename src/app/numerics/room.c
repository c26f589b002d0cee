#include "app/numerics/room.h"
#include "base/error.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- vertices and triangles ---- */

static bool make_room(void **array, size_t *room, size_t count, size_t size) {
    if (count < *room) return true;
    size_t more = *room ? 2 * *room : 256;
    void *grown = realloc(*array, more * size);
    if (grown) *array = grown, *room = more;
    return grown != NULL;
}

size_t sl_room_vertex(sl_room *r, double x, double y, double z) {
    if (!make_room((void **)&r->vertex, &r->vertex_room, r->vertex_count, sizeof *r->vertex)) {
        r->failed = true;
        return 0;
    }
    r->vertex[r->vertex_count][0] = x, r->vertex[r->vertex_count][1] = y, r->vertex[r->vertex_count][2] = z;
    return r->vertex_count++;
}

void sl_room_triangle(sl_room *r, size_t a, size_t b, size_t c, int material) {
    if (!make_room((void **)&r->triangle, &r->triangle_room, r->triangle_count, sizeof *r->triangle)) {
        r->failed = true;
        return;
    }
    r->triangle[r->triangle_count].corner[0] = a;
    r->triangle[r->triangle_count].corner[1] = b;
    r->triangle[r->triangle_count].corner[2] = c;
    r->triangle[r->triangle_count++].material = material;
}

static double share(int i, int count, double skew) {
    double even = (double)i / count;
    if (skew <= 0.0 || i == 0 || i == count) return even;
    double s = skew; /* the first part is `skew` wide, each next one as much wider as it takes */
    for (int k = 1; k < i; k++) s += (1.0 - skew) * k / (0.5 * count * (count - 1));
    return s < 1.0 ? s : even;
}

void sl_room_quad(sl_room *r, const double corner[4][3], int material, const sl_room_cut *cut) {
    size_t first = r->vertex_count, columns = (size_t)cut->columns + 1;
    for (int j = 0; j <= cut->rows; j++) {
        for (int i = 0; i <= cut->columns; i++) {
            double u = share(i, cut->columns, cut->skew), v = (double)j / cut->rows, p[3];
            for (int c = 0; c < 3; c++)
                p[c] = (1.0 - v) * ((1.0 - u) * corner[0][c] + u * corner[1][c]) +
                       v * ((1.0 - u) * corner[3][c] + u * corner[2][c]);
            sl_room_vertex(r, p[0], p[1], p[2]);
        }
    }
    for (size_t j = 0; j < (size_t)cut->rows; j++) {
        for (size_t i = 0; i < (size_t)cut->columns; i++) {
            size_t a = first + j * columns + i;
            sl_room_triangle(r, a, a + 1, a + 1 + columns, material);
            sl_room_triangle(r, a, a + 1 + columns, a + columns, material);
        }
    }
}

/* ---- the room ---- */

static void add_box(sl_room *r, const double low[3], const double high[3]) {
    /* bits: x, y, z */
    static const int side[6][4] = {{4, 5, 7, 6}, {1, 0, 2, 3}, {5, 1, 3, 7},
                                   {0, 4, 6, 2}, {6, 7, 3, 2}, {0, 1, 5, 4}};
    const sl_room_cut whole = {1, 1, 0.0};
    for (int s = 0; s < 6; s++) {
        double corner[4][3];
        for (int k = 0; k < 4; k++)
            for (int c = 0; c < 3; c++) corner[k][c] = side[s][k] >> c & 1 ? high[c] : low[c];
        sl_room_quad(r, corner, SL_ROOM_BOX, &whole);
    }
}

void sl_room_begin(sl_room *r, const sl_room_cut *cut) {
    /* floor */
    static const double walls[5][4][3] = {{{-2, 0, 2.5}, {2, 0, 2.5}, {2, 0, -2.5}, {-2, 0, -2.5}},
                                          /* ceiling */
                                          {{-2, 3, -2.5}, {2, 3, -2.5}, {2, 3, 2.5}, {-2, 3, 2.5}},
                                          /* back */
                                          {{-2, 0, -2.5}, {2, 0, -2.5}, {2, 3, -2.5}, {-2, 3, -2.5}},
                                          /* left */
                                          {{-2, 0, 2.5}, {-2, 0, -2.5}, {-2, 3, -2.5}, {-2, 3, 2.5}},
                                          /* right */
                                          {{2, 0, -2.5}, {2, 0, 2.5}, {2, 3, 2.5}, {2, 3, -2.5}}};
    static const int of_wall[5] = {SL_ROOM_WHITE, SL_ROOM_WHITE, SL_ROOM_WHITE, SL_ROOM_RED, SL_ROOM_GREEN};
    static const double lamp[4][3] = {
        {-0.4, 2.95, -0.6}, {0.4, 2.95, -0.6}, {0.4, 2.95, 0.2}, {-0.4, 2.95, 0.2}};
    const sl_room_cut whole = {1, 1, 0.0};
    *r = (sl_room){.eye = {0.1, 1.4, 6.0},
                   .target = {0.0, 1.3, -2.5},
                   .fov_deg = 42.0,
                   .width = 32,
                   .height = 24,
                   .material = {{"white", {0.7, 0.7, 0.7}, 0, 1, 0, {0}},
                                {"red", {0.6, 0.1, 0.1}, 0, 1, 0, {0}},
                                {"green", {0.1, 0.5, 0.1}, 0, 1, 0, {0}},
                                {"box", {0.6, 0.6, 0.5}, 0, 1, 0, {0}},
                                {"lamp", {0, 0, 0}, 0, 1, 0, {12, 11, 9}}}};
    for (int w = 0; w < 5; w++) sl_room_quad(r, walls[w], of_wall[w], cut);
    sl_room_quad(r, lamp, SL_ROOM_LAMP, &whole);
    add_box(r, (const double[3]){-1.2, 0.0, -1.6}, (const double[3]){-0.2, 1.3, -0.6});
}

void sl_room_end(sl_room *r) {
    free(r->vertex);
    free(r->triangle);
    *r = (sl_room){.vertex_count = 0};
}

static void move_point(double p[3], double scale, const double by[3], bool mirrored) {
    for (int c = 0; c < 3; c++) p[c] = p[c] * scale + by[c];
    if (mirrored) p[0] = -p[0];
}

void sl_room_move(sl_room *r, double scale, const double by[3], bool mirrored) {
    for (size_t i = 0; i < r->vertex_count; i++) move_point(r->vertex[i], scale, by, mirrored);
    move_point(r->eye, scale, by, mirrored);
    move_point(r->target, scale, by, mirrored);
    for (size_t i = 0; mirrored && i < r->triangle_count; i++) { /* fronts stay fronts */
        size_t b = r->triangle[i].corner[1];
        r->triangle[i].corner[1] = r->triangle[i].corner[2];
        r->triangle[i].corner[2] = b;
    }
}

/* ---- as files ---- */

static void write_mesh(const sl_room *r, FILE *out) {
    fprintf(out, "mtllib room.mtl\n");
    for (size_t i = 0; i < r->vertex_count; i++)
        fprintf(out, "v %.9g %.9g %.9g\n", r->vertex[i][0], r->vertex[i][1], r->vertex[i][2]);
    for (size_t i = 0; i < r->triangle_count; i++) {
        if (i == 0 || r->triangle[i].material != r->triangle[i - 1].material)
            fprintf(out, "usemtl %s\n", r->material[r->triangle[i].material].name);
        fprintf(out, "f %zu %zu %zu\n", r->triangle[i].corner[0] + 1, r->triangle[i].corner[1] + 1,
                r->triangle[i].corner[2] + 1);
    }
}

static void write_materials(const sl_room *r, FILE *out) {
    for (int m = 0; m < SL_ROOM_MATERIALS; m++) {
        const sl_room_material *a = &r->material[m];
        fprintf(out, "newmtl %s\n", a->name);
        if (a->mirror > 0.0)
            fprintf(out, "illum 3\nKd 0 0 0\nKs %.9g %.9g %.9g\n", a->mirror, a->mirror, a->mirror);
        else
            fprintf(out, "Kd %.9g %.9g %.9g\nKs %.9g %.9g %.9g\nNs %.9g\n", a->diffuse[0], a->diffuse[1],
                    a->diffuse[2], a->specular, a->specular, a->specular, a->exponent);
        fprintf(out, "Ke %.9g %.9g %.9g\n", a->emission[0], a->emission[1], a->emission[2]);
    }
}

static void write_scene(const sl_room *r, FILE *out) {
    fprintf(out, "{\"softlux\": 1, \"meshes\": [{\"file\": \"room.obj\"}],\n");
    if (r->lights[0]) fprintf(out, " \"lights\": [%s],\n", r->lights);
    fprintf(
        out,
        " \"camera\": {\"eye\": [%.9g, %.9g, %.9g], \"target\": [%.9g, %.9g, %.9g], \"fov_deg\": %.9g},\n",
        r->eye[0], r->eye[1], r->eye[2], r->target[0], r->target[1], r->target[2], r->fov_deg);
    fprintf(out, " \"film\": {\"width\": %d, \"height\": %d}}\n", r->width, r->height);
}

static sl_status cannot_write(const char *path, sl_error *error) {
    return sl_fail(error, SL_ERROR_OUTPUT, "cannot write %s", path);
}

sl_status sl_room_write(const sl_room *r, const char *folder, char *path, size_t size, sl_error *error) {
    static const struct {
        const char *name;
        void (*write)(const sl_room *room, FILE *out);
    } files[] = {{"room.obj", write_mesh}, {"room.mtl", write_materials}, {"room.json", write_scene}};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        snprintf(path, size, "%s/%s", folder, files[i].name);
        FILE *out = r->failed ? NULL : fopen(path, "w");
        if (!out) return cannot_write(path, error);
        files[i].write(r, out);
        if (fclose(out) != 0) return cannot_write(path, error);
    }
    return SL_OK;
}
