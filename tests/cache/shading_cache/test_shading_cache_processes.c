/* Sample renderers as pure functions of (scene, requests): another process, which has loaded the scene itself
 * and knows nothing of the cache, computes the same bits, be it asked for all, for some, or in another order,
 * and whatever else was asked for before. */
#include "renderer_support.h"

#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

enum { REQUESTS = 60, KINDS = 3 };

static const struct {
    const char *name;
    make_renderer *make;
} kinds[KINDS] = {{"area", sl_area_renderer},
                  {"bidirectional", sl_bidirectional_renderer},
                  {"caustic", sl_caustic_renderer}};

/* ---- requests and samples as they go through a pipe: no addresses, no gaps ------------------- */

typedef struct wire_request {
    float position[3], normal[3], geometric[3], eye[3];
    uint32_t triangle, material, radiance, set;
} wire_request;

typedef struct wire_sample {
    float irradiance[3], radiance[3], variance;
    uint32_t valid;
} wire_sample;

static void put3(float to[3], sl_vec3 v) { to[0] = v.x, to[1] = v.y, to[2] = v.z; }
static sl_vec3 get3(const float from[3]) { return sl_v3(from[0], from[1], from[2]); }

static wire_request pack(const sl_scene *scene, const sl_sample_request *q) {
    wire_request w = {.triangle = q->point.triangle,
                      .material = (uint32_t)(q->material - scene->materials),
                      .radiance = q->radiance,
                      .set = q->set};
    put3(w.position, q->point.position);
    put3(w.normal, q->point.normal);
    put3(w.geometric, q->point.geometric_normal);
    put3(w.eye, q->eye);
    return w;
}

static sl_sample_request unpack(const sl_scene *scene, const wire_request *w) {
    return (sl_sample_request){.point = {get3(w->position), get3(w->normal), get3(w->geometric), w->triangle},
                               .material = &scene->materials[w->material],
                               .eye = get3(w->eye),
                               .radiance = w->radiance != 0,
                               .set = w->set};
}

static wire_sample pack_sample(const sl_sample *s) {
    return (wire_sample){{s->irradiance.r, s->irradiance.g, s->irradiance.b},
                         {s->radiance.r, s->radiance.g, s->radiance.b},
                         s->variance,
                         s->valid};
}

static bool read_all(int from, void *data, size_t bytes) {
    for (char *at = data; bytes;) {
        ssize_t got = read(from, at, bytes);
        if (got <= 0) return false;
        at += got;
        bytes -= (size_t)got;
    }
    return true;
}

static bool write_all(int to, const void *data, size_t bytes) {
    for (const char *at = data; bytes;) {
        ssize_t put = write(to, at, bytes);
        if (put <= 0) return false;
        at += put;
        bytes -= (size_t)put;
    }
    return true;
}

/* ---- the other process ----------------------------------------------------------------------- */

static void set_up(shop *s, sl_scene *scene) {
    shop_open(s, scene);
    s->settings.cache.indirect_samples = 8;
    s->settings.cache.area_samples = 16;
    s->settings.cache.caustics = true;
}

/* worker SCENE TIME KIND: a number of requests and then these on standard input, as many samples on standard
 * output, until the input ends. */
static int work(char **argv) {
    sl_scene *scene;
    if (sl_scene_load(argv[0], &scene, NULL) != SL_OK ||
        sl_scene_set_time(scene, atof(argv[1]), NULL, NULL) != SL_OK)
        return 1;
    shop s;
    set_up(&s, scene);
    sl_sample_renderer renderer;
    if (kinds[atoi(argv[2])].make(&s.settings, &renderer, NULL) != SL_OK) return 1;
    wire_request wire[REQUESTS];
    sl_sample_request requests[REQUESTS];
    sl_sample samples[REQUESTS];
    bool ok = true;
    for (uint32_t count; ok && read_all(STDIN_FILENO, &count, sizeof count);) {
        ok = count <= REQUESTS && read_all(STDIN_FILENO, wire, count * sizeof *wire);
        for (uint32_t i = 0; ok && i < count; i++) requests[i] = unpack(scene, &wire[i]);
        if (ok) renderer.render(renderer.state, count, requests, 1, samples, &s.counters);
        for (uint32_t i = 0; ok && i < count; i++) {
            wire_sample answer = pack_sample(&samples[i]);
            ok = write_all(STDOUT_FILENO, &answer, sizeof answer);
        }
    }
    renderer.destroy(renderer.state);
    shop_close(&s);
    return ok ? 0 : 1;
}

typedef struct other_process {
    pid_t id;
    int to, from;
} other_process;

static other_process start_worker(const char *scene, const char *time, int kind) {
    int requests[2], samples[2];
    char number[12];
    snprintf(number, sizeof number, "%d", kind);
    assert_int_equal(pipe(requests), 0);
    assert_int_equal(pipe(samples), 0);
    pid_t id = fork();
    assert_true(id >= 0);
    if (id == 0) {
        dup2(requests[0], STDIN_FILENO);
        dup2(samples[1], STDOUT_FILENO);
        close(requests[1]);
        close(samples[0]);
        execl("/proc/self/exe", "worker", scene, time, number, (char *)NULL);
        _exit(127);
    }
    close(requests[0]);
    close(samples[1]);
    return (other_process){id, requests[1], samples[0]};
}

