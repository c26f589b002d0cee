/* The answer of the importer's process is read as a stranger's file is: the input's bytes stand between a
 * reply's header and its end. */
#include "support.h"

#include <stdlib.h>
#include <string.h>

#include "scene/import_reply.h"

/* A block as long as the reply, for the address sanitizer. */
static char *make_reply(const uint8_t *data, size_t size, size_t *bytes) {
    *bytes = SL_IMPORT_HEADER_BYTES + size + 4;
    char *reply = malloc(*bytes);
    if (!reply) fuzz_fail("no memory");
    memcpy(reply, (const uint32_t[4]){SL_IMPORT_MAGIC, SL_IMPORT_VERSION, (uint32_t)*bytes, 0}, 16);
    if (size) memcpy(reply + SL_IMPORT_HEADER_BYTES, data, size);
    memcpy(reply + *bytes - 4, (const uint32_t[1]){SL_IMPORT_MAGIC}, 4);
    return reply;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    size_t bytes;
    char *reply = make_reply(data, size, &bytes);
    sl_model model = {0};
    sl_scene *scene = NULL;
    sl_error error = {0};
    sl_status status = sl_import_reply_read("i.ply", reply, bytes, &model, &error);
    if (status == SL_OK) status = sl_model_build(&model, &scene, &error);
    if (status != SL_OK) fuzz_check_error(&error);
    else fuzz_check_scene(scene, fuzz_hash(data, size));
    sl_scene_destroy(scene);
    sl_model_clear(&model);
    free(reply);
    return 0;
}
