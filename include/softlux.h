/** @file
 * softlux: global illumination of triangle scenes on a CPU, with methods written for graphics hardware.
 *
 * This is the library's only public header. Start reading at sl_scene_load(), then sl_method_create().
 *
 *     sl_error error;
 *     sl_scene *scene;
 *     sl_method *method;
 *     sl_image *image;
 *     sl_settings *settings;
 *     if (sl_scene_load("scenes/cornell.json", &scene, &error) == SL_OK &&
 *         sl_settings_create(&settings, &error) == SL_OK &&
 *         sl_settings_set(settings, "quality", "high", &error) == SL_OK &&
 *         sl_method_create(scene, settings, &method, &error) == SL_OK) {
 *         sl_progress progress = {0};
 *         while (!progress.done && sl_method_update(method, &progress, &error) == SL_OK) {}
 *         sl_method_resolve(method, &image, &error);
 *         sl_image_write(image, "cornell.exr", &error);
 *     }
 *
 * Conventions: right-handed world, y up; radiance in W/(m^2 sr), irradiance in W/m^2, per RGB channel (Rec.
 * 709, linear); angles in radians; images have row 0 at the top. A function that can fail returns an
 * sl_status and describes the failure, one line, in *error (which may be NULL); what it would have made is
 * NULL then, what it would have reckoned 0, and all else is as it was. A NULL that no comment allows is
 * refused with SL_ERROR_USAGE by functions that return an sl_status, and must not be given to the others. The
 * library never prints, exits or aborts. The same input gives the same bits at any number of threads, with
 * any compiler and instruction set, and in any locale: numbers are read and written with a decimal point.
 * Callers' threads have C's own floating-point environment, rounding to the nearest, and keep denormals: a
 * program linked with -ffast-math flushes them.
 *
 * Threads: there is no global state. Different handles may be used from different threads at once; one
 * handle, and a scene that methods are reading, by one thread at a time (functions that take a const handle
 * may run side by side). A call spreads over as many threads of its own as the option "threads" says; where
 * the system starts fewer, fewer do the work. A caller's thread needs a stack of 256 KiB, these 128 KiB
 * (OMP_STACKSIZE).
 *
 * Processes: one that forks while no call is under way may go on with every handle in the child, to the same
 * bits at any number of threads; but a show that plays (sl_live) is the parent's alone, and must not be
 * touched, not even stopped, in the child.
 *
 * Versions: a program that was linked with the library goes on with every later one of the same soname. No
 * struct that a caller makes room for changes its size: what is added is taken from `reserved`, which is 0
 * (begin what you fill with {0}); but those that begin with their own size grow at their end. Those that the
 * library alone makes, sl_image, sl_pass, sl_setting and sl_explanation, and enumerations, grow at their
 * end; sl_error, sl_tone, sl_observer and what stands in arrays (sl_metadatum, sl_mark,
 * sl_explanation_term) stay as they are. */
#ifndef SOFTLUX_H
#define SOFTLUX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The version of this header. */
#define SL_VERSION "0.1.0"
/** Marks what the shared library exports. */
#define SL_API __attribute__((visibility("default")))
/** The version of the library, which pictures carry in their metadata; a constant string. */
SL_API const char *sl_version(void);

/* ---- errors ---------------------------------------------------------------------------------- */

/** The numbers are also the program's exit statuses; 1 is kept for a comparison that failed its bounds. */
typedef enum sl_status {
    SL_OK = 0,
    /** what was asked for cannot be: a NULL, a number out of range, an unknown name, functions in the wrong
     * order */
    SL_ERROR_USAGE = 2,
    /** a file cannot be read, or it and the pictures and scenes that were given are not what they ought to
     * be */
    SL_ERROR_INPUT = 3,
    SL_ERROR_OUTPUT = 4,   /**< a file cannot be written */
    SL_ERROR_RESOURCES = 5 /**< no memory, threads or descriptors; or more than the option "memory" allows */
} sl_status;

/** Tells what went wrong. Written by the function that failed, and by it alone. */
typedef struct sl_error {
    sl_status status; /**< what that function returned */
    char message[1024]; /**< one line: file, line where there is one, what was expected; no newline */
} sl_error;

/* ---- counters: the hardware's bill ----------------------------------------------------------- */

/** Deterministic: equal at any number of threads. sl_counter_name() gives the name used in JSON and metadata.
 */
typedef enum sl_counter {
    SL_COUNT_RASTER_PASSES,        /**< renders of the scene into some target */
    /** ... that were not needed: no geometry or no light there, or nothing to be lit by it */
    SL_COUNT_RASTER_PASSES_SKIPPED,
    SL_COUNT_CLUSTERS_TESTED,
    /** rejected whole: outside, between pixel centres, or hidden in every tile that they touch */
    SL_COUNT_CLUSTERS_CULLED,
    SL_COUNT_TRIANGLES_SUBMITTED,  /**< reached the transform */
    SL_COUNT_TRIANGLES_CULLED,     /**< outside the view, or covering no pixel centre */
    SL_COUNT_TRIANGLES_DROPPED,    /**< not finite */
    SL_COUNT_TRIANGLES_CLIPPED,
    SL_COUNT_TRIANGLES_RASTERIZED,
    SL_COUNT_FRAGMENTS_SHADED,
    SL_COUNT_FRAGMENTS_BLENDED,
    SL_COUNT_BYTES_READ_BACK,
    SL_COUNT_SHADOW_LOOKUPS,
    SL_COUNT_RAYS,                 /**< closest-hit rays */
    SL_COUNT_SHADOW_RAYS,          /**< any-hit rays */
    SL_COUNT_GATHERS,              /**< gathers computed, also those of records that were discarded */
    SL_COUNT_RECORDS,
    SL_COUNT_RECORDS_DISCARDED,    /**< speculative records found covered at commit */
    SL_COUNT_SPLATS,
    /** records that gathers see and the eye does not: more than one bounce */
    SL_COUNT_SECOND_LEVEL_RECORDS,
    SL_COUNT_SECOND_LEVEL_LOOK_UPS,      /**< points where gathers asked for their irradiance */
    /** ... and no second-level record covered the point: it receives direct light alone */
    SL_COUNT_SECOND_LEVEL_MISSES,
    SL_COUNT_MAP_PHOTONS,          /**< sample photons of direct radiance maps */
    SL_COUNT_MAP_PHOTONS_DROPPED,  /**< ... that lie too near to the light, or hold no light */
    SL_COUNT_PHOTON_LOOK_UPS,      /**< receivers times photons that were summed */
    SL_COUNT_PHOTONS_EMITTED,      /**< photon paths */
    SL_COUNT_PHOTONS_STORED,
    SL_COUNT_PHOTONS_GATHERED,     /**< found by k-nearest gathers, together */
    SL_COUNT_LEAVES,               /**< voxels that got their lights */
    SL_COUNT_LEAVES_WITHOUT_PHOTONS,
    SL_COUNT_DIRECTIONAL_LIGHTS,   /**< virtual ones, of all voxels */
    SL_COUNT_TEXTURE_FETCHES,      /**< of the octree, its lights, and the atlas */
    SL_COUNT_LIGHT_SAMPLES,        /**< irradiance from one light at one vertex */
    /** ... that needed no picture: the light is turned away, below the horizon, or nothing is in between */
    SL_COUNT_LIGHT_SAMPLES_SKIPPED,
    SL_COUNT_COARSE_SAMPLES,       /**< vertices of the coarse mesh, which gathers see */
    SL_COUNT_INDIRECT_SAMPLES,     /**< gathers of indirect irradiance at vertices */
    SL_COUNT_SPLITS,               /**< mesh triangles or patches cut in four */
    SL_COUNT_COLLAPSES,            /**< ... and put together again */
    SL_COUNT_PIXELS_REDRAWN,
    SL_COUNT_PIXEL_TESTS,          /**< hit-and-test draws of the shading cache */
    SL_COUNT_PIXELS_HIT,           /**< ... accepted for their priority */
    SL_COUNT_PIXELS_RANDOM,        /**< ... accepted whatever their priority */
    SL_COUNT_PIXELS_FLOODED,       /**< pixels beside them that were taken too */
    SL_COUNT_POINTS_SHADED,        /**< vertices whose shading a sample renderer computed */
    SL_COUNT_PATCHES_EVICTED,
    SL_COUNT_CHANGES_DETECTED,     /**< vertices that were found to look otherwise than before */
    /** edits of objects or lights that were found to change shading; several before the first is found are
     * one */
    SL_COUNT_CHANGES_SHOWN,
    /** ... updates from them to the pictures that show it first, the last one included: latency */
    SL_COUNT_UPDATES_TO_SHOW,
    SL_COUNT_FRAMES_DISPLAYED,
    SL_COUNT_SAMPLES,              /**< of pixels: by the path tracers, and in sub-frames of a film */
    SL_COUNT_NONFINITE,            /**< samples or pixels that were NaN or infinite and were set aside */
    SL_COUNTERS
} sl_counter;

