/* Radiance cache splatting, told pass by pass. */
#include "app/steps/mathml.h"
#include "app/steps/narrative.h"

static const sl_narrative_pass passes[] = {
    {"G-buffer: depth", "How far each pixel is",
     "The scene is drawn once, from the camera. For every pixel the rasterizer keeps what shading will need, "
     "so that no later pass touches a triangle again: "
     "first the depth, by which nearer triangles win.",
     NULL, "sl_raster_gbuffer(), src/raster/resolve/gbuffer.c", NULL, SL_SHOW_SCALAR},
    {"G-buffer: positions", "Where each pixel is",
     "The point of the world that each pixel shows, here as colours within the box of all that is seen.",
     NULL, "sl_raster_gbuffer(), src/raster/resolve/gbuffer.c", NULL, SL_SHOW_POSITIONS},
    {"G-buffer: normals", "Which way each pixel faces",
     "The surface's normal, turned to the side that is seen. Grey-blue walls, green floors: two pixels of "
     "one colour face the same way.",
     NULL, "sl_raster_gbuffer(), src/raster/resolve/gbuffer.c", NULL, SL_SHOW_NORMALS},
    {"G-buffer: albedo", "What each pixel reflects",
     "The diffuse reflectance, textures included. Light is cached without it, so that textures stay sharp.",
     NULL, "sl_raster_gbuffer(), src/raster/resolve/gbuffer.c", NULL, SL_SHOW_COLOUR},
    {"direct light", "Direct light",
     "Light that comes straight from the lamps. It changes fast, at the edges of shadows, and so is not "
     "cached: every pixel finds its own, by rays to the lamps or by shadow maps.",
     M_SUB(M_I("L"), M_I("d")) M_O("=") M_FRAC(M_I("&#x3C1;"), M_I("&#x3C0;")) M_SUM(M_T("lamps"))
         M_SUB(M_I("E"), M_I("l")) M_TIMES M_SUB(M_I("V"), M_I("l")),
     "sl_direct_rows(), src/cache/light/direct.c", "direct", SL_SHOW_LIGHT},
    {"coverage: sum of w", "What is covered",
     "The sum of the weights of all records at each pixel. Where it stays below the accuracy's threshold "
     "nothing is near enough, and the pixel asks for a record of its own: a whole hemisphere is gathered "
     "there. "
     "Visited from coarse to fine, few pixels have to ask.",
     M_SUM(M_I("k")) M_SUB(M_I("w"), M_I("k")) M_BRACED(M_I("p")) M_O("&#x2265;") M_SUB(M_I("w"), M_T("min")),
     "sl_traversal_advance(), src/cache/splatting/traversal.c", NULL, SL_SHOW_SCALAR},
    {"gather of one record", "What a record sees",
     "The hemisphere above one point, the one nearest to the middle of the picture: as many cells as rays "
     "(or as pixels, where it is rasterized on one plane or on the five faces of half a cube), each with the "
     "light that comes from there. "
     "Their weighted sum is the record's irradiance; how it changes from cell to cell tells its gradients.",
     M_I("E") M_O("=") M_FRAC(M_I("&#x3C0;"), M_SUP(M_I("N"), M_N("2"))) M_SUM(M_I("i") M_O(",") M_I("j"))
         M_SUB(M_I("L"), M_I("i") M_I("j")),
     "sl_gather_irradiance(), src/cache/hemisphere/gather.c", NULL, SL_SHOW_LIGHT},
    {"gather of one record: where", "Where that is", "The point whose hemisphere that was.", NULL,
     "sl_splat_announce_gather(), src/cache/splatting/explanation.c", NULL, SL_SHOW_LIGHT},
    {"records", "The records",
     "Each disc is a record: irradiance that was gathered at its middle, with its gradients, and how far it "
     "is good for. Near corners and edges light changes quickly, and records are small and many; on open "
     "walls few are enough.",
     M_SUB(M_I("R"), M_I("k")) M_O("=") M_T("harmonic mean of the distances seen"),
     "sl_record_make(), src/cache/splatting/record.c", NULL, SL_SHOW_LIGHT},
    {"splat: sum of w E", "Records are splatted: light",
     "Every record is drawn as a square that covers the sphere of its influence. For each pixel under it the "
     "fragment program works out the weight and the irradiance there, by the record's gradients, and adds w "
     "E to what is there: the "
     "hardware's blending is the cache's look-up, turned inside out.",
     M_SUB(M_I("w"), M_I("k")) M_O("=") M_FRAC(
         M_N("1"), M_FRAC(M_ABS(M_I("p") M_O("-") M_SUB(M_I("p"), M_I("k"))), M_SUB(M_I("R"), M_I("k")))
                       M_O("+") M_SQRT(M_N("1") M_O("-") M_I("n") M_TIMES M_SUB(M_I("n"), M_I("k")))),
     "sl_splat_records(), src/cache/splatting/splat.c", NULL, SL_SHOW_LIGHT},
    {"splat: sum of w times", "Records are splatted: what glossy surfaces reflect",
     "A radiance record keeps the incoming light as coefficients of hemispherical harmonics. At each glossy "
     "pixel the lobe of its material is turned into the record's frame, and the two are multiplied: two "
     "short vectors.",
     M_SUB(M_I("L"), M_I("o")) M_O("=") M_SUM(M_I("l") M_O(",") M_I("m"))
         M_SUBSUP(M_I("&#x3BB;"), M_I("l"), M_I("m")) M_SUBSUP(M_I("c"), M_I("l"), M_I("m"))
             M_BRACED(M_SUB(M_I("&#x3C9;"), M_I("o"))),
     "sl_glossy_radiance(), src/cache/splatting/glossy_kernels.c", NULL, SL_SHOW_LIGHT},
    {"splat: sum of w", "Records are splatted: weights",
     "The same squares add their weights alone. Bright spots are the middles of records.", NULL,
     "sl_splat_records(), src/cache/splatting/splat.c", NULL, SL_SHOW_SCALAR},
    {"indirect light", "Indirect light",
     "Each pixel divides one sum by the other: the weighted mean of what the records say. Times its albedo "
     "it is the light that came by way of other surfaces.",
     M_SUB(M_I("L"), M_I("i")) M_O("=") M_FRAC(M_I("&#x3C1;"), M_I("&#x3C0;")) M_TIMES M_FRAC(
         M_SUM(M_I("k")) M_SUB(M_I("w"), M_I("k")) M_SUBSUP(M_I("E"), M_I("k"), M_O("&#x2032;")),
         M_SUM(M_I("k")) M_SUB(M_I("w"), M_I("k"))),
     "sl_compose(), src/cache/splatting/compose.c", "indirect", SL_SHOW_LIGHT},
    {"indirect glossy light", "Indirect glossy light",
     "The same for what glossy surfaces reflect, times their specular reflectance.", NULL,
     "sl_compose(), src/cache/splatting/compose.c", "glossy", SL_SHOW_LIGHT},
    {"sum of emission, direct and indirect light", "The picture",
     "Light that is emitted, direct and indirect light together.",
     M_I("L") M_O("=") M_SUB(M_I("L"), M_I("e")) M_O("+") M_SUB(M_I("L"), M_I("d")) M_O("+")
         M_SUB(M_I("L"), M_I("i")),
     "sl_compose(), src/cache/splatting/compose.c", NULL, SL_SHOW_LIGHT},
    {NULL, NULL, NULL, NULL, NULL, NULL, SL_SHOW_LIGHT}};

const sl_narrative sl_splatting_narrative = {
    "splatting",
    "Gautron, K&#x159;iv&aacute;nek, Bouatouch, Pattanaik: <cite>Radiance Cache Splatting: A GPU-Friendly "
    "Global Illumination Algorithm</cite>, 2005",
    "Indirect light on diffuse surfaces changes slowly. So it is gathered at a few points only, the records, "
    "and interpolated between them. Where the classic cache searches a tree for the records near each point, "
    "this one "
    "draws every record onto the screen, over all the pixels that it can serve, and lets blending add them "
    "up.",
    passes};
