/* The explanation of a pixel: the display's sum (section on display) told vertex by vertex. A pixel lies in a
 * leaf; what the leaf's corners hold, and what hangs on its edges where it is a fan, adds weight x E x kd /
 * pi, and where there is a lobe weight x L_s. */
#include "cache/shading_cache/explanation.h"

#include "base/math.h"
#include "base/memory.h"

/* Those of sl_leaf_value(). */
static sl_vertex_shares shares_of(const sl_display_copy *copy, const sl_leaf *leaf) {
    const sl_fan_spoke *fan = sl_is_fan_word(leaf->word) ? sl_fan_at(&copy->fans, leaf->word) : NULL;
    uint32_t corner[4];
    sl_leaf_corners(copy, leaf, corner);
    return sl_leaf_shares(leaf->triangle ? 3 : 4, corner, fan ? fan->vertex : 0, fan ? fan + 1 : NULL,
                          leaf->a, leaf->b);
}

/* ---- terms ---- */

static void put_colour(float out[3], sl_rgb in) { out[0] = in.r, out[1] = in.g, out[2] = in.b; }
static void put_place(float out[3], sl_vec3 in) { out[0] = in.x, out[1] = in.y, out[2] = in.z; }

/* value times factor; nothing where that is black. */
static void add_term(sl_explanation_writer *writer, sl_explanation_term *term, const float value[3],
                     const double factor[3]) {
    bool any = false;
    for (int c = 0; c < 3; c++) {
        term->value[c] = value[c];
        term->contribution[c] = factor[c] * (double)value[c];
        any = any || term->contribution[c] != 0.0;
    }
    if (any) sl_explanation_add(writer, term);
}

static void tell_colour(sl_explanation_writer *writer, const char *layer, const char *kind, sl_rgb colour,
                        const double factor[3]) {
    float value[3];
    sl_explanation_term term = {.layer = layer, .kind = kind, .weight = 1.0};
    put_colour(value, colour);
    add_term(writer, &term, value, factor);
}

static void tell_vertex(const sl_shading_state *s, const sl_shown_pixel *p, uint32_t vertex, double weight,
                        const double reflectance[3], sl_explanation_writer *writer) {
    float value[6] = {0};
    const sl_patch_vertex *v = &s->patches->vertex[vertex];
    bool sampled = v->evaluated != SL_VERTEX_NEVER;
    sl_display_value(p->copy, p->lobe ? 2 : 1, vertex, value);
    const char *kind = !sampled      ? "vertex between others, without samples yet"
                       : v->extrapolated ? "vertex inside something, with light from around it"
                                     : "vertex with samples";
    sl_explanation_term term = {
        .layer = "irradiance", .kind = kind, .index = vertex, .placed = true, .weight = weight};
    put_place(term.position, sl_vertex_position(s->patches, vertex));
    const double diffuse[3] = {weight * reflectance[0], weight * reflectance[1], weight * reflectance[2]},
                 lobe[3] = {weight, weight, weight};
    add_term(writer, &term, value, diffuse);
    term.layer = "radiance";
    if (p->lobe) add_term(writer, &term, value + 3, lobe);
}

sl_status sl_shading_explanation(void *state, int x, int y, sl_explanation_writer *writer, sl_error *error) {
    (void)error;
    const sl_shading_state *s = state;
    const double whole[3] = {1.0, 1.0, 1.0}, per_pi = (double)(float)(1.0 / SL_PI);
    sl_shown_pixel p;
    sl_display_pixel(s->display, (size_t)y * (size_t)s->settings.width + (size_t)x, &p);
    tell_colour(writer, "emission", p.root == SL_NO_INDEX ? "environment" : "emitted light", p.emission,
                whole);
    if (p.root == SL_NO_INDEX) return SL_OK;
    const double reflectance[3] = {(double)p.diffuse.r * per_pi, (double)p.diffuse.g * per_pi,
                                   (double)p.diffuse.b * per_pi};
    if (!p.wanted) {
        tell_colour(writer, "irradiance", "guess before any sample: the scene's mean", p.guess, reflectance);
        return SL_OK;
    }
    sl_vertex_shares all = shares_of(p.copy, &p.leaf);
    for (size_t k = 0; k < all.count; k++) {
        if (all.weight[k] != 0.0) tell_vertex(s, &p, all.vertex[k], all.weight[k], reflectance, writer);
    }
    return SL_OK;
}