enum { SL_COUNTERS_ROOM = 96 };

/** One number for each sl_counter. */
typedef struct sl_counters {
    uint64_t value[SL_COUNTERS_ROOM]; /**< by sl_counter; 0 from SL_COUNTERS on */
} sl_counters;

/** "rays", "fragments_shaded" and so on; a constant string; "unknown" where there is no such counter. */
SL_API const char *sl_counter_name(sl_counter counter);

/* ---- images ---------------------------------------------------------------------------------- */

enum { SL_CHANNEL_NAME_MAX = 64, SL_METADATA_KEY_MAX = 64 };

/** One entry of a picture's metadata. */
typedef struct sl_metadatum {
    char key[SL_METADATA_KEY_MAX]; /**< NUL-terminated */
    char *value; /**< owned by the image */
} sl_metadatum;

/** Planar float image. Channel c is the width*height floats from planes + c*width*height, row 0 at the top.
 * Channels are named as in EXR: "R", "G", "B" for the picture itself, "direct.R" and so on for its layers. */
typedef struct sl_image {
    int width;    /**< pixels, at least 1 */
    int height;   /**< likewise */
    int channels; /**< planes; width * height * channels is 2^31 at most */
    /** channels of them, NUL-terminated; owned by the image, as are the arrays below */
    char (*channel_name)[SL_CHANNEL_NAME_MAX];
    float *planes;          /**< planes[channel][row][column], without gaps */
    sl_metadatum *metadata; /**< in the order in which it was set; see sl_image_set_metadata() */
    size_t metadata_count;  /**< entries of metadata */
} sl_image;

/** A black image, which the caller destroys; channel_names holds `channels` strings, or is NULL for R, G, B
 * (or Y where channels is 1). USAGE: sizes below 1, names that are missing, empty, too long or there twice.
 * RESOURCES: too large. */
SL_API sl_status sl_image_create(int width, int height, int channels, const char *const *channel_names,
                                 sl_image **image, sl_error *error);
/** Frees a picture and all that it owns. NULL is allowed. */
SL_API void sl_image_destroy(sl_image *image);
/** The plane of a named channel, height rows of width values, or NULL where there is none. It belongs to the
 * image. */
SL_API float *sl_image_channel(const sl_image *image, const char *name);
/** Adds or replaces a metadata string; both strings are copied. USAGE: a key that is empty or too long. */
SL_API sl_status sl_image_set_metadata(sl_image *image, const char *key, const char *value, sl_error *error);
/** The value of a key, which the image owns, or NULL where it has none. */
SL_API const char *sl_image_metadata(const sl_image *image, const char *key);
/** Reads a picture, which the caller destroys: EXR (any channels, half/float/uint, scan lines or tiles, first
 * part, any compression that the OpenEXR library has in C: with 3.1 all but DWA), PFM, Radiance HDR, PNG/JPG
 * (decoded from sRGB to linear; metadata tell the tone, see sl_image_write_png()), recognised by content. RGB
 * is what R, G, B are in the file; a lone Y (or L) becomes R = G = B. INPUT: no such file, or none of these,
 * or damaged. */
SL_API sl_status sl_image_read(const char *path, sl_image **image, sl_error *error);
/** Writes by file name: .exr (32-bit float, ZIP, all channels and metadata), .pfm (R, G, B, or else Y), .png
 * (see sl_tone). The file appears whole or not at all: it is written beside its name and renamed. USAGE:
 * another ending, a picture without the channels that the format needs, a metadata key that EXR has a meaning
 * of its own for (what tells its layout, and its standard attributes that are no strings). OUTPUT: it cannot
 * be written. */
SL_API sl_status sl_image_write(const sl_image *image, const char *path, sl_error *error);

/** PNG out: value * 2^exposure_stops, then the curve, then sRGB, then 8 bits rounded to nearest. */
typedef enum sl_tone_curve {
    SL_TONE_CLIP,     /**< min(x, 1) */
    SL_TONE_REINHARD  /**< per channel x (1 + x/w^2) / (1 + x), w = 4: the extended curve, white at 4 */
} sl_tone_curve;

/** Turns radiance into 8 bits. {0} clips and leaves exposure alone. */
typedef struct sl_tone {
    sl_tone_curve curve;  /**< what compresses bright values */
    float exposure_stops; /**< values are multiplied by 2 to this power */
    /** exposure from the image: its log-average luminance goes to 0.18; exposure_stops is added. Not for
     * golden images: twice the light, the same picture */
    bool automatic;
} sl_tone;

/** R, G, B (or Y, where one of them is missing) as an 8-bit PNG by a tone of the caller's choice;
 * sl_image_write() uses {0}. Appears whole or not at all. USAGE: neither channels, or a tone that is none,
 * its exposure not finite. The file tells the tone: softlux.tone, softlux.exposure (stops),
 * softlux.exposure_automatic; "unknown" once a file that does not is read. */
SL_API sl_status sl_image_write_png(const sl_image *image, const char *path, sl_tone tone, sl_error *error);
/** The same bytes for a screen: R, G, B, 3 * width * height of them, rows from the top. An automatic exposure
 * is left in *tone, as a fixed one, so that the frames that follow look alike. Fails as sl_image_write_png()
 * does, but for the file. */
SL_API sl_status sl_image_srgb(const sl_image *image, sl_tone *tone, uint8_t *bytes, sl_error *error);

/* ---- comparison ------------------------------------------------------------------------------ */

