/* Pictures for viewers: a header (protocol.h) and a JPEG or PNG. */
#pragma once

#include "app/serve/mail.h"
#include "softlux.h"

typedef struct sl_frame_told {
    sl_frame_kind kind;
    unsigned index; /* as the header has it */
    uint32_t frame; /* the number */
    uint64_t event;
    bool still; /* PNG; else JPEG, where the program has that */
} sl_frame_told;

/* rgb: width * height of 3 bytes, rows from the top. For all viewers; NULL: no memory. */
sl_packet *sl_packet_picture(const sl_frame_told *told, int width, int height, const uint8_t *rgb);