/* ---- marks ---- */

void sl_shading_announce_choices(sl_shading_state *s, size_t choices) {
    static const float colours[3][3] = {[SL_CHOICE_HIT] = {0.1f, 0.8f, 0.2f},
                                        [SL_CHOICE_RANDOM] = {0.15f, 0.3f, 1.0f},
                                        [SL_CHOICE_FLOOD] = {1.0f, 0.15f, 0.1f}};
    if (!sl_announcing(&s->announcer)) return;
    sl_mark *marks = choices ? sl_allocate(choices, sizeof *marks) : NULL;
    for (size_t i = 0; marks && i < choices; i++) {
        uint32_t pixel = s->choice[i].pixel, root = sl_patch_root(s->patches, s->ids.patch[pixel]);
        marks[i].kind = SL_MARK_POINT;
        put_place(marks[i].at,
                  sl_root_position(s->primitives, root, (uint32_t)(s->ids.u[pixel] * SL_PATCH_DYADIC),
                                   (uint32_t)(s->ids.v[pixel] * SL_PATCH_DYADIC)));
        for (int c = 0; c < 3; c++) marks[i].colour[c] = colours[s->choice[i].kind][c];
    }
    sl_announce_marks(&s->announcer, "selection", "priority map", marks, marks ? choices : 0);
    sl_free(marks);
}

static bool was_seen(const void *context, uint32_t leaf) {
    const sl_shading_state *s = context;
    return s->patches->patch[leaf].seen == s->now && s->now > 0;
}

static sl_rgb white(const void *context, uint32_t vertex) {
    (void)context;
    (void)vertex;
    return sl_grey(1.0f);
}

static void announce_edges(sl_shading_state *s) {
    size_t count;
    sl_mark *marks = sl_patches_edge_marks(s->patches, &(sl_edge_marking){was_seen, white, s}, &count);
    if (count) sl_announce_marks(&s->announcer, "patches", "patch hierarchy", marks, count);
    sl_free(marks);
}

static void announce_vertices(sl_shading_state *s) {
    size_t made = 0;
    sl_mark *marks = s->patches->vertex_count ? sl_allocate(s->patches->vertex_count, sizeof *marks) : NULL;
    for (uint32_t i = 0; marks && i < s->patches->vertex_count; i++) {
        const sl_patch_vertex *v = &s->patches->vertex[i];
        if (!v->references || v->evaluated == SL_VERTEX_NEVER) continue;
        marks[made].kind = SL_MARK_POINT;
        put_place(marks[made].at, sl_vertex_position(s->patches, i));
        for (int c = 0; c < 3; c++) marks[made].colour[c] = sl_vertex_value(s->patches, i)[c];
        made++;
    }
    if (made) sl_announce_marks(&s->announcer, "vertices", "lazy evaluation", marks, made);
    sl_free(marks);
}

void sl_shading_announce_patches(sl_shading_state *s) {
    if (!sl_announcing(&s->announcer)) return;
    announce_edges(s);
    announce_vertices(s);
}

void sl_shading_announce_priorities(sl_shading_state *s) {
    float *plane = s->announcer.observer ? sl_allocate(sl_shading_pixels(s), sizeof *plane) : NULL;
    for (size_t i = 0; plane && i < sl_shading_pixels(s); i++)
        plane[i] = s->leaf_of_pixel[i] == SL_NO_INDEX ? 0.0f : s->leaf[s->leaf_of_pixel[i]].normal;
    sl_announce(&s->announcer, "priorities", "priority map", s->settings.width, s->settings.height, 1, plane,
                true);
    sl_free(plane);
}
