#include "app/bench/trials.h"

#define METHOD(name) name, name
#define MATCHED(name) "matched:" name

/* Cheap settings first. What a curve adds lies between the qualities, below draft and above high, along the
 * settings that trade time for error best; light samples grow as records do, photons as voxels do, or one of
 * the two would bear all of the error. */
#define SPLATTING(name, quality, arguments) \
    { METHOD("splatting"), name, "-m splatting " arguments, MATCHED("splatting"), quality }
/* So many diffuse bounces that all of global illumination is its truth, but for what glossy surfaces and
 * mirrors send on. */
#define SPLATTING_ON(name, quality, arguments) \
    { "splatting", "splatting, 6 bounces", name, "-m splatting --bounces 6 " arguments, "full", quality }
#define DIRECT_RADIANCE(name, quality, arguments) \
    {METHOD("direct-radiance"), name, "-m direct-radiance " arguments, MATCHED("direct-radiance"), quality}
/* With visibility of its photons it has the very paths of one bounce. */
#define DIRECT_RADIANCE_SEEN(name, arguments) \
    { METHOD("direct-radiance"), name, "-m direct-radiance " arguments, "one-bounce", SL_BENCH_CURVE }
#define LIGHT_OCTREE(name, quality, arguments) \
    { METHOD("light-octree"), name, "-m light-octree " arguments, MATCHED("light-octree"), quality }
/* The peer: the octree's photon map itself, gathered at every pixel. */
#define PHOTONS(name, quality, arguments)                                                                 \
    {                                                                                                     \
        "light-octree", "photons at pixels", name,                                                        \
            "-m light-octree --set light-octree.photons-at-pixels=1 " arguments, MATCHED("light-octree"), \
            quality                                                                                       \
    }
#define MULTI_MESH(name, quality, arguments) \
    { METHOD("multi-mesh"), name, "-m multi-mesh " arguments, MATCHED("multi-mesh"), quality }
#define SHADING_CACHE(name, quality, arguments) \
    { METHOD("shading-cache"), name, "-m shading-cache " arguments, MATCHED("shading-cache"), quality }
/* The reference tracers, on the paths of both truths that all are held against; pixels sampled at their
 * centres as the methods do. */
#define TRACER(tracer, transport, name, quality, arguments)                                              \
    {                                                                                                    \
        tracer, tracer ", " transport, name,                                                             \
            "-m " tracer " --transport " transport " --set filter=centre " arguments, transport, quality \
    }
#define PATH(transport, most)                                              \
    TRACER("path", transport, "1 sample", SL_BENCH_CURVE, "--spp 1"),      \
        TRACER("path", transport, "4 samples", SL_BENCH_CURVE, "--spp 4"), \
        TRACER("path", transport, "draft", SL_BENCH_DRAFT, "-q draft"),    \
        TRACER("path", transport, "normal", SL_BENCH_NORMAL, "-q normal"), \
        TRACER("path", transport, "high", SL_BENCH_HIGH, "-q high"),       \
        TRACER("path", transport, most " samples", SL_BENCH_CURVE, "--spp " most)
#define BIDIRECTIONAL(transport)                                                    \
    TRACER("bidirectional", transport, "4 samples", SL_BENCH_CURVE, "--spp 4"),     \
        TRACER("bidirectional", transport, "draft", SL_BENCH_DRAFT, "-q draft"),    \
        TRACER("bidirectional", transport, "normal", SL_BENCH_NORMAL, "-q normal"), \
        TRACER("bidirectional", transport, "high", SL_BENCH_HIGH, "-q high")

