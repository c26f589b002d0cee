/* A style, the runs as JSON, and a script that makes the page of them. */
#include "app/steps/page.h"

#include "app/html.h"
#include "base/error.h"

#include <stdio.h>
#include <stdlib.h>

/* page.css and page.js, as the linker has put them in. */
extern const char _binary_src_app_steps_page_css_start[], _binary_src_app_steps_page_css_end[];
extern const char _binary_src_app_steps_page_js_start[], _binary_src_app_steps_page_js_end[];

static void put_file(FILE *out, const char *begin, const char *end) {
    fwrite(begin, 1, (size_t)(end - begin), out);
}

static void put_title(FILE *out, const char *scene, const cJSON *runs) {
    const cJSON *run;
    cJSON_ArrayForEach(run, runs) {
        const cJSON *narrative = cJSON_GetObjectItem(run, "narrative");
        fprintf(out, "%s%s", run == runs->child ? "" : " beside ",
                cJSON_GetStringValue(cJSON_GetObjectItem(narrative, "method")));
    }
    fputs(", step by step: ", out);
    sl_put_escaped(out, scene);
}

static void put_page(FILE *out, const char *scene, const cJSON *runs, const char *data) {
    fputs("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
          "content=\"width=device-width, initial-scale=1\">\n"
          "<meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n<title>",
          out);
    put_title(out, scene, runs);
    fputs("</title>\n<style>\n", out);
    put_file(out, _binary_src_app_steps_page_css_start, _binary_src_app_steps_page_css_end);
    fputs("</style>\n</head>\n<body>\n<header><h1>", out);
    sl_put_escaped(out, scene);
    fputs(", step by step</h1></header>\n<main></main>\n<script type=\"application/json\" id=\"data\">", out);
    for (; *data; data++) { /* no tag may begin within the script element */
        if (*data == '<') fputs("\\u003c", out);
        else fputc(*data, out);
    }
    fputs("</script>\n<script>\n", out);
    put_file(out, _binary_src_app_steps_page_js_start, _binary_src_app_steps_page_js_end);
    fputs("</script>\n</body>\n</html>\n", out);
}

sl_status sl_page_write(const char *folder, const char *scene, const cJSON *runs, sl_error *error) {
    char path[4096], *text = NULL, *data = cJSON_PrintUnformatted(runs);
    size_t size = 0;
    snprintf(path, sizeof path, "%s/index.html", folder);
    FILE *out = data ? open_memstream(&text, &size) : NULL;
    if (out) put_page(out, scene, runs, data);
    bool whole = out && !ferror(out);
    if (out && fclose(out) != 0) whole = false;
    sl_status status = whole ? sl_text_write(path, text, size, error) : sl_fail_memory(error, "the page");
    free(text);
    cJSON_free(data);
    return status;
}
