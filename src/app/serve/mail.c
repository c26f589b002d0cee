#include "app/serve/mail.h"

#include <stdlib.h>
#include <string.h>

enum { LETTERS = sizeof((sl_mail *)0)->letters / sizeof(sl_letter) };

/* ---- packets ---- */

static sl_packet *packet_of(unsigned client, const char *text, bool ends) {
    const size_t size = strlen(text);
    sl_packet *p = malloc(sizeof *p + SL_PACKET_ROOM + size);
    if (!p) return NULL;
    *p = (sl_packet){.client = client, .ends = ends, .slot = -1, .size = size};
    memcpy(p->bytes + SL_PACKET_ROOM, text, size);
    return p;
}

sl_packet *sl_packet_text(unsigned client, cJSON *message) {
    char *text = cJSON_PrintUnformatted(message);
    sl_packet *p = text ? packet_of(client, text, false) : NULL;
    cJSON_free(text);
    cJSON_Delete(message);
    return p;
}

sl_packet *sl_packet_end(unsigned client, const char *reason) { return packet_of(client, reason, true); }

/* ---- the mail ---- */

bool sl_mail_open(sl_mail *m) {
    memset(m, 0, sizeof *m);
    m->last = &m->packets;
    return sl_monitor_open(&m->meeting);
}

void sl_mail_close(sl_mail *m) {
    for (; m->count; m->count--, m->first = (m->first + 1) % LETTERS)
        cJSON_Delete(m->letters[m->first].message);
    for (sl_packet *p = m->packets, *next; p; p = next) {
        next = p->next;
        free(p);
    }
    for (size_t i = 0; i < m->file_count; i++) free(m->files[i]);
    sl_monitor_close(&m->meeting);
}

bool sl_mail_post(sl_mail *m, sl_letter letter) {
    sl_monitor_enter(&m->meeting);
    const bool fits = m->count < LETTERS;
    if (fits) m->letters[(m->first + m->count++) % LETTERS] = letter;
    sl_monitor_signal(&m->meeting);
    sl_monitor_leave(&m->meeting);
    if (!fits) cJSON_Delete(letter.message);
    return fits;
}

bool sl_mail_read(sl_mail *m, double seconds, sl_letter *letter) {
    sl_monitor_enter(&m->meeting);
    if (!m->count && !m->closed && seconds > 0.0) sl_monitor_wait_for(&m->meeting, seconds);
    const bool any = m->count > 0;
    if (any) {
        *letter = m->letters[m->first];
        m->first = (m->first + 1) % LETTERS;
        m->count--;
    }
    sl_monitor_leave(&m->meeting);
    return any;
}

void sl_mail_end(sl_mail *m) {
    sl_monitor_enter(&m->meeting);
    m->closed = true;
    sl_monitor_signal(&m->meeting);
    sl_monitor_leave(&m->meeting);
}

bool sl_mail_has_ended(const sl_mail *m) { return m->closed; }

void sl_mail_send(sl_mail *m, sl_packet *packet) {
    if (!packet) return;
    sl_monitor_enter(&m->meeting);
    *m->last = packet;
    m->last = &packet->next;
    sl_monitor_leave(&m->meeting);
    if (m->wake) m->wake(m->context);
}

sl_packet *sl_mail_collect(sl_mail *m) {
    sl_monitor_enter(&m->meeting);
    sl_packet *packets = m->packets;
    m->packets = NULL;
    m->last = &m->packets;
    sl_monitor_leave(&m->meeting);
    return packets;
}

size_t sl_mail_offer(sl_mail *m, const char *path) {
    sl_monitor_enter(&m->meeting);
    size_t number = m->file_count;
    if (number < SL_FILES) m->files[number] = strdup(path);
    if (number < SL_FILES && m->files[number]) m->file_count++;
    else number = SL_FILES;
    sl_monitor_leave(&m->meeting);
    return number;
}

bool sl_mail_offered(sl_mail *m, size_t number, char *path, size_t room) {
    sl_monitor_enter(&m->meeting);
    const bool there = number < m->file_count && strlen(m->files[number]) < room;
    if (there) strcpy(path, m->files[number]);
    sl_monitor_leave(&m->meeting);
    return there;
}
