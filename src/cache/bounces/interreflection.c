/* One bounce after the other (Jacobi's iteration, so that no order of records matters). E = E^(1) + D + T D +
 * T T D + ..., where D is what every record gathers of the light E^(1) of the others, and T the matrix of
 * what they send to each other by one reflection, which the same gathers write down. */
#include "cache/bounces/second_level.h"

#include "base/batch.h"
#include "base/error.h"
#include "base/memory.h"

/* More bounces would not change anything worth telling. */
#define SMALL_CHANGE 1e-4f

/* Gives a record other light than it had; its reach stays. */
static void set_light(sl_record *r, const sl_irradiance *e) {
    r->irradiance = e->value;
    for (int channel = 0; channel < 3; channel++) {
        r->rotational[channel] = e->rotational[channel];
        r->translational[channel] = e->translational[channel];
        r->rotational_length[channel] = sl_length(e->rotational[channel]);
    }
    sl_record_set_radius(r, r->radius); /* the same: limits the new gradient */
    sl_second_tame(r);
}

/* ---- the first bounce, and any while things move ---- */

static size_t in_turn(const sl_second_cache *cache, size_t index) {
    return (cache->next + index) % cache->list.count;
}

/* result: the record with the light that it receives now. */
static void gather_one(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    const sl_second_cache *cache = context;
    const sl_gathers *g = &cache->gathers;
    const size_t i = in_turn(cache, index);
    sl_irradiance e;
    sl_record *r = result;
    sl_gather_irradiance(g->gather, &cache->list.points[i], g->scratch[worker], &e, counters);
    *r = cache->list.records[i];
    set_light(r, &e);
}

sl_status sl_second_gather(sl_second_cache *cache, size_t count, sl_counters *counters, sl_error *error) {
    sl_second_list *list = &cache->list;
    if (!count) return SL_OK;
    sl_record *lit = sl_allocate(count, sizeof *lit);
    if (!lit) return sl_fail_memory(error, "a bounce of second-level records");
    const sl_batch batch = {.count = count, .work = gather_one, .context = cache, .results = lit,
                            .result_bytes = sizeof *lit, .shared = true};
    sl_batch_run(&batch, cache->settings.threads, counters);
    for (size_t k = 0; k < count; k++) {
        const size_t i = in_turn(cache, k);
        list->records[i] = lit[k];
        list->terms[i] = sl_record_terms_of(&lit[k], &cache->rules);
    }
    cache->next = in_turn(cache, count);
    sl_free(lit);
    return SL_OK;
}

/* ---- the second, and what it tells of all others ---- */

/* A record's gather of the others' light. */
typedef struct {
    sl_irradiance light;
    bool failed;
} gathered;

/* The share that each of the others has in it: large, and of no use but to who has gathered it. */
typedef struct {
    sl_second_link *row;
    uint32_t count;
} row;

typedef struct {
    const sl_second_cache *cache;
    sl_link_sums *sums; /* by worker */
    gathered *gathers;
    row *rows;
    float (*now)[3], (*next)[3], (*all)[3]; /* light of this bounce, of the next, of all from D on */
} bouncing;

static void free_all(bouncing *b) {
    for (unsigned w = 0; b->sums && w < b->cache->gathers.threads; w++) {
        SL_FREE_ALL(b->sums[w].share, b->sums[w].touched);
    }
    for (size_t i = 0; b->rows && i < b->cache->list.count; i++) sl_free(b->rows[i].row);
    SL_FREE_ALL(b->sums, b->rows, b->gathers, b->now, b->next, b->all);
}

static bool allocate(bouncing *b) {
    const size_t count = b->cache->list.count;
    const unsigned threads = b->cache->gathers.threads;
    bool room = true;
    b->sums = sl_allocate(threads, sizeof *b->sums);
    b->gathers = sl_allocate(count, sizeof *b->gathers);
    b->rows = sl_allocate(count, sizeof *b->rows);
    b->now = sl_allocate(count, sizeof *b->now);
    b->next = sl_allocate(count, sizeof *b->next);
    b->all = sl_allocate(count, sizeof *b->all);
    if (!b->sums || !b->gathers || !b->rows || !b->now || !b->next || !b->all) return false;
    for (unsigned w = 0; w < threads; w++) {
        sl_link_sums *s = &b->sums[w];
        s->share = sl_allocate(count, sizeof *s->share);
        s->touched = sl_allocate(count, sizeof *s->touched);
        room = room && s->share && s->touched;
        for (size_t i = 0; s->share && i < count; i++) s->share[i][0] = -1.0f;
    }
    return room;
}

/* The worker's sums are as before afterwards. */
static void write_row(sl_link_sums *sums, row *r) {
    r->row = sl_allocate(sums->count, sizeof *r->row);
    r->count = r->row ? sums->count : 0;
    for (uint32_t n = 0; n < sums->count; n++) {
        float *share = sums->share[sums->touched[n]];
        if (r->row) r->row[n] = (sl_second_link){sums->touched[n], {share[0], share[1], share[2]}};
        share[0] = -1.0f;
    }
    sums->count = 0;
}

