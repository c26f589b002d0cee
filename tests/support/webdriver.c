#include "webdriver.h"

#include <arpa/inet.h>
#include <cjson/cJSON.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unit_test.h"

struct browser {
    pid_t driver;
    FILE *said; /* what the driver prints */
    int port;
    char session[128];
};

static void give_up(const char *what, const char *detail) {
    fprintf(stderr, "webdriver: %s: %s\n", what, detail ? detail : "");
    abort();
}

/* ---- HTTP ---- */

static int connect_to(int port) {
    struct sockaddr_in address = {
        .sin_family = AF_INET, .sin_port = htons((uint16_t)port), .sin_addr = {htonl(INADDR_LOOPBACK)}};
    int s = socket(AF_INET, SOCK_STREAM, 0);
    if (s < 0 || connect(s, (struct sockaddr *)&address, sizeof address) != 0)
        give_up("cannot reach the driver", NULL);
    return s;
}

static void send_all(int s, const char *text, size_t size) {
    while (size) {
        ssize_t sent = write(s, text, size);
        if (sent <= 0) give_up("the driver does not listen", NULL);
        text += sent, size -= (size_t)sent;
    }
}

/* Everything until the body is as long as its header says. */
static char *receive(int s) {
    size_t size = 0, capacity = 1 << 16, wanted = (size_t)-1;
    char *text = malloc(capacity), *body = NULL;
    while (!body || size - (size_t)(body - text) < wanted) {
        if (size + 4096 >= capacity) { /* and room for the end */
            size_t offset = body ? (size_t)(body - text) : 0;
            text = realloc(text, capacity *= 2);
            if (body) body = text + offset;
        }
        ssize_t got = read(s, text + size, 4096);
        if (got <= 0) break;
        size += (size_t)got;
        text[size] = '\0';
        if (body || !(body = strstr(text, "\r\n\r\n"))) continue;
        body += 4;
        const char *length =
            strstr(text, "ontent-Length:") ? strstr(text, "ontent-Length:") : strstr(text, "ontent-length:");
        if (length) wanted = strtoul(length + 14, NULL, 10);
    }
    if (!body) give_up("the driver said nothing", NULL);
    char *answer = strdup(body);
    free(text);
    return answer;
}

/* The value of the answer; aborts where it is an error. Takes the message over. */
static cJSON *ask(const browser *b, const char *verb, const char *path, cJSON *message) {
    char *body = message ? cJSON_PrintUnformatted(message) : strdup(""), head[512];
    int length = snprintf(head, sizeof head,
                          "%s %s HTTP/1.1\r\nHost: localhost\r\nContent-Type: "
                          "application/json\r\nContent-Length: %zu\r\nConnection: close\r\n\r\n",
                          verb, path, strlen(body));
    int s = connect_to(b->port);
    send_all(s, head, (size_t)length);
    send_all(s, body, strlen(body));
    char *answer = receive(s);
    close(s);
    cJSON *all = cJSON_Parse(answer), *value = all ? cJSON_DetachItemFromObject(all, "value") : NULL;
    if (cJSON_IsObject(value) && cJSON_GetObjectItem(value, "error")) give_up(path, answer);
    if (!all) give_up("not JSON", answer);
    cJSON_Delete(all);
    cJSON_Delete(message);
    free(answer);
    free(body);
    return value;
}

static cJSON *ask_session(const browser *b, const char *what, cJSON *message) {
    char path[256];
    snprintf(path, sizeof path, "/session/%s/%s", b->session, what);
    return ask(b, "POST", path, message);
}

/* ---- the driver and its browser ---- */

static bool start_driver(browser *b) {
    int ends[2];
    if (pipe(ends) != 0) return false;
    b->driver = fork();
    if (b->driver == 0) {
        prctl(PR_SET_PDEATHSIG, SIGTERM);
        dup2(ends[1], STDOUT_FILENO);
        close(ends[0]);
        execlp("chromedriver", "chromedriver", "--port=0", (char *)NULL);
        _exit(127);
    }
    close(ends[1]);
    b->said = fdopen(ends[0], "r");
    char line[512];
    while (fgets(line, sizeof line, b->said)) {
        const char *port = strstr(line, "on port ");
        if (strstr(line, "started successfully") && port && (b->port = atoi(port + 8)) > 0) return true;
    }
    fclose(b->said);
    waitpid(b->driver, NULL, 0);
    return false;
}

