/* Value noise and a hash, both exact on every machine. */
#include <math.h>

#include "mesh.h"

static uint32_t mix(uint32_t h) { /* a bijection of 32 bits with good avalanche */
    h ^= h >> 16;
    h *= 0x7feb352du;
    h ^= h >> 15;
    h *= 0x846ca68bu;
    return h ^ (h >> 16);
}

static uint32_t hash(uint32_t seed, uint32_t a, uint32_t b, uint32_t c) {
    return mix(mix(mix(mix(seed + 0x9e3779b9u) + a) + b) + c);
}

double gen_random(uint32_t seed, uint32_t a, uint32_t b) { return hash(seed, a, b, 0) / 4294967296.0; }

static double lattice(uint32_t seed, int32_t x, int32_t y, int32_t z) {
    return hash(seed, (uint32_t)x, (uint32_t)y, (uint32_t)z) / 2147483648.0 - 1.0;
}

static double fade(double t) { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); }

double gen_noise(v3 p, uint32_t seed) {
    double fx = floor(p.x), fy = floor(p.y), fz = floor(p.z);
    int32_t x = (int32_t)fx, y = (int32_t)fy, z = (int32_t)fz;
    double u = fade(p.x - fx), v = fade(p.y - fy), w = fade(p.z - fz);
    double plane[2];
    for (int k = 0; k < 2; k++) {
        double low = gen_mix(lattice(seed, x, y, z + k), lattice(seed, x + 1, y, z + k), u);
        double high = gen_mix(lattice(seed, x, y + 1, z + k), lattice(seed, x + 1, y + 1, z + k), u);
        plane[k] = gen_mix(low, high, v);
    }
    return gen_mix(plane[0], plane[1], w);
}

double gen_fractal(v3 p, int octaves, uint32_t seed) {
    double sum = 0.0, amplitude = 1.0;
    for (int i = 0; i < octaves; i++) {
        sum += amplitude * gen_noise(p, seed + (uint32_t)i);
        p = gen_add(gen_scale(p, 2.03), gen_v3(17.3, 5.1, 9.7));
        amplitude *= 0.5;
    }
    return sum;
}
