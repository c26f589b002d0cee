#include "app/serve/network.h"

#include "app/clock.h"
#include "base/error.h"

#include <arpa/inet.h>
#include <errno.h>
#include <libwebsockets.h>
#include <netdb.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

_Static_assert(SL_PACKET_ROOM >= LWS_PRE, "room for a frame's own header");

enum { TEXTS = 128, UNSEEN = 2, CONNECTIONS = 64, CHUNK = 8192, HEADERS = 2048, WAITING = 16 };

/* Who listens at the other end of a WebSocket. */
typedef struct client {
    struct client *next;
    struct lws *wsi;
    unsigned number;
    char *message; /* its parts so far; SL_MESSAGE_BYTES of room */
    size_t length;
    double second; /* in which so many messages came */
    int messages;
    sl_packet *texts[TEXTS]; /* a ring */
    size_t first, count;
    sl_packet *pictures[SL_SLOTS]; /* the newest of each slot, not sent yet */
    uint32_t unseen[UNSEEN];       /* frames that were sent and are not acknowledged; 0: none */
    const char *reason;            /* why it ends */
} client;

/* Of a connection: either a file that is on its way, or a client. */
typedef struct session {
    const char *at, *end;
    client *client;
} session;

struct sl_network {
    sl_network_options options;
    sl_mail *mail;
    struct lws_context *context;
    int port, listener;
    client *clients;
    unsigned joined, present;
};

/* ---- packets of clients ---- */

static void let_go(sl_packet *packet) {
    if (packet && --packet->owners == 0) free(packet);
}

static void give_picture(client *c, sl_packet *p) {
    let_go(c->pictures[p->slot]);
    c->pictures[p->slot] = p;
    p->owners++;
}

static void give_text(client *c, sl_packet *p) {
    if (c->count == TEXTS) {
        c->reason = "too slow: messages have not been read";
        return;
    }
    c->texts[(c->first + c->count++) % TEXTS] = p;
    p->owners++;
}

static void give(sl_network *n, sl_packet *p) {
    p->owners = 1;
    for (client *c = n->clients; c; c = c->next) {
        if (p->client && p->client != c->number) continue;
        if (p->slot >= 0) give_picture(c, p);
        else give_text(c, p);
        lws_callback_on_writable(c->wsi);
    }
    let_go(p);
}

static void collect(sl_network *n) {
    for (sl_packet *p = sl_mail_collect(n->mail), *next; p; p = next) {
        next = p->next;
        give(n, p);
    }
}

/* The oldest picture that waits, unless too many are under way. */
static sl_packet *next_picture(client *c) {
    int oldest = -1, place = -1;
    for (int i = 0; i < UNSEEN; i++)
        if (!c->unseen[i]) place = i;
    for (int i = 0; place >= 0 && i < SL_SLOTS; i++)
        if (c->pictures[i] && (oldest < 0 || c->pictures[i]->frame < c->pictures[oldest]->frame)) oldest = i;
    if (oldest < 0) return NULL;
    sl_packet *p = c->pictures[oldest];
    c->pictures[oldest] = NULL;
    c->unseen[place] = p->frame;
    return p;
}

static sl_packet *next_packet(client *c) {
    if (!c->count) return next_picture(c);
    sl_packet *p = c->texts[c->first];
    c->first = (c->first + 1) % TEXTS;
    c->count--;
    return p;
}

static int end_client(client *c, const char *reason, size_t length) {
    unsigned char text[124];
    length = length < sizeof text ? length : sizeof text - 1;
    memcpy(text, reason, length);
    lws_close_reason(c->wsi, LWS_CLOSE_STATUS_POLICY_VIOLATION, text, length);
    return -1;
}

static int send_next(client *c) {
    if (c->reason) return end_client(c, c->reason, strlen(c->reason));
    sl_packet *p = next_packet(c);
    if (!p) return 0;
    unsigned char *bytes = p->bytes + SL_PACKET_ROOM;
    int result = 0;
    if (p->ends) result = end_client(c, (const char *)bytes, p->size);
    else
        result =
            lws_write(c->wsi, bytes, p->size, p->slot < 0 ? LWS_WRITE_TEXT : LWS_WRITE_BINARY) < 0 ? -1 : 0;
    let_go(p);
    if (result == 0) lws_callback_on_writable(c->wsi);
    return result;
}

