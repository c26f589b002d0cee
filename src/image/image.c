/* The image itself: planes of floats with names, and strings that say where they came from. */

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "image/formats.h"
#include "image/unset.h"

#include <stdlib.h>
#include <string.h>

/* 2^31 floats are 8 GiB: what is larger is a mistake in the caller or a damaged file, not a picture. */
static const uint64_t most_values = (uint64_t)1 << 31;

static const char *default_channel_name(int channels, int channel) {
    static const char *const rgb[3] = {"R", "G", "B"};
    if (channels == 1) return "Y";
    return channels == 3 ? rgb[channel] : NULL;
}

static sl_status check_size(int width, int height, int channels, sl_error *error) {
    if (width < 1 || height < 1 || channels < 1)
        return sl_fail(error, SL_ERROR_USAGE, "an image cannot be %d x %d pixels with %d channels", width,
                       height, channels);
    uint64_t pixels = (uint64_t)width * (uint64_t)height;
    if (pixels > most_values / (uint64_t)channels)
        return sl_fail(error, SL_ERROR_RESOURCES, "an image of %d x %d pixels with %d channels is too large",
                       width, height, channels);
    return SL_OK;
}

static sl_status fail_nameless(int channels, sl_error *error) {
    return sl_fail(error, SL_ERROR_USAGE, "an image of %d channels needs their names", channels);
}

static int compare_names(const void *a, const void *b) {
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

const char **sl_image_sorted_names(const sl_image *image) {
    const char **names = sl_allocate((size_t)image->channels, sizeof *names);
    for (int c = 0; names && c < image->channels; c++) names[c] = image->channel_name[c];
    if (names) qsort(names, (size_t)image->channels, sizeof *names, compare_names);
    return names;
}

/* Sorted, since there may be tens of thousands. */
static sl_status check_distinct(const sl_image *image, sl_error *error) {
    const char *twice = NULL, **sorted = sl_image_sorted_names(image);
    if (!sorted) return sl_fail_memory(error, "an image");
    for (int c = 1; c < image->channels && !twice; c++)
        twice = strcmp(sorted[c - 1], sorted[c]) == 0 ? sorted[c] : NULL;
    sl_free(sorted);
    return twice ? sl_fail(error, SL_ERROR_USAGE, "two channels are called '%s'", twice) : SL_OK;
}

static sl_status name_channels(sl_image *image, const char *const *names, sl_error *error) {
    for (int c = 0; c < image->channels; c++) {
        const char *name = names ? names[c] : default_channel_name(image->channels, c);
        if (!name) return fail_nameless(image->channels, error);
        size_t length = strlen(name);
        if (length == 0 || length >= SL_CHANNEL_NAME_MAX)
            return sl_fail(error, SL_ERROR_USAGE, "a channel name has 1 to %d bytes, '%s' has %zu",
                           SL_CHANNEL_NAME_MAX - 1, name, length);
        memcpy(image->channel_name[c], name, length + 1);
    }
    return check_distinct(image, error);
}

static sl_status create(int width, int height, int channels, const char *const *channel_names, bool clear,
                        sl_image **image, sl_error *error) {
    if (!image) return sl_fail_null(error, "a place for an image");
    *image = NULL;
    sl_status status = check_size(width, height, channels, error);
    if (status != SL_OK) return status;
    /* however many: before any memory is taken */
    if (!channel_names && !default_channel_name(channels, 0)) return fail_nameless(channels, error);
    sl_image *created = sl_allocate(1, sizeof *created);
    if (!created) return sl_fail_memory(error, "an image");
    created->width = width;
    created->height = height;
    created->channels = channels;
    created->channel_name = sl_allocate((size_t)channels, sizeof *created->channel_name);
    const size_t values = (size_t)width * (size_t)height * (size_t)channels;
    created->planes = clear ? sl_allocate(values, sizeof *created->planes)
                            : sl_allocate_unset(values, sizeof *created->planes);
    if (!created->channel_name || !created->planes) status = sl_fail_memory(error, "an image");
    else status = name_channels(created, channel_names, error);
    if (status == SL_OK) *image = created;
    else sl_image_destroy(created);
    return status;
}

sl_status sl_image_create(int width, int height, int channels, const char *const *channel_names,
                          sl_image **image, sl_error *error) {
    return create(width, height, channels, channel_names, true, image, error);
}

sl_status sl_image_create_unset(int width, int height, int channels, const char *const *channel_names,
                                sl_image **image, sl_error *error) {
    return create(width, height, channels, channel_names, false, image, error);
}

void sl_image_clear(sl_image *image) {
    memset(image->planes, 0, (size_t)image->width * (size_t)image->height * (size_t)image->channels *
                                 sizeof *image->planes);
}

void sl_image_destroy(sl_image *image) {
    if (!image) return;
    for (size_t i = 0; i < image->metadata_count; i++) sl_free(image->metadata[i].value);
    SL_FREE_ALL(image->metadata, image->channel_name, image->planes, image);
}

float *sl_image_channel(const sl_image *image, const char *name) {
    size_t plane = (size_t)image->width * (size_t)image->height;
    for (int c = 0; c < image->channels; c++) {
        if (strcmp(image->channel_name[c], name) == 0) return image->planes + (size_t)c * plane;
    }
    return NULL;
}

static sl_metadatum *find_metadatum(const sl_image *image, const char *key) {
    for (size_t i = 0; i < image->metadata_count; i++) {
        if (strcmp(image->metadata[i].key, key) == 0) return &image->metadata[i];
    }
    return NULL;
}

sl_status sl_image_set_metadata(sl_image *image, const char *key, const char *value, sl_error *error) {
    if (!image || !key || !value) return sl_fail_null(error, "an image, a key and its value");
    size_t key_length = strlen(key);
    if (key_length == 0 || key_length >= SL_METADATA_KEY_MAX)
        return sl_fail(error, SL_ERROR_USAGE, "a metadata key has 1 to %d bytes, '%s' has %zu",
                       SL_METADATA_KEY_MAX - 1, key, key_length);
    char *copy = sl_copy_of(value, strlen(value) + 1, 1);
    sl_metadatum *datum = find_metadatum(image, key);
    const size_t count = image->metadata_count;
    if (!copy || (!datum && !sl_regrow(&image->metadata, count, count + 1, sizeof *image->metadata))) {
        sl_free(copy);
        return sl_fail_memory(error, "metadata");
    }
    if (!datum) {
        datum = &image->metadata[image->metadata_count++];
        memcpy(datum->key, key, key_length + 1);
    }
    sl_free(datum->value);
    datum->value = copy;
    return SL_OK;
}

const char *sl_image_metadata(const sl_image *image, const char *key) {
    const sl_metadatum *datum = find_metadatum(image, key);
    return datum ? datum->value : NULL;
}
