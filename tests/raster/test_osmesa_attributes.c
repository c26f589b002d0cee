/* How accurate our attributes and depth are, beside OSMesa's: both against long double evaluation at the
 * pixel's centre of the triangle as it was before its vertices were snapped: attributes from the vertices'
 * positions, depth from their clip coordinates, which the vertex shader has rounded to float and both
 * rasterizers begin with.
 *
 * Snapping moves edges by up to 1/512 pixel, so a pixel that is drawn may have its centre outside the
 * unsnapped triangle. There an attribute could be extrapolated; we take the nearest point of the triangle
 * instead, since on a sliver the plane may be so steep that extrapolated values have nothing to do with the
 * triangle's (a G-buffer's position would leave the surface, a colour become negative). Depth is
 * extrapolated, but not beyond the corners' depths. So what is right there is a matter of choice: ours is
 * held to these values, OSMesa's to whichever of the clamped and the extrapolated is nearer. */
#include "osmesa_soup.h"

enum { CHANNELS = 3, SIZE = 1024, PIXELS = SIZE * SIZE };
typedef long double real;

typedef struct error_sum {
    double max, sum;
    uint64_t count;
} error_sum;
typedef struct tally {
    error_sum attribute[2], depth[2]; /* ours, theirs */
    uint64_t other_triangle;
} tally;
static tally tallies[SOUP_KINDS];

/* Of a kind: triangles of one picture, and pictures. */
static const struct { size_t triangles; int pictures;
} how_many[SOUP_KINDS] = {
    [SOUP_BIG] = {20, 4},
    [SOUP_MEDIUM] = {3000, 3},
    [SOUP_SMALL] = {100000, 2},
    [SOUP_SUBPIXEL] = {400000, 1},
    [SOUP_SLIVER] = {10000, 4},
    [SOUP_MESH] = {100000, 2},
    [SOUP_PIXEL_CENTRES] = {5000, 2},
    [SOUP_TIES] = {10000, 2},
    [SOUP_PARTLY_OFF] = {20, 4},
    [SOUP_FAR_OFF] = {40, 4},
    [SOUP_PERSPECTIVE] = {4000, 4},
    [SOUP_NEAR_CLIPPED] = {20, 6},
};

/* ---- the truth ------------------------------------------------------------------------------- */

/* A triangle in clip space. */
typedef struct clip_triangle {
    real x[3], y[3], z[3], w[3];
} clip_triangle;

static clip_triangle rounded_triangle_of(const soup *s, uint32_t t) {
    clip_triangle c;
    for (size_t k = 0; k < 3; k++) {
        size_t v = 3 * t + k;
        sl_vec3 q = sl_sub(sl_v3(s->position[0][v], s->position[1][v], s->position[2][v]), s->view.origin);
        float r[4];
        for (int i = 0; i < 4; i++) {
            const float *m = s->view.clip[i];
            r[i] = ((m[0] * q.x + m[1] * q.y) + m[2] * q.z) + m[3];
        }
        c.x[k] = (real)r[0], c.y[k] = (real)r[1], c.z[k] = (real)r[2], c.w[k] = (real)r[3];
    }
    return c;
}

static clip_triangle exact_triangle_of(const soup *s, uint32_t t) {
    clip_triangle c;
    const real origin[3] = {s->view.origin.x, s->view.origin.y, s->view.origin.z};
    for (size_t k = 0; k < 3; k++) {
        real q[3], r[4];
        for (int i = 0; i < 3; i++) q[i] = (real)s->position[i][3 * t + k] - origin[i];
        for (int i = 0; i < 4; i++) {
            const float *m = s->view.clip[i];
            r[i] = (real)m[0] * q[0] + (real)m[1] * q[1] + (real)m[2] * q[2] + (real)m[3];
        }
        c.x[k] = r[0], c.y[k] = r[1], c.z[k] = r[2], c.w[k] = r[3];
    }
    return c;
}

/* Weights of the corners for the point (px, py) of the screen: edge functions in homogeneous coordinates
 * (Olano and Greer 1997). clamp: outside, the nearest point of the first edge that it is beyond. False where
 * there are none. */
