/* Multi-mesh caching with hardware sampling, told pass by pass. */
#include "app/steps/mathml.h"
#include "app/steps/narrative.h"

static const sl_narrative_pass passes[] = {
    {"identifiers, visible sizes", "Which triangle each pixel shows",
     "The scene is drawn once with a number for each triangle. Counted, the numbers say how large each "
     "triangle is in the picture; sorted, they hand every pixel down the quadtrees of all meshes, so that a "
     "leaf knows exactly which pixels show it, "
     "also where something else hides a part of it.",
     NULL, "sl_visible_pixels_sort(), src/cache/multi_mesh/pixels.c", NULL, SL_SHOW_IDS},
    {"material: k_d", "What each pixel reflects to all sides",
     "The diffuse reflectance, textures included. The meshes keep light alone; this picture multiplies it at "
     "the very end, so that textures stay sharp.",
     NULL, "sl_materials_resolve(), src/cache/multi_mesh/merge.c", NULL, SL_SHOW_COLOUR},
    {"material: k_s", "What each pixel reflects as a highlight",
     "The specular reflectance, a second render target of the same pass.", NULL,
     "sl_materials_resolve(), src/cache/multi_mesh/merge.c", NULL, SL_SHOW_COLOUR},
    {"vertices of the roots", "The first samples",
     "Every triangle in view is the root of a quadtree, in each mesh. Light is sampled at the roots' corners "
     "first: a picture from these alone is there at once, and all else makes it better.",
     NULL, "sl_displayed_missing(), src/cache/multi_mesh/displayed.c", NULL, SL_SHOW_LIGHT},
    {"priorities of the roots", "What matters most",
     "A leaf matters by the pixels that show it times what an eye could tell between the colours at its "
     "corners. Each node passes the largest of its children's on to the root; a heap has the root with the "
     "most on top. Bright pixels are "
     "refined first.",
     M_I("P") M_O("=") M_SUB(M_I("n"), M_T("px"))
         M_TIMES M_BRACED(M_I("&#x3B4;") M_O("+") M_SUB(M_I("&#x3B4;"), M_N("0"))),
     "sl_displayed_leaf_priority(), src/cache/multi_mesh/priorities.c", NULL, SL_SHOW_SCALAR},
    {"coarse mesh, the environment's light", "The coarse mesh gathers the environment",
     "No lamp's frustum holds an environment: the coarse mesh's vertices gather its light, past surfaces "
     "that are black as yet; added to the lamps' it is what gathers see.",
     M_SUB(M_I("U"), M_T("dd")) M_O("+") M_FRAC(M_SUB(M_I("E"), M_I("i")), M_I("&#x3C0;")),
     "sl_multi_mesh_extend_coarse(), src/cache/multi_mesh/coarse_light.c", NULL, SL_SHOW_LIGHT},
    {"coarse mesh, second bounce", "The coarse mesh gathers, too",
     "For a second bounce the coarse mesh's vertices gather what the others reflect; added to the direct "
     "light it is what all later gathers see.",
     M_SUB(M_I("U"), M_T("dd")) M_O("+") M_FRAC(M_SUB(M_I("E"), M_I("i")), M_I("&#x3C0;")),
     "sl_multi_mesh_extend_coarse(), src/cache/multi_mesh/coarse_light.c", NULL, SL_SHOW_LIGHT},
    {"coarse mesh", "A coarse mesh of everything",
     "Indirect light comes from surfaces that no camera sees. So the whole scene, cut into large triangles, "
     "gets direct light at its vertices, times what it reflects. It is coarse because a hemisphere of it is "
     "averaged anyway.",
     M_SUB(M_I("L"), M_T("coarse")) M_O("=") M_FRAC(M_SUB(M_I("k"), M_I("d")), M_I("&#x3C0;"))
         M_SUM(M_T("lights")) M_SUB(M_I("E"), M_I("l")),
     "sl_multi_mesh_extend_coarse(), src/cache/multi_mesh/coarse_light.c", NULL, SL_SHOW_LIGHT},
    {"one gather", "Indirect light at one point",
     "For each vertex of the indirect mesh the coarse mesh is drawn once, over a field of view of 160 "
     "degrees straight up from the surface. Each pixel counts by its share of the hemisphere and its cosine, "
     "from a texture made once; "
     "halving the picture again and again adds all of it up. This is what the point in the middle of the "
     "largest triangle in view sees.",
     M_SUB(M_I("E"), M_I("i")) M_O("=") M_I("&#x3C0;") M_SUM(M_T("pixels")) M_I("&#x394;G")
         M_TIMES M_SUB(M_I("L"), M_T("coarse")),
     "sl_mesh_gather_take(), src/cache/hemisphere/mesh_gather.c", NULL, SL_SHOW_LIGHT},
    {"direct diffuse radiance", "Direct light",
     "The triangles' leaves are drawn with the colours of their vertices in between. Vertices that a "
     "neighbour has on a common edge count on both sides, so there are no cracks and no steps. Each vertex "
     "sums what the lights' own meshes say.",
     M_SUB(M_I("U"), M_T("dd")) M_O("=") M_FRAC(M_N("1"), M_I("&#x3C0;")) M_SUM(M_T("lights"))
         M_SUB(M_I("E"), M_I("l")),
     "sl_displayed_draw(), src/cache/multi_mesh/displayed.c", "direct", SL_SHOW_LIGHT},
    {"edges of the direct diffuse mesh", "The mesh of direct light",
     "A leaf is cut in four where the middle of an edge differs from the mean of its ends by more than an "
     "eye can tell, at the final pixel, tone mapping included; and where it is too large to rule out that "
     "something hides between its "
     "corners. What was cut in vain is put together again: only shadows' borders stay fine.",
     M_ABS(M_I("D") M_BRACED(M_FRAC(M_SUB(M_I("L"), M_I("a")) M_O("+") M_SUB(M_I("L"), M_I("b")), M_N("2")))
               M_O("&#x2212;") M_I("D") M_BRACED(M_SUB(M_I("L"), M_T("middle")))) M_O("&gt;") M_I("T"),
     "sl_displayed_test_edge(), src/cache/multi_mesh/refine.c", NULL, SL_SHOW_LIGHT},
    {"direct specular radiance", "Highlights",
     "Each lamp is shrunk to a point as far as the lobe is concerned; how much of it is seen comes from the "
     "same irradiance meshes. Highlights move with the eye, so this mesh starts again with every new view.",
     M_SUB(M_I("U"), M_T("ds")) M_O("=") M_FRAC(M_I("n") M_O("+") M_N("2"), M_N("2") M_I("&#x3C0;"))
         M_SUM(M_T("lights")) M_SUP(M_T("cos"), M_I("n")) M_SUB(M_I("&#x3B1;"), M_I("l"))
             M_TIMES M_SUB(M_I("E"), M_I("l")),
     "sl_direct_specular(), src/cache/multi_mesh/direct.c", "specular", SL_SHOW_LIGHT},
    {"edges of the direct specular mesh", "The mesh of highlights",
     "It is fine where a highlight begins, and knows nothing of shadows where there is none.", NULL,
     "sl_displayed_commit(), src/cache/multi_mesh/refine.c", NULL, SL_SHOW_LIGHT},
    {"indirect irradiance", "Indirect light",
     "The third mesh holds irradiance that its vertices gathered. Until the coarse mesh is whole a constant "
     "stands in: the lamps' power over all surfaces, times their mean reflectance.",
     M_SUB(M_I("L"), M_T("id")) M_O("=") M_FRAC(M_SUB(M_I("k"), M_I("d")), M_I("&#x3C0;"))
         M_SUB(M_I("E"), M_I("i")),
     "sl_displayed_draw(), src/cache/multi_mesh/displayed.c", "indirect", SL_SHOW_LIGHT},
    {"edges of the indirect mesh", "The mesh of indirect light",
     "Indirect light changes slowly, and its mesh is the coarsest: that is why it is one of its own.", NULL,
     "sl_displayed_commit(), src/cache/multi_mesh/refine.c", NULL, SL_SHOW_LIGHT},
    {"edges of the first light's irradiance mesh", "A mesh for each light",
     "The paper's central point: each light has a mesh of its own for the share of it that arrives. The "
     "shadow of one light is not sampled again for all others. The direct meshes ask it for values; it is "
     "cut, and sampled, only where they do.",
     M_I("F") M_O("=") M_FRAC(M_SUB(M_I("E"), M_I("l")), M_I("&#x3C0;") M_I("L")),
     "sl_irradiance_at(), src/cache/multi_mesh/irradiance.c", NULL, SL_SHOW_LIGHT},
    {"edges of the second light's irradiance mesh", "... and another",
     "The second light's mesh follows its own shadows.", NULL,
     "sl_irradiance_at(), src/cache/multi_mesh/irradiance.c", NULL, SL_SHOW_LIGHT},
    {"one light sample", "How much of a lamp a vertex sees",
     "The scene is drawn from the vertex into the frustum that just holds the lamp. Every pixel in which the "
     "lamp is in front counts by its solid angle and its cosine, all others are black: a shadow's border is "
     "sampled 4,096 times at once. "
     "This is a vertex that sees about half of the first light.",
     M_I("F") M_O("=") M_SUM(M_T("pixels that see the lamp"))
         M_FRAC(M_I("h") M_TIMES M_T("cos") M_I("&#x3B8;"), M_I("&#x3C0;") M_TIMES M_SUP(M_I("r"), M_N("3")))
             M_TIMES M_I("&#x394;A"),
     "sl_light_sample_take(), src/cache/light/light_sample.c", NULL, SL_SHOW_SCALAR},
    {"... reduced to 16 x 16", "... added up",
     "Two by two pixels become one, again and again, until 16 by 16 are left: only these are read back and "
     "added by the processor.",
     NULL, "sl_raster_reduce(), src/raster/fragments/reduce.c", NULL, SL_SHOW_SCALAR},
    {"merge", "The picture",
     "One pass over the screen multiplies light by what is reflected, and adds up. While the eye rests it is "
     "all that is done for a new picture, whatever the meshes' size.",
     M_I("L") M_O("=") M_SUB(M_I("k"), M_I("d"))
         M_BRACED(M_SUB(M_I("U"), M_T("dd")) M_O("+") M_FRAC(M_SUB(M_I("E"), M_I("i")), M_I("&#x3C0;")))
             M_O("+") M_SUB(M_I("k"), M_I("s")) M_SUB(M_I("U"), M_T("ds")) M_O("+") M_SUB(M_I("L"), M_I("e")),
     "sl_merge_picture(), src/cache/multi_mesh/merge.c", NULL, SL_SHOW_LIGHT},
    {NULL, NULL, NULL, NULL, NULL, NULL, SL_SHOW_LIGHT}};

const sl_narrative sl_multi_mesh_narrative = {
    "multi-mesh",
    "<cite>Multi-mesh caching and hardware sampling for progressive and interactive rendering</cite>",
    "Light is kept at the vertices of meshes over the scene's own triangles, and in between the rasterizer's "
    "interpolation fills in. Direct light, highlights and indirect light change in different places, and so "
    "does each lamp's light: each has "
    "a mesh of its own, refined only where its own edges are. The samples themselves are pictures, too: what "
    "a vertex sees of a lamp, or of the hemisphere above it, is drawn and added up.",
    passes};
