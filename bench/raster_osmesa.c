#include "raster_osmesa.h"

#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "common.h"
#include "osmesa.h"
#include "raster_shaders.h"

enum { TARGETS = 16, MAX_PLANES = OSMESA_PLANES + 1 };

struct peer_pass {
    /* one for every size of view; a reduction's levels, the last being what is read */
    osmesa_target target[TARGETS];
    int targets;
    osmesa_mesh mesh;
    unsigned program, texture[3];
    bool depth, add, reduction, added_up;
    sl_view *views; /* NULL: a pass without a matrix */
    size_t view_count;
    void *memory[MAX_PLANES];
};

/* ---- passes ---------------------------------------------------------------------------------- */

static bool running;

const char *peer_start(unsigned threads) {
    const char *reason = NULL;
    running = osmesa_open(threads > 1 ? threads : 0, &reason);
    return running ? NULL : reason;
}

const char *peer_name(void) { return running ? osmesa_name() : "not here"; }

static size_t plane_bytes(const osmesa_target *target, int plane) {
    static const size_t channels[] = {[PLANE_R32UI] = 1, [PLANE_RG32UI] = 2, [PLANE_R32F] = 1,
                                      [PLANE_RG32F] = 2, [PLANE_RGB32F] = 3, [PLANE_RGBA32F] = 4};
    size_t pixels = (size_t)target->width * (size_t)target->height;
    return pixels * sizeof(float) * (plane < target->planes ? channels[target->format[plane]] : 1);
}

static void add_target(peer_pass *pass, int width, int height, int planes, const osmesa_format *formats) {
    osmesa_target *target = &pass->target[pass->targets++];
    *target = osmesa_target_create(width, height, planes, formats, pass->depth);
    for (int k = 0; k < planes + (pass->depth ? 1 : 0); k++) {
        if (!pass->memory[k]) pass->memory[k] = bench_allocate(plane_bytes(target, k), 1);
    }
}

static peer_pass *make_pass(int width, int height, int planes, const osmesa_format *formats, bool depth,
                            bool add) {
    peer_pass *pass = bench_allocate(1, sizeof *pass);
    pass->depth = depth;
    pass->add = add;
    add_target(pass, width, height, planes, formats);
    return pass;
}

static unsigned scene_program(const char *vertex, const char *fragment) {
    char text[2048];
    snprintf(text, sizeof text, "%s%s", transform, vertex);
    return osmesa_program(text, fragment);
}

static osmesa_mesh upload(const peer_mesh *m, const float *second, const float *third) {
    osmesa_stream streams[3] = {{m->position, m->vertex_count, 3, false}};
    int count = 1;
    if (second) streams[count++] = (osmesa_stream){second, m->vertex_count, 3, false};
    if (third) streams[count++] = (osmesa_stream){third, m->vertex_count, 3, false};
    return osmesa_mesh_create(count, streams, 3 * m->triangle_count, m->index);
}

/* gl_PrimitiveID sends every triangle through a stage that copies its vertices (twice the time). So each
 * triangle gets a last (provoking) vertex of its own, which carries the triangle's number: an unused one of
 * its three, or a copy. */
static osmesa_mesh upload_numbered(const peer_mesh *m) {
    size_t most = m->vertex_count + m->triangle_count, count = m->vertex_count;
    float *position = bench_allocate(3 * most, sizeof *position),
          *number = bench_allocate(most, sizeof *number);
    uint32_t *index = bench_allocate(3 * m->triangle_count, sizeof *index);
    bool *used = bench_allocate(most, sizeof *used);
    memcpy(position, m->position, 3 * count * sizeof *position);
    for (size_t t = 0; t < m->triangle_count; t++) {
        const uint32_t *v = &m->index[3 * t];
        size_t last = !used[v[2]] ? 2 : !used[v[0]] ? 0 : !used[v[1]] ? 1 : 3;
        /* a turn, the same triangle */
        for (size_t k = 0; k < 3; k++) index[3 * t + k] = v[(last + 1 + k) % 3];
        if (last == 3) {
            memcpy(&position[3 * count], &m->position[3 * index[3 * t + 2]], 3 * sizeof *position);
            index[3 * t + 2] = (uint32_t)count++;
        }
        used[index[3 * t + 2]] = true;
        number[index[3 * t + 2]] = (float)t;
    }
    const osmesa_stream streams[2] = {{position, count, 3, false}, {number, count, 1, false}};
    osmesa_mesh mesh = osmesa_mesh_create(2, streams, 3 * m->triangle_count, index);
    sl_free(position);
    sl_free(number);
    sl_free(index);
    sl_free(used);
    return mesh;
}

static void set_views(peer_pass *pass, const sl_view *views, size_t count) {
    pass->view_count = count;
    pass->views = bench_allocate(count, sizeof *views);
    memcpy(pass->views, views, count * sizeof *views);
}

static const osmesa_target *target_of(const peer_pass *pass, const sl_view *view) {
    for (int k = 0; k < pass->targets; k++) {
        if (pass->target[k].width == view->width && pass->target[k].height == view->height)
            return &pass->target[k];
    }
    return NULL;
}

