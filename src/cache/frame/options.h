/* The one table of options. The settings' fields, their bounds and defaults, the command line, --help and the
 * manual pages, the library's sl_settings_set() and sl_setting_at(), and what the metadata of pictures tell
 * are made from it: to take an option away, delete its row here and the code that reads its field.
 *
 * O(type, field, name, unit, least, most, default, the paper's symbol, audience, help)
 *
 * unit: what --help calls a value; DEGREES are radians in the field; BYTES may have K, M, G or T; choices
 * stand as the enumeration in base/choices.h has them; "" is a flag. A field of 0 is the default: IS, BY
 * quality, or what the method decides, as TOLD in words. USER: an option of the program, with a letter or
 * without. RESEARCH: by --set, for experiments with the paper. UNSTAMPED: as USER, but no bit of a pixel
 * depends on it. */
#pragma once

/* every method */
#define SL_OPTIONS_OF_COMMON(O)                                                                            \
    O(const char *, method, "method", "NAME", 0, 0, TOLD("splatting; live: shading-cache"), "", USER('m'), \
      "splatting, direct-radiance, light-octree, multi-mesh, shading-cache, path, bidirectional, auto")    \
    O(const char *, transport, "transport", "PATHS", 0, 0, TOLD("the method's own"), "", USER(0),          \
      "path, bidirectional: direct, one-bounce, full or matched:METHOD")                                   \
    O(sl_pixel_filter, filter, "filter", "method|box|centre|blackman-harris", 0, 0, TOLD("box"), "",       \
      USER(0),                                                                                             \
      "what a pixel is: a mean over its square or around it, or what its centre shows; method: as its "    \
      "paper")                                                                                             \
    O(unsigned, sub_samples, "sub-samples", "N", 1, 4096, BY(16, 64, 256), "", RESEARCH,                   \
      "but for filter centre: samples of a pixel, at most")                                                \
    O(double, filter_radius, "filter-radius", "PIXELS", 0.5, 8, TOLD("1.5"), "", RESEARCH,                 \
      "of filter blackman-harris")                                                                         \
    O(int, width, "size", "WxH", 1, 32768, TOLD("the scene's"), "", UNSTAMPED('s'),                        \
      "pixels, 16384 a side at most, 32768 for path and bidirectional")                                    \
    O(unsigned, threads, "threads", "N", 1, 65536, TOLD("a processor each, 256 at most"), "",              \
      UNSTAMPED('t'), "workers; the bits do not depend on it")                                             \
    O(uint64_t, seed, "seed", "N", 0, 0, IS(0), "", USER(0), "another number, other noise")                \
    O(sl_quality, quality, "quality", "draft|normal|high", 0, 0, TOLD("normal"), "", USER('q'),            \
      "where on the curve of speed against error")                                                         \
    O(uint64_t, memory_bytes, "memory", "BYTES", 1, 0x1p50, TOLD("no limit"), "", UNSTAMPED(0),            \
      "512M, 2G: do less, or nothing, rather than take more")                                              \
    O(uint32_t, spp, "spp", "N", 1, 1e8, TOLD("by quality"), "", USER(0),                                  \
      "path, bidirectional: samples a pixel; splatting, light-octree: light samples a pixel")

/* methods that gather */
#define SL_OPTIONS_OF_GATHERING(O) \
    O(int, gather_size, "gather-size", "N", 4, 1024, TOLD("by quality"), "", RESEARCH, \
      "N x N samples a gather, N even; of multi-mesh a power of two") \
    O(uint32_t, bounces, "bounces", "N", 1, 64, TOLD("as many as matter"), "", USER(0), \
      "surfaces between the one that is seen and the light")