/** x = image, r = reference, over R, G, B (or, where one of them is missing, Y three times) of the compared
 * pixels: those whose six values are all finite and whose mask, if any, is > 0.5. Sums in double in a fixed
 * order. A ratio 0/0 is 0; another ratio to 0 (the mean of a black reference) is infinite. ssim (Wang et al.
 * 2004) and flip (Andersson et al. 2020) see all pixels as neighbours, those with a value that is not finite
 * as black in both images, and average over the compared ones. Both see value * 2^exposure_stops clipped to
 * [0,1]: ssim the sRGB-encoded Rec. 709 luminance (Gaussian window of 11x11 pixels, sigma 1.5, K1 = 0.01, K2
 * = 0.03), flip the colours. */
typedef struct sl_comparison {
    uint64_t values;      /**< how many values were compared: 3 a pixel */
    uint64_t nonfinite;   /**< NaN or infinite values under the mask, of both images together */
    uint64_t negative;    /**< values below 0 under the mask, of both images together */
    /** every bit of every R, G, B value under the mask is equal, be it finite or not */
    bool identical;
    double rmse;          /**< sqrt(mean (x-r)^2) */
    double rel_rmse;      /**< rmse / |mean(r)| */
    double rel_mse;       /**< mean((x-r)^2 / (r^2 + 0.01 mean(r)^2)) */
    /** the same without the largest 0.1 % of the terms (rounded down to a whole number) */
    double rel_mse_trimmed;
    double rel_mse_noise; /**< the reference's own share of rel_mse: mean((A-B)^2 / 4 / (r^2 + ...)) where it
                             has the layers even.* and odd.*, two independent halves (the path tracers write
                             them), both finite; else 0 */
    double max_abs;       /**< max |x-r| */
    double bias;          /**< sum(x-r) / |sum(r)| */
    double ssim;          /**< mean structural similarity; 1 where equal */
    double flip;          /**< mean LDR-FLIP at 67 pixels per degree, in [0,1]; 0 where equal */
    double mean_image;     /**< mean(x) */
    double mean_reference; /**< mean(r) */
    /** rel_rmse of what a screen shows: both images * 2^stops, clipped to [0,1], in linear light */
    double rel_rmse_shown;
    double reserved[7];    /**< 0 */
} sl_comparison;

/** {0}: all pixels, exposure as it is. */
typedef struct sl_compare_options {
    const sl_image *mask;  /**< first channel, same size; or NULL */
    float exposure_stops;  /**< of what a screen shows: ssim, flip and rel_rmse_shown */
    uint64_t reserved[8];  /**< 0 */
} sl_compare_options;

/** Tells how far a picture is from a reference. options may be NULL. INPUT: the sizes differ, a picture has
 * neither R, G, B nor Y, or no pixel can be compared. USAGE: an exposure that is not finite. If difference is
 * not NULL it receives a picture of (x-r)/(|r| + 0.01 |mean r|) in false colour, which the caller destroys:
 * of each pixel's three values the farthest from 0; blue where too dark, red where too bright, full colour at
 * 50 %; grey outside the mask, green where a value is not finite. */
SL_API sl_status sl_image_compare(const sl_image *image, const sl_image *reference,
                                  const sl_compare_options *options, sl_comparison *result,
                                  sl_image **difference, sl_error *error);

/* ---- scenes ---------------------------------------------------------------------------------- */

/** Triangles, materials, lights, environment and camera; opaque. Immutable but for the two functions that
 * move it, and for edits (below). */
typedef struct sl_scene sl_scene;

/** Loads a JSON scene file or a mesh file (whatever Assimp reads). Nothing half-read is returned. The caller
 * destroys the scene. The files that it names must lie in the folder of `path` or below. INPUT: a file is
 * missing, damaged, or beyond the limits (docs/scene-format.md). USAGE: an empty path. Mesh files are read by
 * a program of their own, softlux-import, which runs for each of them, under limits of memory and time: one
 * that crashes it, or that it does not come to the end of, is an INPUT error as other damaged ones are. The
 * caller's signals, children, descriptors and environment stay as they are. It is where the library was
 * installed to have it, or where the environment's SOFTLUX_IMPORTER says; RESOURCES: it is not there. */
SL_API sl_status sl_scene_load(const char *path, sl_scene **scene, sl_error *error);
/** A camera that stands still, in place of the file's and its keyframes. What is not given is that of the
 * file's camera, or of the framed one; an eye without a target looks at the middle of the scene's box. */
typedef struct sl_viewpoint {
    bool has_eye;           /**< eye counts */
    bool has_target;        /**< target counts */
    bool has_up;            /**< up counts */
    bool has_fov;           /**< vertical_fov_rad counts */
    float eye[3];           /**< in the scene's world, y up */
    float target[3];        /**< likewise */
    float up[3];            /**< need not be perpendicular to the view */
    float vertical_fov_rad; /**< between 0 and pi */
    uint32_t reserved[8];   /**< 0 */
} sl_viewpoint;
/** Which axis of a mesh file points up. */
typedef enum sl_up_axis {
    SL_UP_AUTO, /**< as the format has it; formats that do not say (STL, PLY, OFF, OBJ) are y up */
    SL_UP_Y,
    SL_UP_Z     /**< (x, y, z) becomes (x, z, -y) */
} sl_up_axis;
/** Permissions for loading a scene. {0} is what sl_scene_load() does. */
typedef struct sl_load_options {
    /** files that a scene names may lie outside of its folder: absolute names, "..", symbolic links; else
     * they are refused */
    bool allow_outside;
    /** of a mesh file that is loaded alone; a scene file says it itself ("up"), and other than AUTO is
     * refused for one (USAGE) */
    sl_up_axis up_axis;
    /** or NULL; read while loading alone. USAGE: an eye at its target, an up vector along the view */
    const sl_viewpoint *view;
    uint64_t reserved[8]; /**< 0 */
} sl_load_options;
/** The same as it is told to; options must not be NULL. */
SL_API sl_status sl_scene_load_with(const char *path, const sl_load_options *options, sl_scene **scene,
                                    sl_error *error);
/** Frees a scene that no method reads any more. NULL is allowed. */
SL_API void sl_scene_destroy(sl_scene *scene);
/** Returns how many lines there are about what loading had to decide or repair: a framed camera, the default
 * light, dropped triangles, scaled reflectances. */
SL_API size_t sl_scene_warning_count(const sl_scene *scene);
/** One of them, without a newline, owned by the scene; NULL past the end. */
SL_API const char *sl_scene_warning(const sl_scene *scene, size_t index);
/** Triangles that can be seen or hit, those of curved surfaces included. */
SL_API size_t sl_scene_triangle_count(const sl_scene *scene);
/** Bytes that the scene holds: triangles, textures, environment, lights. */
SL_API size_t sl_scene_memory_bytes(const sl_scene *scene);
/** The size in pixels that the scene's file asks for, or 512 x 512. */
SL_API void sl_scene_film(const sl_scene *scene, int *width, int *height);
/** A hash of everything that can reach a pixel, the camera included: equal scenes have equal ones, on every
 * machine. */