static void start_session(browser *b, int width, int height) {
    char size[64];
    snprintf(size, sizeof size, "--window-size=%d,%d", width, height);
    cJSON *message = cJSON_Parse("{\"capabilities\":{\"alwaysMatch\":{\"browserName\":\"chrome\",\"goog:"
                                 "loggingPrefs\":{\"browser\":\"ALL\"},"
                                 "\"goog:chromeOptions\":{\"args\":[\"--headless=new\",\"--no-sandbox\",\"--"
                                 "disable-gpu\",\"--disable-dev-shm-usage\",\"--disable-renderer-"
                                 "backgrounding\"]}}}}");
    cJSON *match = cJSON_GetObjectItem(cJSON_GetObjectItem(message, "capabilities"), "alwaysMatch");
    cJSON_AddItemToArray(cJSON_GetObjectItem(cJSON_GetObjectItem(match, "goog:chromeOptions"), "args"),
                         cJSON_CreateString(size));
    cJSON *value = ask(b, "POST", "/session", message);
    const cJSON *id = cJSON_GetObjectItem(value, "sessionId");
    snprintf(b->session, sizeof b->session, "%s", cJSON_IsString(id) ? id->valuestring : "");
    cJSON_Delete(value);
}

browser *browser_open(int width, int height) {
    browser *b = calloc(1, sizeof *b);
    if (!start_driver(b)) {
        free(b);
        return NULL;
    }
    start_session(b, width, height);
    return b;
}

void browser_close(browser *b) {
    if (!b) return;
    char path[256];
    snprintf(path, sizeof path, "/session/%s", b->session);
    cJSON_Delete(ask(b, "DELETE", path, NULL));
    kill(b->driver, SIGTERM);
    waitpid(b->driver, NULL, 0);
    fclose(b->said);
    free(b);
}

void browser_resize(browser *b, int width, int height) {
    cJSON *message = cJSON_CreateObject();
    cJSON_AddNumberToObject(message, "width", width);
    cJSON_AddNumberToObject(message, "height", height);
    cJSON_Delete(ask_session(b, "window/rect", message));
}

/* Of the browser's own protocol. */
static void command(browser *b, const char *name, const char *parameters) {
    cJSON *message = cJSON_CreateObject();
    cJSON_AddStringToObject(message, "cmd", name);
    cJSON_AddItemToObject(message, "params", cJSON_Parse(parameters));
    cJSON_Delete(ask_session(b, "goog/cdp/execute", message));
}

void browser_screen(browser *b, int width, int height) {
    char text[200];
    snprintf(text, sizeof text, "{\"width\":%d,\"height\":%d,\"deviceScaleFactor\":2,\"mobile\":true}", width,
             height);
    command(b, width ? "Emulation.setDeviceMetricsOverride" : "Emulation.clearDeviceMetricsOverride",
            width ? text : "{}");
}

void browser_colours(browser *b, bool dark) {
    char text[200];
    snprintf(text, sizeof text, "{\"features\":[{\"name\":\"prefers-color-scheme\",\"value\":\"%s\"}]}",
             dark ? "dark" : "light");
    command(b, "Emulation.setEmulatedMedia", text);
}

void browser_go_to(browser *b, const char *address) {
    cJSON *message = cJSON_CreateObject();
    cJSON_AddStringToObject(message, "url", address);
    cJSON_Delete(ask_session(b, "url", message));
}

void browser_go_to_file(browser *b, const char *path) {
    char url[4096];
    snprintf(url, sizeof url, "file://%s", path);
    browser_go_to(b, url);
}

void browser_open_tab(browser *b) {
    cJSON *value = ask_session(b, "window/new", cJSON_Parse("{\"type\":\"tab\"}")), *message = cJSON_CreateObject();
    cJSON_AddItemToObject(message, "handle", cJSON_DetachItemFromObject(value, "handle"));
    cJSON_Delete(ask_session(b, "window", message));
    cJSON_Delete(value);
}

void browser_turn_to_tab(browser *b, int index) {
    char path[256];
    snprintf(path, sizeof path, "/session/%s/window/handles", b->session);
    cJSON *handles = ask(b, "GET", path, NULL), *message = cJSON_CreateObject();
    cJSON_AddItemToObject(message, "handle", cJSON_DetachItemFromArray(handles, index));
    cJSON_Delete(ask_session(b, "window", message));
    cJSON_Delete(handles);
}

/* ---- scripts ---- */

cJSON *browser_run(browser *b, const char *script) {
    cJSON *message = cJSON_CreateObject();
    cJSON_AddStringToObject(message, "script", script);
    cJSON_AddArrayToObject(message, "args");
    return ask_session(b, "execute/sync", message);
}

double browser_number(browser *b, const char *script) {
    cJSON *value = browser_run(b, script);
    if (!cJSON_IsNumber(value) && !cJSON_IsBool(value)) give_up("no number", script);
    double number = cJSON_IsBool(value) ? (double)cJSON_IsTrue(value) : value->valuedouble;
    cJSON_Delete(value);
    return number;
}

