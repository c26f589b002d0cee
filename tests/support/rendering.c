#include "unit_test.h"
#include "rendering.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

sl_scene *load_scene(const char *path) {
    sl_error error;
    sl_scene *scene = NULL;
    if (sl_scene_load(path, &scene, &error) != SL_OK) fail_msg("%s", error.message);
    return scene;
}

const char *load_refused(const char *path) {
    static sl_error error;
    sl_scene *scene = (sl_scene *)&error; /* no result */
    error = (sl_error){0};
    assert_int_equal(sl_scene_load(path, &scene, &error), SL_ERROR_INPUT);
    assert_null(scene);
    assert_null(strchr(error.message, '\n'));
    return error.message;
}

bool scene_warns_of(const sl_scene *scene, const char *words) {
    size_t i = 0;
    while (i < sl_scene_warning_count(scene) && !strstr(sl_scene_warning(scene, i), words)) i++;
    return i < sl_scene_warning_count(scene);
}

static void write_text(const char *path, const char *text) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

sl_scene *scene_from_text(const char *json, const char *obj) {
    char folder[] = "/tmp/softlux-test-XXXXXX", scene_path[64], mesh_path[64];
    assert_non_null(mkdtemp(folder));
    snprintf(scene_path, sizeof scene_path, "%s/scene.json", folder);
    snprintf(mesh_path, sizeof mesh_path, "%s/mesh.obj", folder);
    write_text(scene_path, json);
    if (obj) write_text(mesh_path, obj);
    sl_error error;
    sl_scene *scene = NULL;
    sl_status status =
        sl_scene_load_with(scene_path, &(sl_load_options){.allow_outside = true}, &scene, &error);
    unlink(scene_path);
    unlink(mesh_path);
    rmdir(folder);
    if (status != SL_OK) fail_msg("%s", error.message);
    return scene;
}

sl_scene *room_with_a_box(double scale, double offset, const char *wall, const char *box, const char *lamp,
                          const char *lights) {
    static const int corner[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, -1, 1}, {-1, -1, 1},
                                     {-1, 1, -1},  {1, 1, -1},  {1, 1, 1},  {-1, 1, 1}};
    static const double box_size = 0.3, lamp_size = 0.4;
    char obj[4096], json[1024];
    int n = 0;
    for (int i = 0; i < 8; i++) {
        n += snprintf(obj + n, sizeof obj - (size_t)n, "v %.9g %.9g %.9g\n", offset + scale * corner[i][0],
                      offset + scale * corner[i][1], offset + scale * corner[i][2]);
    }
    for (int i = 0; i < 8; i++) {
        n += snprintf(obj + n, sizeof obj - (size_t)n, "v %.9g %.9g %.9g\n",
                      offset + scale * box_size * corner[i][0],
                      offset + scale * (box_size * corner[i][1] - 1.0 + box_size),
                      offset + scale * box_size * corner[i][2]);
    }
    for (int i = 0; i < 4; i++) {
        n += snprintf(obj + n, sizeof obj - (size_t)n, "v %.9g %.9g %.9g\n",
                      offset + scale * lamp_size * corner[i][0], offset + scale * 0.9,
                      offset + scale * lamp_size * corner[i][2]);
    }
    snprintf(
        obj + n, sizeof obj - (size_t)n,
        "usemtl wall\nf 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 4 8 5\nf 2 3 7 6\n"
        "usemtl box\nf 9 10 11 12\nf 13 14 15 16\nf 9 10 14 13\nf 11 12 16 15\nf 9 12 16 13\nf 10 11 15 14\n"
        "usemtl lamp\nf 17 18 19 20\n");
    snprintf(json, sizeof json,
             "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}],\n"
             " \"materials\": {\"wall\": {%s}, \"box\": {%s}, \"lamp\": {\"diffuse\": 0, "
             "%s\"two_sided\": true}},\n"
             "%s \"camera\": {\"eye\": [%.9g, %.9g, %.9g], \"target\": [%.9g, %.9g, %.9g], \"fov_deg\": 70}}",
             wall, box, lamp, lights, offset, offset, offset + 0.9 * scale, offset, offset - 0.3 * scale,
             offset);
    return scene_from_text(json, obj);
}

sl_settings small_settings(const char *method, int width, int height) {
    sl_settings settings = sl_settings_of_papers();
    settings.method = method;
    settings.width = width;
    settings.height = height;
    settings.quality = SL_QUALITY_DRAFT;
    settings.threads = 2;
    return settings;
}

void good(sl_status status, const sl_error *error) {
    if (status != SL_OK) fail_msg("%s", error->message);
}

sl_method *created_method(const sl_scene *scene, const sl_settings *settings) {
    sl_error error;
    sl_method *method;
    good(sl_method_create(scene, settings, &method, &error), &error);
    return method;
}

