/* The Shading Cache, told pass by pass. */
#include "app/steps/mathml.h"
#include "app/steps/narrative.h"

static const sl_narrative_pass passes[] = {
    {"id map", "Which patch each pixel shows",
     "Every triangle, quadrilateral and curved surface is the root of a tree of patches. The hardware draws "
     "the geometry as it is, and each pixel keeps the leaf that it shows, here in a colour of its own. "
     "Counting pixels by their colours tells how large each patch is on the screen, and what nobody sees "
     "costs nothing.",
     NULL, "sl_display_id_map(), src/cache/shading_cache/draw.c", NULL, SL_SHOW_IDS},
    {"priorities", "Where samples are wanted most",
     "Shading is known at a patch's corners, and blended in between. The more its corners differ, as "
     "displayed, the more that blend may hide: that difference, in grey levels, is its priority. What was "
     "shaded before something moved grows older, and "
     "its priority with it. Patches never shaded come first.",
     M_SUB(M_I("p"), M_T("norm")) M_O("=")
         M_FRAC(M_I("p") M_O("-") M_SUB(M_I("p"), M_T("low")),
                M_SUB(M_I("p"), M_T("high")) M_O("-") M_SUB(M_I("p"), M_T("low"))) M_O(",") M_I("p") M_O("=")
             M_SUB(M_I("p"), M_T("error")) M_O("+") M_SUB(M_I("p"), M_T("age")),
     "sl_patch_priority(), src/cache/shading_cache/priority.c", NULL, SL_SHOW_SCALAR},
    {"selection", "Pixels are chosen",
     "Pixels are drawn at random and kept with the chance that their priority gives (green), a few whatever "
     "it is, as corners that agree may have a shadow between them (blue). From those that hit, a flood runs "
     "over neighbours "
     "that want samples as badly (red): along the edge of a shadow.",
     M_SUB(M_I("p"), M_T("total")) M_O("=") M_I("&#x3B5;") M_O("+") M_BRACED(M_N("1") M_O("-") M_I("&#x3B5;"))
         M_SUB(M_I("p"), M_T("norm")),
     "sl_hit_and_test(), src/cache/shading_cache/shading_cache.c", NULL, SL_SHOW_LIGHT},
    {"requests", "Patches are split, corners asked for",
     "A chosen place asks for its patch's corners if they have no samples yet. If they have, and the patch "
     "is larger than a pixel, it is cut in four, and the new corners of the part that holds the place are "
     "asked for. Corners are shared: "
     "nobody is asked for twice.",
     NULL, "sl_work_out(), src/cache/shading_cache/work.c", NULL, SL_SHOW_LIGHT},
    {"samples", "Samples are computed",
     "All corners that were asked for go to the sample renderers as one batch: direct light by points spread "
     "over the lamps, the rest by bidirectional paths. Nothing but the scene and the request decides an "
     "answer, so that any number of processors, "
     "here or elsewhere, may share the work. It is nearly all of the work there is.",
     M_SUB(M_I("E"), M_I("d")) M_O("=") M_SUM(M_T("lamps")) M_FRAC(M_I("A"), M_I("N")) M_SUM(M_I("i"))
         M_I("L") M_TIMES M_I("V") M_TIMES M_FRAC(M_I("cos") M_SUB(M_I("&#x3B8;"), M_I("x"))
                                                      M_TIMES M_I("cos") M_SUB(M_I("&#x3B8;"), M_I("i")),
                                                  M_SUP(M_I("r"), M_N("2"))),
     "sl_shading_sample(), src/cache/shading_cache/shading_cache.c", NULL, SL_SHOW_LIGHT},
    {"commit", "Values take their places; changes are noticed",
     "A value that replaces one made with the same random numbers can differ for one reason only: the scene "
     "has changed there. Then its object is shown with coarser patches until they are all shaded anew. "
     "Patches that nobody has seen for long make room.",
     M_ABS(M_I("D") M_BRACED(M_SUB(M_I("E"), M_T("new"))) M_O("-") M_I("D")
               M_BRACED(M_SUB(M_I("E"), M_T("old")))) M_O(">") M_SUB(M_I("&#x3C4;"), M_I("c")),
     "sl_shading_commit(), src/cache/shading_cache/shading_cache.c", NULL, SL_SHOW_LIGHT},
    {"display arrays", "What is shown is brought up to date",
     "The trees and their colours are kept twice. One copy is shown, frame after frame, from wherever camera "
     "and objects are by then; the other one takes in what has changed, and the two are swapped. So the "
     "display never waits for samples.",
     NULL, "sl_display_build(), src/cache/shading_cache/arrays.c", NULL, SL_SHOW_LIGHT},
    {"patches", "The patches that are seen",
     "The leaves of all trees, by their edges. They are small where light changes quickly and large where it "
     "does not; and no smaller than a pixel.",
     NULL, "sl_patch_split(), src/cache/patches/patches.c", NULL, SL_SHOW_LIGHT},
    {"vertices", "The samples that are kept",
     "The corners of patches that have been shaded, in the colour of the irradiance there. Diffuse surfaces "
     "keep irradiance, which textures multiply pixel by pixel; others also keep the radiance that leaves "
     "towards the eye.",
     NULL, "sl_patches_root(), src/cache/patches/patches.c", NULL, SL_SHOW_LIGHT},
    {"display", "The picture",
     "Each pixel finds its leaf, blends what its corners hold, and multiplies by its texture: Gouraud "
     "shading, of patches in the place of triangles. Beside smaller leaves a patch is drawn as a fan, so "
     "that colours meet along its edges.",
     M_I("L") M_O("=") M_SUB(M_I("L"), M_I("e")) M_O("+") M_FRAC(M_I("&#x3C1;"), M_I("&#x3C0;"))
         M_SUM(M_T("corners")) M_I("w") M_TIMES M_I("E") M_O("+") M_SUM(M_T("corners")) M_I("w")
             M_TIMES M_SUB(M_I("L"), M_I("s")),
     "sl_display_draw(), src/cache/shading_cache/draw.c", NULL, SL_SHOW_LIGHT},
    {NULL, NULL, NULL, NULL, NULL, NULL, SL_SHOW_LIGHT}};

const sl_narrative sl_shading_cache_narrative = {
    "shading-cache",
    "Tole, Pellacini, Walter, Greenberg: <cite>Interactive Global Illumination in Dynamic Scenes</cite>, "
    "2002",
    "Shading is slow and display is fast. So shading is computed at few points only, at the corners of "
    "patches on the objects, and the display blends it in between, sixty times a second if need be. Each "
    "update asks where on the screen the blend is "
    "most likely to be wrong, and spends a handful of samples there. Objects, lights and the camera may move "
    "all the while: the picture follows at once, the shading as fast as it can.",
    passes};
