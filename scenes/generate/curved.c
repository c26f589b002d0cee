/* Bicubic surfaces and their files (.bpt). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "mesh.h"

/* The control points of a cubic that stands for an arc: its middle two lie on the end tangents, 4/3 tan(angle
 * / 4) radii away. For a quarter turn it is off by 0.03 % of the radius, for half a turn by 2 %. */
int gen_revolve(const v2 curve[4], int parts, gen_bicubic *surfaces) {
    double angle = 2.0 * SL_PI / parts, handle = 4.0 / 3.0 * sl_tan(angle / 4.0);
    for (int part = 0; part < parts; part++) {
        double from = part * angle, to = (part + 1) % parts * angle;
        const double x[4] = {sl_cos(from), sl_cos(from) - handle * sl_sin(from),
                             sl_cos(to) + handle * sl_sin(to), sl_cos(to)};
        const double z[4] = {-sl_sin(from), -sl_sin(from) - handle * sl_cos(from),
                             -sl_sin(to) + handle * sl_cos(to), -sl_sin(to)};
        for (int v = 0; v < 4; v++)
            for (int u = 0; u < 4; u++)
                surfaces[part].p[v][u] = gen_v3(curve[v].x * x[u], curve[v].y, curve[v].x * z[u]);
    }
    return parts;
}

void gen_write_bicubic(const char *folder, const char *name, const gen_bicubic *surfaces, int count) {
    enum { LINE = 64 };
    size_t room = (size_t)count * 17 * LINE + LINE;
    char *text = gen_allocate(room), *to = text;
    to += snprintf(to, LINE, "%d\n", count);
    for (int i = 0; i < count; i++) {
        to += snprintf(to, LINE, "3 3\n");
        for (int k = 0; k < 16; k++) {
            v3 p = surfaces[i].p[k / 4][k % 4];
            to += snprintf(to, LINE, "%.5f %.5f %.5f\n", p.x + 0.0, p.y + 0.0, p.z + 0.0);
        }
    }
    gen_write_text(folder, name, ".bpt", "%s", text);
    free(text);
}
