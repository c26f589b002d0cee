/* The light octree, told pass by pass. */
#include "app/steps/mathml.h"
#include "app/steps/narrative.h"

static const sl_narrative_pass passes[] = {
    {"G-buffer: depth", "How far each pixel is",
     "The scene is drawn from the camera; for every pixel the rasterizer keeps what shading will need. Where "
     "a mirror is seen, the buffers hold what it shows.",
     NULL, "sl_raster_gbuffer(), src/raster/resolve/gbuffer.c", NULL, SL_SHOW_SCALAR},
    {"G-buffer: positions", "Where each pixel is",
     "The point of the world that each pixel shows: it decides which voxels light the pixel.", NULL,
     "sl_raster_gbuffer(), src/raster/resolve/gbuffer.c", NULL, SL_SHOW_POSITIONS},
    {"G-buffer: normals", "Which way each pixel faces",
     "The shading normal, turned to where the pixel is seen from. The octree's lights have directions, so "
     "that bumps and curves show in indirect light, too.",
     NULL, "sl_raster_gbuffer(), src/raster/resolve/gbuffer.c", NULL, SL_SHOW_NORMALS},
    {"G-buffer: albedo", "What each pixel reflects",
     "The diffuse reflectance, textures included. The octree holds light alone.", NULL,
     "sl_raster_gbuffer(), src/raster/resolve/gbuffer.c", NULL, SL_SHOW_COLOUR},
    {"direct light", "Direct light",
     "Light that comes straight from a lamp has sharp shadows, which no voxel could hold: it is another "
     "pass's affair, with rays to samples of the lamps.",
     NULL, "sl_direct_rows(), src/cache/light/direct.c", "direct", SL_SHOW_LIGHT},
    {"photons", "Photons leave the lamps",
     "Each carries an equal part of the power. Where it hits a surface after at least one bounce it is "
     "stored: place, direction, power. Then it is reflected, or absorbed by Russian roulette.",
     M_SUB(M_I("&#x3A6;"), M_I("i")) M_O("=") M_FRAC(M_I("&#x3A6;"), M_SUB(M_I("N"), M_T("emitted"))),
     "sl_photons_trace(), src/cache/photons/photons.c", NULL, SL_SHOW_LIGHT},
    {"photon hits", "Where they hit",
     "Some of the photons that were stored. They lie close together where it is bright, and say nothing else "
     "of brightness: all have about the same power.",
     NULL, "sl_photons_trace(), src/cache/photons/photons.c", NULL, SL_SHOW_LIGHT},
    {"octree", "Voxels where there is geometry",
     "The scene's cube is cut in eight as long as a surface passes through a cell, down to depth 4, then 5, "
     "then 6: one picture after another, each from voxels half as large. A cell without a surface costs "
     "nothing.",
     NULL, "sl_octree_create(), src/cache/light_octree/octree.c", NULL, SL_SHOW_LIGHT},
    {"lights of the voxels", "Lights instead of photons",
     "Around each voxel's middle the nearest photons are gathered, within a flat ellipsoid, and spread over "
     "the surface that it holds. A flat matt surface reflects light of all directions alike: there one "
     "directional light along its normal holds all. "
     "Elsewhere K-means sorts the photons' directions into a few groups; each group becomes one directional "
     "light, drawn here as an arrow towards where the light comes from. "
     "Its colour is the irradiance on a plane perpendicular to it.",
     M_SUB(M_I("V"), M_I("j")) M_O("=") M_SUM(M_I("i") M_O("&#x2208;") M_I("j"))
         M_FRAC(M_I("&#x3BA;") M_SUB(M_I("&#x3A6;"), M_I("i")),
                M_I("A") M_TIMES M_BRACED(M_SUB(M_I("n"), M_I("i")) M_TIMES M_SUB(M_I("&#x3C9;"), M_I("i"))))
             M_SUB(M_I("&#x3C9;"), M_I("i")),
     "sl_voxel_lights_compute(), src/cache/light_octree/voxel_lights.c", NULL, SL_SHOW_LIGHT},
    {"atlas", "A texture for all surfaces",
     "The surfaces are cut into charts that bend little, each laid flat onto its mean plane, and packed into one "
     "texture. Light "
     "is rendered there once; every later view looks it up.",
     NULL, "sl_lit_atlas_create(), src/cache/light_octree/pixels.c", NULL, SL_SHOW_LIGHT},
    {"indirect light", "Pixels lit by the octree",
     "A pixel finds the eight voxels around it, lets each one's lights shine on its own normal, and blends "
     "what it reflects of them: not their directions, which have nothing to do with each other. Voxels "
     "without a surface are left out.",
     M_I("L") M_O("=")
         M_FRAC(M_SUM(M_I("v")) M_SUB(M_I("w"), M_I("v")) M_SUM(M_I("j")) M_SUB(M_I("f"), M_I("r"))
                    M_SUB(M_I("c"), M_I("j")) M_BRACED(M_I("n") M_TIMES M_SUB(M_I("d"), M_I("j"))),
                M_SUM(M_I("v")) M_SUB(M_I("w"), M_I("v"))),
     "sl_octree_shade(), src/cache/light_octree/shade.c", "indirect", SL_SHOW_LIGHT},
    {NULL, NULL, NULL, NULL, NULL, NULL, SL_SHOW_LIGHT}};

const sl_narrative sl_light_octree_narrative = {
    "light-octree",
    "Vivanloc, Hoelt, Hong, Paulin: <cite>Light Octree: Global Illumination Fast Reconstruction and Realtime "
    "Navigation</cite>, WSCG 2007",
    "A photon map knows all of a scene's indirect light, but asking it for every pixel is slow. Here it is "
    "asked once for each small voxel of the scene, and what it says becomes a few directional lights. A "
    "shader adds them up as it would any "
    "others: from every view, for bumps and for highlights, without a photon.",
    passes};
