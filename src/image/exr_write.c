/* Writing OpenEXR through its C library: 32-bit floats, ZIP-compressed scan lines, all metadata as strings.
 * The same image gives the same bytes: nothing but the image goes into the file. */
#include "image/formats.h"

#include "base/error.h"
#include "base/memory.h"

#include <openexr.h>
#include <stdio.h>
#include <string.h>

typedef struct exr_sink {
    sl_output_file *file;
    sl_status status; /* of the file itself */
    sl_error *error;
} exr_sink;

/* It may hold its own lock while it complains, and a handler that asked it for anything would wait for ever:
 * so its result codes have to do, and it must not print. */
static void on_error(exr_const_context_t context, exr_result_t code, const char *message) {
    (void)context, (void)code, (void)message;
}

static int64_t sink_write(exr_const_context_t context, void *user, const void *from, uint64_t count,
                          uint64_t offset, exr_stream_error_func_ptr_t report) {
    exr_sink *sink = user;
    if (sink->status == SL_OK)
        sink->status = sl_output_write_at(sink->file, from, count, offset, sink->error);
    (void)context;
    (void)report; /* it would wait for the lock that is held while this is called */
    return sink->status == SL_OK ? (int64_t)count : -1;
}

/* ---- the header ------------------------------------------------------------------------------ */

