/* How a scene is read, as command-line options: one table for every command that shows a scene. */
#ifndef SL_APP_LOAD_OPTIONS_H
#define SL_APP_LOAD_OPTIONS_H

#include "app/options.h"
#include "softlux.h"

/* Values as the command line gives them. It must stay where it is: what is taken points into it. */
typedef struct sl_load_request {
    bool allow_outside;
    int up_axis;
    double eye[3], target[3], up[3], fov_degrees;
    sl_viewpoint view;
} sl_load_request;

enum { SL_LOAD_OPTIONS = 6 };

/* Writes that many options. */
void sl_load_options_table(sl_load_request *request, sl_option *options);
/* Once the command line has been read. */
sl_load_options sl_load_options_taken(sl_load_request *request);

#endif
