#include "app/utf8.h"

#include <stdbool.h>
#include <stddef.h>

/* Bytes of the character that begins here; 0: none does (RFC 3629: no longer form than needed, no surrogates,
 * nothing above U+10FFFF). */
static size_t character(const unsigned char *at) {
    const unsigned char lead = *at;
    const size_t length = lead < 0x80                   ? 1
                          : lead >= 0xc2 && lead < 0xe0 ? 2
                          : lead >= 0xe0 && lead < 0xf0 ? 3
                          : lead >= 0xf0 && lead < 0xf5 ? 4
                                                        : 0;
    for (size_t i = 1; i < length; i++) {
        if ((at[i] & 0xc0) != 0x80) return 0;
    }
    const bool longer = (lead == 0xe0 && at[1] < 0xa0) || (lead == 0xf0 && at[1] < 0x90);
    const bool none = (lead == 0xed && at[1] >= 0xa0) || (lead == 0xf4 && at[1] >= 0x90);
    return longer || none ? 0 : length;
}

char *sl_utf8_mend(char *text) {
    for (char *at = text; at && *at;) {
        size_t length = character((const unsigned char *)at);
        if (!length) *at = '?';
        at += length ? length : 1;
    }
    return text;
}