static exr_result_t add_channels(exr_context_t context, const char *const *names, int count) {
    exr_result_t result = EXR_ERR_SUCCESS;
    for (int c = 0; c < count && result == EXR_ERR_SUCCESS; c++)
        result = exr_add_channel(context, 0, names[c], EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    return result;
}

/* Of a channel by its place among the sorted ones. */
static const float *plane_of(const sl_image *image, const char *const *names, int c) {
    size_t channel = (size_t)(names[c] - image->channel_name[0]) / SL_CHANNEL_NAME_MAX;
    return image->planes + channel * (size_t)image->width * (size_t)image->height;
}

static exr_result_t add_metadata(exr_context_t context, const sl_image *image) {
    exr_result_t result = EXR_ERR_SUCCESS;
    for (size_t i = 0; i < image->metadata_count && result == EXR_ERR_SUCCESS; i++)
        result = exr_attr_set_string(context, 0, image->metadata[i].key, image->metadata[i].value);
    return result;
}

/* The names that OpenEXR has a meaning for: under one of the first fifteen a string of ours would make the
 * file unreadable; the others are its standard attributes of other types (up to 3.4), which readers take for
 * these. */
static const char *reserved_key(const sl_image *image) {
    static const char reserved[] =
        " channels compression dataWindow displayWindow lineOrder pixelAspectRatio"
        " screenWindowCenter screenWindowWidth name type version chunkCount tiles view"
        " maxSamplesPerPixel adoptedNeutral altitude aperture cameraCCTSetting cameraColorBalance"
        " cameraTintSetting captureRate chromaticities deepImageState dwaCompressionLevel"
        " effectiveFocalLength entrancePupilOffset envmap expTime focus framesPerSecond"
        " idManifest imageCounter isoSpeed keyCode latitude longitude multiView"
        " nominalFocalLength originalDataWindow pinholeFocalLength preview"
        " sensorAcquisitionRectangle sensorCenterOffset sensorOverallDimensions"
        " sensorPhotositePitch shutterAngle tStop timeCode utcOffset whiteLuminance worldToCamera"
        " worldToNDC xDensity ";
    for (size_t i = 0; i < image->metadata_count; i++) {
        char word[SL_METADATA_KEY_MAX + 2];
        snprintf(word, sizeof word, " %s ", image->metadata[i].key);
        if (!strchr(image->metadata[i].key, ' ') && strstr(reserved, word)) return image->metadata[i].key;
    }
    return NULL;
}

static exr_result_t write_header(exr_context_t context, const sl_image *image, const char *const *names) {
    int part;
    /* names of up to 255 bytes; only a version flag if unused */
    exr_result_t result = exr_set_longname_support(context, 1);
    if (result == EXR_ERR_SUCCESS) result = exr_add_part(context, NULL, EXR_STORAGE_SCANLINE, &part);
    if (result == EXR_ERR_SUCCESS) {
        exr_attr_box2i_t window = {.min = {.x = 0, .y = 0},
                                   .max = {.x = image->width - 1, .y = image->height - 1}};
        exr_attr_v2f_t centre = {.x = 0.0f, .y = 0.0f};
        result = exr_initialize_required_attr(context, 0, &window, &window, 1.0f, &centre, 1.0f,
                                              EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP);
    }
    if (result == EXR_ERR_SUCCESS) result = add_channels(context, names, image->channels);
    if (result == EXR_ERR_SUCCESS) result = add_metadata(context, image);
    return result == EXR_ERR_SUCCESS ? exr_write_header(context) : result;
}

/* ---- pixels ---------------------------------------------------------------------------------- */

typedef exr_result_t compress_function(exr_encode_pipeline_t *encoder);

/* A chunk as long as its pixels means that it is stored and not compressed. OpenEXR 3.1's C library forgets
 * this where the compressed form happens to have just that length, and nobody could read the file; so its
 * step is wrapped. */
static exr_result_t compress_or_store(exr_encode_pipeline_t *encoder) {
    compress_function *const *compress = encoder->encoding_user_data;
    exr_result_t result = (*compress)(encoder);
    if (result == EXR_ERR_SUCCESS && encoder->compressed_bytes >= encoder->packed_bytes) {
        memmove(encoder->compressed_buffer, encoder->packed_buffer, encoder->packed_bytes);
        encoder->compressed_bytes = encoder->packed_bytes;
    }
    return result;
}

static exr_result_t encode_chunk(exr_context_t context, const sl_image *image, const char *const *names,
                                 int y, exr_encode_pipeline_t *encoder, compress_function **compress) {
    exr_chunk_info_t info;
    exr_result_t result = exr_write_scanline_chunk_info(context, 0, y, &info);
    if (result != EXR_ERR_SUCCESS) return result;
    bool first = encoder->channels == NULL;
    result = first ? exr_encoding_initialize(context, 0, &info, encoder)
                   : exr_encoding_update(context, 0, &info, encoder);
    if (result != EXR_ERR_SUCCESS) return result;
    for (int c = 0; c < encoder->channel_count; c++) {
        exr_coding_channel_info_t *channel = &encoder->channels[c];
        const float *plane = plane_of(image, names, c); /* the file has them in the order of their names */
        channel->encode_from_ptr = (const uint8_t *)(plane + (size_t)y * (size_t)image->width);
        channel->user_bytes_per_element = 4;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 4;
        channel->user_line_stride = 4 * image->width;
    }
    if (first) {
        result = exr_encoding_choose_default_routines(context, 0, encoder);
        *compress = encoder->compress_fn;
        encoder->encoding_user_data = compress;
        encoder->compress_fn = compress_or_store;
    }
    return result == EXR_ERR_SUCCESS ? exr_encoding_run(context, 0, encoder) : result;
}

static exr_result_t write_pixels(exr_context_t context, const sl_image *image, const char *const *names) {
    int32_t lines;
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    compress_function *compress = NULL;
    exr_result_t result = exr_get_scanlines_per_chunk(context, 0, &lines);
    for (int y = 0; y < image->height && result == EXR_ERR_SUCCESS; y += lines)
        result = encode_chunk(context, image, names, y, &encoder, &compress);
    if (encoder.channels) exr_encoding_destroy(context, &encoder);
    return result;
}

sl_status sl_exr_write(const sl_image *image, sl_output_file *file, sl_error *error) {
    const char *reserved = reserved_key(image);
    if (reserved)
        return sl_fail(error, SL_ERROR_USAGE,
                       "cannot write %s: '%s' has a meaning of its own in EXR and cannot be metadata",
                       file->name, reserved);
    exr_sink sink = {.file = file, .status = SL_OK, .error = error};
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.error_handler_fn = on_error;
    start.user_data = &sink;
    start.write_fn = sink_write;
    start.zip_level = 4; /* said, so that the bytes do not change with the library's defaults */
    exr_context_t context = NULL;
    const char **names = sl_image_sorted_names(image); /* in OpenEXR's order */
    exr_result_t result = names ? exr_start_write(&context, file->name, EXR_WRITE_FILE_DIRECTLY, &start)
                                : EXR_ERR_OUT_OF_MEMORY;
    if (result == EXR_ERR_SUCCESS) result = write_header(context, image, names);
    if (result == EXR_ERR_SUCCESS) result = write_pixels(context, image, names);
    sl_free(names);
    if (context) {
        exr_result_t finished = exr_finish(&context); /* writes the table of chunks */
        if (result == EXR_ERR_SUCCESS) result = finished;
    }
    if (result != EXR_ERR_SUCCESS && sink.status == SL_OK)
        sink.status = result == EXR_ERR_OUT_OF_MEMORY
                          ? sl_fail_memory(error, file->name)
                          : sl_fail(error, SL_ERROR_OUTPUT, "cannot write %s: %s", file->name,
                                    exr_get_default_error_message(result));
    return sink.status;
}
