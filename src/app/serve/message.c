/* What is told of a message and of a request before anything is done with it. */
#include "app/serve/network.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool sl_message_is_shallow(const char *text, size_t length) {
    int depth = 0;
    bool quoted = false;
    for (size_t i = 0; i < length; i++) {
        if (quoted && text[i] == '\\') i++;
        else if (text[i] == '"') quoted = !quoted;
        else if (!quoted && (text[i] == '{' || text[i] == '[') && ++depth > SL_MESSAGE_DEPTH) return false;
        else if (!quoted && (text[i] == '}' || text[i] == ']')) depth--;
    }
    return true;
}

cJSON *sl_message_parse(const char *text, size_t length, const char **reason) {
    const char *end = NULL;
    *reason = NULL;
    if (length > SL_MESSAGE_BYTES) *reason = "a message is too long";
    else if (!sl_message_is_shallow(text, length)) *reason = "a message is too deep";
    if (*reason) return NULL;
    cJSON *message = cJSON_ParseWithLengthOpts(text, length, &end, false);
    const cJSON *what = cJSON_GetObjectItemCaseSensitive(message, "do");
    if (cJSON_IsObject(message) && cJSON_IsString(what) && end == text + length) return message;
    cJSON_Delete(message);
    *reason = "a message is no JSON object with \"do\"";
    return NULL;
}

/* An address in numbers names no other machine than itself, so that no foreign name server can make it lead
 * here. */
static bool is_numeric(const char *name, size_t length) {
    if (length > 2 && name[0] == '[')
        return strspn(name, "[]0123456789abcdefABCDEF:.") >= length && name[length - 1] == ']';
    return length > 0 && strspn(name, "0123456789.") >= length;
}

bool sl_host_is_ours(const char *header, const char *host, int port) {
    char behind[16];
    const int digits = snprintf(behind, sizeof behind, ":%d", port);
    const size_t all = strlen(header), tail = (size_t)digits;
    if (all <= tail || strcmp(header + all - tail, behind) != 0) return false;
    const size_t length = all - tail;
    return is_numeric(header, length) || (length == 9 && strncmp(header, "localhost", 9) == 0) ||
           (length == strlen(host) && strncmp(header, host, length) == 0);
}