/* Radiance cache splatting (Gautron, Krivanek, Bouatouch, Pattanaik 2005) */
#define SL_OPTIONS_OF_SPLATTING(O) \
    O(double, accuracy, "accuracy", "A", 1e-3, 2, BY(0.5, 0.25, 0.12), "a", USER('a'), \
      "how far from a record its irradiance is used") \
    O(double, glossy_accuracy, "glossy-accuracy", "A", 1e-3, 2, BY(0.3, 0.2, 0.12), "a", RESEARCH, \
      "the same of radiance records") \
    O(sl_gather_kind, gather, "gather", "auto|raster|hemicube|trace", 0, 0, NOTHING, "", RESEARCH, \
      "what samples the hemisphere; auto: rays") \
    O(sl_direct_kind, direct, "direct", "auto|rays|shadow-maps", 0, 0, NOTHING, "", RESEARCH, \
      "how it is told whether a light is seen") \
    O(sl_traversal_order, order, "order", "coarse-to-fine|linear", 0, 0, NOTHING, "", RESEARCH, \
      "in which pixels are visited; the paper's is linear") \
    O(sl_radius_metric, metric, "metric", "auto|harmonic|hessian", 0, 0, NOTHING, "R_k", \
      RESEARCH, "what decides how far records reach; the paper's is harmonic") \
    O(int, harmonics_order, "harmonics", "N", 1, 12, TOLD("by the lobes"), "n", RESEARCH, \
      "order of the radiance records' harmonics") \
    O(uint32_t, hit_samples, "hit-samples", "N", 1, 256, IS(1), "", RESEARCH, \
      "light samples for each thing that a gather sees") \
    O(uint32_t, records_per_frame, "records-per-frame", "N", 1, 1e9, TOLD("no limit"), "", RESEARCH, \
      "a walk-through: at most N new records a frame")

/* Direct Radiance Mapping (Frisvad, Frisvad, Christensen, Falster 2005) */
#define SL_OPTIONS_OF_RADIANCE_MAP(O) \
    O(int, samples, "photons", "M", 1, 256, BY(3, 6, 8), "m", USER('M'), \
      "M x M sample photons a face of the map") \
    O(int, map_size, "map-size", "TEXELS", 1, 1024, IS(16), "w", RESEARCH, "a side of a face") \
    O(sl_map_shape, shape, "map", "auto|frustum|hemicube|cube", 0, 0, NOTHING, "", RESEARCH, \
      "by the light; the paper's is a frustum") \
    O(double, map_fov, "map-fov", "DEGREES", 0.6, 172, TOLD("the spot's own, or 90"), "", RESEARCH, \
      "of a frustum") \
    O(sl_photon_weight, weight, "weight", "auto|flux|polygon|plain|11|14|15", 0, 0, NOTHING, "w", \
      RESEARCH, "a photon's: numbers are the paper's equations") \
    O(sl_map_filter, filter, "map-filter", "auto|point|radiance|flux", 0, 0, NOTHING, "", RESEARCH, \
      "what a photon takes from the map around it") \
    O(sl_photon_visibility, visibility, "visibility", "none|rays", 0, 0, NOTHING, "", USER(0), \
      "indirect shadows, which the paper leaves out") \
    O(int, shadow_size, "shadow-size", "TEXELS", 16, 8192, IS(512), "", RESEARCH, \
      "a side of a depth cube's face") \
    O(int, emitter_samples, "emitter-samples", "N", 1, 64, BY(1, 2, 2), "", RESEARCH, \
      "area lights shine from N x N points, each with a map") \
    O(bool, eight_bit_positions, "8-bit-positions", "", 0, 1, NOTHING, "", RESEARCH, \
      "the map's positions as colours") \
    O(bool, local_light_only, "local-light", "", 0, 1, NOTHING, "", RESEARCH, \
      "no shadows and no indirect light") \
    O(bool, direct_light_only, "direct-light", "", 0, 1, NOTHING, "", RESEARCH, "no indirect light") \
    O(bool, without_layers, "without-layers", "", 0, 1, NOTHING, "", RESEARCH, "R, G and B alone")

