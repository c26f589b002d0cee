/* The files of a scene: NAME.obj, NAME.mtl, NAME.json. Each is written beside its name and renamed when
 * complete. */
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mesh.h"

enum { PATH_BYTES = 4096 };

static void fail(const char *doing, const char *path) {
    fprintf(stderr, "generate: cannot %s %s: %s\n", doing, path, strerror(errno));
    exit(4);
}

static FILE *open_beside(const char *folder, const char *name, const char *ending, char *path, char *beside) {
    int length = snprintf(path, PATH_BYTES, "%s/%s%s", folder, name, ending);
    if (length < 0 || length > PATH_BYTES - 8) {
        errno = ENAMETOOLONG;
        fail("write into", folder);
    }
    snprintf(beside, PATH_BYTES + 8, "%s.part", path);
    FILE *file = fopen(beside, "wb");
    if (!file) fail("write", beside);
    return file;
}

static void close_and_rename(FILE *file, const char *path, const char *beside) {
    bool bad = ferror(file) != 0;
    bad |= fclose(file) != 0;
    if (bad) {
        remove(beside);
        fail("write", beside);
    }
    if (rename(beside, path) != 0) fail("rename to", path);
}

/* " -1.25" for -12500: a space, then the ten-thousandths as a decimal without trailing zeros. */
static char *put_number(char *to, int32_t ten_thousandths) {
    char digits[16];
    int64_t value = ten_thousandths < 0 ? -(int64_t)ten_thousandths : ten_thousandths;
    *to++ = ' ';
    if (ten_thousandths < 0) *to++ = '-';
    int count = snprintf(digits, sizeof digits, "%lld", (long long)(value / 10000));
    memcpy(to, digits, (size_t)count);
    to += count;
    int fraction = (int)(value % 10000);
    if (fraction) {
        *to++ = '.';
        for (int place = 1000; fraction; place /= 10) {
            *to++ = (char)('0' + fraction / place);
            fraction %= place;
        }
    }
    return to;
}

static void put_vectors(FILE *file, const char *keyword, int32_t (*vectors)[3], size_t count) {
    for (size_t i = 0; i < count; i++) {
        char line[64];
        char *to = line;
        for (const char *k = keyword; *k; k++) *to++ = *k;
        for (int c = 0; c < 3; c++) to = put_number(to, vectors[i][c]);
        *to++ = '\n';
        fwrite(line, 1, (size_t)(to - line), file);
    }
}

static void put_faces(FILE *file, const mesh *m) {
    size_t run = 0;
    const char *object = NULL;
    for (size_t i = 0; i < m->face_count; i++) {
        while (run < m->run_count && m->runs[run].first_face <= i) {
            const gen_run *r = &m->runs[run++];
            bool has_faces = run == m->run_count || m->runs[run].first_face > i;
            if (!has_faces) continue;
            if (!object || strcmp(object, r->object) != 0) fprintf(file, "o %s\n", r->object);
            object = r->object;
            fprintf(file, "usemtl %s\n", m->materials[r->material].name);
        }
        const gen_corner *f = m->faces[i];
        fprintf(file, "f %u//%u %u//%u %u//%u\n", f[0].position + 1, f[0].normal + 1, f[1].position + 1,
                f[1].normal + 1,
                f[2].position + 1, f[2].normal + 1);
    }
}

static void write_mtl(const char *folder, const char *name, const mesh *m) {
    char path[PATH_BYTES], beside[PATH_BYTES + 8];
    FILE *file = open_beside(folder, name, ".mtl", path, beside);
    for (uint32_t i = 0; i < m->material_count; i++)
        fprintf(file, "%snewmtl %s\n%s", i ? "\n" : "", m->materials[i].name, m->materials[i].mtl);
    close_and_rename(file, path, beside);
}

void gen_write_text(const char *folder, const char *name, const char *ending, const char *format, ...) {
    char path[PATH_BYTES], beside[PATH_BYTES + 8];
    FILE *file = open_beside(folder, name, ending, path, beside);
    va_list arguments;
    va_start(arguments, format);
    vfprintf(file, format, arguments);
    va_end(arguments);
    close_and_rename(file, path, beside);
}

void gen_write_mesh(const char *folder, const char *name, const mesh *m) {
    char path[PATH_BYTES], beside[PATH_BYTES + 8];
    write_mtl(folder, name, m);
    FILE *file = open_beside(folder, name, ".obj", path, beside);
    fprintf(file, "# softlux generated scene: %s, %zu triangles\nmtllib %s.mtl\n", name, m->face_count, name);
    put_vectors(file, "v", m->positions, m->position_count);
    put_vectors(file, "vn", m->normals, m->normal_count);
    put_faces(file, m);
    close_and_rename(file, path, beside);
    printf("%-10s %7zu triangles, %7zu vertices\n", name, m->face_count, m->position_count);
    fflush(stdout);
}

void gen_write_scene(const char *folder, const char *name, const mesh *m, const char *json_middle) {
    gen_write_mesh(folder, name, m);
    gen_write_text(folder, name, ".json",
                   "{\n  \"softlux\": 1,\n  \"meshes\": [{\"file\": \"%s.obj\"}],\n%s,\n"
                   "  \"film\": {\"width\": 1000, \"height\": 1000}\n}\n", name, json_middle);
}

/* PFM: bottom row first; a negative scale says little endian, written so whatever the machine's own order is.
 */
void gen_write_pfm(const char *folder, const char *name, const float *rgb, int width, int height) {
    char path[PATH_BYTES], beside[PATH_BYTES + 8];
    FILE *file = open_beside(folder, name, ".pfm", path, beside);
    fprintf(file, "PF\n%d %d\n-1.0\n", width, height);
    for (int row = height - 1; row >= 0; row--) {
        for (int i = 0; i < width * 3; i++) {
            uint32_t bits;
            memcpy(&bits, &rgb[(size_t)row * (size_t)width * 3 + (size_t)i], sizeof bits);
            for (int byte = 0; byte < 4; byte++) fputc((int)(bits >> (8 * byte) & 255u), file);
        }
    }
    close_and_rename(file, path, beside);
}
