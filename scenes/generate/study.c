/* The room with less in it, for measurements on things that move: about 4,000 triangles and quadrilaterals,
 * nine bicubic surfaces (a vase, and a cloth over the table's end) and one area light. Four scenes of the
 * same files: all at rest; the eye walks; a chair is moved; the lamp is. From time 0 to 1 that takes a
 * second; who jumps goes from one to the other at once. */
#include "mesh.h"

typedef struct motion {
    const char *name, *eye, *chair, *lamp; /* keyframes; NULL: rests */
} motion;

static const motion motions[] = {
    {"study", NULL, NULL, NULL},
    {"study-walk",
     "{\"time\": 0, \"eye\": [4.55, 1.65, 5.7], \"target\": [2.0, 0.95, 1.6]},\n    {\"time\": 1, \"eye\": "
     "[4.3, 1.6, 4.6], \"target\": [1.7, 0.9, 1.5]},\n"
     "    {\"time\": 2, \"eye\": [3.6, 1.5, 4.2], \"target\": [3.0, 0.9, 0.6]}",
     NULL, NULL},
    {"study-chair", NULL,
     "{\"time\": 0, \"translate\": [2.75, 0, 3.05], \"rotate_deg\": [0, 176, 0]}, {\"time\": 1, "
     "\"translate\": [1.85, 0, 3.5], \"rotate_deg\": [0, 128, 0]}",
     NULL},
    {"study-lamp", NULL, NULL,
     "{\"time\": 0, \"translate\": [0, 0, 0]}, {\"time\": 1, \"translate\": [1.3, 0, -1.2]}"},
};

static void write_scene(const char *folder, const motion *m) {
    const char *chair =
        m->chair ? m->chair : "{\"time\": 0, \"translate\": [2.75, 0, 3.05], \"rotate_deg\": [0, 176, 0]}";
    const char *lamp = m->lamp ? m->lamp : "{\"time\": 0, \"translate\": [0, 0, 0]}";
    const char *eye =
        m->eye ? m->eye : "{\"time\": 0, \"eye\": [4.55, 1.65, 5.7], \"target\": [2.0, 0.95, 1.6]}";
    gen_write_text(folder, m->name, ".json",
                   "{\n  \"softlux\": 1,\n  \"meshes\": [\n    {\"file\": \"study.obj\"},\n    {\"file\": "
                   "\"study-chair.obj\", \"keyframes\": [%s]},\n"
                   "    {\"file\": \"study-vase.bpt\", \"material\": \"glaze\", \"transform\": "
                   "{\"translate\": [2.72, 0.755, 2.2]}},\n"
                   "    {\"file\": \"study-cloth.bpt\", \"material\": \"linen\", \"transform\": "
                   "{\"translate\": [3.45, 0.757, 2.3]}}\n  ],\n"
                   "  \"materials\": {\"glaze\": {\"diffuse\": [0.2, 0.36, 0.55]}, \"linen\": {\"diffuse\": "
                   "[0.7, 0.62, 0.5]}},\n"
                   "  \"lights\": [\n    {\"type\": \"quad\", \"corner\": [1.7, 2.66, 2.6], \"edge1\": [1, "
                   "0, 0], \"edge2\": [0, 0, 1], \"radiance\": [16, 14.5, 12],\n"
                   "     \"keyframes\": [%s]}\n  ],\n"
                   "  \"camera\": {\"eye\": [4.55, 1.65, 5.7], \"target\": [2.0, 0.95, 1.6], \"fov_deg\": "
                   "58, \"keyframes\": [\n    %s]},\n"
                   "  \"film\": {\"width\": 512, \"height\": 512}\n}\n",
                   chair, lamp, eye);
}

static void write_curved(const char *folder) {
    static const v2 belly[4] = {{0.05, 0.0}, {0.17, 0.06}, {0.15, 0.2}, {0.07, 0.25}},
                    neck[4] = {{0.07, 0.25}, {0.03, 0.275}, {0.035, 0.33}, {0.06, 0.36}};
    gen_bicubic vase[8], cloth;
    int quarters = gen_revolve(belly, 4, vase);
    gen_write_bicubic(folder, "study-vase", vase, quarters + gen_revolve(neck, 4, vase + quarters));
    for (int v = 0; v < 4; v++) /* it lies on the table and hangs down, in a wave, over its end */
        for (int u = 0; u < 4; u++) {
            static const v2 hang[4] = {{-0.2, 0.0}, {0.36, 0.02}, {0.46, 0.02}, {0.40, -0.45}};
            double wave = v == 3 ? (u % 2 ? 0.12 : -0.02) : 0.0;
            cloth.p[v][u] = gen_v3(hang[v].x + wave, hang[v].y, -0.32 + 0.64 * u / 3.0);
        }
    gen_write_bicubic(folder, "study-cloth", &cloth, 1);
}

void gen_study(const char *folder) {
    mesh m, chair;
    gen_room_walls(&m);
    gen_mesh_init(&chair, m.materials, m.material_count);
    gen_room_chair(&chair, 0.0, 0.0, 0.0);
    gen_room_table(&m);
    gen_room_chair(&m, 3.5, 3.1, -168.0);
    gen_room_chair(&m, 2.7, 1.6, 4.0);
    gen_room_chair(&m, 3.55, 1.55, -7.0);
    gen_room_sides(&m);
    gen_write_mesh(folder, "study", &m);
    gen_write_mesh(folder, "study-chair", &chair);
    write_curved(folder);
    for (size_t i = 0; i < sizeof motions / sizeof motions[0]; i++) write_scene(folder, &motions[i]);
    gen_mesh_free(&m);
    gen_mesh_free(&chair);
}