/* The light octree (Vivanloc, Hoelt, Hong, Paulin 2007) */
#define SL_OPTIONS_OF_LIGHT_OCTREE(O) \
    O(int, depth, "depth", "D", 1, 8, BY(5, 5, 6), "", USER(0), "of the octree") \
    O(uint64_t, photons, "stored-photons", "N", 1, 1e9, BY(150000, 600000, 1200000), "", USER(0), \
      "photons to be stored") \
    O(int, neighbours, "neighbours", "K", 2, 4096, BY(150, 300, 500), "k", RESEARCH, \
      "nearest photons that a voxel takes") \
    O(double, radius, "radius", "R", 1e-12, 1e12, TOLD("by density"), "r", RESEARCH, \
      "how far it looks for them") \
    O(double, flatness, "flatness", "F", 1e-3, 1, IS(0.25), "f", RESEARCH, \
      "of the ellipsoid in which it looks") \
    O(int, lights, "lights", "N", 1, 8, IS(4), "n", RESEARCH, "virtual directional lights a voxel") \
    O(double, acceptance, "acceptance", "DEGREES", 0.5, 181, IS(60), "", RESEARCH, \
      "between photons' and voxels' normals") \
    O(sl_photon_store, store, "store", "indirect|all|caustic", 0, 0, NOTHING, "", RESEARCH, \
      "which photon hits") \
    O(sl_photon_area, area, "photon-area", "clip|section|disc", 0, 0, NOTHING, "", RESEARCH, \
      "over which photons are spread") \
    O(sl_voxel_lobes, lobes, "lobes", "perpendicular|surface|none", 0, 0, NOTHING, "", RESEARCH, \
      "what a voxel keeps of directions") \
    O(sl_voxel_filter, filter, "voxel-filter", "trilinear|nearest", 0, 0, NOTHING, "", RESEARCH, \
      "how voxels around a point are put together") \
    O(bool, unit_weights, "unit-weights", "", 0, 1, NOTHING, "", RESEARCH, "K-means with equal weights") \
    O(bool, own_photons, "own-photons", "", 0, 1, NOTHING, "", RESEARCH, \
      "a voxel counts its own photons, and looks for no others") \
    O(bool, photons_at_pixels, "photons-at-pixels", "", 0, 1, NOTHING, "", RESEARCH, \
      "the photon map itself: every pixel gathers, there are no lights") \
    O(bool, whole_voxels, "whole-voxels", "", 0, 1, NOTHING, "", RESEARCH, \
      "one set of lights a voxel, not one for each group of normals") \
    O(bool, keep_void_dark, "void-dark", "", 0, 1, NOTHING, "", RESEARCH, "empty voxels count as black") \
    O(double, dilation, "dilation", "H", 0, 1, IS(0), "", RESEARCH, \
      "voxels also hold what is within that share of their edge around them") \
    O(bool, environment_mirrors, "environment-mirrors", "", 0, 1, NOTHING, "", RESEARCH, \
      "mirrors show the environment alone") \
    O(bool, atlas, "atlas", "", 0, 1, NOTHING, "", RESEARCH, "light goes to a texture atlas first") \
    O(int, atlas_size, "atlas-size", "TEXELS", 16, 16384, IS(1024), "", RESEARCH, "a side of the atlas") \
    O(bool, indirect_only, "indirect-only", "", 0, 1, NOTHING, "", RESEARCH, "direct light is left out")

/* Multi-mesh caching with hardware sampling */
#define SL_OPTIONS_OF_MULTI_MESH(O) \
    O(sl_light_estimator, estimator, "light-estimator", "ratio|look-at|rays", 0, 0, NOTHING, "", \
      RESEARCH, "of light from area lights; the paper's is look-at") \
    O(int, light_size, "light-size", "N", 16, 256, IS(64), "N", RESEARCH, \
      "N x N pixels around a light, N up to a power of two") \
    O(int, light_rays, "light-rays", "N", 1, 256, IS(16), "", RESEARCH, \
      "N x N shadow rays to a light, by rays") \
    O(double, gather_fov, "gather-fov", "DEGREES", 57, 179, IS(160), "", RESEARCH, \
      "of an indirect gather") \
    O(double, threshold_scale, "threshold", "X", 1e-3, 1e3, BY(2, 1, 0.5), "", USER(0), \
      "times what an eye can tell") \
    O(double, exposure, "exposure-of-thresholds", "E", 1e-30, 1e30, TOLD("by the light in the scene"), "", \
      RESEARCH, "which radiance displays how bright") \
    O(double, leaf_area, "leaf-area", "PIXELS", 1, 1e9, BY(256, 144, 16), "", RESEARCH, \
      "larger mesh triangles are always split; of indirect light 4 times that") \
    O(double, leaf_edge, "leaf-edge", "PIXELS", 1, 1e9, BY(32, 24, 8), "", RESEARCH, \
      "likewise, by their longest edges; of indirect light twice that") \
    O(int, max_depth, "mesh-depth", "D", 1, 12, IS(12), "", RESEARCH, \
      "splits of a triangle, one in another") \
    O(int, coarse_depth, "coarse-depth", "D", 1, 8, BY(3, 4, 5), "", RESEARCH, "of the coarse mesh") \
    O(double, coarse_edge, "coarse-edge", "LENGTH", 1e-12, 1e12, \
      TOLD("by quality and the scene's diagonal"), "", RESEARCH, "of the coarse mesh") \
    O(sl_mesh_selection, selection, "selection", "heap|chain", 0, 0, NOTHING, "", RESEARCH, \
      "what is refined next; the paper's is a random chain") \
    O(int, batch, "batch", "K", 1, 65536, IS(32), "K", RESEARCH, \
      "mesh triangles that are tested together") \
    O(bool, joint_mesh, "joint-mesh", "", 0, 1, NOTHING, "", RESEARCH, \
      "light and radiance share one mesh, which the paper argues against") \
    O(bool, keep_hanging, "keep-hanging", "", 0, 1, NOTHING, "", RESEARCH, "T-vertices stay visible")