SL_API uint64_t sl_scene_hash(const sl_scene *scene);
/** Changes between two states of a scene; a method finds them out with sl_method_edit(). */
enum {
    SL_CHANGED_CAMERA = 1,
    SL_CHANGED_OBJECTS = 2,    /**< the place or shape of surfaces */
    SL_CHANGED_LIGHTS = 4,     /**< the place or direction of a light or lamp; one was lit or put out */
    SL_CHANGED_POWER = 8,      /**< power or colour of lights, what surfaces emit */
    SL_CHANGED_MATERIALS = 16, /**< colour or gloss of surfaces */
    SL_CHANGED_SKY = 32,
    SL_CHANGED_KINDS = 64      /**< surfaces have become diffuse, glossy or a mirror, or are no more;
                                  textures, masks, bumps; objects that come, go or are deformed */
};
/** Moves camera, objects and lights to their keyframes' state at a time. Methods that were created for the
 * scene are then to be told by sl_method_edit(), before anything else is asked of them (which is refused
 * else); *changes (may be NULL) gets SL_CHANGED_ bits. USAGE: a time that is not finite. INPUT: one at which
 * keyframes leave no camera, or move things beyond all numbers. */
SL_API sl_status sl_scene_set_time(sl_scene *scene, double time_seconds, unsigned *changes, sl_error *error);
/** Looks from eye to target; the up vector need not be perpendicular. USAGE: the frame is degenerate, a
 * number not finite, or the field of view not between 0 and pi. */
SL_API sl_status sl_scene_set_camera(sl_scene *scene, const float eye[3], const float target[3],
                                     const float up[3], float vertical_fov_rad, sl_error *error);

/* ---- scenes from arrays ---------------------------------------------------------------------- */

/** A scene while a program makes it, by the rules for scene files (docs/scene-format.md), whose keys its
 * messages name. What is added is told apart by numbers, which begin at 1: 0 is none. A function that fails
 * has added nothing; INPUT: what is given breaks a rule. All that is given is copied, but for the arrays of a
 * mesh that says otherwise. A struct that a caller fills begins with its own size, {.size = sizeof data}:
 * fields that a later version appends are 0 then, and a field that is 0 is as if it were not given. */
typedef struct sl_scene_builder sl_scene_builder;

/** A picture's texels, row 0 at the top. */
typedef struct sl_texture_data {
    size_t size;         /**< of this struct, in bytes */
    const char *name;    /**< for messages */
    int width;           /**< 1 to 65536 */
    int height;          /**< likewise */
    int channels;        /**< 1: grey, 2: grey and alpha, 3: R, G, B, 4: R, G, B and alpha */
    const uint8_t *srgb; /**< channels of them a texel, as 8-bit files have them; or NULL, and: */
    /** the same from 0 to 1, colours in linear light; they are rounded to 8 bits, colours of the sRGB curve
     */
    const float *linear;
} sl_texture_data;

/** A surface. */
typedef struct sl_material_data {
    size_t size;       /**< of this struct, in bytes */
    const char *name;  /**< NULL: "material N" */
    float diffuse[3];  /**< kd, 0 to 1 */
    float specular[3]; /**< ks, 0 to 1 */
    float exponent;    /**< n, 0 to 1000000 */
    float mirror[3];   /**< reflectance of a perfect mirror, 0 to 1; not beside kd or ks */
    float emission[3]; /**< radiance that leaves the front */
    bool two_sided;    /**< it leaves both sides */
    uint32_t texture;  /**< that multiplies kd */
    uint32_t alpha;    /**< a mask: alpha channel, or luminance where there is none */
    uint32_t bump;     /**< a height map */
    float bump_depth;  /**< in widths of the texture, to 1; 0: 0.04 */
} sl_material_data;

/** Triangles, counter-clockwise where they are seen from the front. */
typedef struct sl_mesh_data {
    size_t size;            /**< of this struct, in bytes */
    const char *name;       /**< NULL: "mesh N" */
    size_t vertex_count;    /**< vertices in the arrays below */
    const float *positions; /**< x, y, z a vertex */
    const float *normals;   /**< likewise, of any length; (0, 0, 0) or NULL: those of the triangles */
    const float *texture_coordinates; /**< u, v a vertex, v = 0 at the bottom; or NULL */
    size_t triangle_count;            /**< triangles in the arrays below */
    const uint32_t *indices;   /**< three vertices a triangle, from 0 */
    const uint32_t *materials; /**< one a triangle; NULL: `material` for all of them */
    uint32_t material;         /**< 0, here as above: a diffuse grey of 0.5 */
    /** the arrays are not copied: they must stay until the scene is built or the builder destroyed */
    bool borrowed;
} sl_mesh_data;

/** A mesh at a place: an object of the scene. */
typedef struct sl_instance_data {
    size_t size;             /**< of this struct, in bytes */
    uint32_t mesh;           /**< which one */
    uint32_t material;       /**< for all of it; 0: the mesh's own */
    const char *name;        /**< of the object; NULL: the mesh's */
    const double *transform; /**< 16 numbers by columns; may mirror, may not flatten; NULL: as it is */
} sl_instance_data;

/** The kinds of lights beside surfaces that emit. */
typedef enum sl_light_type {
    SL_LIGHT_POINT,       /**< the same in all directions */
    SL_LIGHT_SPOT,        /**< full in an inner cone, none outside of an outer one */
    SL_LIGHT_DIRECTIONAL, /**< from infinitely far away */
    SL_LIGHT_QUAD         /**< a parallelogram that shines towards edge1 x edge2: two triangles */
} sl_light_type;

/** A light. */
typedef struct sl_light_data {
    size_t size;         /**< of this struct, in bytes */
    sl_light_type type;  /**< which of the fields below count */
    const char *name;    /**< NULL: "light N" */
    double position[3];  /**< point and spot; of a quad its corner */
    double direction[3]; /**< spot and directional: the way light travels */
    double edge1[3];     /**< of a quad */
    double edge2[3];     /**< of a quad */
    /** point, spot: intensity; directional: irradiance of a plane that faces it; quad: radiance */
    float strength[3];
    bool is_power;    /**< point, quad: strength is the power in W */
    bool two_sided;   /**< a quad shines on both sides */
    double inner_rad; /**< spot: of the cone with all of it, from its axis; at most outer_rad */
    double outer_rad; /**< spot: of the cone beyond which there is none; 0.01 to 180 degrees */
} sl_light_data;

/** An empty one, which the caller destroys. */
SL_API sl_status sl_scene_builder_create(sl_scene_builder **builder, sl_error *error);
/** NULL is allowed. Scenes that it has built stay. */
SL_API void sl_scene_builder_destroy(sl_scene_builder *builder);
/** Adds a texture; its number in *texture. */
SL_API sl_status sl_scene_builder_texture(sl_scene_builder *builder, const sl_texture_data *data,
                                          uint32_t *texture, sl_error *error);
/** Adds a material; its number in *material. */
SL_API sl_status sl_scene_builder_material(sl_scene_builder *builder, const sl_material_data *data,
                                           uint32_t *material, sl_error *error);
/** Adds a mesh, which is not seen until it is placed; its number in *mesh. INPUT also: an index names no
 * vertex, which the message tells by the mesh's name, the index and its triangle. */
SL_API sl_status sl_scene_builder_mesh(sl_scene_builder *builder, const sl_mesh_data *data, uint32_t *mesh,
                                       sl_error *error);
