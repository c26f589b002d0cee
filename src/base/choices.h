/* Choices of options, in the order in which the table of options names them (cache/frame/options.h). */
#pragma once

/* A place on a method's curve of speed against error: settings that are left at 0 follow it. */
typedef enum sl_quality { SL_QUALITY_DRAFT, SL_QUALITY_NORMAL, SL_QUALITY_HIGH } sl_quality;
/* The meaning of a pixel. */
typedef enum sl_pixel_filter {
    SL_FILTER_METHOD, /* what the method or the matched method does */
    SL_FILTER_BOX,    /* the mean over its square: by a film, or the tracers' samples spread over it */
    SL_FILTER_CENTRE, /* what its centre shows, as a rasterizer samples */
    SL_FILTER_BLACKMAN_HARRIS /* a mean that falls off smoothly, over parts of the pixels around it */
} sl_pixel_filter;
/* Pictures of the hemisphere over a point: rasterized planes of one view or of five, or rays. */
typedef enum sl_gather_kind {
    SL_GATHER_AUTO, /* rays */
    SL_GATHER_PLANE,
    SL_GATHER_HEMICUBE,
    SL_GATHER_RAYS
} sl_gather_kind;
/* Visibility of lights in splatting. AUTO: by rays where there are any, else by shadow maps. */
typedef enum sl_direct_kind { SL_DIRECT_AUTO, SL_DIRECT_RAYS, SL_DIRECT_SHADOW_MAPS } sl_direct_kind;
/* The order in which splatting visits pixels for new records. */
typedef enum sl_traversal_order {
    SL_ORDER_COARSE_TO_FINE, /* few gathers in vain when records are made in parallel */
    SL_ORDER_LINEAR          /* row by row, as in the paper */
} sl_traversal_order;
/* Measures that decide the reach of a splatting record. */
typedef enum sl_radius_metric {
    SL_METRIC_AUTO,     /* the one that measured best */
    SL_METRIC_HARMONIC, /* harmonic mean distance (Ward et al. 1988), the paper's */
    SL_METRIC_HESSIAN   /* second derivatives, occlusion included (Schwarzhaupt et al. 2012) */
} sl_radius_metric;

/* ---- Direct Radiance Mapping ---- */

/* Weights of a sample photon's light at a receiver. Numbers are of the paper's equations, as printed. */
typedef enum sl_photon_weight {
    SL_WEIGHT_AUTO,     /* flux; polygon at high quality */
    SL_WEIGHT_FLUX,     /* (14) with a disc's form factor put right, of the photon's flux: bounded */
    SL_WEIGHT_POLYGON,  /* the photon's footprint as a polygon, in closed form: for receivers close to it */
    SL_WEIGHT_PLAIN,    /* point to point: unbiased, singular */
    SL_WEIGHT_EVEN,     /* (11) */
    SL_WEIGHT_DISC,     /* (14) */
    SL_WEIGHT_BOX       /* (15) */
} sl_photon_weight;
/* Which directions a light's map covers. */
typedef enum sl_map_shape {
    SL_MAP_AUTO,     /* a frustum for spots, a hemicube for area lights, a cube for points */
    SL_MAP_FRUSTUM,  /* the paper's */
    SL_MAP_HEMICUBE,
    SL_MAP_CUBE
} sl_map_shape;
/* The part of the map around a sample photon that it takes. */
typedef enum sl_map_filter {
    SL_MAP_FILTER_AUTO,     /* flux */
    SL_MAP_FILTER_POINT,    /* the texel at the sample */
    SL_MAP_FILTER_RADIANCE, /* radiance from a MIP level, the paper's */
    SL_MAP_FILTER_FLUX      /* the flux of all texels around the sample, in groups that lie on one surface */
} sl_map_filter;
/* Occlusion between a receiver and the photons, which the paper leaves out. */
typedef enum sl_photon_visibility {
    SL_VISIBILITY_NONE,
    SL_VISIBILITY_RAYS   /* a ray for each pixel and photon */
} sl_photon_visibility;

/* ---- the light octree ---- */

/* Which photon hits are kept. */
typedef enum sl_photon_store {
    SL_STORE_INDIRECT, /* those after at least one bounce: direct light is another pass's affair */
    SL_STORE_ALL,      /* the first hits too: the picture's indirect part then holds direct light as well */
    SL_STORE_CAUSTIC   /* those that came by mirrors alone */
} sl_photon_store;
/* The area over which gathered photons are spread: irradiance is their flux over it. */
typedef enum sl_photon_area {
    SL_PHOTON_AREA_CLIP,   /* of the scene's triangles within the ellipsoid */
    SL_PHOTON_AREA_SECTION, /* of the photons' mean plane within it */
    SL_PHOTON_AREA_DISC    /* of its equator */
} sl_photon_area;
/* Directions of its photons that a voxel keeps. */
typedef enum sl_voxel_lobes {
    SL_LOBES_PERPENDICULAR, /* lights of the irradiance perpendicular to them: shading has a cosine */
    SL_LOBES_SURFACE,       /* ... of that on the surface, as the paper's sum is printed: shading has none */
    SL_LOBES_NONE           /* one irradiance: the paper's colour octree */
} sl_voxel_lobes;
/* Interpolation between the voxels around a point. */
typedef enum sl_voxel_filter { SL_VOXEL_TRILINEAR, SL_VOXEL_NEAREST } sl_voxel_filter;

/* ---- multi-mesh caching ---- */

/* Estimators of the light that arrives from an area light at a vertex. */
typedef enum sl_light_estimator {
    SL_LIGHT_RATIO,   /* in closed form, times the visible share by the frustum */
    SL_LIGHT_LOOK_AT, /* the paper's frustum around the light alone, with the pixels' solid angles */
    SL_LIGHT_RAYS     /* as SL_LIGHT_RATIO, the visible share by jittered shadow rays */
} sl_light_estimator;
/* Which mesh triangle is refined next. */
typedef enum sl_mesh_selection {
    SL_SELECT_HEAP,  /* the one that matters most */
    SL_SELECT_CHAIN  /* the paper's random chain */
} sl_mesh_selection;

/* ---- the Shading Cache ---- */

/* Estimators of direct light of area lights at a point. */
typedef enum sl_area_sampling {
    SL_AREA_RATIO,  /* in closed form, times the visible share of the samples: the default */
    SL_AREA_SAMPLED /* the samples' mean alone, the paper's */
} sl_area_sampling;
/* Who computes indirect light. */
typedef enum sl_indirect_renderer {
    SL_INDIRECT_BIDIRECTIONAL, /* bidirectional path tracing, the paper's */
    SL_INDIRECT_NONE
} sl_indirect_renderer;
/* Choice of pixels for samples. */
typedef enum sl_pixel_selection {
    SL_PIXELS_HIT_AND_TEST, /* the paper's: random pixels, accepted by priority, and flood fill from them */
    SL_PIXELS_SORTED       /* the highest priorities first: what the paper compares with */
} sl_pixel_selection;
