/* Rooms that are hard to compute: a small mesh in the making, and what is changed about it. Written as files
 * that anybody could have written. */
#ifndef SL_APP_NUMERICS_ROOM_H
#define SL_APP_NUMERICS_ROOM_H

#include "softlux.h"

typedef struct sl_room_material {
    const char *name;
    double diffuse[3], specular, exponent, mirror, emission[3];
} sl_room_material;

/* Materials that every room has; emission leaves the front. */
enum { SL_ROOM_WHITE, SL_ROOM_RED, SL_ROOM_GREEN, SL_ROOM_BOX, SL_ROOM_LAMP, SL_ROOM_MATERIALS };

typedef struct sl_room {
    double (*vertex)[3];
    size_t vertex_count, vertex_room;
    struct {
        size_t corner[3];
        int material;
    } *triangle;
    size_t triangle_count, triangle_room;
    sl_room_material material[SL_ROOM_MATERIALS];
    char lights[512];       /* JSON, between the brackets of "lights" */
    double eye[3], target[3], fov_deg;
    int width, height;
    bool failed;            /* for want of memory */
} sl_room;

/* How finely the walls of a room are cut, which ought to change nothing. */
typedef struct sl_room_cut {
    int columns, rows; /* of every wall */
    double skew;       /* 0: even; else the first column takes this share of the width, and so on */
} sl_room_cut;

/* A room of 4 x 3 x 5 with a box on its floor and a lamp of .8 x .8 under its ceiling, seen from its open
 * front. */
void sl_room_begin(sl_room *room, const sl_room_cut *cut);
void sl_room_end(sl_room *room);
/* A quadrilateral, counter-clockwise from the front, cut in parts. */
void sl_room_quad(sl_room *room, const double corner[4][3], int material, const sl_room_cut *cut);
size_t sl_room_vertex(sl_room *room, double x, double y, double z);
void sl_room_triangle(sl_room *room, size_t a, size_t b, size_t c, int material);
/* Everything, the camera and its lamp too: times scale, then moved, then x turned into -x if mirrored. */
void sl_room_move(sl_room *room, double scale, const double by[3], bool mirrored);
/* Writes folder/room.obj, room.mtl and room.json; path receives the last one's name. */
sl_status sl_room_write(const sl_room *room, const char *folder, char *path, size_t size, sl_error *error);

#endif
