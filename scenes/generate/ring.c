/* A polished ring on a table beside a book, under one small lamp: light that its inside throws back meets in
 * a bright cusped line on the table. The ring is moved from time 0 to 1. */
#include "mesh.h"

enum { TABLE, WALL, BOOK, METAL, MATERIALS };

static const gen_material materials[MATERIALS] = {
    [TABLE] = {"table", "Kd 0.62 0.55 0.45\n"},
    [WALL] = {"wall", "Kd 0.6 0.62 0.65\n"},
    [BOOK] = {"book", "Kd 0.5 0.16 0.12\n"},
    [METAL] = {"metal", "Kd 0 0 0\nKs 0.92 0.84 0.62\nillum 3\n"},
};

void gen_ring(const char *folder) {
    static const v2 band[] = {{0.2, 0.0},   {0.222, 0.0}, {0.222, 0.0}, {0.222, 0.1},
                              {0.222, 0.1}, {0.2, 0.1},   {0.2, 0.1},   {0.2, 0.0}};
    mesh m, ring;
    gen_mesh_init(&m, materials, MATERIALS);
    gen_mesh_init(&ring, materials, MATERIALS);
    gen_paint(&m, "table", TABLE);
    gen_panel(&m, gen_v3(-1, 0, 0.7), gen_v3(1, 0, 0.7), gen_v3(1, 0, -0.7), gen_v3(-1, 0, -0.7), 4, 3);
    gen_paint(&m, "wall", WALL);
    gen_panel(&m, gen_v3(-1, 0, -0.7), gen_v3(1, 0, -0.7), gen_v3(1, 1, -0.7), gen_v3(-1, 1, -0.7), 4, 2);
    gen_paint(&m, "book", BOOK);
    frame before = gen_move(&m, -0.55, 0.0, -0.25);
    gen_turn(&m, 25.0);
    gen_box(&m, gen_v3(-0.15, 0.0, -0.1), gen_v3(0.15, 0.05, 0.1));
    m.frame = before;
    gen_paint(&ring, "ring", METAL);
    gen_lathe(&ring, band, sizeof band / sizeof band[0], 96);
    gen_write_mesh(folder, "ring-table", &m);
    gen_write_mesh(folder, "ring", &ring);
    gen_write_text(folder, "ring", ".json",
                   "{\n  \"softlux\": 1,\n  \"meshes\": [\n    {\"file\": \"ring-table.obj\"},\n"
                   "    {\"file\": \"ring.obj\", \"keyframes\": [{\"time\": 0, \"translate\": [-0.1, 0, "
                   "0.15]}, {\"time\": 1, \"translate\": [0.3, 0, -0.1]}]}\n  ],\n"
                   "  \"lights\": [\n    {\"type\": \"quad\", \"corner\": [0.85, 0.95, 0.05], \"edge1\": "
                   "[0.085, -0.085, 0], \"edge2\": [0, 0, 0.12], \"radiance\": [300, 280, 240]}\n  ],\n"
                   "  \"camera\": {\"eye\": [0.15, 1.25, 1.35], \"target\": [0.08, 0.0, -0.02], \"fov_deg\": "
                   "42},\n  \"film\": {\"width\": 512, \"height\": 512}\n}\n");
    gen_mesh_free(&m);
    gen_mesh_free(&ring);
}
