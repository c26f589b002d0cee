/* The explanation of a pixel: the display's sum (section on display) told vertex by vertex. A pixel lies in a
 * leaf; what the leaf's corners hold, and what hangs on its edges where it is a fan, adds weight x E x kd /
 * pi, and where there is a lobe weight x L_s. */
#include "cache/shading_cache/state.h"

#include "base/math.h"
#include "base/memory.h"
#include "cache/patches/display/leaf_lookup.h"

static const sl_display_copy *shown_copy(const sl_shading_state *s) {
    return &s->display->copy[s->display->copies.shown];
}

/* Those of sl_leaf_value(). */
static sl_vertex_shares shares_of(const sl_display_copy *copy, const sl_leaf *leaf) {
    const sl_fan_spoke *fan = sl_is_fan_word(leaf->word) ? sl_fan_at(&copy->fans, leaf->word) : NULL;
    uint32_t corner[4];
    sl_leaf_corners(copy, leaf, corner);
    return sl_leaf_shares(leaf->triangle ? 3 : 4, corner, fan ? fan->vertex : 0, fan ? fan + 1 : NULL,
                          (double)leaf->a, (double)leaf->b);
}

/* ---- terms ---- */

static void put_place(float out[3], sl_vec3 in) { out[0] = in.x, out[1] = in.y, out[2] = in.z; }

static void tell_colour(sl_explanation_writer *writer, const char *layer, const char *kind, sl_rgb colour,
                        const double factor[3]) {
    const float value[3] = {colour.r, colour.g, colour.b};
    sl_explanation_add_light(writer, layer, kind, 0, NULL, 1.0, value, factor);
}

static const double whole[3] = {1.0, 1.0, 1.0};

static void tell_vertex(const sl_shading_state *s, const sl_shown_root *p, uint32_t vertex, double weight,
                        const double reflectance[3], sl_explanation_writer *writer) {
    float value[6] = {0};
    const sl_patch_vertex *v = &s->patches->vertex[vertex];
    const char *kind = v->evaluated == SL_VERTEX_NEVER ? "vertex between others, without samples yet"
                       : v->extrapolated ? "vertex inside something, with light from around it"
                                         : "vertex with samples";
    sl_vec3 at = sl_vertex_position(s->patches, vertex);
    sl_display_value(shown_copy(s), p->lobe ? 2 : 1, vertex, value);
    sl_explanation_add_light(writer, "irradiance", kind, vertex, &at, weight, value, reflectance);
    if (p->lobe) sl_explanation_add_light(writer, "radiance", kind, vertex, &at, weight, value + 3, whole);
}

sl_status sl_shading_explanation(void *state, int x, int y, sl_explanation_writer *writer, sl_error *error) {
    (void)error;
    const sl_shading_state *s = state;
    const double per_pi = (double)(float)(1.0 / SL_PI);
    sl_shown_root p;
    sl_display_pixel(s->display, (size_t)y * (size_t)s->settings.width + (size_t)x, &p);
    tell_colour(writer, "emission", p.root == SL_NO_INDEX ? "environment" : "emitted light", p.emission,
                whole);
    if (p.root == SL_NO_INDEX) return SL_OK;
    const double reflectance[3] = {(double)p.diffuse.r * per_pi, (double)p.diffuse.g * per_pi,
                                   (double)p.diffuse.b * per_pi};
    if (!p.wanted) {
        tell_colour(writer, "irradiance", "guess before any sample: the scene's mean", shown_copy(s)->guess,
                    reflectance);
        return SL_OK;
    }
    sl_vertex_shares all = shares_of(shown_copy(s), &p.leaf);
    for (size_t k = 0; k < all.count; k++)
        tell_vertex(s, &p, all.vertex[k], all.weight[k], reflectance, writer);
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
    const size_t pixels = sl_settings_pixels(&s->settings);
    float *plane = s->announcer.observer ? sl_allocate(pixels, sizeof *plane) : NULL;
    for (size_t i = 0; plane && i < pixels; i++)
        plane[i] = s->leaf_of_pixel[i] == SL_NO_INDEX ? 0.0f : s->leaf[s->leaf_of_pixel[i]].normal;
    sl_announce(&s->announcer, "priorities", "priority map", s->settings.width, s->settings.height, 1, plane,
                true);
    sl_free(plane);
}
