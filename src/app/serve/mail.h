/* What the network's thread and the stage's hand each other: letters in, packets out. */
#pragma once

#include "app/serve/protocol.h"
#include "base/thread.h"

#include <cjson/cJSON.h>
#include <stdatomic.h>
#include <stdint.h>

/* ---- from viewers ---- */

typedef enum sl_letter_kind { SL_LETTER_MESSAGE, SL_LETTER_JOINED, SL_LETTER_LEFT } sl_letter_kind;

typedef struct sl_letter {
    unsigned client; /* from 1 */
    sl_letter_kind kind;
    cJSON *message; /* the reader's to delete; or NULL */
} sl_letter;

/* ---- to viewers ---- */

/* Room in front of a packet's bytes for the network's own. */
enum { SL_PACKET_ROOM = 64 };
/* Pictures of one slot take each other's place where they wait. */
enum { SL_SLOTS = SL_FRAME_KINDS + 62 };

typedef struct sl_packet {
    struct sl_packet *next; /* in the mail */
    unsigned client;        /* 0: for all */
    int owners;             /* the network's */
    bool ends;              /* text: the reason why the connection ends */
    int slot;               /* of a picture; text: -1 */
    uint32_t frame;         /* of a picture */
    size_t size;
    uint8_t bytes[]; /* SL_PACKET_ROOM of nothing, then size */
} sl_packet;

/* Text is printed, and the message deleted; NULL: no memory. */
sl_packet *sl_packet_text(unsigned client, cJSON *message);
sl_packet *sl_packet_end(unsigned client, const char *reason);

/* ---- frame.c: pictures, a header (protocol.h) and a JPEG or PNG ---- */

typedef struct sl_frame_told {
    sl_frame_kind kind;
    unsigned index; /* as the header has it */
    uint32_t frame; /* the number */
    uint64_t event;
    bool still; /* PNG; else JPEG, where the program has that */
} sl_frame_told;

/* rgb: width * height of 3 bytes, rows from the top. For all viewers; NULL: no memory. */
sl_packet *sl_packet_picture(const sl_frame_told *told, int width, int height, const uint8_t *rgb);

enum { SL_FILES = 256 };

typedef struct sl_mail {
    sl_monitor meeting; /* guards what follows */
    sl_letter letters[512];
    size_t first, count;
    sl_packet *packets, **last;
    char *files[SL_FILES]; /* that viewers may fetch */
    size_t file_count;
    atomic_bool closed;
    void (*wake)(void *context); /* the network's thread: there are packets */
    void *context;
} sl_mail;

bool sl_mail_open(sl_mail *mail);
void sl_mail_close(sl_mail *mail); /* and forgets what is in it */
/* False: the box is full, and the message was deleted. */
bool sl_mail_post(sl_mail *mail, sl_letter letter);
/* Takes the next letter, waiting so many seconds for one at most; false: there is none. */
bool sl_mail_read(sl_mail *mail, double seconds, sl_letter *letter);
/* Tells the stage to end, which waits no more then. */
void sl_mail_end(sl_mail *mail);
bool sl_mail_has_ended(const sl_mail *mail);
/* Takes the packet over; NULL is allowed. */
void sl_mail_send(sl_mail *mail, sl_packet *packet);
/* Lets viewers fetch a file by a number, which is returned; SL_FILES: there are too many. */
size_t sl_mail_offer(sl_mail *mail, const char *path);
bool sl_mail_offered(sl_mail *mail, size_t number, char *path, size_t room);
/* All packets, in order, now the caller's. */
sl_packet *sl_mail_collect(sl_mail *mail);
