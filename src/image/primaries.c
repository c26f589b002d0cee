#include "image/primaries.h"

#include <math.h>

static const sl_primaries rec709 = {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}};

static double determinant(double m[3][3]) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

static bool invert(double m[3][3], double inverse[3][3]) {
    double d = determinant(m);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, e = (i + 2) % 3;
            inverse[i][j] = (m[a][c] * m[b][e] - m[a][e] * m[b][c]) / (d != 0.0 ? d : 1.0);
        }
    }
    return isfinite(d) && fabs(d) > 1e-9;
}

/* SMPTE RP 177: each primary as strong as makes 1, 1, 1 the white of Y = 1. */
static bool to_xyz(const sl_primaries *p, double m[3][3]) {
    const double *const point[3] = {p->red, p->green, p->blue};
    if (!(p->white[1] > 0.0)) return false;
    const double white[3] = {p->white[0] / p->white[1], 1.0, (1.0 - p->white[0] - p->white[1]) / p->white[1]};
    double inverse[3][3];
    for (int c = 0; c < 3; c++)
        m[0][c] = point[c][0], m[1][c] = point[c][1], m[2][c] = 1.0 - point[c][0] - point[c][1];
    if (!invert(m, inverse)) return false;
    for (int c = 0; c < 3; c++) {
        double strength = inverse[c][0] * white[0] + inverse[c][1] * white[1] + inverse[c][2] * white[2];
        for (int row = 0; row < 3; row++) m[row][c] *= strength;
    }
    return true;
}

static bool are_rec709(const sl_primaries *p) {
    const double *const a[4] = {p->red, p->green, p->blue, p->white};
    const double *const b[4] = {rec709.red, rec709.green, rec709.blue, rec709.white};
    double most = 0.0;
    for (int i = 0; i < 4; i++) most = fmax(most, fmax(fabs(a[i][0] - b[i][0]), fabs(a[i][1] - b[i][1])));
    return most < 1e-3;
}

bool sl_to_rec709(sl_image *image, const sl_primaries *from) {
    float *plane[3] = {sl_image_channel(image, "R"), sl_image_channel(image, "G"),
                       sl_image_channel(image, "B")};
    double xyz[3][3], ours[3][3], back[3][3], m[3][3];
    if (are_rec709(from)) return true;
    if (!plane[0] || !plane[1] || !plane[2] || !to_xyz(from, xyz) || !to_xyz(&rec709, ours) ||
        !invert(ours, back))
        return false;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            m[i][j] = back[i][0] * xyz[0][j] + back[i][1] * xyz[1][j] + back[i][2] * xyz[2][j];
    }
    for (size_t i = 0; i < (size_t)image->width * (size_t)image->height; i++) {
        double rgb[3] = {(double)plane[0][i], (double)plane[1][i], (double)plane[2][i]};
        for (int c = 0; c < 3; c++)
            plane[c][i] = (float)(m[c][0] * rgb[0] + m[c][1] * rgb[1] + m[c][2] * rgb[2]);
    }
    return true;
}
