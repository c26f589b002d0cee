/* The scene file: JSON beside a mesh, surfaces, a texture and a sky. */
#include "support.h"

#include <string.h>

static const char obj[] =
    "mtllib a.mtl\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv -1 2 -1\nv 1 2 -1\nvt 0 0\nvt 1 0\nvt 1 1\n"
    "usemtl floor\nf 4/1 3/2 2/3\nf 4/1 2/2 1/3\nusemtl wall\nf 1/1 2/2 6/3\nf 1 6 5\n";
static const char mtl[] =
    "newmtl floor\nKd .7 .6 .5\nmap_Kd t.png\nnewmtl wall\nKd .2 .3 .4\nKs .3 .3 .3\nNs 20\n";
static const char bpt[] = "1\n3 3\n0 0 0  1 0 0  2 0 0  3 0 0\n0 1 0  1 1 1  2 1 1  3 1 0\n0 2 0  1 2 1  2 2 "
                          "1  3 2 0\n0 3 0  1 3 0  2 3 0  3 3 0\n";
static const char gltf[] = "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                           "\"nodes\":[{\"mesh\":0,\"name\":\"n\"}],"
                           "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],"
                           "\"materials\":[{\"name\":\"wall\"}],"
                           "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":"
                           "\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}],"
                           "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":"
                           "36,\"uri\":\"data:application/octet-stream;base64,"
                           "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}";

static void write_pictures(void) {
    sl_image *image = NULL;
    sl_error error;
    if (sl_image_create(4, 2, 3, NULL, &image, &error) != SL_OK) fuzz_fail(error.message);
    for (int i = 0; i < 24; i++) image->planes[i] = (float)(i * i) * 0.002f;
    fuzz_write("t.png", "", 0); /* so that they are removed */
    fuzz_write("e.pfm", "", 0);
    if (sl_image_write(image, fuzz_path("t.png"), &error) != SL_OK ||
        sl_image_write(image, fuzz_path("e.pfm"), &error) != SL_OK)
        fuzz_fail(error.message);
    sl_image_destroy(image);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static bool ready;
    if (!ready) {
        fuzz_write("a.obj", obj, strlen(obj));
        fuzz_write("a.mtl", mtl, strlen(mtl));
        fuzz_write("p.bpt", bpt, strlen(bpt));
        fuzz_write("g.gltf", gltf, strlen(gltf));
        write_pictures();
        ready = true;
    }
    fuzz_write("s.json", data, size);
    sl_scene *scene = NULL;
    sl_error error = {0};
    if (sl_scene_load(fuzz_path("s.json"), &scene, &error) == SL_OK)
        fuzz_check_scene(scene, fuzz_hash(data, size));
    else fuzz_check_error(&error);
    if (error.status != SL_OK && scene) fuzz_fail("a scene in spite of an error");
    sl_scene_destroy(scene);
    return 0;
}