/** Places a mesh, as often as one likes. Each instance is a copy of its own: 36 bytes a triangle and 32 a
 * vertex in the scene, up to as much again while it is built, and what a method holds of each triangle; but
 * rays share a hierarchy among the copies of a mesh where that saves half a million triangles or more. */
SL_API sl_status sl_scene_builder_instance(sl_scene_builder *builder, const sl_instance_data *data,
                                           sl_error *error);
/** Adds a light. */
SL_API sl_status sl_scene_builder_light(sl_scene_builder *builder, const sl_light_data *data,
                                        sl_error *error);
/** Sets the sky, in place of the one before: R, G, B a texel of a latitude-longitude picture, row 0 at the
 * top, its middle along -z; with width and height 0 one radiance, three numbers, all around. */
SL_API sl_status sl_scene_builder_environment(sl_scene_builder *builder, int width, int height,
                                              const float *radiance, sl_error *error);
/** Sets the camera, as sl_scene_set_camera() does, from 0.01 to 179 degrees. Without one the scene is framed.
 */
SL_API sl_status sl_scene_builder_camera(sl_scene_builder *builder, const float eye[3], const float target[3],
                                         const float up[3], float vertical_fov_rad, sl_error *error);
/** Sets the picture's size in pixels, 1 to 65536; else it is 512 x 512. */
SL_API sl_status sl_scene_builder_film(sl_scene_builder *builder, int width, int height, sl_error *error);
/** Makes the scene, as loading makes it of a file that says the same, to the same bits. The caller destroys
 * it. Whatever comes of it, the builder can only be destroyed then: all else is refused with USAGE. */
SL_API sl_status sl_scene_builder_build(sl_scene_builder *builder, sl_scene **scene, sl_error *error);

/** Writes a scene as it stands now, so that a fault can be shown to others: NAME.json, beside it its
 * triangles (NAME-0.obj and NAME.mtl, NAME-1.bpt and so on), textures (PNG) and sky (EXR). Read again it is
 * the same scene, to the same bits of every picture, but for curved surfaces that were moved, whose points
 * are rounded anew; keyframes are left out, and names changed where files cannot have them. Each file appears
 * whole or not at all, NAME.json last. USAGE: a name that does not end in .json. OUTPUT: a file cannot be
 * written. */
SL_API sl_status sl_scene_write(const sl_scene *scene, const char *path, sl_error *error);

/* ---- edits of a scene ------------------------------------------------------------------------ */

/** Changes of a scene, collected beside it by the rules for scenes that are built. They take place together
 * with sl_scene_edit_commit(), or not at all; then methods are told with sl_method_edit(). A scene that was
 * edited is the scene: a method that has followed gives what one gives that is created then, and one that is
 * created anew its bits.
 *
 * Materials, textures, objects and lights are known by numbers from 1. In a scene that was built those of
 * materials and textures are the builder's; objects are numbered in the order in which instances and quads
 * were added, points, spots and directional lights in theirs. In one that was loaded they are in the order of
 * its file, but for lights without any intensity, which are left out. A quad is an object with a material of
 * its own, both of its name: its power is what the material emits. */
typedef struct sl_scene_edit sl_scene_edit;
/** The number of the first object of that name; 0: there is none. */
SL_API uint32_t sl_scene_find_object(const sl_scene *scene, const char *name);
/** Likewise of materials. */
SL_API uint32_t sl_scene_find_material(const sl_scene *scene, const char *name);
/** Points, spots and directional lights, those that are turned off included. */
SL_API size_t sl_scene_light_count(const sl_scene *scene);
/** Fills *data with a material as it is now, the name being the scene's own. False: there is none of that
 * number. */
SL_API bool sl_scene_material(const sl_scene *scene, uint32_t material, sl_material_data *data);
/** Begins an edit. The scene must outlive it, and must not change before it is committed. */
SL_API sl_status sl_scene_edit_begin(sl_scene *scene, sl_scene_edit **edit, sl_error *error);
/** Leaves off an edit that was not committed. NULL is allowed. */
SL_API void sl_scene_edit_destroy(sl_scene_edit *edit);
/** Gives a material other values, all but its name. */
SL_API sl_status sl_edit_material(sl_scene_edit *edit, uint32_t material, const sl_material_data *data,
                                  sl_error *error);
/** Gives a point, spot or directional light another strength (W/sr, or W/m^2 of directional ones; 0 turns it
 * off), place or direction, as its type has them; what is NULL stays. Keyframes move it again. */
SL_API sl_status sl_edit_light(sl_scene_edit *edit, uint32_t light, const float strength[3],
                               const double position[3], const double direction[3], sl_error *error);
/** Moves an object from where it was when the scene was made, by 16 numbers by columns: turned, moved,
 * scaled, not mirrored. From then on keyframes do not move it; NULL: they do again. */
SL_API sl_status sl_edit_transform(sl_scene_edit *edit, uint32_t object, const double columns[16],
                                   sl_error *error);
/** Adds a point, spot or directional light, whose number is the next one. One that is to go again is turned
 * off. */
SL_API sl_status sl_edit_add_light(sl_scene_edit *edit, const sl_light_data *light, uint32_t *number,
                                   sl_error *error);
/** Adds an object, whose number is the next one: a mesh of the scene's materials (each triangle names one),
 * which is copied. */
SL_API sl_status sl_edit_add_object(sl_scene_edit *edit, const sl_mesh_data *mesh, uint32_t *object,
                                    sl_error *error);
/** Takes away an object that was there before the edit, not one of bicubic surfaces. The others keep their
 * numbers; its own stands for nothing from then on. */
SL_API sl_status sl_edit_remove_object(sl_scene_edit *edit, uint32_t object, sl_error *error);
/** Returns how many vertices an object has, and fills positions and normals (three numbers each; or NULL)
 * with them as they are before it is moved. Vertices of a mesh that agree in all that they have are one, and
 * a mesh without normals has some for each facet. */
SL_API size_t sl_scene_vertices(const sl_scene *scene, uint32_t object, float *positions, float *normals);
/** Deforms an object: gives all its vertices, in that order, other positions and normals (copied; NULL: those
 * of the triangles around them), from which it is moved as before by sl_edit_transform(), and no more by
 * keyframes. Likewise not of bicubic surfaces. */
SL_API sl_status sl_edit_vertices(sl_scene_edit *edit, uint32_t object, size_t count, const float *positions,
                                  const float *normals, sl_error *error);
/** Sets the sky, as sl_scene_builder_environment() does; one that is black takes it away. */
SL_API sl_status sl_edit_environment(sl_scene_edit *edit, int width, int height, const float *radiance,
                                     sl_error *error);
/** Sets the camera, as sl_scene_builder_camera() does. */
SL_API sl_status sl_edit_camera(sl_scene_edit *edit, const float eye[3], const float target[3],
                                const float up[3], float vertical_fov_rad, sl_error *error);
/** Changes the scene, if all of it can be done; *changes (may be NULL) gets SL_CHANGED_ bits. The edit is
 * destroyed either way. USAGE: the scene has changed since it began. INPUT: an object would leave all
 * numbers. */
SL_API sl_status sl_scene_edit_commit(sl_scene_edit *edit, unsigned *changes, sl_error *error);

/* ---- observers: every pass announces itself -------------------------------------------------- */