static bool weights_at(const clip_triangle *c, real px, real py, bool clamp, real weight[3]) {
    real a[3], b[3], d[3], e[3], determinant = 0;
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        real xi = c->x[i] - px * c->w[i], yi = c->y[i] - py * c->w[i], xj = c->x[j] - px * c->w[j],
             yj = c->y[j] - py * c->w[j];
        a[k] = yi * c->w[j] - c->w[i] * yj;
        b[k] = c->w[i] * xj - xi * c->w[j];
        d[k] = xi * yj - yi * xj;
        determinant += d[k];
    }
    real sign = determinant < 0 ? -1 : 1, step_x = 0, step_y = 0, sum = 0;
    for (int k = 0; clamp && k < 3; k++) {
        if (sign * d[k] >= 0) continue;
        step_x = -d[k] * a[k] / (a[k] * a[k] + b[k] * b[k]);
        step_y = -d[k] * b[k] / (a[k] * a[k] + b[k] * b[k]);
        break;
    }
    for (int k = 0; k < 3; k++) {
        e[k] = sign * (a[k] * step_x + b[k] * step_y + d[k]);
        if (clamp && e[k] < 0) e[k] = 0;
        sum += e[k];
    }
    for (int k = 0; k < 3; k++) weight[k] = e[k] / sum;
    return sum > 0;
}

static real weighted(const real weight[3], const real value[3]) {
    return weight[0] * value[0] + weight[1] * value[1] + weight[2] * value[2];
}

static real clamp_to(real x, real low, real high) { return x < low ? low : x > high ? high : x; }

static real window_depth(const clip_triangle *c, const real weight[3]) {
    return clamp_to(0.5L * weighted(weight, c->z) / weighted(weight, c->w) + 0.5L, 0, 1);
}

/* Not beyond the corners' depths, if none of them is behind the eye. */
static real within_corners(const clip_triangle *c, real depth) {
    real low = 1, high = 0;
    for (int k = 0; k < 3; k++) {
        if (c->w[k] <= 0) return depth;
        real z = clamp_to(0.5L * c->z[k] / c->w[k] + 0.5L, 0, 1);
        low = fminl(low, z);
        high = fmaxl(high, z);
    }
    return clamp_to(depth, low, high);
}

/* ---- comparison ------------------------------------------------------------------------------ */

static void add_error(error_sum *sum, real error) {
    double e = fabs((double)error);
    if (!(e <= sum->max)) sum->max = e; /* a NaN stays */
    sum->sum += e;
    sum->count++;
}

static real nearer(real value, real a, real b) {
    return fabsl(value - a) < fabsl(value - b) ? value - a : value - b;
}

typedef struct picture {
    uint32_t *id;
    float *depth, *attributes; /* ours: planes; theirs: interleaved */
} picture;

static picture picture_create(void) {
    return (picture){checked_calloc(PIXELS, 4), checked_calloc(PIXELS, 4),
                     checked_calloc(CHANNELS * PIXELS, 4)};
}
static void picture_free(picture *p) { free(p->id), free(p->depth), free(p->attributes); }

static void compare_pixel(tally *sum, const clip_triangle *c, const clip_triangle *rounded,
                          const float *attributes, size_t i, const picture *ours, const picture *theirs) {
    real px = (real)(2 * (i % SIZE) + 1) / SIZE - 1, py = (real)(2 * (i / SIZE) + 1) / SIZE - 1, clamped[3],
         free_[3], depth_free[3];
    if (!weights_at(c, px, py, true, clamped) || !weights_at(c, px, py, false, free_)) return;
    if (!weights_at(rounded, px, py, false, depth_free)) return;
    real free_depth = window_depth(rounded, depth_free), depth = within_corners(rounded, free_depth);
    add_error(&sum->depth[0], (real)ours->depth[i] - depth);
    add_error(&sum->depth[1], nearer((real)theirs->depth[i], depth, free_depth));
    for (size_t k = 0; k < CHANNELS; k++) {
        const real value[3] = {attributes[k], attributes[CHANNELS + k], attributes[2 * CHANNELS + k]};
        real truth = weighted(clamped, value), free_truth = weighted(free_, value);
        add_error(&sum->attribute[0], (real)ours->attributes[k * PIXELS + i] - truth);
        add_error(&sum->attribute[1], nearer((real)theirs->attributes[CHANNELS * i + k], truth, free_truth));
    }
}

