/* The explanation of a pixel: Algorithm 1 and step 6 told backwards. Each record that reaches the pixel adds
 * w E' / sum w, times albedo / pi; on glossy pixels also what the lobe reflects of it, times ks. And marks,
 * so that records can be seen where they are. */

#include "base/isa.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/print.h"
#include "cache/splatting/record_weight.h"
#include "cache/splatting/state.h"

#include <math.h>

static void put_colour(float out[3], sl_rgb in) { out[0] = in.r, out[1] = in.g, out[2] = in.b; }

static void put_place(float out[3], sl_vec3 in) { out[0] = in.x, out[1] = in.y, out[2] = in.z; }

/* (8) at a pixel. */
static void irradiance_at(const sl_record_pass *pass, const sl_record *record, size_t i, float e[3]) {
    const sl_splat_receivers *p = &pass->receivers;
    const sl_record_terms k = sl_record_terms_of(record, &pass->weights);
    const sl_record_offsets o = sl_record_offsets_at(&k, p->position_x[i], p->position_y[i], p->position_z[i],
                                                     p->normal_x[i], p->normal_y[i], p->normal_z[i]);
    float turn = sl_record_turn(&o);
    for (int c = 0; c < 3; c++) e[c] = sl_record_extrapolate(&k, c, &o, turn);
}

/* Computes what the pixel's glossy lobe reflects of a radiance record, per unit ks. */
static void reflected_at(const sl_record_cache *cache, size_t index, size_t i, float radiance[3]) {
    const sl_record *record = &cache->list.records[index];
    const sl_glossy_record glossy = {record->position, sl_frame_from_normal(record->normal),
                                     cache->list.coefficients + index * cache->pass.coefficient_count};
    SL_KERNEL_OF(sl_isa_best(), sl_glossy_radiance)(&cache->pass.glossy, &glossy, i, radiance);
}

/* Adds w / sum w of what a record says to a layer that reflects so much of it. */
static void tell(const char *layer, const char *kind, const sl_record_cache *cache, size_t index,
                 float weight, float total, const float says[3], sl_rgb reflectance,
                 sl_explanation_writer *writer) {
    const double all = (double)total, factor[3] = {(double)reflectance.r / all, (double)reflectance.g / all,
                                                   (double)reflectance.b / all};
    sl_explanation_add_light(writer, layer, kind, index, &cache->list.records[index].position, (double)weight,
                             says, factor);
}

/* Albedo / pi, and ks: a lobe of finite order rings below 0, where the picture is black. */
static void reflectances_at(const sl_splat_state *s, size_t i, sl_rgb *diffuse, sl_rgb *specular) {
    const sl_gbuffer *g = s->gbuffer;
    const sl_rgb mirrors = sl_reflections_throughput(s->reflections, i),
                 albedo = {g->diffuse_r[i], g->diffuse_g[i], g->diffuse_b[i]};
    float *const *lobe = s->splats.glossy;
    *diffuse = sl_rgb_mul(sl_rgb_scale(albedo, (float)(1.0 / SL_PI)), mirrors);
    *specular = sl_rgb_mul(s->scene->materials[g->material[i]].specular, mirrors);
    if (!lobe[0] || !(lobe[0][i] > 0.0f)) specular->r = 0.0f;
    if (!lobe[0] || !(lobe[1][i] > 0.0f)) specular->g = 0.0f;
    if (!lobe[0] || !(lobe[2][i] > 0.0f)) specular->b = 0.0f;
}

static void tell_records(const sl_splat_state *s, const sl_record_cache *cache, size_t pixel,
                         sl_explanation_writer *writer) {
    const float total = s->splats.weight[pixel];
    sl_rgb diffuse, specular;
    reflectances_at(s, pixel, &diffuse, &specular);
    for (size_t k = 0; k < cache->list.count; k++) {
        const float weight = sl_record_weight(&cache->pass, &cache->list.records[k], pixel);
        float says[3];
        if (!(weight > 0.0f)) continue;
        irradiance_at(&cache->pass, &cache->list.records[k], pixel, says);
        tell("indirect", "irradiance record", cache, k, weight, total, says, diffuse, writer);
        if (!cache->list.coefficients) continue;
        reflected_at(cache, k, pixel, says);
        tell("glossy", "radiance record", cache, k, weight, total, says, specular, writer);
    }
}

