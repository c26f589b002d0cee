/* Reading OpenEXR through its C library. The picture is the display window: what the data window leaves of it
 * is black, and data outside it is dropped. */
#include "image/formats.h"

#include "base/error.h"
#include "base/memory.h"

#include <math.h>
#include <openexr.h>
#include <stdio.h>
#include <string.h>

/* ---- the library's view of the bytes --------------------------------------------------------- */

typedef struct exr_source {
    const sl_bytes *bytes;
    char reason[256]; /* the first thing that the library complained about */
    bool starved;     /* ... or anything was want of memory */
} exr_source;

static void on_error(exr_const_context_t context, exr_result_t code, const char *message) {
    exr_source *source = NULL;
    if (!context || exr_get_user_data(context, (void **)&source) != EXR_ERR_SUCCESS || !source) return;
    if (code == EXR_ERR_OUT_OF_MEMORY) source->starved = true;
    if (!source->reason[0]) snprintf(source->reason, sizeof source->reason, "%s", message);
}

static int64_t source_size(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((exr_source *)user)->bytes->size;
}

/* The library reads its header in large steps and expects what there is; it checks for itself where it needs
 * all. */
static int64_t source_read(exr_const_context_t context, void *user, void *to, uint64_t count, uint64_t offset,
                           exr_stream_error_func_ptr_t report) {
    const sl_bytes *bytes = ((exr_source *)user)->bytes;
    (void)context, (void)report;
    if (offset >= bytes->size) return 0;
    if (count > bytes->size - offset) count = bytes->size - offset;
    memcpy(to, bytes->data + offset, count);
    return (int64_t)count;
}

/* ---- what is in the file --------------------------------------------------------------------- */

typedef struct exr_reader {
    exr_context_t context;
    exr_source source;
    exr_attr_box2i_t data, display;
    int64_t data_width, data_height;
    const exr_attr_chlist_t *channels;
    int *plane;       /* of each channel of the file */
    int gray;         /* the channel that is copied to R, G and B, or -1 */
    int32_t chunk_width, chunk_height;
    uint8_t *chunk;   /* one plane of chunk_width * chunk_height 4-byte values for each channel */
    sl_image *image;
} exr_reader;

bool sl_exr_recognise(const sl_bytes *bytes) {
    static const uint8_t magic[4] = {0x76, 0x2f, 0x31, 0x01};
    return bytes->size >= 4 && memcmp(bytes->data, magic, 4) == 0;
}

/* Unsupported: compressions of which the C library learnt late. */
static sl_status fail_reading(const exr_reader *reader, sl_error *error) {
    if (reader->source.starved || sl_memory_has_ended())
        return sl_fail_memory(error, reader->source.bytes->path);
    return sl_fail(error, SL_ERROR_INPUT, "%s: damaged or unsupported EXR: %s", reader->source.bytes->path,
                   reader->source.reason[0] ? reader->source.reason : "unreadable");
}

static int64_t box_width(const exr_attr_box2i_t *box) { return (int64_t)box->max.x - box->min.x + 1; }
static int64_t box_height(const exr_attr_box2i_t *box) { return (int64_t)box->max.y - box->min.y + 1; }

static sl_status check_storage(exr_reader *reader, sl_error *error) {
    exr_storage_t storage;
    const char *path = reader->source.bytes->path;
    if (exr_get_storage(reader->context, 0, &storage) != EXR_ERR_SUCCESS) return fail_reading(reader, error);
    if (storage == EXR_STORAGE_DEEP_SCANLINE || storage == EXR_STORAGE_DEEP_TILED)
        return sl_fail(error, SL_ERROR_INPUT, "%s: deep EXR pictures are not supported", path);
    for (int c = 0; c < reader->channels->num_channels; c++) {
        const exr_attr_chlist_entry_t *channel = &reader->channels->entries[c];
        if (channel->x_sampling != 1 || channel->y_sampling != 1)
            return sl_fail(error, SL_ERROR_INPUT, "%s: channel %s is subsampled, which is not supported",
                           path, channel->name.str);
        if (channel->name.length >= SL_CHANNEL_NAME_MAX)
            return sl_fail(error, SL_ERROR_INPUT, "%s: a channel's name is longer than %d bytes", path,
                           SL_CHANNEL_NAME_MAX - 1);
    }
    return SL_OK;
}