static const sl_trial trials[] = {
    SPLATTING("a 0.7, 2 light samples, 16x16", SL_BENCH_CURVE,
              "-q draft --accuracy 0.7 --spp 2 --set gather-size=16"),
    SPLATTING("draft", SL_BENCH_DRAFT, "-q draft"),
    SPLATTING("a 0.5, 8 light samples, 16x16", SL_BENCH_CURVE, "--accuracy 0.5 --spp 8 --set gather-size=16"),
    SPLATTING("normal", SL_BENCH_NORMAL, "-q normal"),
    SPLATTING("a 0.25, 32 light samples, 28x28", SL_BENCH_CURVE,
              "-q high --accuracy 0.25 --spp 32 --set gather-size=28"),
    SPLATTING("high", SL_BENCH_HIGH, "-q high"),
    SPLATTING("a 0.1, 128 light samples, 48x48", SL_BENCH_CURVE,
              "-q high --accuracy 0.1 --spp 128 --set gather-size=48"),
    SPLATTING_ON("draft", SL_BENCH_DRAFT, "-q draft"),
    SPLATTING_ON("normal", SL_BENCH_NORMAL, "-q normal"),
    SPLATTING_ON("high", SL_BENCH_HIGH, "-q high"),
    DIRECT_RADIANCE("2x2 photons", SL_BENCH_CURVE, "-q draft --photons 2"),
    DIRECT_RADIANCE("draft", SL_BENCH_DRAFT, "-q draft"),
    DIRECT_RADIANCE("4x4 photons, a point a lamp", SL_BENCH_CURVE, "--photons 4 --emitter-samples 1"),
    DIRECT_RADIANCE("normal", SL_BENCH_NORMAL, "-q normal"),
    DIRECT_RADIANCE("high", SL_BENCH_HIGH, "-q high"),
    DIRECT_RADIANCE_SEEN("high, visibility by rays", "-q high --visibility rays"),
    DIRECT_RADIANCE("12x12 photons, 4x4 emitters", SL_BENCH_CURVE,
                    "-q high --photons 12 --emitter-samples 4"),
    DIRECT_RADIANCE_SEEN("8x8 photons, 4x4 emitters, rays",
                         "-q high --photons 8 --emitter-samples 4 --visibility rays"),
    LIGHT_OCTREE("40k photons, depth 4", SL_BENCH_CURVE,
                 "-q draft --stored-photons 40000 --set light-octree.neighbours=60 --depth 4"),
    LIGHT_OCTREE("draft", SL_BENCH_DRAFT, "-q draft"),
    LIGHT_OCTREE("300k photons, depth 5", SL_BENCH_CURVE,
                 "--stored-photons 300000 --set light-octree.neighbours=200 --depth 5"),
    LIGHT_OCTREE("normal", SL_BENCH_NORMAL, "-q normal"),
    LIGHT_OCTREE("1.2M photons, depth 5", SL_BENCH_CURVE,
                 "--stored-photons 1200000 --set light-octree.neighbours=500 --depth 5"),
    LIGHT_OCTREE("high", SL_BENCH_HIGH, "-q high"),
    PHOTONS("40k photons, k 60", SL_BENCH_CURVE,
            "-q draft --stored-photons 40000 --set light-octree.neighbours=60"),
    PHOTONS("draft", SL_BENCH_DRAFT, "-q draft"),
    PHOTONS("normal", SL_BENCH_NORMAL, "-q normal"),
    MULTI_MESH("threshold 4", SL_BENCH_CURVE, "-q draft --threshold 4"),
    MULTI_MESH("draft", SL_BENCH_DRAFT, "-q draft"),
    MULTI_MESH("normal", SL_BENCH_NORMAL, "-q normal"),
    MULTI_MESH("high", SL_BENCH_HIGH, "-q high"),
    MULTI_MESH("threshold 0.25, leaves of 8", SL_BENCH_CURVE,
               "-q high --threshold 0.25 --set multi-mesh.leaf-area=8 --set multi-mesh.leaf-edge=6"),
    MULTI_MESH("threshold 0.1, leaves of 2", SL_BENCH_CURVE,
               "-q high --threshold 0.1 --set multi-mesh.leaf-area=2 --set multi-mesh.leaf-edge=2"),
    SHADING_CACHE("draft", SL_BENCH_DRAFT, "-q draft"),
    SHADING_CACHE("normal", SL_BENCH_NORMAL, "-q normal"),
    SHADING_CACHE("normal, 100 updates", SL_BENCH_CURVE, "-q normal --updates 100"),
    SHADING_CACHE("high", SL_BENCH_HIGH, "-q high"),
    PATH("one-bounce", "1024"),
    PATH("full", "512"),
    BIDIRECTIONAL("full"),
};

const sl_trial *sl_trial_at(size_t index) {
    return index < sizeof trials / sizeof *trials ? &trials[index] : NULL;
}