static void compare_picture(soup_kind kind, uint64_t seed, const osmesa_target *target, unsigned program,
                            picture *ours, picture *theirs) {
    soup s = soup_make(kind, 500 + seed, how_many[kind].triangles, SIZE, SIZE);
    float *attributes = checked_calloc(CHANNELS * 3 * s.triangles, sizeof *attributes);
    uint64_t key = sl_random_key(4000, seed);
    for (size_t i = 0; i < CHANNELS * 3 * s.triangles; i++) attributes[i] = sl_random_unit(key, i);
    sl_raster *raster = soup_raster(&s);
    sl_target planes = {.width = SIZE, .height = SIZE, .id = ours->id, .depth = ours->depth};
    sl_counters counters = {{0}};
    assert_int_equal(sl_raster_id(raster, &s.view, 1, &planes, &counters, NULL), SL_OK);
    sl_raster_gouraud(raster, &s.view, 1, ours->id,
                      &(sl_gouraud_pass){.channels = CHANNELS, .vertex = attributes, .out = ours->attributes},
                      &counters);
    osmesa_mesh mesh = mesh_of(s.position, 3 * s.triangles, attributes, CHANNELS, 0, NULL);
    judge_draw(program, target, &mesh, &s.view, true, false);
    osmesa_read(target, 0, theirs->id);
    osmesa_read(target, 1, theirs->attributes);
    osmesa_read_depth(target, theirs->depth);
    uint32_t last = SL_NO_INDEX;
    clip_triangle c = {{0}, {0}, {0}, {0}}, rounded = c;
    for (size_t i = 0; i < PIXELS; i++) {
        uint32_t id = ours->id[i];
        if (id != theirs->id[i]) tallies[kind].other_triangle++;
        if (id != theirs->id[i] || id == SL_NO_INDEX) continue;
        if (id != last) {
            c = exact_triangle_of(&s, id);
            rounded = rounded_triangle_of(&s, id);
        }
        last = id;
        compare_pixel(&tallies[kind], &c, &rounded, attributes + CHANNELS * 3 * (size_t)id, i, ours, theirs);
    }
    osmesa_mesh_destroy(&mesh);
    sl_raster_destroy(raster);
    free(attributes);
    soup_free(&s);
}

/* Below 2^-23, two steps of a float just below 1, the largest errors only tell which roundings happened to
 * add up. */
static void assert_not_worse(const error_sum error[2]) {
    assert_true(error[0].count > 0);
    assert_true(error[0].max <= error[1].max || error[0].max < 0x1p-23);
    assert_true(error[0].sum <= error[1].sum);
}

static void attributes_and_depth_are_as_accurate_as_osmesas_in_every_class(void **state) {
    (void)state;
    open_or_skip();
    unsigned program = program_in_view(
        "layout(location = 3) in vec3 a; out vec3 value;", "value = a;",
        "in vec3 value; layout(location = 0) out uint id; layout(location = 1) out vec3 colour;"
        "void main() { id = uint(gl_PrimitiveID); colour = value; }");
    const osmesa_format formats[] = {PLANE_R32UI, PLANE_RGB32F};
    osmesa_target target = osmesa_target_create(SIZE, SIZE, 2, formats, true);
    picture ours = picture_create(), theirs = picture_create();
    for (int kind = 0; kind < SOUP_KINDS; kind++) {
        int pictures = how_many[kind].pictures;
        if (soup_share(100) < 100 && pictures > 3) pictures = 3;
        for (int n = 0; n < pictures; n++)
            compare_picture((soup_kind)kind, (uint64_t)n, &target, program, &ours, &theirs);
    }
    picture_free(&ours);
    picture_free(&theirs);
    osmesa_target_destroy(&target);
    osmesa_program_destroy(program);
    print_message("%-16s %10s   %-36s   %-36s   %s\n", "", "", "attribute: ours max, mean; OSMesa's",
                  "depth: ours max, mean; OSMesa's", "other");
    for (int kind = 0; kind < SOUP_KINDS; kind++) {
        const tally *t = &tallies[kind];
        print_message("%-16s %10llu", soup_names[kind], (unsigned long long)t->depth[0].count);
        for (int what = 0; what < 2; what++) {
            const error_sum *e = what ? t->depth : t->attribute;
            print_message("   %8.1e %8.1e  %8.1e %8.1e", e[0].max, e[0].sum / (double)e[0].count, e[1].max,
                          e[1].sum / (double)e[1].count);
        }
        print_message("   %llu\n", (unsigned long long)t->other_triangle);
    }
    for (int kind = 0; kind < SOUP_KINDS; kind++) {
        assert_not_worse(tallies[kind].attribute);
        assert_not_worse(tallies[kind].depth);
    }
}

static int close_group(void **state) {
    (void)state;
    osmesa_close();
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(attributes_and_depth_are_as_accurate_as_osmesas_in_every_class)};
    return cmocka_run_group_tests(tests, NULL, close_group);
}
