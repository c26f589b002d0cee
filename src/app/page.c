#include "app/page.h"

#include "base/error.h"
#include "image/formats.h"
#include "image/output_file.h"

#include <stdlib.h>
#include <string.h>

/* ---- lines for people ---- */

int sl_complain(const sl_error *error) {
    fprintf(stderr, "softlux: %s\n", error->message);
    return (int)error->status;
}

void sl_tell_warnings(const sl_scene *scene, bool quiet) {
    for (size_t i = 0; !quiet && i < sl_scene_warning_count(scene); i++)
        fprintf(stderr, "softlux: warning: %s\n", sl_scene_warning(scene, i));
}

/* ---- text ---- */

const char *sl_next_item(const char **at, const char *between, size_t *length) {
    const char *item = *at ? *at + strspn(*at, between) : "";
    *length = strcspn(item, between);
    *at = item + *length;
    return *length ? item : NULL;
}

void sl_put_escaped(FILE *out, const char *text) {
    for (; *text; text++) {
        switch (*text) {
        case '&': fputs("&amp;", out); break;
        case '<': fputs("&lt;", out); break;
        case '>': fputs("&gt;", out); break;
        case '"': fputs("&quot;", out); break;
        default: fputc((unsigned char)*text < 32 ? ' ' : *text, out);
        }
    }
}

char *sl_base_64(const void *data, size_t count) {
    const unsigned char *bytes = data;
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char *text = malloc(4 * ((count + 2) / 3) + 1), *out = text;
    if (!text) return NULL;
    for (size_t i = 0; i < count; i += 3) {
        uint32_t three = (uint32_t)bytes[i] << 16;
        if (i + 1 < count) three |= (uint32_t)bytes[i + 1] << 8;
        if (i + 2 < count) three |= bytes[i + 2];
        for (size_t k = 0; k < 4; k++) *out++ = i + k > count ? '=' : digits[(three >> (18 - 6 * k)) & 63];
    }
    *out = '\0';
    return text;
}

char *sl_picture_text(const sl_image *image, bool tone) {
    sl_tone curve = {tone ? SL_TONE_REINHARD : SL_TONE_CLIP, 0.0f, tone};
    uint8_t *rgb = malloc(3 * (size_t)image->width * (size_t)image->height);
    sl_output_file png;
    sl_output_open_memory(&png);
    char *text = NULL;
    if (rgb && sl_image_srgb(image, &curve, rgb, NULL) == SL_OK &&
        sl_png_write(image->width, image->height, 3, rgb, NULL, 0, &png, NULL) == SL_OK)
        text = sl_base_64(png.memory, png.size);
    sl_output_discard(&png);
    free(rgb);
    return text;
}

char *sl_printed(sl_printer *print, const void *what) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    print(out, what);
    bool whole = !ferror(out);
    if (fclose(out) == 0 && whole) return text;
    free(text);
    return NULL;
}

sl_status sl_print_file(const char *path, sl_printer *print, const void *what, sl_error *error) {
    char *text = sl_printed(print, what);
    sl_status status =
        text ? sl_output_whole(path, text, strlen(text), error) : sl_fail_memory(error, path);
    free(text);
    return status;
}

/* ---- JSON ---- */

/* Bytes of the character that begins here; 0: none does (RFC 3629: no longer form than needed, no surrogates,
 * nothing above U+10FFFF). */
static size_t character(const unsigned char *at) {
    const unsigned char lead = *at;
    const size_t length = lead < 0x80                   ? 1
                          : lead >= 0xc2 && lead < 0xe0 ? 2
                          : lead >= 0xe0 && lead < 0xf0 ? 3
                          : lead >= 0xf0 && lead < 0xf5 ? 4
                                                        : 0;
    for (size_t i = 1; i < length; i++) {
        if ((at[i] & 0xc0) != 0x80) return 0;
    }
    const bool longer = (lead == 0xe0 && at[1] < 0xa0) || (lead == 0xf0 && at[1] < 0x90);
    const bool none = (lead == 0xed && at[1] >= 0xa0) || (lead == 0xf4 && at[1] >= 0x90);
    return longer || none ? 0 : length;
}

static void mend(char *text) {
    for (char *at = text; at && *at;) {
        size_t length = character((const unsigned char *)at);
        if (!length) *at = '?';
        at += length ? length : 1;
    }
}

void sl_json_print(cJSON *json, bool one_line) {
    char *text = one_line ? cJSON_PrintUnformatted(json) : cJSON_Print(json);
    mend(text);
    if (text) puts(text);
    if (one_line) fflush(stdout);
    cJSON_free(text);
    cJSON_Delete(json);
}

static void put_lines(FILE *out, const cJSON *object, const char *indent) {
    const cJSON *item;
    cJSON_ArrayForEach(item, object) {
        const bool word = cJSON_IsBool(item) || cJSON_IsNull(item);
        fprintf(out, "%s%-19s ", indent, item->string ? item->string : ""); /* an array's have none */
        if (cJSON_IsNumber(item)) fprintf(out, "%.9g\n", item->valuedouble);
        if (cJSON_IsString(item)) fprintf(out, "%s\n", item->valuestring);
        if (word) fprintf(out, "%s\n", cJSON_IsNull(item) ? "unknown" : cJSON_IsTrue(item) ? "yes" : "no");
        if (word || !item->child) continue;
        fputc('\n', out);
        put_lines(out, item, "  ");
    }
}

void sl_json_lines(FILE *out, cJSON *json) {
    put_lines(out, json, "");
    cJSON_Delete(json);
}

void sl_json_add_counters(cJSON *to, const char *name, const sl_counters *counters, bool zeros) {
    cJSON *object = cJSON_AddObjectToObject(to, name);
    for (int i = 0; i < SL_COUNTERS; i++)
        if (zeros || counters->value[i])
            cJSON_AddNumberToObject(object, sl_counter_name((sl_counter)i), (double)counters->value[i]);
}

/* ---- pages ---- */

typedef struct page {
    const char *title, *heading;
    const sl_page_files *files;
    const char *data;
} page;

static void put_page(FILE *out, const void *what) {
    const page *p = what;
    const sl_page_files *files = p->files;
    fputs("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
          "content=\"width=device-width, initial-scale=1\">\n"
          "<meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n<title>",
          out);
    sl_put_escaped(out, p->title);
    fputs("</title>\n<style>\n", out);
    fwrite(files->css, 1, (size_t)(files->css_end - files->css), out);
    fputs("</style>\n</head>\n<body>\n", out);
    if (*p->heading) {
        fputs("<header><h1>", out);
        sl_put_escaped(out, p->heading);
        fputs("</h1></header>\n", out);
    }
    fputs("<main></main>\n<script type=\"application/json\" id=\"data\">", out);
    for (const char *data = p->data; *data; data++) { /* no tag may begin within the script element */
        if (*data == '<') fputs("\\u003c", out);
        else fputc(*data, out);
    }
    fputs("</script>\n<script>\n", out);
    if (files->before_js)
        fwrite(files->before_js, 1, (size_t)(files->before_js_end - files->before_js), out);
    fwrite(files->js, 1, (size_t)(files->js_end - files->js), out);
    fputs("</script>\n</body>\n</html>\n", out);
}

sl_status sl_page_write(const char *path, const char *title, const char *heading, const sl_page_files *files,
                        const cJSON *data, sl_error *error) {
    char *json = cJSON_PrintUnformatted(data);
    const page p = {title, heading, files, json};
    sl_status status = json ? sl_print_file(path, put_page, &p, error) : sl_fail_memory(error, "the page");
    cJSON_free(json);
    return status;
}
