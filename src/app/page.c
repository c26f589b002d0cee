#include "app/page.h"

#include "app/html.h"
#include "base/error.h"

#include <stdio.h>
#include <stdlib.h>

static void put_page(FILE *out, const char *title, const char *heading, const sl_page_files *files,
                     const char *data) {
    fputs("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
          "content=\"width=device-width, initial-scale=1\">\n"
          "<meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n<title>",
          out);
    sl_put_escaped(out, title);
    fputs("</title>\n<style>\n", out);
    fwrite(files->css, 1, (size_t)(files->css_end - files->css), out);
    fputs("</style>\n</head>\n<body>\n", out);
    if (*heading) {
        fputs("<header><h1>", out);
        sl_put_escaped(out, heading);
        fputs("</h1></header>\n", out);
    }
    fputs("<main></main>\n<script type=\"application/json\" id=\"data\">", out);
    for (; *data; data++) { /* no tag may begin within the script element */
        if (*data == '<') fputs("\\u003c", out);
        else fputc(*data, out);
    }
    fputs("</script>\n<script>\n", out);
    fwrite(files->js, 1, (size_t)(files->js_end - files->js), out);
    fputs("</script>\n</body>\n</html>\n", out);
}

sl_status sl_page_write(const char *path, const char *title, const char *heading, const sl_page_files *files,
                        const cJSON *data, sl_error *error) {
    char *text = NULL, *json = cJSON_PrintUnformatted(data);
    size_t size = 0;
    FILE *out = json ? open_memstream(&text, &size) : NULL;
    if (out) put_page(out, title, heading, files, json);
    bool whole = out && !ferror(out);
    if (out && fclose(out) != 0) whole = false;
    sl_status status = whole ? sl_text_write(path, text, size, error) : sl_fail_memory(error, "the page");
    free(text);
    cJSON_free(json);
    return status;
}