static sl_status read_header(exr_reader *reader, sl_error *error) {
    if (exr_get_data_window(reader->context, 0, &reader->data) != EXR_ERR_SUCCESS ||
        exr_get_display_window(reader->context, 0, &reader->display) != EXR_ERR_SUCCESS ||
        exr_get_channels(reader->context, 0, &reader->channels) != EXR_ERR_SUCCESS ||
        reader->channels->num_channels < 1) {
        return fail_reading(reader, error);
    }
    sl_status status = check_storage(reader, error);
    /* Wavelets can pack a plain picture almost without limit, so the bound is only against nonsense. */
    const uint64_t expansion = 1 << 15;
    reader->data_width = box_width(&reader->data);
    reader->data_height = box_height(&reader->data);
    if (status == SL_OK)
        status = sl_check_claimed_size(reader->source.bytes, reader->data_width, reader->data_height,
                                           reader->channels->num_channels, expansion, error);
    if (status == SL_OK)
        status = sl_check_claimed_size(reader->source.bytes, box_width(&reader->display),
                                           box_height(&reader->display), reader->channels->num_channels,
                                           expansion, error);
    return status;
}

/* ---- channels and metadata ------------------------------------------------------------------- */

static int find_channel(const exr_attr_chlist_t *channels, const char *name) {
    for (int c = 0; c < channels->num_channels; c++) {
        if (strcmp(channels->entries[c].name.str, name) == 0) return c;
    }
    return -1;
}

/* R, G, B come first; the others follow as in the file, alphabetically. */
static int order_channels(exr_reader *reader, const char **names) {
    static const char *const picture[3] = {"R", "G", "B"};
    int count = 0;
    for (int c = 0; c < reader->channels->num_channels; c++) reader->plane[c] = -1;
    for (int c = 0; c < 3; c++) {
        int channel = find_channel(reader->channels, picture[c]);
        if (channel < 0) continue;
        names[count] = picture[c];
        reader->plane[channel] = count++;
    }
    reader->gray = -1;
    if (count == 0) {
        reader->gray = find_channel(reader->channels, "Y");
        if (reader->gray < 0) reader->gray = find_channel(reader->channels, "L");
    }
    if (reader->gray >= 0) {
        for (int c = 0; c < 3; c++) names[count++] = picture[c];
        reader->plane[reader->gray] = 0;
    }
    for (int c = 0; c < reader->channels->num_channels; c++) {
        if (reader->plane[c] >= 0) continue;
        names[count] = reader->channels->entries[c].name.str;
        reader->plane[c] = count++;
    }
    return count;
}

static sl_status create_image(exr_reader *reader, sl_error *error) {
    size_t stored = (size_t)reader->channels->num_channels;
    const char *path = reader->source.bytes->path;
    reader->plane = sl_allocate(stored, sizeof *reader->plane);
    const char **names = sl_allocate(stored + 2, sizeof *names);
    sl_error detail;
    sl_status status = SL_OK;
    if (!reader->plane || !names) {
        status = sl_fail_memory(error, path);
    } else {
        int count = order_channels(reader, names);
        status = sl_image_create((int)box_width(&reader->display), (int)box_height(&reader->display), count,
                                 names, &reader->image, &detail);
        if (status != SL_OK)
            status = sl_fail(error, status == SL_ERROR_USAGE ? SL_ERROR_INPUT : status, "%s: %s", path,
                             detail.message);
    }
    sl_free(names);
    return status;
}

static sl_status copy_metadata(exr_reader *reader, sl_error *error) {
    int32_t count = 0;
    if (exr_get_attribute_count(reader->context, 0, &count) != EXR_ERR_SUCCESS)
        return fail_reading(reader, error);
    for (int32_t i = 0; i < count; i++) {
        const exr_attribute_t *attribute;
        if (exr_get_attribute_by_index(reader->context, 0, EXR_ATTR_LIST_FILE_ORDER, i, &attribute) !=
            EXR_ERR_SUCCESS) {
            return fail_reading(reader, error);
        }
        /* "name" and "type" describe the part of the file, not the picture. */
        if (attribute->type != EXR_ATTR_STRING || !attribute->string->str || strlen(attribute->name) == 0 ||
            strlen(attribute->name) >= SL_METADATA_KEY_MAX || strcmp(attribute->name, "name") == 0 ||
            strcmp(attribute->name, "type") == 0) {
            continue;
        }
        sl_status status =
            sl_image_set_metadata(reader->image, attribute->name, attribute->string->str, error);
        if (status != SL_OK) return status;
    }
    return SL_OK;
}

/* ---- pixels ---------------------------------------------------------------------------------- */