static void gather_second(void *context, size_t index, unsigned worker, void *result,
                          sl_counters *counters) {
    const bouncing *b = context;
    const sl_gathers *g = &b->cache->gathers;
    gathered *r = result;
    sl_gather_second_irradiance(g->gather, &b->cache->list.points[index], g->scratch[worker], &r->light,
                                counters);
    const sl_gather_hits_seen seen = sl_gather_last_hits(g->scratch[worker]);
    SL_KERNEL_OF(b->cache->isa, sl_second_links)(b->cache, &seen, &b->sums[worker]);
    write_row(&b->sums[worker], &b->rows[index]);
    r->failed = !b->rows[index].row;
}

/* ---- all others ---- */

static void send_one(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    (void)worker, (void)counters;
    const bouncing *b = context;
    const row *r = &b->rows[index];
    double sum[3] = {0.0, 0.0, 0.0};
    for (uint32_t n = 0; n < r->count; n++) {
        const sl_second_link *t = &r->row[n];
        for (int c = 0; c < 3; c++) sum[c] += (double)t->share[c] * (double)b->now[t->from][c];
    }
    for (int c = 0; c < 3; c++) ((float *)result)[c] = (float)sum[c];
}

/* T times what the records receive by this bounce. */
static void send(bouncing *b, sl_counters *counters) {
    const sl_batch batch = {.count = b->cache->list.count, .work = send_one, .context = b, .results = b->next,
                            .result_bytes = sizeof *b->next, .shared = true};
    sl_batch_run(&batch, b->cache->gathers.threads, counters);
}

/* Adds this bounce. Returns the largest relative change of a record's mean over the channels; dark records
 * are measured by a tenth of the average. */
static float add_bounce(const bouncing *b) {
    const size_t count = b->cache->list.count;
    double sum = 0.0;
    float largest = 0.0f;
    for (size_t i = 0; i < count; i++) {
        for (int c = 0; c < 3; c++) {
            b->all[i][c] += b->now[i][c];
            sum += (double)(b->all[i][c] / 3.0f);
        }
        sum += (double)sl_rgb_mean(b->cache->list.records[i].irradiance);
    }
    const float dark = count ? (float)(0.1 * sum / (double)count) : 0.0f;
    for (size_t i = 0; i < count; i++) {
        const float *now = b->now[i], *all = b->all[i], change = fabsf(now[0] + now[1] + now[2]) / 3.0f,
                    is =
                        sl_rgb_mean(b->cache->list.records[i].irradiance) + (all[0] + all[1] + all[2]) / 3.0f,
                    scale = is > dark ? is : dark;
        if (change > largest * scale) largest = change / scale;
    }
    return largest;
}

/* Light of later bounces falls off across a record as that of the second one does, in proportion. */
static void add_to_record(const gathered *r, const float all[3], sl_record *record) {
    const float second[3] = {r->light.value.r, r->light.value.g, r->light.value.b};
    sl_irradiance e = {.value = sl_rgb_add(record->irradiance, (sl_rgb){all[0], all[1], all[2]})};
    for (int c = 0; c < 3; c++) {
        const float times = second[c] > 0.0f ? all[c] / second[c] : 0.0f,
                    scale = isfinite(times) ? times : 0.0f;
        e.rotational[c] = sl_mad(record->rotational[c], scale, r->light.rotational[c]);
        e.translational[c] = sl_mad(record->translational[c], scale, r->light.translational[c]);
    }
    set_light(record, &e);
}

static void let_bounce(bouncing *b, sl_second_cache *cache, sl_counters *counters) {
    sl_second_report *report = &cache->report;
    const size_t count = cache->list.count;
    const sl_batch batch = {.count = count, .work = gather_second, .context = b, .results = b->gathers,
                            .result_bytes = sizeof *b->gathers, .shared = true};
    sl_batch_run(&batch, cache->gathers.threads, counters);
    for (size_t i = 0; i < count; i++) {
        const sl_rgb d = b->gathers[i].light.value;
        b->now[i][0] = d.r, b->now[i][1] = d.g, b->now[i][2] = d.b;
    }
    for (;;) {
        report->change = add_bounce(b);
        report->bounces++;
        report->converged = report->change < SMALL_CHANGE;
        if (report->converged || report->bounces + 1 >= cache->settings.bounces) break;
        send(b, counters);
        float(*swapped)[3] = b->now;
        b->now = b->next;
        b->next = swapped;
    }
    for (size_t i = 0; i < count; i++) {
        add_to_record(&b->gathers[i], b->all[i], &cache->list.records[i]);
        cache->list.terms[i] = sl_record_terms_of(&cache->list.records[i], &cache->rules);
    }
}

sl_status sl_let_light_bounce(sl_second_cache *cache, sl_counters *counters, sl_error *error) {
    bouncing b = {.cache = cache};
    cache->shines = true;
    cache->report.records = cache->bounced = cache->list.count;
    cache->report.converged = false;
    cache->report.bounces = 1;
    if (cache->settings.bounces < 3 || cache->list.count == 0) return SL_OK;
    bool room = allocate(&b);
    if (room) {
        let_bounce(&b, cache, counters);
        for (size_t i = 0; i < cache->list.count; i++) room = room && !b.gathers[i].failed;
    }
    free_all(&b);
    return room ? SL_OK : sl_fail_memory(error, "bounces of second-level records");
}