/* views[0] is the largest: memory for its planes serves for all. */
peer_pass *peer_ids(const peer_mesh *mesh, const sl_view *views, size_t count, bool ids) {
    if (!running) return NULL;
    const osmesa_format format = PLANE_R32UI;
    peer_pass *pass = make_pass(views[0].width, views[0].height, ids ? 1 : 0, &format, true, false);
    for (size_t i = 1; i < count; i++) {
        if (!target_of(pass, &views[i]))
            add_target(pass, views[i].width, views[i].height, ids ? 1 : 0, &format);
    }
    pass->mesh = ids ? upload_numbered(mesh) : upload(mesh, NULL, NULL);
    pass->program =
        ids ? scene_program(id_vertex, id_fragment) : scene_program(depth_vertex, depth_fragment);
    set_views(pass, views, count);
    return pass;
}

peer_pass *peer_gbuffer(const peer_mesh *mesh, const sl_view *view) {
    if (!running) return NULL;
    const osmesa_format formats[3] = {PLANE_RGBA32F, PLANE_RGBA32F, PLANE_RGBA32F};
    peer_pass *pass = make_pass(view->width, view->height, 3, formats, true, false);
    pass->mesh = upload(mesh, mesh->normal, mesh->colour);
    pass->program = scene_program(gbuffer_vertex, gbuffer_fragment);
    set_views(pass, view, 1);
    return pass;
}

peer_pass *peer_gouraud(const peer_mesh *mesh, const sl_view *view) {
    if (!running) return NULL;
    peer_pass *pass = make_pass(view->width, view->height, 1, (osmesa_format[]){PLANE_RGBA32F}, true, false);
    pass->mesh = upload(mesh, mesh->colour, NULL);
    pass->program = scene_program(gouraud_vertex, gouraud_fragment);
    set_views(pass, view, 1);
    return pass;
}

/* ---- splats ---------------------------------------------------------------------------------- */

enum { RECORD_TEXELS = 10 };

static void put4(float *out, float x, float y, float z, float w) {
    out[0] = x;
    out[1] = y;
    out[2] = z;
    out[3] = w;
}

static void put_splat(float *row, const peer_splat *splat) {
    const sl_record *r = splat->record;
    put4(row, (float)splat->rect.x0, (float)splat->rect.y0, (float)splat->rect.x1, (float)splat->rect.y1);
    put4(row + 4, r->position.x, r->position.y, r->position.z, r->radius);
    put4(row + 8, r->normal.x, r->normal.y, r->normal.z, 0.0f);
    put4(row + 12, r->irradiance.r, r->irradiance.g, r->irradiance.b, 0.0f);
    for (int c = 0; c < 3; c++) {
        put4(row + 16 + 4 * c, r->rotational[c].x, r->rotational[c].y, r->rotational[c].z,
             r->rotational_length[c]);
        put4(row + 28 + 4 * c, r->translational[c].x, r->translational[c].y, r->translational[c].z, 0.0f);
    }
}

static unsigned splat_texture(const peer_splat *splats, size_t count) {
    float *texels = bench_allocate(count * RECORD_TEXELS, 4 * sizeof *texels);
    for (size_t i = 0; i < count; i++) put_splat(texels + i * RECORD_TEXELS * 4, &splats[i]);
    unsigned texture = osmesa_texture(RECORD_TEXELS, (int)count, texels);
    sl_free(texels);
    return texture;
}

static unsigned plane_texture(const sl_splat_receivers *r, const float *x, const float *y, const float *z) {
    size_t pixels = (size_t)r->width * (size_t)r->height;
    float *texels = bench_allocate(pixels, 4 * sizeof *texels);
    for (size_t i = 0; i < pixels; i++) put4(texels + 4 * i, x[i], y[i], z[i], r->receives[i] ? 1.0f : 0.0f);
    unsigned texture = osmesa_texture(r->width, r->height, texels);
    sl_free(texels);
    return texture;
}

peer_pass *peer_splats(int width, int height, const peer_splat *splats, size_t count,
                       const sl_weight_rules *rules, const sl_splat_receivers *receivers) {
    if (!running) return NULL;
    const osmesa_format formats[2] = {PLANE_RGBA32F, PLANE_RGBA32F};
    peer_pass *pass = make_pass(width, height, 2, formats, false, true);
    pass->mesh = osmesa_mesh_create(0, NULL, 6 * count, NULL);
    pass->program = osmesa_program(splat_vertex, splat_fragment);
    osmesa_uniform(pass->program, "size", 2, (float[]){(float)width, (float)height});
    pass->texture[0] = splat_texture(splats, count);
    pass->texture[1] =
        plane_texture(receivers, receivers->position_x, receivers->position_y, receivers->position_z);
    pass->texture[2] =
        plane_texture(receivers, receivers->normal_x, receivers->normal_y, receivers->normal_z);
    osmesa_uniform(pass->program, "rules", 3,
                   (float[]){rules->accuracy, rules->offset, rules->front_tolerance});
    return pass;
}