sl_status sl_splat_explanation(void *state, int x, int y, sl_explanation_writer *writer, sl_error *error) {
    (void)error;
    const sl_splat_state *s = state;
    size_t pixel = (size_t)y * (size_t)s->settings.width + (size_t)x;
    sl_explanation_add_layer(writer, "emission", "emitted light");
    sl_explanation_add_layer(writer, "direct", "direct light");
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        const sl_record_cache *cache = &s->cache[c];
        if (!cache->receivers || !cache->receives[pixel]) continue;
        if (s->splats.weight[pixel] > 0.0f) {
            tell_records(s, cache, pixel, writer);
        } else {
            sl_explanation_add_layer(writer, "indirect", "mean of the pixels around, for want of a record");
            sl_explanation_add_layer(writer, "glossy", "mean of the pixels around, for want of a record");
        }
    }
    return SL_OK;
}

/* Second-level records are made with the first gathers. */
void sl_splat_announce_second_level(sl_splat_state *s) {
    char name[128];
    sl_second_report r = sl_second_cache_report(s->second);
    sl_print(name, sizeof name,
             "%zu second-level records, %u bounces%s: the last changed them by at most %.2g", r.records,
             (unsigned)r.bounces, r.converged ? ", more would change nothing" : "", (double)r.change);
    sl_announce_pass(&s->announcer, name, "beyond the paper: more bounces");
}

/* ---- what a record saw ---- */

static const sl_record *record_near(const sl_record_cache *cache, sl_vec3 p) {
    const sl_record *nearest = NULL;
    float least = INFINITY;
    for (size_t i = 0; i < cache->list.count; i++) {
        sl_vec3 d = sl_sub(cache->list.records[i].position, p);
        float squared = sl_dot(d, d);
        if (squared < least) least = squared, nearest = &cache->list.records[i];
    }
    return nearest;
}

void sl_splat_announce_gather(sl_splat_state *s, sl_record_cache *cache) {
    const sl_gbuffer *g = s->gbuffer;
    size_t middle = sl_splat_pixels(s) / 2 + (size_t)s->settings.width / 2;
    if (!sl_announcing(&s->announcer) || !cache->gathers.gather || g->material[middle] == SL_NO_INDEX) return;
    const sl_record *record =
        record_near(cache, sl_gbuffer_position(g, middle));
    if (!record || record->triangle == SL_NO_INDEX) return;
    const sl_scene *scene = s->scene;
    uint32_t t = record->triangle;
    sl_vec3 face = sl_scene_geometric_normal(scene, t);
    if (sl_dot(face, record->normal) < 0.0f) face = sl_neg(face);
    const sl_gather_point point = {record->position, face, record->normal, t, 0};
    sl_irradiance ignored_value;
    sl_counters ignored = {{0}};
    sl_gather_irradiance(cache->gathers.gather, &point, cache->gathers.scratch[0], &ignored_value, &ignored);
    const sl_gather_picture picture = sl_gather_last_picture(cache->gathers.scratch[0]);
    const float *const planes[3] = {picture.r, picture.g, picture.b};
    sl_announce_planes(&s->announcer, "gather of one record", "incident radiance of a record", picture.width,
                       picture.height, planes);
    const sl_mark mark = {.kind = SL_MARK_POINT,
                          .at = {record->position.x, record->position.y, record->position.z},
                          .colour = {1.0f, 1.0f, 1.0f}};
    sl_announce_marks(&s->announcer, "gather of one record: where", "incident radiance of a record", &mark,
                      1);
}

/* ---- marks ---- */

void sl_splat_announce_records(sl_splat_state *s) {
    size_t count = 0, made = 0;
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) count += s->cache[c].list.count;
    sl_mark *marks = sl_announcing(&s->announcer) && count ? sl_allocate(count, sizeof *marks) : NULL;
    if (!marks) return;
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        const sl_record_cache *cache = &s->cache[c];
        for (size_t i = 0; i < cache->list.count; i++) {
            const sl_record *record = &cache->list.records[i];
            sl_mark *m = &marks[made++];
            m->kind = SL_MARK_DISC;
            m->radius = (float)cache->pass.radii.accuracy * record->radius;
            put_place(m->at, record->position);
            put_place(m->to, record->normal);
            put_colour(m->colour, record->irradiance);
        }
    }
    sl_announce_marks(&s->announcer, "records", "equation (4): where each may count", marks, made);
    sl_free(marks);
}
