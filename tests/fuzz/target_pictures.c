/* Pictures of every kind: as textures, as images, compared and tone mapped. */
#include "support.h"

#include "image/formats.h"
#include "scene/model.h"

#include <stdlib.h>
#include <string.h>

enum { COMPARED_PIXELS = 4096 };

static void check_texture(const uint8_t *data, size_t size) {
    sl_model model = {0};
    uint32_t index;
    sl_error error = {0};
    sl_status status = sl_model_texture(&model, "t", data, size, &index, &error);
    if (status != SL_OK) fuzz_check_error(&error);
    else if (index == SL_NO_INDEX && !model.scene.warning_count)
        fuzz_fail("a texture left out without a word");
    sl_model_clear(&model);
}

static void compare(const sl_image *image) {
    sl_image *difference = NULL, *other = NULL;
    sl_comparison result;
    sl_error error = {0};
    sl_compare_options options = {.exposure_stops = 1.0f};
    if (sl_image_compare(image, image, &options, &result, &difference, &error) != SL_OK)
        fuzz_check_error(&error);
    else if (result.rmse != 0.0) fuzz_fail("a picture that differs from itself");
    sl_image_destroy(difference);
    error = (sl_error){0};
    if (sl_image_create(image->width, image->height, 3, NULL, &other, &error) != SL_OK) return;
    for (size_t i = 0; i < 3 * (size_t)image->width * (size_t)image->height; i++)
        other->planes[i] = 0.25f * (float)(i % 5);
    difference = NULL;
    if (sl_image_compare(image, other, NULL, &result, &difference, &error) != SL_OK) fuzz_check_error(&error);
    sl_image_destroy(difference);
    sl_image_destroy(other);
}

/* Written and read again, a picture is the same, bit for bit. */
static void write_and_read(const sl_image *image) {
    static const char *const names[] = {"p.exr", "p.pfm"};
    for (int i = 0; i < 2; i++) {
        sl_image *again = NULL;
        sl_error error = {0};
        fuzz_write(names[i], "", 0);
        if (sl_image_write(image, fuzz_path(names[i]), &error) != SL_OK) {
            fuzz_check_error(&error);
            continue;
        }
        if (sl_image_read(fuzz_path(names[i]), &again, &error) != SL_OK) fuzz_fail(error.message);
        for (int c = 0; c < again->channels; c++) {
            const float *before = sl_image_channel(image, again->channel_name[c]),
                        *after = sl_image_channel(again, again->channel_name[c]);
            size_t bytes = (size_t)image->width * (size_t)image->height * sizeof(float);
            if (before && memcmp(before, after, bytes) != 0)
                fuzz_fail("a picture that is another after writing and reading");
        }
        sl_image_destroy(again);
    }
}

static void tone_map(const sl_image *image) {
    sl_tone tone = {SL_TONE_REINHARD, 0.0f, true};
    sl_error error = {0};
    uint8_t *bytes = malloc(3 * (size_t)image->width * (size_t)image->height);
    if (bytes && sl_image_srgb(image, &tone, bytes, &error) != SL_OK) fuzz_check_error(&error);
    free(bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    sl_bytes bytes = {"picture", (uint8_t *)(uintptr_t)data, size};
    sl_image *image = NULL;
    sl_error error = {0};
    check_texture(data, size);
    if (sl_image_decode(&bytes, &image, &error) != SL_OK) {
        fuzz_check_error(&error);
        if (image) fuzz_fail("a picture in spite of an error");
        return 0;
    }
    if ((int64_t)image->width * image->height <= COMPARED_PIXELS) {
        compare(image);
        tone_map(image);
        if (fuzz_hash(data, size) % 8 == 0) write_and_read(image);
    }
    sl_image_destroy(image);
    return 0;
}