bool browser_holds(browser *b, const char *expression) {
    char script[2048];
    snprintf(script, sizeof script, "return Boolean(%s)", expression);
    return browser_number(b, script) == 1.0;
}

void assert_holds(browser *b, const char *expression) {
    if (!browser_holds(b, expression)) fail_msg("not so: %s", expression);
}

char *browser_text(browser *b, const char *script) {
    cJSON *value = browser_run(b, script);
    if (!cJSON_IsString(value)) give_up("no text", script);
    char *text = strdup(value->valuestring);
    cJSON_Delete(value);
    return text;
}

/* ---- what people do ---- */

void browser_click(browser *b, int x, int y) {
    char text[512];
    snprintf(text, sizeof text,
             "{\"actions\":[{\"type\":\"pointer\",\"id\":\"mouse\",\"parameters\":{\"pointerType\":\"mouse\"}"
             ",\"actions\":["
             "{\"type\":\"pointerMove\",\"duration\":0,\"x\":%d,\"y\":%d},{\"type\":\"pointerDown\","
             "\"button\":0},{\"type\":\"pointerUp\",\"button\":0}]}]}",
             x, y);
    cJSON_Delete(ask_session(b, "actions", cJSON_Parse(text)));
}

static cJSON *pointer(const char *id, const char *type, cJSON *actions) {
    cJSON *source = cJSON_CreateObject(), *parameters = cJSON_AddObjectToObject(source, "parameters");
    cJSON_AddStringToObject(source, "type", "pointer");
    cJSON_AddStringToObject(source, "id", id);
    cJSON_AddStringToObject(parameters, "pointerType", type);
    cJSON_AddItemToObject(source, "actions", actions);
    return source;
}

static void add_move(cJSON *actions, browser_place to, int milliseconds) {
    cJSON *move = cJSON_CreateObject();
    cJSON_AddStringToObject(move, "type", "pointerMove");
    cJSON_AddNumberToObject(move, "duration", milliseconds);
    cJSON_AddNumberToObject(move, "x", to.x);
    cJSON_AddNumberToObject(move, "y", to.y);
    cJSON_AddItemToArray(actions, move);
}

static void add_button(cJSON *actions, const char *type) {
    cJSON *press = cJSON_CreateObject();
    cJSON_AddStringToObject(press, "type", type);
    cJSON_AddNumberToObject(press, "button", 0);
    cJSON_AddItemToArray(actions, press);
}

static cJSON *drag(const browser_place *places, int count, bool held) {
    cJSON *actions = cJSON_CreateArray();
    add_move(actions, places[0], 0);
    add_button(actions, "pointerDown");
    for (int i = 1; i < count; i++) add_move(actions, places[i], 25);
    if (!held) add_button(actions, "pointerUp");
    return actions;
}

static void act(browser *b, cJSON *first, cJSON *second) {
    cJSON *message = cJSON_CreateObject(), *list = cJSON_AddArrayToObject(message, "actions");
    cJSON_AddItemToArray(list, first);
    if (second) cJSON_AddItemToArray(list, second);
    cJSON_Delete(ask_session(b, "actions", message));
}

void browser_drag(browser *b, const char *type, const browser_place *places, int count, bool held) {
    act(b, pointer(type, type, drag(places, count, held)), NULL);
}

void browser_pinch(browser *b, const browser_place one[2], const browser_place other[2]) {
    act(b, pointer("one", "touch", drag(one, 2, false)), pointer("other", "touch", drag(other, 2, false)));
}

void browser_release(browser *b) {
    char path[256];
    snprintf(path, sizeof path, "/session/%s/actions", b->session);
    cJSON_Delete(ask(b, "DELETE", path, NULL));
}

void browser_press(browser *b, const char *key) {
    char text[512];
    snprintf(text, sizeof text,
             "{\"actions\":[{\"type\":\"key\",\"id\":\"keys\",\"actions\":[{\"type\":\"keyDown\",\"value\":"
             "\"%s\"},{\"type\":\"keyUp\",\"value\":\"%s\"}]}]}",
             key, key);
    cJSON_Delete(ask_session(b, "actions", cJSON_Parse(text)));
}

int browser_errors(browser *b) {
    int errors = 0;
    cJSON *log = ask_session(b, "se/log", cJSON_Parse("{\"type\":\"browser\"}"));
    const cJSON *entry;
    cJSON_ArrayForEach(entry, log) {
        const cJSON *level = cJSON_GetObjectItem(entry, "level"),
                    *message = cJSON_GetObjectItem(entry, "message");
        if (!cJSON_IsString(level) || strcmp(level->valuestring, "SEVERE") != 0) continue;
        fprintf(stderr, "console: %s\n", cJSON_IsString(message) ? message->valuestring : "");
        errors++;
    }
    cJSON_Delete(log);
    return errors;
}