bool run_batches(sl_method *method, uint64_t batches) {
    sl_error error;
    sl_progress p = {0};
    while (!p.done && (!batches || p.batches < batches)) good(sl_method_update(method, &p, &error), &error);
    return p.done;
}

void run_to_end(sl_method *method) { run_batches(method, 0); }

bool update(sl_method *method) {
    sl_error error;
    sl_progress progress = {0};
    good(sl_method_update(method, &progress, &error), &error);
    return progress.done;
}

sl_image *resolved_picture(sl_method *method) {
    sl_error error;
    sl_image *image;
    good(sl_method_resolve(method, &image, &error), &error);
    return image;
}

sl_image *finished_picture(sl_method *method) {
    run_to_end(method);
    return resolved_picture(method);
}

double time_of_move(int move) { return 3.96 - fabs(fmod(0.04 * move, 7.92) - 3.96); }

void go_to_time(sl_scene *scene, sl_method *method, double time) {
    sl_error error;
    unsigned changes;
    good(sl_scene_set_time(scene, time, &changes, &error), &error);
    good(sl_method_edit(method, changes, &error), &error);
}

sl_image *render(const sl_scene *scene, const sl_settings *settings, sl_counters *counters) {
    sl_method *method = created_method(scene, settings);
    sl_image *image = finished_picture(method);
    if (counters) *counters = *sl_method_counters(method);
    sl_method_destroy(method);
    return image;
}

void destroy_pictures(sl_image *one, sl_image *other) {
    sl_image_destroy(one);
    sl_image_destroy(other);
}

void destroy_picture(sl_image *image, sl_scene *scene) {
    sl_image_destroy(image);
    sl_scene_destroy(scene);
}

void destroy_method(sl_method *method, sl_scene *scene) {
    sl_method_destroy(method);
    sl_scene_destroy(scene);
}

sl_image *blank_image(int width, int height, int channels) {
    sl_error error;
    sl_image *image;
    good(sl_image_create(width, height, channels, NULL, &image, &error), &error);
    return image;
}

uint64_t count_of(const sl_method *method, sl_counter counter) {
    return sl_method_counters(method)->value[counter];
}

double channel_mean(const sl_image *image, const char *channel) {
    const float *plane = sl_image_channel(image, channel);
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    double sum = 0.0;
    assert_non_null(plane);
    for (size_t i = 0; i < pixels; i++) sum += (double)plane[i];
    return sum / (double)pixels;
}

double displayed_difference(const sl_image *image, const sl_image *from) {
    const int values = 3 * image->width * image->height;
    double squares = 0.0, sum = 0.0;
    for (int i = 0; i < values; i++) {
        const double a = fmin((double)image->planes[i], 1.0), b = fmin((double)from->planes[i], 1.0);
        squares += (a - b) * (a - b);
        sum += b;
    }
    return sqrt(squares / values) / (sum / values);
}

sl_comparison comparison_of(const sl_image *image, const sl_image *reference) {
    sl_error error;
    sl_comparison c;
    good(sl_image_compare(image, reference, NULL, &c, NULL, &error), &error);
    return c;
}

bool same_picture(const sl_image *a, const sl_image *b) {
    size_t values = (size_t)a->width * (size_t)a->height * (size_t)a->channels;
    return a->width == b->width && a->height == b->height && a->channels == b->channels &&
           memcmp(a->planes, b->planes, values * sizeof(float)) == 0;
}

void assert_same_bits_with_any_threads(const sl_scene *scene, const sl_settings *settings) {
    static const unsigned threads[] = {2, 3, 7};
    sl_settings s = *settings;
    sl_counters counters, other_counters;
    s.threads = 1;
    sl_image *first = render(scene, &s, &counters);
    for (size_t t = 0; t < sizeof threads / sizeof threads[0]; t++) {
        s.threads = threads[t];
        sl_image *other = render(scene, &s, &other_counters);
        assert_true(same_picture(first, other));
        assert_memory_equal(&counters, &other_counters, sizeof counters);
        sl_image_destroy(other);
    }
    sl_image_destroy(first);
}

void pause_a_millisecond(void) { nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL); }

static int threads_listed(void) {
    int count = 0;
    DIR *tasks = opendir("/proc/self/task");
    assert_non_null(tasks);
    for (const struct dirent *entry; (entry = readdir(tasks));) count += entry->d_name[0] != '.';
    closedir(tasks);
    return count;
}

int threads_left(int expected) {
    int count = threads_listed();
    for (int tries = 0; count > expected && tries < 10000; tries++) {
        pause_a_millisecond();
        count = threads_listed();
    }
    return count;
}