/* The Shading Cache (Tole, Pellacini, Walter, Greenberg 2002) */
#define SL_OPTIONS_OF_SHADING_CACHE(O) \
    O(int, points, "points", "M", 1, 1e6, IS(64), "M", RESEARCH, "shaded in an update") \
    O(int, area_samples, "area-samples", "N", 1, 1e6, TOLD("64; sampled: 100; high: 4 times that"), "", \
      RESEARCH, "points on each area light") \
    O(sl_area_sampling, area, "area-sampling", "ratio|sampled", 0, 0, NOTHING, "", RESEARCH, \
      "ratio to the closed form, or the paper's samples alone") \
    O(int, indirect_samples, "indirect-samples", "N", 1, 1e6, BY(100, 400, 1200), "", RESEARCH, \
      "paths from each point") \
    O(int, path_depth, "path-depth", "N", 1, 64, IS(6), "", RESEARCH, "surfaces on a path") \
    O(sl_indirect_renderer, indirect, "indirect", "bidirectional|none", 0, 0, NOTHING, "", RESEARCH, \
      "who computes indirect light") \
    O(bool, caustics, "caustics", "", 0, 1, NOTHING, "", USER(0), "by a photon map of their own") \
    O(double, random_share, "random-share", "E", 1e-4, 1, IS(0.03), "epsilon", RESEARCH, \
      "pixels chosen whatever their priority") \
    O(sl_pixel_selection, selection, "pixel-selection", "hit-and-test|sorted", 0, 0, NOTHING, \
      "", RESEARCH, "how pixels are chosen for samples") \
    O(double, flood_threshold, "flood-threshold", "P", 1e-6, 1, IS(0.5), "", RESEARCH, \
      "priority down to which floods run") \
    O(bool, no_flood, "no-flood", "", 0, 1, NOTHING, "", RESEARCH, "no flood fill") \
    O(bool, no_random, "no-random", "", 0, 1, NOTHING, "", RESEARCH, "no pixels at random") \
    O(bool, plain_normalisation, "plain-normalisation", "", 0, 1, NOTHING, "", RESEARCH, \
      "priorities by mean and 4 sigma, as printed") \
    O(bool, no_ageing, "no-ageing", "", 0, 1, NOTHING, "", RESEARCH, "samples do not grow old") \
    O(bool, no_resolution_drop, "no-resolution-drop", "", 0, 1, NOTHING, "", RESEARCH, \
      "what changes keeps its fine patches") \
    O(double, stop_size, "stop-size", "PIXELS", 1e-4, 1e6, TOLD("1; of pictures below 24x24 less"), "", \
      RESEARCH, "smaller patches are not split") \
    O(int, ageing_window, "ageing-window", "N", 1, 1e6, IS(60), "", RESEARCH, \
      "updates for which the unseen is kept") \
    O(double, cache_limit, "cache-limit", "X", 0.01, 100, IS(1.5), "", RESEARCH, "patches a pixel") \
    O(double, clean_up_seconds, "clean-up", "SECONDS", 0.01, 1e6, IS(5), "T_c", RESEARCH, \
      "in which what changes is to look right again") \
    O(double, nominal_rate, "nominal-rate", "R", 1, 1e9, \
      TOLD("2000; live: as many as are had"), "", RESEARCH, "samples a second that is reckoned with") \
    O(double, change_threshold, "change-threshold", "LEVELS", 0.01, 255, IS(2), "", RESEARCH, \
      "of change that count") \
    O(int, change_window, "change-window", "N", 1, 1e6, IS(3), "", RESEARCH, \
      "updates without change that end it") \
    O(double, blending, "blending", "B", 0.01, 1, IS(1), "beta", RESEARCH, "share of new values") \
    O(bool, variance_aware, "variance-aware", "", 0, 1, NOTHING, "", RESEARCH, \
      "more samples where noise passes for contrast") \
    O(int, frames_per_update, "frames-per-update", "N", 1, 1e6, IS(20), "", RESEARCH, \
      "of the deterministic schedule") \
    O(uint32_t, updates, "updates", "N", 1, 1e9, TOLD("by quality and size"), "", USER(0), \
      "after which a picture is done") \
    O(double, mean_level_radiance, "mean-level", "L", 1e-30, 1e30, TOLD("by the light in the scene"), \
      "Y_ref", RESEARCH, "radiance of a middle grey")