/* ---- clients ---- */

static client *join(sl_network *n, struct lws *wsi) {
    client *c = n->present < SL_CLIENTS ? calloc(1, sizeof *c) : NULL;
    if (c) c->message = malloc(SL_MESSAGE_BYTES);
    if (!c || !c->message) {
        free(c);
        return NULL;
    }
    c->wsi = wsi;
    c->number = ++n->joined;
    c->next = n->clients;
    n->clients = c;
    n->present++;
    sl_mail_post(n->mail, (sl_letter){c->number, SL_LETTER_JOINED, NULL});
    return c;
}

static void leave(sl_network *n, client *c) {
    client **at = &n->clients;
    while (*at != c) at = &(*at)->next;
    *at = c->next;
    n->present--;
    for (; c->count; c->count--, c->first = (c->first + 1) % TEXTS) let_go(c->texts[c->first]);
    for (int i = 0; i < SL_SLOTS; i++) let_go(c->pictures[i]);
    sl_mail_post(n->mail, (sl_letter){c->number, SL_LETTER_LEFT, NULL});
    free(c->message);
    free(c);
}

/* Acknowledges frames up to this one; the network's own message. */
static bool take_got(client *c, cJSON *message) {
    const cJSON *frame = cJSON_GetObjectItemCaseSensitive(message, "frame");
    const bool sound = cJSON_IsNumber(frame);
    for (int i = 0; i < UNSEEN && sound; i++)
        if (c->unseen[i] <= frame->valuedouble) c->unseen[i] = 0;
    cJSON_Delete(message);
    lws_callback_on_writable(c->wsi);
    return sound;
}

static bool is_too_fast(client *c) {
    const double now = sl_seconds_now();
    if (now - c->second >= 1.0) c->second = now, c->messages = 0;
    return ++c->messages > SL_MESSAGES_A_SECOND;
}

static void take_message(sl_network *n, client *c) {
    cJSON *message = sl_message_parse(c->message, c->length, &c->reason);
    c->length = 0;
    if (!message) return;
    if (strcmp(cJSON_GetObjectItemCaseSensitive(message, "do")->valuestring, "got") == 0) {
        if (!take_got(c, message)) c->reason = "got: expected a frame's number";
    } else if (is_too_fast(c)) {
        cJSON_Delete(message);
        c->reason = "too many messages a second";
    } else if (!sl_mail_post(n->mail, (sl_letter){c->number, SL_LETTER_MESSAGE, message})) {
        c->reason = "too many messages wait";
    }
}

/* Leaves what comes after a fault unread here, not in the socket: closing over bytes that were never read
 * resets the connection, and the reason would be lost on its way. */
static int receive(sl_network *n, client *c, const char *part, size_t length) {
    if (c->reason) return 0;
    if (lws_frame_is_binary(c->wsi)) c->reason = "expected text";
    else if (c->length + length > SL_MESSAGE_BYTES) c->reason = "a message is too long";
    if (!c->reason) {
        memcpy(c->message + c->length, part, length);
        c->length += length;
        if (lws_is_final_fragment(c->wsi) && !lws_remaining_packet_payload(c->wsi)) take_message(n, c);
    }
    if (c->reason) lws_callback_on_writable(c->wsi);
    return 0;
}

/* ---- requests ---- */

static bool header(struct lws *wsi, enum lws_token_indexes which, char *text, size_t room) {
    return lws_hdr_copy(wsi, text, (int)room, which) > 0;
}

/* A page of somebody else's cannot name us, whatever name it reaches us by, nor speak for ours. */
static bool is_from_here(const sl_network *n, struct lws *wsi, bool needs_origin) {
    char host[256], origin[256];
    if (!header(wsi, WSI_TOKEN_HOST, host, sizeof host) || !sl_host_is_ours(host, n->options.host, n->port))
        return false;
    if (!header(wsi, WSI_TOKEN_ORIGIN, origin, sizeof origin)) return !needs_origin;
    return strncmp(origin, "http://", 7) == 0 && strcmp(origin + 7, host) == 0;
}

