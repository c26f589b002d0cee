#include "app/rate.h"

#include "app/clock.h"

/* Gives the samples a second of a span that ends now, a second or more from the end of an update to that of
 * another, and begins the next span; false: none ends. Spans in which updates rest, or in which all was made
 * anew, count for nothing. */
static bool measure(sl_rate *r, const sl_live_state *last, double *rate) {
    const double now = sl_seconds_now(), took = now - r->begin, samples = last->samples - r->samples;
    const bool rests = last->done || samples < 0.0 || !r->begun,
               ends = took >= 1.0 && last->updates != r->updates;
    r->updates = last->updates;
    r->begun = true;
    if (!rests && !ends) return false;
    r->begin = now;
    r->samples = last->samples;
    *rate = rests ? 0.0 : samples / took;
    return *rate >= 1.0;
}

sl_status sl_rate_tell(sl_rate *r, sl_live *live, const sl_settings *settings, const sl_live_state *frame,
                       sl_error *error) {
    double rate;
    if (settings->shading_cache.nominal_rate > 0.0 || !measure(r, frame, &rate)) return SL_OK;
    if (rate > 0.8 * r->told && rate < 1.25 * r->told) return SL_OK;
    r->told = rate;
    return sl_live_rate(live, rate, error);
}