/** The kind of a mark. */
typedef enum sl_mark_kind {
    SL_MARK_POINT,   /**< a photon's hit, a sample: at `at` */
    SL_MARK_SEGMENT, /**< an edge of a mesh, a lobe's axis: from `at` to `to` */
    SL_MARK_DISC     /**< a record's reach: around `at`, perpendicular to `to`, a unit vector */
} sl_mark_kind;

/** Something that a pass leaves in the scene rather than in a picture, to be drawn over one. */
typedef struct sl_mark {
    sl_mark_kind kind; /**< which of the fields below count */
    float at[3];       /**< world */
    float to[3];       /**< world: the other end of a segment, or a disc's normal */
    float radius;      /**< of a disc, scene units */
    float colour[3];   /**< linear, of whatever it stands for: irradiance, flux */
} sl_mark;

/** One pass of a method, as it is told to an observer. */
typedef struct sl_pass {
    const char *method;   /**< "splatting" */
    const char *name;     /**< "splat irradiance records" */
    /** equation, algorithm or pass of the paper, "Algorithm 1, equation (9)"; or its words for it */
    const char *source;
    /** what the pass made, row 0 at the top; valid during the call only; may be NULL */
    const sl_image *buffer;
    const sl_counters *counters; /**< what this pass alone cost */
    const sl_mark *marks;        /**< mark_count of them, valid during the call only */
    size_t mark_count;           /**< 0 where the pass leaves none */
} sl_pass;

/** Is told of every pass, in order, by the thread that called the library. */
typedef struct sl_observer {
    void *context; /**< handed to pass */
    void (*pass)(void *context, const sl_pass *pass); /**< must not call the method that it is told of */
} sl_observer;

/* ---- methods --------------------------------------------------------------------------------- */

/** A request to a method; opaque. Settings left out follow the quality, the scene and the machine. */
typedef struct sl_settings sl_settings;

/** One option, as the program's --help, its manual pages and `softlux help settings` tell of it. */
typedef struct sl_setting {
    const char *name;     /**< "light-octree.depth", or "spp" where several methods heed it */
    const char *methods;  /**< those that do, "splatting, multi-mesh"; "": all */
    /** what a value is: "N", "DEGREES", "WxH"; or the choices, "auto|rays|shadow-maps"; "": a flag, 0 or
     * 1 */
    const char *unit;
    const char *symbol;   /**< the paper's, "k"; or "" */
    const char *help;     /**< one line */
    double minimum;       /**< in that unit */
    double maximum;       /**< not above the minimum: there are no bounds */
    /** default at draft, normal and high quality; 0 where otherwise tells, and of flags and choices: the
     * first */
    double by_quality[3];
    const char *otherwise; /**< how it is chosen, "by density"; or NULL */
    bool everyday;        /**< an option of the program; the others are for experiments */
    char letter;          /**< its short form, or 0 */
} sl_setting;

/** All of them, in order; NULL past the end. */
SL_API const sl_setting *sl_setting_at(size_t index);

/** Splatting at normal quality, everything else by quality, scene and machine: pixels are means over their
 * squares, and light bounces as often as it matters (filter "centre" and bounces "1": the papers' pictures).
 * The caller destroys them. */
SL_API sl_status sl_settings_create(sl_settings **settings, sl_error *error);
/** NULL is allowed. */
SL_API void sl_settings_destroy(sl_settings *settings);
/** Sets one by its name or the last part of it, "method", "size", "light-octree.depth", to a value as text:
 * "path", "640x480", "6". A picture's metadata softlux.NAME, with _ for -, are such names and values. USAGE:
 * no such name, or not such a value. */
SL_API sl_status sl_settings_set(sl_settings *settings, const char *name, const char *value, sl_error *error);
/** Its value as text, cut to the room that there is, the NUL included; 0 stands for what is left open. USAGE:
 * no such name. */
SL_API sl_status sl_settings_get(const sl_settings *settings, const char *name, char *text, size_t room,
                                 sl_error *error);
/** Sets who is told of every pass from then on, by methods that are created with these settings; or NULL. It
 * must outlive them. */
SL_API void sl_settings_observe(sl_settings *settings, const sl_observer *observer);

/** A method at work on a scene: its caches and its picture so far; opaque. */
typedef struct sl_method sl_method;

/** Progress of a method. */
typedef struct sl_progress {
    uint64_t batches;  /**< done so far */
    double fraction;   /**< an estimate in [0,1] */
    /** with splatting.records-per-frame: the frame has what it may have; resolve it, then edit or go on
     * refining */
    bool frame_done;
    bool done;         /**< nothing left to refine; until an edit, updating again changes nothing */
    uint64_t reserved[4]; /**< 0 */
} sl_progress;

/** Prepares a method for a scene: checks and completes the settings (which are copied), and computes no pixel
 * yet. The scene must outlive the method and must not change but as told to sl_method_edit(); the caller
 * destroys the method. USAGE: an unknown method or transport, or a setting out of its range. RESOURCES: the
 * option "memory" is less than the least that it needs. */
SL_API sl_status sl_method_create(const sl_scene *scene, const sl_settings *settings, sl_method **method,
                                  sl_error *error);
/** Frees a method; its scene stays. NULL is allowed. */
SL_API void sl_method_destroy(sl_method *method);
/** One more batch: a pure function of the state and the batch's number, never of time. Short: tenths of a
 * second, so that a caller can show progress and stop between batches. After a failure, which leaves
 * *progress alone, the method can only be destroyed; all else is refused with SL_ERROR_USAGE. */
SL_API sl_status sl_method_update(sl_method *method, sl_progress *progress, sl_error *error);
/** The picture so far, also before the first update: R, G, B and the method's layers, with all that made it
 * as metadata. The caller destroys it. softlux.warning, where there is one, has a line for each limit of the
 * method that shows in the picture. */
SL_API sl_status sl_method_resolve(sl_method *method, sl_image **image, sl_error *error);
/** Follows the scene: what of it has changed since the method last saw it the method finds out itself, all
 * edits since then together; `changes`, SL_CHANGED_ bits, are taken to have changed besides (0: none). The
 * method keeps what is still right and goes on with updates from there. After a failure it wants another edit
 * before anything else, and then does all anew. USAGE: other bits.
 *
 * Kept, by what has changed (all methods keep hierarchies over surfaces that have not moved):
 *
 *                    camera              power, colours        places of lights     surfaces, sky
 *   splatting        records             -                     -                    -
 *   direct-radiance  direct radiance     -                     -                    -
 *   light-octree     photons, leaves     the octree shows until photons are traced anew
 *   multi-mesh       irradiance, coarse  samples of direct     meshes; samples of   meshes; samples that
 *                    mesh, diffuse and   light; meshes, which   other lights; what   nothing moved before;
 *                    indirect meshes     show until renewed    shows, as left       what shows, as left
 *   shading-cache    shading             direct light where    patches; their       as places of lights,
 *                                        surfaces alone have   shading shows until  and direct light that
 *                                        other colours         it is renewed        nothing moved before
 *   path, bidirectional   -              -                     -                    -
 *
 * Of multi-mesh's direct light nothing is sampled again after power or colours have changed, but for lights
 * of the coarse mesh that matter more or less than before beside the others; thresholds that are new may
 * split meshes further, whose samples are all that SL_COUNT_LIGHT_SAMPLES counts then. Indirect light is
 * gathered again. With 16 lights or more by the ratio estimator samples depend on what other lights give,
 * and go. Where its meshes have ended at the option "memory" it keeps nothing. Of the shading cache all is
 * scaled, to within the rounding of a float, where the power of all lights changes by one ratio and there is no sky;
 * where their colour does, too, indirect light is renewed. At rest it shades no more than a method created
 * then, and indirect light of fine patches follows that of coarse ones. SL_CHANGED_KINDS (objects that come,
 * go or are deformed are of these), lights of a kind that there was none of, and a light that is lit or put
 * out in multi-mesh: all is made anew, so that bits are those of a method that is created then. The paper of
 * splatting keeps records of a scene that stands still, as this does. */