/* ---- reduction ------------------------------------------------------------------------------- */

static void read_back(const peer_pass *pass, const osmesa_target *target) {
    for (int k = 0; k < target->planes; k++) osmesa_read(target, k, pass->memory[k]);
    if (pass->depth) osmesa_read_depth(target, pass->memory[target->planes]);
}

static void reduce(const peer_pass *pass, bool read) {
    osmesa_state(false, false);
    for (int k = 0; k < pass->targets; k++) {
        osmesa_draw_to(&pass->target[k]);
        osmesa_input(pass->program, "from", 0, k ? pass->target[k - 1].plane[0] : pass->texture[0]);
        osmesa_draw_all(pass->program, &pass->mesh);
    }
    if (read) read_back(pass, &pass->target[pass->targets - 1]);
}

peer_pass *peer_reduction(const float *rgba, int size, int final) {
    if (!running) return NULL;
    const osmesa_format format = PLANE_RGBA32F;
    int first = final ? size / 2 : size;
    peer_pass *pass = make_pass(first, first, 1, &format, false, false);
    for (int s = first / 2; final && s >= final; s /= 2) add_target(pass, s, s, 1, &format);
    pass->mesh = osmesa_mesh_create(0, NULL, 3, NULL);
    pass->program = osmesa_program(screen_vertex, final ? halve_fragment : copy_fragment);
    pass->texture[0] = osmesa_texture(size, size, rgba);
    pass->reduction = true;
    pass->added_up = !final;
    if (!final) {
        reduce(pass, false); /* the copy, once */
        pass->memory[1] = bench_allocate(4, sizeof(float));
    }
    return pass;
}

/* Sixteen sums at a time, four pixels. */
static void add_up(const float *rgba, size_t floats, float total[4]) {
    float sum[16] = {0};
    for (size_t i = 0; i < floats; i += 16) {
        for (size_t k = 0; k < 16; k++) sum[k] += rgba[i + k];
    }
    for (size_t c = 0; c < 4; c++) total[c] = (sum[c] + sum[c + 4]) + (sum[c + 8] + sum[c + 12]);
}

static void read_and_add(const peer_pass *pass, bool read) {
    if (!read) return;
    read_back(pass, &pass->target[0]);
    add_up(pass->memory[0], plane_bytes(&pass->target[0], 0) / sizeof(float), pass->memory[1]);
}

/* ---- drawing --------------------------------------------------------------------------------- */

/* OpenGL has a far plane: for views without one, z/w = 1 - 2 near/w. */
static void set_view(unsigned program, const sl_view *view) {
    float rows[4][4];
    memcpy(rows, view->clip, sizeof rows);
    if (view->depth == SL_DEPTH_INVERSE_W) rows[2][3] *= 2.0f;
    osmesa_uniform_matrix(program, "clip", (const float(*)[4])rows);
    osmesa_uniform(program, "origin", 3, &view->origin.x);
}

static void begin(const peer_pass *pass) {
    static const char *const samplers[3] = {"records", "positions", "normals"};
    osmesa_draw_to(&pass->target[0]);
    osmesa_state(pass->depth, pass->add);
    for (int k = 0; k < 3 && pass->texture[k]; k++)
        osmesa_input(pass->program, samplers[k], k, pass->texture[k]);
}

static void draw(const peer_pass *pass, size_t view, bool read) {
    const osmesa_target *target = pass->views ? target_of(pass, &pass->views[view]) : &pass->target[0];
    if (pass->views) set_view(pass->program, &pass->views[view]);
    if (!pass->add) osmesa_clear(target);
    osmesa_draw_all(pass->program, &pass->mesh);
    if (read) read_back(pass, target);
}

void peer_run(peer_pass *pass, bool read) {
    if (pass->added_up) {
        read_and_add(pass, read);
    } else if (pass->reduction) {
        reduce(pass, read);
    } else {
        begin(pass);
        for (size_t i = 0; i < (pass->views ? pass->view_count : 1); i++) draw(pass, i, read);
    }
    if (!read) osmesa_finish();
}

void peer_run_view(peer_pass *pass, size_t view) {
    begin(pass);
    draw(pass, view, true);
}

void peer_clear(peer_pass *pass) { osmesa_clear(&pass->target[0]); }

const void *peer_plane(const peer_pass *pass, int plane) { return pass->memory[plane]; }

void peer_destroy(peer_pass *pass) {
    if (!pass) return;
    for (int k = 0; k < pass->targets; k++) osmesa_target_destroy(&pass->target[k]);
    for (int k = 0; k < 3; k++) {
        if (pass->texture[k]) osmesa_texture_destroy(pass->texture[k]);
    }
    osmesa_mesh_destroy(&pass->mesh);
    osmesa_program_destroy(pass->program);
    for (int k = 0; k < MAX_PLANES; k++) sl_free(pass->memory[k]);
    sl_free(pass->views);
    sl_free(pass);
}
