/* Shared by the tests of whole pictures: every function fails the test, with the library's message, where
 * anything fails. */
#pragma once

#include "cache/frame/settings.h"

sl_scene *load_scene(const char *path);
/* Returns the one line in which a file is refused as input; good until the next call. */
const char *load_refused(const char *path);
/* Tells whether a scene has a warning that holds the words. */
bool scene_warns_of(const sl_scene *scene, const char *words);
/* A scene file from text, in a temporary folder; mesh text (OBJ) may be NULL, else the scene calls it
 * "mesh.obj". */
sl_scene *scene_from_text(const char *json, const char *obj);
/* A room of half size 1 about the origin before it is scaled, then moved: six walls, a box on the floor, a
 * lamp below the ceiling. Materials and lights are parts of scene files; that of the lamp ends in a comma. */
sl_scene *room_with_a_box(double scale, double offset, const char *wall, const char *box, const char *lamp,
                          const char *lights);
/* Fails the test with the message of a call that failed. */
void good(sl_status status, const sl_error *error);
sl_settings small_settings(const char *method, int width, int height);
/* Runs a method to its end and resolves it; counters (may be NULL) receives what it cost. */
sl_image *render(const sl_scene *scene, const sl_settings *settings, sl_counters *counters);
sl_method *created_method(const sl_scene *scene, const sl_settings *settings);
void run_to_end(sl_method *method);
bool update(sl_method *method); /* once; is it at its end? */
/* Runs so many batches, or to its end where they are 0 or more than there are. Was that reached? */
bool run_batches(sl_method *method, uint64_t batches);
sl_image *resolved_picture(sl_method *method); /* as far as it has come */
/* Returns the time of a move, to and fro, 25 frames a second. */
double time_of_move(int move);
/* Tells a method of its scene at another time. */
void go_to_time(sl_scene *scene, sl_method *method, double time);
/* Updates a method to its end and resolves it. */
sl_image *finished_picture(sl_method *method);
sl_image *blank_image(int width, int height,
                      int channels); /* with the names that channels have by themselves */
uint64_t count_of(const sl_method *method, sl_counter counter);
void destroy_pictures(sl_image *one, sl_image *other);
void destroy_picture(sl_image *image, sl_scene *scene); /* and its scene */
void destroy_method(sl_method *method, sl_scene *scene); /* and its scene */
double channel_mean(const sl_image *image, const char *channel);
/* Relative RMS difference of what is displayed: lamps count as white. */
double displayed_difference(const sl_image *image, const sl_image *from);
sl_comparison comparison_of(const sl_image *image, const sl_image *reference);
/* Are all channels equal, bit for bit? */
bool same_picture(const sl_image *a, const sl_image *b);
/* The picture and the counters with 2, 3 and 7 threads are those with 1. */
void assert_same_bits_with_any_threads(const sl_scene *scene, const sl_settings *settings);
void pause_a_millisecond(void);
/* Threads of this process, once no more than `expected` are left, or after ten seconds. Of 4,000 threads that
 * had been joined the system still listed 5 right after their end, and none 5 ms later. */
int threads_left(int expected);
