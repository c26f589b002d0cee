/* Direct Radiance Mapping, told pass by pass. */
#include "app/steps/mathml.h"
#include "app/steps/narrative.h"

static const sl_narrative_pass passes[] = {
    {"depth cubes", "What each light sees: how far",
     "The scene is drawn six times around each light, and only depths are kept: a point whose distance to "
     "the light is greater than what the cube says lies in shadow.",
     NULL, "sl_shadow_cubes_render(), src/cache/direct_radiance/direct.c", NULL, SL_SHOW_SCALAR},
    {"map of positions", "What each light sees: where",
     "The direct radiance map is a small picture taken from the light (a frustum, half a cube or a whole "
     "one, its faces one above another). Its texels hold the points that are lit directly: they are what "
     "will shine on everything else.",
     NULL, "sl_radiance_map_render(), src/cache/direct_radiance/map.c", NULL, SL_SHOW_POSITIONS},
    {"map of radiance", "What each light sees: how bright",
     "The radiance that leaves each of these points after one reflection of the light that falls on it.",
     M_SUB(M_I("L"), M_I("o")) M_O("=") M_FRAC(M_I("&#x3C1;"), M_I("&#x3C0;"))
         M_TIMES M_FRAC(M_I("I"), M_SUP(M_I("b"), M_N("2"))) M_TIMES M_T("cos") M_I("&#x3B1;"),
     "sl_radiance_map_render(), src/cache/direct_radiance/map.c", NULL, SL_SHOW_LIGHT},
    {"map of true colour", "What each light sees: how bright",
     "Where a surface is glossy its reflection depends on who looks, so the map holds the light that "
     "arrives, and reflections are worked out for each receiver.",
     NULL, "sl_radiance_map_render(), src/cache/direct_radiance/map.c", NULL, SL_SHOW_LIGHT},
    {"map of normals", "What each light sees: which way",
     "The normals of the lit points: light leaves them on this side only.", NULL,
     "sl_radiance_map_render(), src/cache/direct_radiance/map.c", NULL, SL_SHOW_NORMALS},
    {"sample photons", "Sample photons",
     "Of all texels a few are taken as photons: each stands for the light of the block of texels around it, "
     "gathered into one point for each surface. They are drawn here where they lie, in the colour of their "
     "flux.",
     M_I("&#x3A8;") M_O("=") M_FRAC(M_I("&#x3C1;"), M_I("&#x3C0;")) M_TIMES M_I("I") M_TIMES M_I("d&#x3A9;"),
     "sl_map_photons_take(), src/cache/direct_radiance/photons.c", NULL, SL_SHOW_LIGHT},
    {"G-buffer: depth", "How far each pixel is",
     "The scene is drawn from the camera, planar mirrors with what they show; for every pixel the rasterizer "
     "keeps what shading will need.",
     NULL, "sl_receivers_render(), src/cache/direct_radiance/receivers.c", NULL, SL_SHOW_SCALAR},
    {"G-buffer: positions", "Where each pixel is", "The point of the world that each pixel shows.", NULL,
     "sl_receivers_render(), src/cache/direct_radiance/receivers.c", NULL, SL_SHOW_POSITIONS},
    {"G-buffer: normals", "Which way each pixel faces", "The normal, turned to where the pixel is seen from.",
     NULL, "sl_receivers_render(), src/cache/direct_radiance/receivers.c", NULL, SL_SHOW_NORMALS},
    {"G-buffer: albedo", "What each pixel reflects", "The diffuse reflectance, textures included.", NULL,
     "sl_receivers_render(), src/cache/direct_radiance/receivers.c", NULL, SL_SHOW_COLOUR},
    {"direct light", "Direct light",
     "Each pixel sums the lights that the depth cubes say it sees. A curved mirror shows a cube of pictures "
     "that "
     "was drawn around its middle, lit like everything else.",
     M_SUB(M_I("L"), M_I("d")) M_O("=") M_SUM(M_T("lights")) M_SUB(M_I("f"), M_I("r")) M_TIMES M_I("V")
         M_TIMES M_FRAC(M_I("I"), M_SUP(M_I("r"), M_N("2"))) M_TIMES M_T("cos") M_I("&#x3B8;"),
     "sl_direct_light_tile(), src/cache/direct_radiance/direct.c", "direct", SL_SHOW_LIGHT},
    {"indirect light", "Indirect light",
     "Each pixel sums all sample photons: no search, no structure, the same few for everyone. A photon is no "
     "point but has an area; so its weight stays bounded for receivers that are near. The paper leaves out "
     "whether a photon is seen, and "
     "so light passes through walls; visibility is an option here.",
     M_SUB(M_I("L"), M_I("r")) M_O("=") M_SUM(M_I("j")) M_SUB(M_I("f"), M_I("r"))
         M_TIMES M_SUB(M_I("&#x3A8;"), M_I("j")) M_TIMES M_FRAC(
             M_T("cos") M_I("&#x3B8;") M_TIMES M_T("cos") M_SUP(M_I("&#x3B8;"), M_O("&#x2032;")),
             M_SUP(M_I("r"), M_N("2")) M_O("+") M_FRAC(M_I("A"), M_I("&#x3C0;"))),
     "sl_indirect_light_tile(), src/cache/direct_radiance/indirect.c", "indirect", SL_SHOW_LIGHT},
    {NULL, NULL, NULL, NULL, NULL, NULL, SL_SHOW_LIGHT}};

const sl_narrative sl_direct_radiance_narrative = {
    "direct-radiance",
    "Frisvad, Frisvad, Christensen, Falster: <cite>Scene Independent Real-Time Indirect Illumination</cite>, "
    "2005",
    "One bounce of indirect light leaves from the surfaces that the lights see. So a picture is taken from "
    "each light, a few of its texels become photons, and every pixel sums them. Everything is made anew in "
    "every frame: lights, objects "
    "and camera may move as they like, and the price does not depend on the scene.",
    passes};