static bool is_token(const sl_network *n, const char *text, size_t length) {
    unsigned differs = length != SL_TOKEN_BYTES - 1;
    for (size_t i = 0; i < SL_TOKEN_BYTES - 1 && !differs; i++)
        differs |= (unsigned char)(text[i] ^ n->options.token[i]);
    return !differs;
}

static bool is_viewer(const sl_network *n, struct lws *wsi) {
    char path[64] = "", token[128] = "";
    header(wsi, WSI_TOKEN_GET_URI, path, sizeof path);
    header(wsi, WSI_TOKEN_HTTP_URI_ARGS, token, sizeof token);
    return is_from_here(n, wsi, true) && strcmp(path, "/socket") == 0 && is_token(n, token, strlen(token)) &&
           n->present < SL_CLIENTS;
}

/* ---- files ---- */

#define PAGE_FILE(name, ending, type)                                                                        \
    extern const char _binary_src_app_serve_page_##name##_##ending##_start[],                                \
        _binary_src_app_serve_page_##name##_##ending##_end[];
#include "app/serve/page_files.h"
#undef PAGE_FILE

typedef struct page_file {
    const char *path, *type, *at, *end;
} page_file;

#define PAGE_FILE(name, ending, type)                                                                        \
    {"/" #name "." #ending, type, _binary_src_app_serve_page_##name##_##ending##_start,                      \
     _binary_src_app_serve_page_##name##_##ending##_end},
static const page_file page_files[] = {
#include "app/serve/page_files.h"
};
#undef PAGE_FILE

/* Of every response. Frames are blobs of the page's own, if it shows them as images. */
static const struct lws_protocol_vhost_options safe_headers[] = {
    {&safe_headers[1], NULL, "content-security-policy:",
     "default-src 'self'; img-src 'self' blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
    {&safe_headers[2], NULL, "x-frame-options:", "DENY"},
    {&safe_headers[3], NULL, "referrer-policy:", "no-referrer"},
    {&safe_headers[4], NULL, "x-content-type-options:", "nosniff"},
    {&safe_headers[5], NULL, "cross-origin-opener-policy:", "same-origin"},
    {&safe_headers[6], NULL, "cross-origin-resource-policy:", "same-origin"},
    {NULL, NULL, "cache-control:", "no-store"}};

static int send_head(struct lws *wsi, unsigned status, const char *type, size_t length) {
    unsigned char buffer[LWS_PRE + HEADERS], *start = buffer + LWS_PRE, *at = start,
                                             *end = start + HEADERS - 1;
    if (lws_add_http_common_headers(wsi, status, type, length, &at, end)) return 1;
    return lws_finalize_write_http_header(wsi, start, &at, end);
}

static int send_file(struct lws *wsi, session *s, unsigned status, const char *type, const char *at,
                     const char *end) {
    s->at = at;
    s->end = end;
    if (send_head(wsi, status, type, (size_t)(end - at))) return 1;
    lws_callback_on_writable(wsi);
    return 0;
}

static int send_part(struct lws *wsi, session *s) {
    unsigned char buffer[LWS_PRE + CHUNK];
    const size_t left = (size_t)(s->end - s->at), part = left < CHUNK ? left : CHUNK;
    if (!s->at) return 0;
    memcpy(buffer + LWS_PRE, s->at, part);
    s->at += part;
    const bool last = s->at == s->end;
    if (lws_write(wsi, buffer + LWS_PRE, part, last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) < 0) return 1;
    if (!last) {
        lws_callback_on_writable(wsi);
        return 0;
    }
    s->at = NULL;
    return lws_http_transaction_completed(wsi) ? -1 : 0;
}

static int refuse(struct lws *wsi, session *s, unsigned status, const char *text) {
    return send_file(wsi, s, status, "text/plain", text, text + strlen(text));
}

/* /kept/TOKEN/7: the number of a file that the stage has offered. */
static int send_kept(sl_network *n, struct lws *wsi, session *s, const char *path) {
    char name[4096], *end;
    const char *slash = strchr(path, '/');
    if (!slash || !is_token(n, path, (size_t)(slash - path))) return refuse(wsi, s, 403, "not allowed\n");
    const unsigned long number = strtoul(slash + 1, &end, 10);
    if (*end || !sl_mail_offered(n->mail, number, name, sizeof name))
        return refuse(wsi, s, 404, "not here\n");
    unsigned char buffer[HEADERS], *at = buffer;
    const char *file = strrchr(name, '/') ? strrchr(name, '/') + 1 : name;
    char as[300];
    snprintf(as, sizeof as, "attachment; filename=\"%.200s\"", file);
    if (lws_add_http_header_by_name(wsi, (const unsigned char *)"content-disposition:",
                                    (const unsigned char *)as, (int)strlen(as), &at, buffer + HEADERS))
        return -1;
    const int result =
        lws_serve_http_file(wsi, name, "application/octet-stream", (const char *)buffer, (int)(at - buffer));
    return result < 0 || (result > 0 && lws_http_transaction_completed(wsi)) ? -1 : 0;
}

static int answer(sl_network *n, struct lws *wsi, session *s, const char *path) {
    s->at = NULL;
    if (!is_from_here(n, wsi, false)) return refuse(wsi, s, 403, "not allowed\n");
    if (strncmp(path, "/kept/", 6) == 0) return send_kept(n, wsi, s, path + 6);
    if (strcmp(path, "/") == 0) path = "/index.html";
    for (size_t i = 0; i < sizeof page_files / sizeof page_files[0]; i++) {
        const page_file *f = &page_files[i];
        if (strcmp(f->path, path) == 0) return send_file(wsi, s, 200, f->type, f->at, f->end);
    }
    return refuse(wsi, s, 404, "not here\n");
}

/* ---- the loop ---- */

static int welcome(const sl_network *n) {
    const int fd = accept(n->listener, NULL, NULL);
    if (fd >= 0) lws_adopt_socket(n->context, fd);
    return 0;
}

static int on_http(sl_network *n, struct lws *wsi, enum lws_callback_reasons why, session *s,
                   const char *in) {
    switch (why) {
    case LWS_CALLBACK_HTTP: return answer(n, wsi, s, in);
    case LWS_CALLBACK_HTTP_WRITEABLE: return send_part(wsi, s);
    case LWS_CALLBACK_HTTP_FILE_COMPLETION: return lws_http_transaction_completed(wsi) ? -1 : 0;
    default: return 0;
    }
}

static int on_event(struct lws *wsi, enum lws_callback_reasons why, void *user, void *in, size_t length) {
    sl_network *n = lws_context_user(lws_get_context(wsi));
    session *s = user;
    switch (why) {
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION: return is_viewer(n, wsi) ? 0 : 1;
    case LWS_CALLBACK_ESTABLISHED: return (s->client = join(n, wsi)) ? 0 : -1;
    case LWS_CALLBACK_RECEIVE: return receive(n, s->client, in, length);
    case LWS_CALLBACK_SERVER_WRITEABLE: return send_next(s->client);
    case LWS_CALLBACK_CLOSED:
        if (s->client) leave(n, s->client);
        s->client = NULL;
        return 0;
    case LWS_CALLBACK_EVENT_WAIT_CANCELLED: collect(n); return 0;
    case LWS_CALLBACK_RAW_RX_FILE: return welcome(n);
    default: return on_http(n, wsi, why, s, in);
    }
}

static const struct lws_protocols protocols[] = {{.name = "softlux",
                                                  .callback = on_event,
                                                  .per_session_data_size = sizeof(session),
                                                  .rx_buffer_size = 4096},
                                                 {.name = NULL}};

static void wake(void *context) { lws_cancel_service(((sl_network *)context)->context); }

sl_status sl_network_token(char token[SL_TOKEN_BYTES], sl_error *error) {
    uint8_t bytes[(SL_TOKEN_BYTES - 1) / 2];
    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes)
        return sl_fail(error, SL_ERROR_RESOURCES, "no random numbers could be had for a token");
    for (size_t i = 0; i < sizeof bytes; i++) snprintf(token + 2 * i, 3, "%02x", bytes[i]);
    return SL_OK;
}

/* Opens the first of the addresses that a name stands for at which this machine can listen; -1: none. A
 * socket of its own, so that it is that address and no other. */
static int bound_socket(const struct addrinfo *addresses) {
    for (const struct addrinfo *a = addresses; a; a = a->ai_next) {
        const int fd = socket(a->ai_family, a->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, a->ai_protocol),
                  on = 1;
        if (fd < 0) continue;
        setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
        if (bind(fd, a->ai_addr, a->ai_addrlen) == 0 && listen(fd, WAITING) == 0) return fd;
        close(fd);
    }
    return -1;
}

static sl_status open_socket(sl_network *n, int *fd, sl_error *error) {
    const struct addrinfo hints = {.ai_flags = AI_PASSIVE, .ai_socktype = SOCK_STREAM};
    struct addrinfo *addresses = NULL;
    struct sockaddr_storage at;
    socklen_t size = sizeof at;
    char port[16];
    snprintf(port, sizeof port, "%d", n->options.port);
    errno = EADDRNOTAVAIL; /* where the name stands for none */
    *fd = getaddrinfo(n->options.host, port, &hints, &addresses) == 0 ? bound_socket(addresses) : -1;
    if (addresses) freeaddrinfo(addresses);
    if (*fd < 0 || getsockname(*fd, (struct sockaddr *)&at, &size) != 0)
        return sl_fail(error, SL_ERROR_RESOURCES, "cannot listen at %.200s, port %s: %s", n->options.host,
                       port, strerror(errno));
    n->port = ntohs(at.ss_family == AF_INET6 ? ((struct sockaddr_in6 *)&at)->sin6_port
                                             : ((struct sockaddr_in *)&at)->sin_port);
    return SL_OK;
}

static sl_status listen_at(sl_network *n, sl_error *error) {
    struct lws_context_creation_info info;
    lws_sock_file_fd_type listener;
    sl_status status = open_socket(n, &listener.filefd, error);
    if (status != SL_OK) return status;
    memset(&info, 0, sizeof info);
    info.port = CONTEXT_PORT_NO_LISTEN_SERVER;
    info.protocols = protocols;
    info.headers = safe_headers;
    info.user = n;
    info.gid = info.uid = -1;
    info.fd_limit_per_thread = CONNECTIONS;
    info.timeout_secs = 10;
    info.keepalive_timeout = 10;
    lws_set_log_level(0, NULL);
    n->listener = listener.filefd;
    n->context = lws_create_context(&info);
    struct lws_vhost *host = n->context ? lws_get_vhost_by_name(n->context, "default") : NULL;
    if (host && lws_adopt_descriptor_vhost(host, LWS_ADOPT_RAW_FILE_DESC, listener, protocols[0].name, NULL))
        return SL_OK;
    if (n->context) lws_context_destroy(n->context);
    return sl_fail(error, SL_ERROR_RESOURCES, "no server could be had");
}

sl_status sl_network_open(const sl_network_options *options, sl_mail *mail, sl_network **network,
                          sl_error *error) {
    sl_network *n = calloc(1, sizeof *n);
    *network = NULL;
    if (!n) return sl_fail_memory(error, "the server");
    n->options = *options;
    n->mail = mail;
    sl_status status = listen_at(n, error);
    if (status != SL_OK) {
        free(n);
        return status;
    }
    mail->context = n;
    mail->wake = wake;
    *network = n;
    return SL_OK;
}

int sl_network_port(const sl_network *network) { return network->port; }

void sl_network_run(sl_network *n) {
    while (!sl_interrupted() && !sl_mail_has_ended(n->mail) && lws_service(n->context, 0) >= 0) {}
}

void sl_network_close(sl_network *n) {
    if (!n) return;
    n->mail->wake = NULL;
    lws_context_destroy(n->context);
    free(n);
}