SL_API sl_status sl_method_edit(sl_method *method, unsigned changes, sl_error *error);
/** Sets shading-cache.nominal-rate from the next update on, to how many samples a second (as
 * sl_live_state.samples counts them) there have turned out to be: by that the Shading Cache settles how fine
 * patches are while things move. An event like an edit: told of the same after as many updates a method has
 * the same bits. Other methods take no notice. USAGE: not from 1 to 1e9. */
SL_API sl_status sl_method_rate(sl_method *method, double samples_a_second, sl_error *error);
/** Tells whether the two functions below do anything: splatting keeps a cache on disk, the others do not. */
SL_API bool sl_method_keeps_cache(const sl_method *method);
/** Writes the method's cache to a file, for another run: the records of splatting, and what they took hold
 * of. They belong to the scene (its geometry, materials, lights and environment; not its camera) and to the
 * settings that decide what is in them; a file of other ones, of another version, or one that is damaged is
 * refused with SL_ERROR_INPUT, with a line that says so, and nothing changes. With a file saved from the same
 * place, under the same "memory", nothing is gathered anew, and the picture has the same bits. The file
 * appears whole or not at all. USAGE: the method keeps none. */
SL_API sl_status sl_method_save(const sl_method *method, const char *path, sl_error *error);
/** Takes over what sl_method_save() wrote, in place of what the method has: best before the first update. */
SL_API sl_status sl_method_load(sl_method *method, const char *path, sl_error *error);
/** All that was counted since the method was created; owned by it, and valid until it is called again. */
SL_API const sl_counters *sl_method_counters(const sl_method *method);
/** Bytes that the method holds, its own hierarchies, caches and pictures, without the scene. */
SL_API size_t sl_method_memory_bytes(const sl_method *method);
/** An upper estimate, from counts alone and before anything is allocated, of what the option "memory" bounds,
 * for these settings as they stand: 32 MiB for the program itself, the scene, the hierarchies over it, the
 * method at its largest, and its picture as it is given and written. Caches that grow as they are filled
 * count with the least that they can work with. No observer is counted. Fails as sl_method_create() does. */
SL_API sl_status sl_method_memory_need(const sl_scene *scene, const sl_settings *settings, uint64_t *bytes,
                                       sl_error *error);
/** One line on what the method does less than its settings ask for, so as to keep within "memory": "75000
 * stored photons instead of 600000". Caches that are full by then are told of once they are. Owned by the
 * method, and valid until it is called again; NULL where it does all. The picture's metadata tell the
 * settings that were used. */
SL_API const char *sl_method_reduction(sl_method *method);

/* ---- the explanation of a pixel ---- */

/** One thing that made a pixel: a record, a photon, a voxel's light, a vertex of a mesh. */
typedef struct sl_explanation_term {
    /** of the picture, that it adds to: "indirect", "direct", "emission"; a constant string */
    const char *layer;
    const char *kind;       /**< "irradiance record"; a constant string */
    uint64_t index;         /**< which one, by the method's own numbers */
    bool placed;            /**< whether position means anything */
    float position[3];      /**< world */
    double weight;          /**< as the method computes it, before any normalisation */
    float value[3];         /**< what it holds, by the method's own units: irradiance, radiance, flux */
    double contribution[3]; /**< what it adds to the pixel */
} sl_explanation_term;

/** All that made a pixel. Contributions and rounding add up, in double, to the pixel's exact value. */
typedef struct sl_explanation {
    float pixel[3];       /**< R, G, B of the picture */
    size_t count;         /**< terms */
    sl_explanation_term *terms; /**< in the order in which the method adds them */
    /** what rounding of the method's own sums, in float, has left: parts in a million */
    double rounding[3];
} sl_explanation;

/** Tells what made the pixel of column x and row y, from the top, in the picture that sl_method_resolve()
 * gave last: the method must not have been updated or edited since. The caller destroys the explanation.
 * USAGE: the method tells none (the tracers; direct-radiance without layers; any with filter=box), there is
 * no such picture (known by what is stamped on it), or the pixel lies outside. */
SL_API sl_status sl_method_explanation(sl_method *method, const sl_image *picture, int x, int y,
                                       sl_explanation **explanation, sl_error *error);
/** Frees an explanation. NULL is allowed. */
SL_API void sl_explanation_destroy(sl_explanation *explanation);

/** The names of all methods, in order; NULL past the end. */
SL_API const char *sl_method_name(size_t index);

/** Tells what a method would do with a scene: one line for each pass that runs or is left out, and why, and
 * for each limit of the method that will show. NUL-terminated text, the caller frees it with free(). Fails as
 * sl_method_create() does. */
SL_API sl_status sl_method_plan(const sl_scene *scene, const sl_settings *settings, char **text,
                                sl_error *error);

/* ---- live: frames beside updates ------------------------------------------------------------- */

/** A method at work in a thread of its own, while the caller's thread shows what there is: the two loops of
 * the Shading Cache. Frames never wait for updates. What they show depends on the clock, as nothing else in
 * this library does: for the same bits twice there are sl_method_update() and sl_method_resolve(). */
typedef struct sl_live sl_live;

/** Facts about a shown frame. */
typedef struct sl_live_state {
    uint64_t frames;      /**< drawn so far, this one included */
    /** how often the shading that it shows has been brought up to date: a frame is of one version whole */
    uint64_t versions;
    uint64_t updates;     /**< done so far */
    double time_seconds;  /**< the scene's time that the frame shows */
    /** how wrong what is seen seems to be, in displayed levels of 255, as the last update found it;
     * negative: unknown */
    double error_levels;
    uint64_t changes_shown; /**< moves whose change of light frames have shown, of methods other than the
                             Shading Cache once their picture has been finished there; several before the
                             first of them shows are one */
    /** the scene's time of the last of those moves, and of its first where it was several: what shading
     * lags behind by, to a frame that shows one more */
    double change_seconds;
    /** ... and how many frames after the first that could have shown it that was; 0: in that one */
    uint64_t change_frames;
    bool done;            /**< nothing is left to refine: updates rest until something moves */
    /** that updates have taken since all was made anew last, where of one with direct and indirect light a
     * part counts as what it costs; 0: of methods that take no notice of sl_live_rate() */
    double samples;
    uint64_t reserved[7]; /**< 0 */
} sl_live_state;

/** An event that led the updates of a show: a rate, or a move. */
typedef struct sl_live_event {
    uint64_t updates;     /**< that were done before it */
    bool rate;            /**< sl_method_rate(); else sl_scene_set_time(), and sl_method_edit() */
    double value;         /**< samples a second; else seconds */
} sl_live_event;

