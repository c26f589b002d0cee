/* The server: the page over HTTP, viewers over WebSockets. It knows nothing of scenes: what viewers say goes
 * to the mail as letters, packets from the mail go to them. */
#pragma once

#include "app/serve/mail.h"
#include "softlux.h"

#include <stdbool.h>

enum { SL_TOKEN_BYTES = 33 };

typedef struct sl_network_options {
    const char *host;           /* an address of this machine, or its name */
    int port;                   /* 0: any */
    char token[SL_TOKEN_BYTES]; /* that viewers must know */
} sl_network_options;

typedef struct sl_network sl_network;

/* A random token. RESOURCES: where the system has none. */
sl_status sl_network_token(char token[SL_TOKEN_BYTES], sl_error *error);
/* Listens from then on. The mail must outlive it; its wake is the network's. */
sl_status sl_network_open(const sl_network_options *options, sl_mail *mail, sl_network **network,
                          sl_error *error);
int sl_network_port(const sl_network *network);
/* Serves until Ctrl-C, or until the mail has been ended. */
void sl_network_run(sl_network *network);
void sl_network_close(sl_network *network); /* NULL is allowed */

/* ---- what can be told apart without a network ---- */

/* Tells whether the text is JSON that is no deeper than SL_MESSAGE_DEPTH: {} is 1 deep. */
bool sl_message_is_shallow(const char *text, size_t length);
/* Tells whether the header Host is that of a server at this host and port, and no other name that leads
 * here. */
bool sl_host_is_ours(const char *header, const char *host, int port);
/* The message of a letter, or NULL and why not. */
cJSON *sl_message_parse(const char *text, size_t length, const char **reason);