/* Copies what of a decoded chunk, whose first pixel is (x0, y0), lies in the display window. */
static void place_chunk(const exr_reader *reader, const exr_decode_pipeline_t *decoder, int64_t x0,
                        int64_t y0) {
    const sl_image *image = reader->image;
    size_t chunk_plane = (size_t)reader->chunk_width * (size_t)reader->chunk_height * 4;
    size_t plane = (size_t)image->width * (size_t)image->height;
    for (int c = 0; c < decoder->channel_count; c++) {
        const exr_coding_channel_info_t *channel = &decoder->channels[c];
        int64_t left = x0 - reader->display.min.x, first = left < 0 ? -left : 0;
        int64_t end = channel->width < image->width - left ? channel->width : image->width - left;
        for (int32_t row = 0; row < channel->height; row++) {
            int64_t y = y0 + row - reader->display.min.y;
            if (y < 0 || y >= image->height || end <= first) continue;
            const uint8_t *from =
                reader->chunk + (size_t)c * chunk_plane + (size_t)row * (size_t)channel->user_line_stride;
            float *to =
                image->planes + (size_t)reader->plane[c] * plane + (size_t)(y * image->width + left + first);
            for (int64_t i = first; i < end; i++, to++) {
                uint32_t whole;
                memcpy(&whole, from + 4 * i, sizeof whole);
                if (channel->data_type == EXR_PIXEL_UINT) *to = (float)whole;
                else memcpy(to, &whole, sizeof whole);
            }
        }
    }
}

static bool decode_chunk(exr_reader *reader, const exr_chunk_info_t *info, exr_decode_pipeline_t *decoder) {
    if (info->width > reader->chunk_width || info->height > reader->chunk_height) return false;
    exr_result_t result = decoder->channels ? exr_decoding_update(reader->context, 0, info, decoder)
                                            : exr_decoding_initialize(reader->context, 0, info, decoder);
    if (result != EXR_ERR_SUCCESS || decoder->channel_count != reader->channels->num_channels) return false;
    size_t chunk_plane = (size_t)reader->chunk_width * (size_t)reader->chunk_height * 4;
    for (int c = 0; c < decoder->channel_count; c++) {
        exr_coding_channel_info_t *channel = &decoder->channels[c];
        channel->decode_to_ptr = reader->chunk + (size_t)c * chunk_plane;
        channel->user_pixel_stride = channel->user_bytes_per_element = 4;
        channel->user_data_type =
            channel->data_type == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        channel->user_line_stride = 4 * channel->width;
    }
    /* The choice depends on the size of the chunk's rows, which differs in the last tile of a row. */
    return exr_decoding_choose_default_routines(reader->context, 0, decoder) == EXR_ERR_SUCCESS &&
           exr_decoding_run(reader->context, 0, decoder) == EXR_ERR_SUCCESS;
}

static exr_result_t find_chunk(const exr_reader *reader, bool tiled, int column, int row, int y,
                               exr_chunk_info_t *info) {
    return tiled ? exr_read_tile_chunk_info(reader->context, 0, column, row, 0, 0, info)
                 : exr_read_scanline_chunk_info(reader->context, 0, y, info);
}

/* Chunks are tiles, or as wide as the picture. */
static bool read_chunks(exr_reader *reader, bool tiled, exr_decode_pipeline_t *decoder) {
    const int64_t across = (reader->data_width + reader->chunk_width - 1) / reader->chunk_width,
                  down = (reader->data_height + reader->chunk_height - 1) / reader->chunk_height;
    for (int64_t i = 0; i < across * down; i++) {
        const int64_t x = reader->data.min.x + i % across * reader->chunk_width,
                      y = reader->data.min.y + i / across * reader->chunk_height;
        exr_chunk_info_t info;
        if (find_chunk(reader, tiled, (int)(i % across), (int)(i / across), (int)y, &info) !=
                EXR_ERR_SUCCESS ||
            !decode_chunk(reader, &info, decoder))
            return false;
        place_chunk(reader, decoder, x, y);
    }
    return true;
}