/** Makes a method and starts to update it, with workers of its own. Until sl_live_stop() the scene is the
 * show's own: nobody else may change it. An observer is called in the updating thread. All calls on one show
 * come from one thread at a time. Fails as sl_method_create() does. */
SL_API sl_status sl_live_start(sl_scene *scene, const sl_settings *settings, sl_live **live, sl_error *error);
/** Stops after the update under way and releases everything; the scene stays as the updates had it last.
 * *counters (may be NULL) gets the method's, and those of the frames. NULL is allowed. */
SL_API void sl_live_stop(sl_live *live, sl_counters *counters);
/** Moves camera, objects and lights to their keyframes' state at a time: the next frame shows it, whatever is
 * under way (methods without a display of their own, all but the Shading Cache and multi-mesh caching, show
 * it once a picture has light there, and follow no other move before that). Fails as sl_scene_set_time()
 * does, and stays where it is. */
SL_API sl_status sl_live_move(sl_live *live, double time_seconds, sl_error *error);
/** As sl_scene_set_camera(), whatever the keyframes say of the camera, from now on; fails likewise. */
SL_API sl_status sl_live_look(sl_live *live, const float eye[3], const float target[3], const float up[3],
                              float vertical_fov_rad, sl_error *error);
/** As sl_method_rate(), before the next update; fails likewise. The library itself reads no clock. */
SL_API sl_status sl_live_rate(sl_live *live, double samples_a_second, sl_error *error);
/** Gives the first `room` of all events that updates have followed so far, in their order, and returns how
 * many there are. events may be NULL where room is 0. A method that is led through them, each after as many
 * updates, has the same picture, to the bit, as a show with filter=centre after that number of updates, at
 * any number of threads (others differ at edges): from the scene as the show found it, with the show's
 * settings but for shading-cache.frames-per-update=1 and, where they were left open,
 * shading-cache.updates=1000000000 and splatting.records-per-frame=256. Not so with the option "memory", of
 * which a show takes a part for itself, and after sl_live_look(), which stands in no event. */
SL_API size_t sl_live_log(sl_live *live, sl_live_event *events, size_t room);
/** The picture as it is now, R, G, B, drawn by the calling thread alone; *frame is the show's own, and valid
 * until the next call. state may be NULL. Black until there is anything. A pixel is its centre, at edges the
 * mean of four samples, each of the colour of the nearest centre of its surface; all are centres with
 * filter=centre. Fails once an update has failed. */
SL_API sl_status sl_live_frame(sl_live *live, const sl_image **frame, sl_live_state *state, sl_error *error);

/* ---- the error of a picture, without a reference --------------------------------------------- */

/** Error of a picture against the converged picture of the same light paths: that of --method path with the
 * same transport and pixel filter, and no noise. Judged are all pixels, and those that show no lamp and no
 * sky by themselves, whose error the lamps' brightness would hide: what is told is the worse of the two. */
typedef struct sl_error_estimate {
    /** an estimate of sl_comparison.rel_rmse over them; 0 where the picture is better than the
     * probes can tell */
    double rel_rmse;
    /** with 95 % confidence the error is not above that; infinite where nothing can be promised */
    double bound;
    double least;       /**< with 95 % confidence it is not below that */
    /** the bound that a picture without any error would have by the same probes; 0 by a picture's own
     * halves */
    double resolution;
    double rmse;        /**< the estimate in units of radiance */
    double mean;        /**< of the converged picture, estimated */
    double noise;       /**< rmse of the probes' own values: what one half of their samples is off by */
    /** pixels that were looked at: all that are judged where a picture's own halves tell */
    uint64_t probes;
    uint64_t samples;   /**< that the probes have traced so far, for this picture and others */
    /** pixels of the picture with a value that is NaN or infinite: left out, and nothing is promised */
    uint64_t nonfinite;
    bool blind; /**< light of lights without extent by way of mirrors would count, but no path from an eye
                   finds it: the converged picture meant here is without it */
    uint64_t reserved[8]; /**< 0 */
} sl_error_estimate;

/** Probes: pixels of which two independent estimates p and q are path traced. E[(x - p)(x - q)] is the
 * squared error of a picture's value x there. Values that were traced once serve for any number of pictures
 * of the scene with this size, transport and filter. */
typedef struct sl_error_probe sl_error_probe;

/** settings: of the pictures to be judged; method, transport, filter, size, seed and threads count, and what
 * the method's light paths depend on. The scene must outlive the probe and must not change. USAGE: as
 * sl_method_create(). */
SL_API sl_status sl_error_probe_create(const sl_scene *scene, const sl_settings *settings,
                                       sl_error_probe **probe, sl_error *error);
SL_API void sl_error_probe_destroy(sl_error_probe *probe); /**< NULL is allowed */
/** Judges a picture by about so many probes (every pixel, if there are no more), with so many samples or more
 * for each of p and q: what is there already is used, what is missing is traced. The first time every pixel
 * (of large pictures, one of each block) is traced once besides, to choose the probes by. INPUT: the
 * picture's size is another, or it has neither R, G, B nor Y. USAGE: no probes, no samples. */
SL_API sl_status sl_error_probe_estimate(sl_error_probe *probe, const sl_image *image, uint64_t probes,
                                         uint32_t samples, sl_error_estimate *estimate, sl_error *error);
/** The same with few probes, and more until it is clear whether the error is within rel_rmse: until bound <=
 * rel_rmse, or least is above it, or the probe's counters would have more than so many rays and shadow rays.
 * 0: a number that grows as 1/rel_rmse^2. USAGE: rel_rmse is not above 0. */
SL_API sl_status sl_error_probe_judge(sl_error_probe *probe, const sl_image *image, double rel_rmse,
                                      uint64_t rays, sl_error_estimate *estimate, sl_error *error);
/** Finds how much of the first picture's error is left in the second, which was judged last: with 95 %
 * confidence no less than *share (0 to 1) of it. Told by the differences at the same probes, from which most
 * of the probes' own noise falls out. INPUT: as sl_error_probe_estimate(). USAGE: none was judged. */
SL_API sl_status sl_error_probe_left(sl_error_probe *probe, const sl_image *first, const sl_image *second,
                                     double *share, sl_error *error);
/** The surfaces seen, as sl_compare_options.mask takes them: 0 where a pixel shows a lamp or the sky, of a
 * box pixel any part; 1 elsewhere. All pixels are judged relative to their mean, and surfaces by themselves
 * relative to theirs, which lamps would hide; an estimate is of the worse. Owned by the probe. */
SL_API const sl_image *sl_error_probe_surfaces(const sl_error_probe *probe);
/** Returns what tracing the probes has cost so far; owned by the probe. */
SL_API const sl_counters *sl_error_probe_counters(const sl_error_probe *probe);
/** From the picture's own layers even.* and odd.*, where it is their mean, as those of path and bidirectional
 * are. mask: as sl_compare_options.mask: its pixels are judged by themselves, too, and the worse is told; or
 * NULL. INPUT: it has none, or the mask is of another
 * size. */
SL_API sl_status sl_error_estimate_from_halves(const sl_image *image, const sl_image *mask,
                                               sl_error_estimate *estimate, sl_error *error);

#ifdef __cplusplus
}
#endif
#endif
