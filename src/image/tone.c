#include "image/tone.h"

#include "image/color.h"

#include "base/error.h"
#include "base/math.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

bool sl_layer_planes(const sl_image *image, const char *layer, const float *planes[3]) {
    bool whole = true;
    for (int c = 0; c < 3; c++) {
        char name[SL_CHANNEL_NAME_MAX];
        snprintf(name, sizeof name, "%s%s%c", layer ? layer : "", layer ? "." : "", "RGB"[c]);
        planes[c] = sl_image_channel(image, name);
        whole = whole && planes[c];
    }
    return whole;
}

bool sl_picture_planes(const sl_image *image, const float *planes[3]) {
    const float *gray = sl_image_channel(image, "Y");
    if (sl_layer_planes(image, NULL, planes)) return true;
    for (int c = 0; c < 3; c++) planes[c] = gray;
    return gray != NULL;
}

/* Reinhard et al., "Photographic tone reproduction for digital images" (2002), equation 1 without its small
 * constant: black pixels are left out instead, so that the result scales exactly with the image. */
static double log_average_luminance(const float *const planes[3], size_t pixels) {
    double sum = 0.0;
    size_t count = 0;
    for (size_t i = 0; i < pixels; i++) {
        double luminance =
            0.2126 * (double)planes[0][i] + 0.7152 * (double)planes[1][i] + 0.0722 * (double)planes[2][i];
        if (!(luminance > 0.0) || isinf(luminance)) continue;
        sum += sl_log(luminance);
        count++;
    }
    return count ? sl_exp(sum / (double)count) : 0.18;
}

static double exposure_of(const sl_image *image, sl_tone tone) {
    const float *planes[3];
    double factor = sl_pow(2.0, (double)tone.exposure_stops);
    if (!tone.automatic || !sl_picture_planes(image, planes)) return factor;
    return factor * (0.18 / log_average_luminance(planes, (size_t)image->width * (size_t)image->height));
}

/* Reinhard's equation 4 for each channel, the smallest value that becomes white being 4. */
static double apply_curve(sl_tone_curve curve, double x) {
    const double white = 4.0;
    if (curve == SL_TONE_CLIP) return x;
    return x * (1.0 + x / (white * white)) / (1.0 + x);
}

/* Returns the least value that the curve takes to y: the root of its quadratic, to the last bit. */
static double before_curve(sl_tone_curve curve, double y) {
    if (curve == SL_TONE_CLIP) return y;
    double x = 8.0 * (y - 1.0 + sqrt((1.0 - y) * (1.0 - y) + 0.25 * y));
    while (apply_curve(curve, x) >= y) x = nextafter(x, 0.0);
    while (apply_curve(curve, x) < y) x = nextafter(x, INFINITY);
    return x;
}

/* borders[i]: the exposed value at which the encoded value passes from code i to code i + 1, so that rounding
 * to the nearest code is a search for the number of borders at or below a value. */
static void find_code_borders(sl_tone_curve curve, double borders[256]) {
    for (int i = 0; i < 255; i++)
        borders[i] = before_curve(curve, (double)sl_srgb_decode(((float)i + 0.5f) / 255.0f));
    borders[255] = INFINITY;
}

static uint8_t nearest_code(const double borders[256], double x) {
    unsigned code = 0;
    for (unsigned step = 128; step > 0; step /= 2) {
        if (code + step <= 255 && x >= borders[code + step - 1]) code += step; /* NaN passes no border */
    }
    return (uint8_t)code;
}

/* The code at the low end of each of 128 steps of a doubling, from 2^-13 on to 4, which is white: from there
 * to the code of a value it is at most one border, since a doubling holds 68 of them. A value's step stands
 * in its bits. */
enum {
    BELOW = 13,
    OCTAVES = BELOW + 2,
    STEP_BITS = 45,
    STEPS = OCTAVES * 128,
    FIRST_STEP = (1023 - BELOW) << 7
};

static void find_first_codes(const double borders[256], uint8_t first[STEPS]) {
    for (uint64_t i = 0; i < STEPS; i++) {
        const uint64_t bits = (FIRST_STEP + i) << STEP_BITS;
        double low;
        memcpy(&low, &bits, sizeof low);
        first[i] = nearest_code(borders, low);
    }
}

/* Without branches, which nobody could guess. */
static uint8_t code_of(const double borders[256], const uint8_t first[STEPS], double x) {
    uint64_t bits;
    x = x >= 0x1p-13 ? x : 0x1p-13; /* below the first border; NaN, too */
    x = x < 4.0 ? x : 0x1.fffffffffffffp+1;
    memcpy(&bits, &x, sizeof bits);
    const unsigned code = first[(bits >> STEP_BITS) - FIRST_STEP];
    return (uint8_t)(code + (x >= borders[code]));
}

static void map_planes(const float *const planes[3], size_t pixels, double exposure, sl_tone_curve curve,
                       uint8_t *mapped) {
    double borders[256];
    uint8_t first[STEPS];
    find_code_borders(curve, borders);
    find_first_codes(borders, first);
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < pixels; i++) {
            const double x = (double)planes[c][i] * exposure;
            mapped[3 * i + c] = code_of(borders, first, x);
        }
    }
}

/* Finite, though the exposure may be 0 or infinite: what is further off is that, too. */
static double stops_of(double exposure) {
    const double most = 4096.0, stops = sl_log(exposure) * 1.4426950408889634;
    return fmin(fmax(stops, -most), most);
}

double sl_tone_stops(const sl_image *image, sl_tone tone) {
    return tone.automatic ? stops_of(exposure_of(image, tone)) : (double)tone.exposure_stops;
}

const char *sl_tone_curve_name(size_t index) {
    static const char *const names[] = {"clip", "reinhard"}; /* as sl_tone_curve */
    return index < sizeof names / sizeof *names ? names[index] : NULL;
}

static sl_status check_tone(sl_tone tone, sl_error *error) {
    if (!isfinite(tone.exposure_stops))
        return sl_fail(error, SL_ERROR_USAGE, "expected a finite exposure, got %g",
                       (double)tone.exposure_stops);
    if (tone.curve == SL_TONE_CLIP || tone.curve == SL_TONE_REINHARD) return SL_OK;
    return sl_fail(error, SL_ERROR_USAGE, "there is no tone curve %d", (int)tone.curve);
}

sl_status sl_image_srgb(const sl_image *image, sl_tone *tone, uint8_t *bytes, sl_error *error) {
    if (!image || !tone || !bytes) return sl_fail_null(error, "an image, a tone and room for bytes");
    const float *planes[3];
    sl_status status = check_tone(*tone, error);
    if (status != SL_OK) return status;
    if (!sl_picture_planes(image, planes))
        return sl_fail(error, SL_ERROR_USAGE,
                       "a PNG needs the channels R, G, B or Y, which the image does not have");
    double exposure = exposure_of(image, *tone);
    if (tone->automatic) *tone = (sl_tone){tone->curve, (float)stops_of(exposure), false};
    map_planes(planes, (size_t)image->width * (size_t)image->height, exposure, tone->curve, bytes);
    return SL_OK;
}
