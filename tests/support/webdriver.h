/* A browser for tests: headless Chromium through its WebDriver, spoken over a socket of this machine. */
#pragma once

#include <stdbool.h>

struct cJSON;
typedef struct browser browser;

/* NULL: there is no chromedriver here. */
browser *browser_open(int width, int height);
void browser_close(browser *browser);
void browser_resize(browser *browser, int width, int height);
/* Shows pages as on a screen of that size, narrower than a window can be, until it is 0. */
void browser_screen(browser *browser, int width, int height);
/* What `prefers-color-scheme` is. */
void browser_colours(browser *browser, bool dark);
void browser_go_to(browser *browser, const char *address);
/* A file of this machine, by its absolute path. */
void browser_go_to_file(browser *browser, const char *path);
/* Runs the body of a function and returns what it returns; the caller frees it with cJSON_Delete(). Aborts
 * the test where the script fails. */
struct cJSON *browser_run(browser *browser, const char *script);
double browser_number(browser *browser, const char *script);
/* Is an expression true there? */
bool browser_holds(browser *browser, const char *expression);
void assert_holds(browser *browser, const char *expression);
/* The caller frees it. */
char *browser_text(browser *browser, const char *script);
/* A click at a place of the window, in CSS pixels. */
void browser_click(browser *browser, int x, int y);
/* Goes from place to place with a button of the mouse or a finger down; `held`: it is down before, and stays. */
typedef struct browser_place {
    int x, y;
} browser_place;
void browser_drag(browser *browser, const char *pointer, const browser_place *places, int count, bool held);
/* Two fingers, each from its first place to its second. */
void browser_pinch(browser *browser, const browser_place one[2], const browser_place other[2]);
void browser_release(browser *browser); /* all buttons and keys */
/* Opens another tab and turns to it, or back to the first one. */
void browser_open_tab(browser *browser);
void browser_turn_to_tab(browser *browser, int index);
/* Keys as WebDriver has them, UTF-8. */
void browser_press(browser *browser, const char *key);
/* Counts the console's messages of level SEVERE; each is printed. */
int browser_errors(browser *browser);

#define KEY_TAB "\xee\x80\x84"
#define KEY_ENTER "\xee\x80\x87"
#define KEY_SPACE "\xee\x80\x8d"
#define KEY_LEFT "\xee\x80\x92"
#define KEY_HOME "\xee\x80\x91"
#define KEY_RIGHT "\xee\x80\x94"
#define KEY_DOWN "\xee\x80\x95"
