/* A browser for tests: headless Chromium through its WebDriver, spoken over a socket of this machine. */
#ifndef SL_TESTS_WEBDRIVER_H
#define SL_TESTS_WEBDRIVER_H

#include <stdbool.h>

struct cJSON;
typedef struct browser browser;

/* NULL: there is no chromedriver here. */
browser *browser_open(int width, int height);
void browser_close(browser *browser);
void browser_resize(browser *browser, int width, int height);
/* A file of this machine, by its absolute path. */
void browser_go_to_file(browser *browser, const char *path);
/* Runs the body of a function and returns what it returns; the caller frees it with cJSON_Delete(). Aborts
 * the test where the script fails. */
struct cJSON *browser_run(browser *browser, const char *script);
double browser_number(browser *browser, const char *script);
/* The caller frees it. */
char *browser_text(browser *browser, const char *script);
/* A click at a place of the window, in CSS pixels. */
void browser_click(browser *browser, int x, int y);
/* Keys as WebDriver has them, UTF-8. */
void browser_press(browser *browser, const char *key);
/* Counts the console's messages of level SEVERE; each is printed. */
int browser_errors(browser *browser);

#define KEY_HOME "\xee\x80\x91"
#define KEY_RIGHT "\xee\x80\x94"
#define KEY_DOWN "\xee\x80\x95"

#endif