static void ask(const other_process *p, uint32_t count, const wire_request *requests, wire_sample *samples) {
    assert_true(write_all(p->to, &count, sizeof count));
    assert_true(write_all(p->to, requests, count * sizeof *requests));
    assert_true(read_all(p->from, samples, count * sizeof *samples));
}

static void end_worker(const other_process *p) {
    int status;
    close(p->to);
    assert_int_equal(waitpid(p->id, &status, 0), p->id);
    close(p->from);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

/* ---- the same bits --------------------------------------------------------------------------- */

/* Anywhere; of mirrors fewer, which have more triangles than all else. */
static uint32_t triangle_number(const sl_scene *scene, uint64_t key, uint64_t i) {
    uint32_t triangle = 0;
    for (uint64_t k = 0; k < 20; k++) {
        triangle = (uint32_t)(sl_random_unit(sl_random_key(key, i), k) * (float)scene->triangle_count);
        if (i % 5 == 0 || sl_material_is_diffuse(&scene->materials[scene->material_index[triangle]])) break;
    }
    return triangle;
}

static sl_sample_request request_number(const sl_scene *scene, uint64_t key, uint64_t i) {
    uint32_t triangle = triangle_number(scene, key, i);
    float w1 = sl_random_unit(key, 5 * i + 1), w2 = (1.0f - w1) * sl_random_unit(key, 5 * i + 2);
    sl_sample_request q = request_on(scene, triangle, w1, w2, sl_random_unit(key, 5 * i + 3) < 0.8f);
    q.eye = scene->camera.eye;
    q.radiance = sl_material_is_glossy(q.material) || sl_material_is_mirror(q.material);
    q.set = i % 4 == 3;
    return q;
}

/* Here the scene has moved there under the renderer; there it was loaded so. */
static void assert_another_process_agrees(const char *path, const char *time, int kind) {
    shop s;
    unsigned changes;
    set_up(&s, load_scene(path));
    sl_sample_renderer here = shop_renderer(&s, kinds[kind].make);
    assert_int_equal(sl_scene_set_time(s.scene, atof(time), &changes, NULL), SL_OK);
    if (changes) {
        sl_tracer_destroy(s.tracer);
        assert_int_equal(sl_tracer_create(s.scene, 1, NULL, &s.tracer, NULL), SL_OK);
        s.shown = s.tracer;
        assert_int_equal(here.edit(here.state, changes, NULL), SL_OK);
    }
    sl_sample_request requests[REQUESTS];
    sl_sample samples[REQUESTS];
    wire_request wire[REQUESTS], backwards[REQUESTS];
    wire_sample expected[REQUESTS], answers[REQUESTS];
    bool light = false;
    for (uint32_t i = 0; i < REQUESTS; i++) {
        requests[i] = request_number(s.scene, sl_random_key(19, (uint64_t)kind), i);
        wire[i] = backwards[REQUESTS - 1 - i] = pack(s.scene, &requests[i]);
    }
    here.render(here.state, REQUESTS, requests, 3, samples, &s.counters);
    for (uint32_t i = 0; i < REQUESTS; i++) {
        expected[i] = pack_sample(&samples[i]);
        light = light || expected[i].irradiance[1] > 0.0f || expected[i].radiance[1] > 0.0f;
    }
    assert_true(light);
    other_process there = start_worker(path, time, kind);
    ask(&there, REQUESTS, wire, answers);
    assert_memory_equal(answers, expected, sizeof expected);
    ask(&there, 7, wire + 20, answers); /* again, some of them */
    assert_memory_equal(answers, expected + 20, 7 * sizeof *expected);
    ask(&there, REQUESTS, backwards, answers);
    for (uint32_t i = 0; i < REQUESTS; i++)
        assert_memory_equal(&answers[REQUESTS - 1 - i], &expected[i], sizeof *expected);
    end_worker(&there);
    here.destroy(here.state);
    shop_close(&s);
}

static void another_process_computes_the_same_samples(void **state) {
    (void)state;
    assert_another_process_agrees("scenes/cornell-glossy.json", "0", 0);
    assert_another_process_agrees("scenes/cornell-glossy.json", "0", 1);
    assert_another_process_agrees("scenes/vase.json", "0", 0);
    assert_another_process_agrees("scenes/cornell-mirror.json", "0", 1);
    assert_another_process_agrees("scenes/cornell-mirror.json", "0", 2);
}

static void and_of_a_scene_that_has_moved(void **state) {
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        assert_another_process_agrees("scenes/moving-ball.json", "1.3", kind);
        assert_another_process_agrees("scenes/moving-light.json", "2.2", kind);
    }
}

int main(int argc, char **argv) {
    if (argc == 4) return work(argv + 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(another_process_computes_the_same_samples),
        cmocka_unit_test(and_of_a_scene_that_has_moved),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
