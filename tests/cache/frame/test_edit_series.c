/* Methods that follow any series of edits give what those give that are created for the scene as it stands:
 * with memory that ends now and then, with pictures that are finished and others that are not. */
#include <math.h>
#include <stdio.h>

#include "unit_test.h"
#include "edited_methods.h"
#include "failing_memory.h"

enum { EDITS = 200, EDITS_A_LOOK = 40 };

static sl_settings settings_for(const char *method) {
    sl_settings settings = settings_in_room(method);
    settings.threads = 1; /* memory that fails is for one */
    return settings;
}

/* Of a kind that is drawn by weights: what methods can keep much of comes more often. */
static room_edit kind_of(edited_room *r) {
    static const room_edit kinds[] = {EDIT_COLOUR, EDIT_COLOUR, EDIT_LAMP,   EDIT_LAMP,   EDIT_POWER,
                                      EDIT_POWER,  EDIT_PLACE,  EDIT_CAMERA, EDIT_CAMERA, EDIT_TRANSFORM,
                                      EDIT_SKY,    EDIT_KIND,   EDIT_SHAPE,  EDIT_CHAIR, EDIT_NEW_LIGHT,
                                      EDIT_TEXTURE};
    return kinds[(int)(16.0 * room_random(r))];
}

static void edit_scene(edited_room *r, sl_scene *scene, int edits) {
    sl_error error;
    sl_scene_edit *e;
    good(begin_room_edit(r, scene, &e, &error), &error);
    for (int i = 0; i < edits; i++) good(edit_room(r, scene, kind_of(r), e, &error), &error);
    good(sl_scene_edit_commit(e, NULL, &error), &error);
}

/* Every seventh edit memory ends; the edit is made once more then. */
static void tell(sl_method *method, edited_room *r, int step, int *failures) {
    sl_error error;
    allocations_left = step % 7 == 3 ? (long)(30.0 * room_random(r)) : -1;
    sl_status status = sl_method_edit(method, 0, &error);
    allocations_left = -1;
    *failures += status != SL_OK;
    if (status != SL_OK) {
        assert_int_equal(status, SL_ERROR_RESOURCES);
        assert_int_equal(sl_method_update(method, &(sl_progress){0}, NULL), SL_ERROR_USAGE);
        status = sl_method_edit(method, 0, &error);
    }
    good(status, &error);
}

static double error_of(const sl_image *image, const sl_image *reference) {
    sl_comparison c = comparison_of(image, reference);
    assert_int_equal(c.nonfinite, 0);
    return c.rmse / (c.mean_reference + 0.01);
}

typedef struct looks {
    double edited, fresh; /* sums of squared errors */
    int same, anew;       /* the fresh one's bits; when told to begin anew */
} looks;

static sl_image *render_reference(const sl_scene *scene, const sl_settings *settings) {
    char transport[64];
    sl_settings truth = settings_for("path");
    truth.spp = 256;
    snprintf(transport, sizeof transport, "matched:%s", settings->method);
    truth.transport = transport;
    return render(scene, &truth, NULL);
}

/* Pictures that are the same are equally good. */
static void look_at(sl_method *method, const sl_scene *scene, const sl_settings *settings, looks *l) {
    sl_error error;
    sl_image *edited = finished_picture(method), *fresh = render(scene, settings, NULL), *reference = NULL;
    if (same_picture(edited, fresh)) {
        l->same++;
    } else {
        reference = render_reference(scene, settings);
        l->edited += pow(error_of(edited, reference), 2.0);
        l->fresh += pow(error_of(fresh, reference), 2.0);
    }
    good(sl_method_edit(method, SL_CHANGED_KINDS, &error), &error);
    sl_image *anew = finished_picture(method), *all[] = {edited, fresh, reference, anew};
    l->anew += same_picture(anew, fresh);
    for (int i = 0; i < 4; i++) sl_image_destroy(all[i]);
}

/* limited: with half as much memory again as is enough for the room as it is at first. */
static void follow_series(const char *name, int edits, bool limited, looks *l) {
    sl_error error;
    sl_scene *scene;
    sl_method *method;
    edited_room r = room_at_first(11);
    int failures = 0;
    sl_settings settings = settings_for(name);
    good(build_room(&r, &scene, &error), &error);
    if (limited) {
        good(sl_method_memory_need(scene, &settings, &settings.memory_bytes, &error), &error);
        settings.memory_bytes += settings.memory_bytes / 2; /* lights and a sky come */
    }
    good(sl_method_create(scene, &settings, &method, &error), &error);
    for (int step = 1; step <= edits; step++) {
        edit_scene(&r, scene, 1 + step % 2);
        tell(method, &r, step, &failures);
        for (int i = 0; i < step % 4; i++) good(sl_method_update(method, &(sl_progress){0}, &error), &error);
        if (step % EDITS_A_LOOK == 0) look_at(method, scene, &settings, l);
    }
    print_message("%-16s %.4f, a fresh one %.4f; %d the same; memory ended %d times\n", name,
                  sqrt(l->edited), sqrt(l->fresh), l->same, failures);
    destroy_method(method, scene);
}

static void check_series(const char *name, int edits, bool limited) {
    looks l = {0};
    follow_series(name, edits, limited, &l);
    const bool keeps = strcmp(name, "multi-mesh") == 0 || strcmp(name, "shading-cache") == 0 ||
                       strcmp(name, "splatting") == 0;
    if (!keeps) assert_int_equal(l.same, edits / EDITS_A_LOOK);
    assert_true(l.edited <= 1.1 * 1.1 * l.fresh);
    assert_int_equal(l.anew, edits / EDITS_A_LOOK);
}

static void methods_that_have_followed_are_as_good_as_fresh_ones(void **state) {
    for (size_t i = 0; sl_method_name(i); i++) {
        const char *name = sl_method_name(i);
        check_series(name, EDITS, false);
        check_series(name, EDITS_A_LOOK, true);
    }
    assert_int_equal(blocks_held, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(methods_that_have_followed_are_as_good_as_fresh_ones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