static sl_status read_pixels(exr_reader *reader, sl_error *error) {
    exr_storage_t storage;
    exr_get_storage(reader->context, 0, &storage);
    bool tiled = storage == EXR_STORAGE_TILED;
    exr_result_t result;
    if (tiled) {
        result = exr_get_tile_sizes(reader->context, 0, 0, 0, &reader->chunk_width, &reader->chunk_height);
    } else {
        reader->chunk_width = (int32_t)reader->data_width;
        result = exr_get_scanlines_per_chunk(reader->context, 0, &reader->chunk_height);
    }
    if (result != EXR_ERR_SUCCESS || reader->chunk_width < 1 || reader->chunk_height < 1)
        return fail_reading(reader, error);
    if (reader->chunk_width > reader->data_width) reader->chunk_width = (int32_t)reader->data_width;
    if (tiled && reader->chunk_height > reader->data_height)
        reader->chunk_height = (int32_t)reader->data_height;
    size_t chunk_values = (size_t)reader->chunk_width * (size_t)reader->chunk_height;
    reader->chunk = sl_allocate(chunk_values * (size_t)reader->channels->num_channels, 4);
    if (!reader->chunk) return sl_fail_memory(error, reader->source.bytes->path);
    exr_decode_pipeline_t decoder = EXR_DECODE_PIPELINE_INITIALIZER;
    bool done = read_chunks(reader, tiled, &decoder);
    if (decoder.channels) exr_decoding_destroy(reader->context, &decoder);
    return done ? SL_OK : fail_reading(reader, error);
}

static void spread_gray(const exr_reader *reader) {
    size_t plane = (size_t)reader->image->width * (size_t)reader->image->height;
    float *planes = reader->image->planes;
    for (size_t c = 1; c < 3; c++) memcpy(planes + c * plane, planes, plane * sizeof *planes);
}

/* ---- skies ----------------------------------------------------------------------------------- */

static bool has_attribute(const exr_reader *reader, const char *name) {
    const exr_attribute_t *attribute;
    return exr_get_attribute_by_name(reader->context, 0, name, &attribute) == EXR_ERR_SUCCESS;
}

/* A sky that is marked as one fills its data window, wherever that lies. */
static sl_status place_sky(exr_reader *reader, sl_error *error) {
    exr_envmap_t kind;
    if (!has_attribute(reader, "envmap") ||
        exr_attr_get_envmap(reader->context, 0, "envmap", &kind) != EXR_ERR_SUCCESS)
        return SL_OK;
    if (kind != EXR_ENVMAP_LATLONG)
        return sl_fail(error, SL_ERROR_INPUT, "%s: is a cube map: expected a latitude-longitude picture",
                       reader->source.bytes->path);
    reader->display = reader->data;
    return SL_OK;
}

/* Refuses colours by other primaries than Rec. 709's. */
static sl_status check_primaries(const exr_reader *reader, sl_error *error) {
    static const float rec709[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
    exr_attr_chromaticities_t c;
    if (!has_attribute(reader, "chromaticities") ||
        exr_attr_get_chromaticities(reader->context, 0, "chromaticities", &c) != EXR_ERR_SUCCESS)
        return SL_OK;
    const float given[8] = {c.red_x, c.red_y, c.green_x, c.green_y, c.blue_x, c.blue_y, c.white_x, c.white_y};
    for (int i = 0; i < 8; i++) {
        if (!(fabsf(given[i] - rec709[i]) < 1e-3f))
            return sl_fail(error, SL_ERROR_INPUT,
                           "%s: has chromaticities of its own: expected colours of Rec. 709 (sRGB), linear",
                           reader->source.bytes->path);
    }
    return SL_OK;
}

/* ---- the whole ------------------------------------------------------------------------------- */

sl_status sl_exr_read(const sl_bytes *bytes, bool sky, sl_image **image, sl_error *error) {
    exr_reader reader = {.source = {.bytes = bytes}};
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.error_handler_fn = on_error;
    start.user_data = &reader.source;
    start.read_fn = source_read;
    start.size_fn = source_size;
    /* a file cut short is an error, not half a picture */
    start.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    sl_status status = SL_OK;
    exr_result_t result = exr_start_read(&reader.context, bytes->path, &start);
    if (result == EXR_ERR_OUT_OF_MEMORY) reader.source.starved = true;
    if (result != EXR_ERR_SUCCESS) status = fail_reading(&reader, error);
    if (status == SL_OK) status = read_header(&reader, error);
    if (status == SL_OK && sky) status = place_sky(&reader, error);
    if (status == SL_OK && sky) status = check_primaries(&reader, error);
    if (status == SL_OK) status = create_image(&reader, error);
    if (status == SL_OK) status = copy_metadata(&reader, error);
    if (status == SL_OK) status = read_pixels(&reader, error);
    if (status == SL_OK && reader.gray >= 0) spread_gray(&reader);
    /* it went on, with something left out */
    if (status == SL_OK && reader.source.starved) status = fail_reading(&reader, error);
    if (reader.context) exr_finish(&reader.context);
    sl_free(reader.chunk);
    sl_free(reader.plane);
    if (status == SL_OK) *image = reader.image;
    else sl_image_destroy(reader.image);
    return status;
}
