#include "app/compare_tone.h"

#include "image/tone.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool find_curve(const char *name, sl_tone_curve *curve) {
    for (size_t i = 0; sl_tone_curve_name(i); i++) {
        if (strcmp(sl_tone_curve_name(i), name) != 0) continue;
        *curve = (sl_tone_curve)i;
        return true;
    }
    return false;
}

sl_shown sl_shown_of(const sl_image *image) {
    const char *curve = sl_image_metadata(image, SL_TONE_KEY),
               *stops = sl_image_metadata(image, SL_TONE_EXPOSURE_KEY);
    sl_shown s = {.is_shown = curve != NULL,
                  .automatic = sl_image_metadata(image, SL_TONE_AUTOMATIC_KEY) != NULL};
    char *end = NULL;
    if (!curve || !stops) return s;
    s.stops = strtod(stops, &end);
    s.known = end != stops && !*end && isfinite(s.stops) && find_curve(curve, &s.curve);
    return s;
}

static sl_status show(sl_image **radiance, const char *path, const sl_shown *other, const char *other_path,
                      sl_error *error) {
    sl_image *displayed;
    if (!other->known) {
        snprintf(
            error->message, sizeof error->message,
            "%.400s does not tell the tone that it was made with, so that it cannot be compared with the "
            "radiance of %.400s; expected two EXR files, or a PNG by softlux",
            other_path, path);
        return error->status = SL_ERROR_INPUT;
    }
    sl_status status = sl_tone_display(*radiance, other->curve, other->stops, &displayed, error);
    if (status != SL_OK) return status;
    sl_image_destroy(*radiance);
    *radiance = displayed;
    return SL_OK;
}

sl_status sl_shown_alike(sl_image **a, const char *a_path, sl_image **b, const char *b_path,
                         sl_error *error) {
    const sl_shown of_a = sl_shown_of(*a), of_b = sl_shown_of(*b);
    if (of_a.is_shown == of_b.is_shown) return SL_OK;
    return of_a.is_shown ? show(b, b_path, &of_a, a_path, error) : show(a, a_path, &of_b, b_path, error);
}

void sl_shown_warn(const sl_shown *a, const char *a_path, const sl_shown *b, const char *b_path) {
    if (!a->is_shown || !b->is_shown || !a->known || !b->known) return;
    const bool differ = a->curve != b->curve || a->stops != b->stops,
               automatic = a->automatic || b->automatic;
    if (!differ && !automatic) return;
    fprintf(stderr,
            "softlux: warning: %s (%s %.4g stops, %s %.4g stops)%s: brightness is not compared; EXR files, "
            "or a fixed --exposure, show it\n",
            differ ? "the exposures differ" : "the exposure was automatic", a_path, a->stops, b_path,
            b->stops, differ && automatic ? ", being automatic" : "");
}

void sl_shown_print(const char *name, const sl_shown *s, bool json) {
    const char *curve = s->known ? sl_tone_curve_name((size_t)s->curve) : "unknown",
               *automatic = s->automatic ? "true" : "false";
    if (!s->is_shown) printf(json ? "\"%s\": null, " : "%-19s radiance, shown by the other's\n", name);
    else if (!s->known) printf(json ? "\"%s\": {\"curve\": null}, " : "%-19s unknown\n", name);
    else if (json)
        printf("\"%s\": {\"curve\": \"%s\", \"exposure\": %.17g, \"automatic\": %s}, ", name, curve, s->stops,
               automatic);
    else printf("%-19s %s, %.9g stops%s\n", name, curve, s->stops, s->automatic ? ", automatic" : "");
}
