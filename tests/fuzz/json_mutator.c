/* Mutations that keep a scene file JSON: so the fuzzer gets behind the parser. One in eight is left to
 * libFuzzer, byte by byte. */
#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed);

/* Every key there is, for others to take their values from. */
static const char whole[] =
    "{\"softlux\": 1, \"up\": \"z\", \"meshes\": [{\"file\": \"a.obj\", \"name\": \"m\", \"material\": "
    "\"wall\", \"normals\": \"faceted\", \"transform\": "
    "{\"translate\": [0, 1, 2], \"rotate_deg\": [10, 20, 30], \"scale\": [1, 2, -1]}, \"keyframes\": "
    "[{\"time\": 0}, {\"time\": 2, \"translate\": [1, 0, 0], "
    "\"rotate_deg\": [0, 90, 0], \"scale\": 2}]}, {\"file\": \"p.bpt\", \"transform\": [1,0,0,0, 0,1,0,0, "
    "0,0,1,0, 5,0,0,1]}, {\"file\": \"g.gltf\"}], "
    "\"materials\": {\"wall\": {\"diffuse\": [0.2, 0.3, 0.4], \"specular\": 0.3, \"exponent\": 30, "
    "\"emission\": [1, 2, 3], \"two_sided\": true, \"texture\": "
    "\"t.png\", \"alpha\": \"t.png\", \"bump\": \"t.png\", \"bump_depth\": 0.5}, \"floor\": {\"mirror\": "
    "0.9, \"texture\": null}}, \"lights\": [{\"type\": \"point\", "
    "\"name\": \"l\", \"position\": [0, 1, 0], \"intensity\": 5, \"keyframes\": [{\"time\": 0, \"position\": "
    "[0, 2, 0]}]}, {\"type\": \"spot\", \"position\": [0, 1, 1], "
    "\"direction\": [0, -1, 0], \"intensity\": [1, 1, 1], \"inner_deg\": 10, \"outer_deg\": 30, "
    "\"keyframes\": [{\"time\": 1, \"direction\": [1, 0, 0]}]}, {\"type\": "
    "\"directional\", \"direction\": [0, -1, 0], \"irradiance\": 1}, {\"type\": \"quad\", \"corner\": [0, "
    "1.9, 0], \"edge1\": [0.5, 0, 0], \"edge2\": [0, 0, 0.5], "
    "\"radiance\": 10, \"two_sided\": false}, {\"type\": \"quad\", \"corner\": [0, 1, 0], \"edge1\": [0, 0, "
    "1], \"edge2\": [1, 0, 0], \"power\": 9}], \"environment\": "
    "{\"file\": \"e.pfm\", \"scale\": 2, \"radiance\": 1}, \"camera\": {\"eye\": [0, 1, 4], \"target\": [0, "
    "1, 0], \"up\": [0, 1, 0], \"fov_deg\": 40, \"keyframes\": "
    "[{\"time\": 0, \"eye\": [0, 1, 5]}, {\"time\": 1, \"target\": [0, 0, 0], \"fov_deg\": 20}]}, \"film\": "
    "{\"width\": 8, \"height\": 6}}";

static uint32_t state;

static uint32_t draw(uint32_t below) {
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return below ? state % below : 0;
}

static uint32_t count_nodes(const cJSON *item) {
    uint32_t count = 1;
    for (const cJSON *child = item->child; child; child = child->next) count += count_nodes(child);
    return count;
}

/* The item of a number in the order of the text; its parent beside it. */
static cJSON *find_node(cJSON *item, uint32_t *number, cJSON **parent) {
    if (*number == 0) return item;
    for (cJSON *child = item->child; child; child = child->next) {
        --*number;
        cJSON *found = find_node(child, number, parent);
        if (found && found == child) *parent = item;
        if (found) return found;
    }
    return NULL;
}

static cJSON *any_node(cJSON *root, cJSON **parent) {
    uint32_t number = draw(count_nodes(root));
    *parent = NULL;
    return find_node(root, &number, parent);
}

static cJSON *any_literal(void) {
    static const double numbers[] = {0,     1,   -1,  0.5,   1e-30, 1e30, 3.4e38,       -3.4e38, 1e-45,
                                     1e300, 180, 179, 65536, 65537, 1e9,  2147483648.0, 0.01,    1e6};
    static const char *const words[] = {"",       "a.obj", "p.bpt", "g.gltf",      "t.png",  "e.pfm",
                                        "s.json", "wall",  "floor", "y",           "z",      "..",
                                        "point",  "spot",  "quad",  "directional", "faceted"};
    switch (draw(8)) {
    case 0: return cJSON_CreateNull();
    case 1: return cJSON_CreateBool((int)draw(2));
    case 2: return cJSON_CreateString(words[draw(sizeof words / sizeof words[0])]);
    case 3: return cJSON_CreateArray();
    case 4: return cJSON_CreateObject();
    default: return cJSON_CreateNumber(numbers[draw(sizeof numbers / sizeof numbers[0])]);
    }
}

static void replace(cJSON *parent, cJSON *item, cJSON *made) {
    char *key = parent && item->string ? strdup(item->string) : NULL;
    bool done = key ? cJSON_ReplaceItemInObjectCaseSensitive(parent, key, made)
                    : parent && cJSON_ReplaceItemViaPointer(parent, item, made);
    if (!done) cJSON_Delete(made);
    free(key);
}

static void mutate(cJSON *root) {
    cJSON *parent, *item = any_node(root, &parent), *other_parent, *template = cJSON_Parse(whole);
    if (!item || !template) return;
    switch (draw(7)) {
    case 0:
    case 1:
        if (cJSON_IsNumber(item))
            cJSON_SetNumberHelper(item, item->valuedouble * (draw(2) ? -0.5 : 1.7) + (double)draw(3));
        else replace(parent, item, any_literal());
        break;
    case 2: replace(parent, item, any_literal()); break;
    case 3:
        if (parent) cJSON_Delete(cJSON_DetachItemViaPointer(parent, item));
        break;
    case 4: /* once more, in a list */
        if (parent && cJSON_IsArray(parent)) cJSON_AddItemToArray(parent, cJSON_Duplicate(item, 1));
        else if (parent && item->string)
            cJSON_AddItemToObject(parent, item->string, cJSON_Duplicate(item, 1));
        break;
    default: { /* what the template has */
        const cJSON *from = any_node(template, &other_parent);
        if (cJSON_IsObject(item) && from->string && !cJSON_HasObjectItem(item, from->string))
            cJSON_AddItemToObject(item, from->string, cJSON_Duplicate(from, 1));
        else if (cJSON_IsArray(item) && cJSON_IsArray(other_parent))
            cJSON_AddItemToArray(item, cJSON_Duplicate(from, 1));
        else replace(parent, item, cJSON_Duplicate(from, 1));
    }
    }
    cJSON_Delete(template);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed) {
    state = seed * 2654435761u | 1u;
    cJSON *root = draw(8) ? cJSON_ParseWithLength((const char *)data, size) : NULL;
    if (!root && draw(8) == 0) root = cJSON_Parse(whole);
    if (!root) return LLVMFuzzerMutate(data, size, max_size);
    for (uint32_t i = 0, times = 1 + draw(3); i < times; i++) mutate(root);
    char *text = cJSON_PrintUnformatted(root);
    size_t length = text ? strlen(text) : 0;
    if (text && length && length <= max_size) memcpy(data, text, size = length);
    free(text);
    cJSON_Delete(root);
    return size;
}
