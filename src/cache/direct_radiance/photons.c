/* Pass 3: regular samples of the direct radiance map, and what they have in common with the other ways to take them. */
#include "cache/direct_radiance/photons.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "cache/direct_radiance/photon_groups.h"

/* A receiver that is as near as that to a photon gets nothing from it: its direction would be noise. */
#define NEAREST_RECEIVER 1e-6

double sl_block_angle(const sl_radiance_map *map, const sl_map_face *face, int column, int row) {
    double angle = 0.0;
    int texels = sl_block_texels(face);
    for (int y = row; y < row + texels; y++) {
        for (int x = column; x < column + texels; x++) angle += (double)map->block_angle[sl_map_texel_index(face, x, y)];
    }
    return angle;
}

/* Photon (i, k) of m x m is the texel at ((i + 1/2) / m, (k + 1/2) / m). With an even number of texels a block that is a texel's corner:
 * the lower left of the four around it is taken. It stands for the whole block, whose solid angle is the texels' together:
 * with the texel's own, the photons would hold m^2 / w^2 of the light. */
void sl_photon_at_point(sl_photon_list *list, const sl_map_face *face, int column, int row, const double *color) {
    int texels = sl_block_texels(face), x = column + (texels - 1) / 2, y = row + (texels - 1) / 2;
    size_t before = list->photons->count;
    sl_map_texel t;
    if (sl_map_texel_read(list->scene, list->map, face, x, y, color, &t)) {
        double own = (double)list->map->block_angle[sl_map_texel_index(face, x, y)];
        const sl_texel_rectangle block = {column, row, column + texels, row + texels};
        sl_photon_sample sample = sl_photon_of_texel(list, &t, sl_block_angle(list->map, face, column, row) / own, block);
        sl_photon_add(list, face, &sample);
    }
    if (list->photons->count == before) list->photons->dropped++;
}

sl_status sl_photons_at_points(sl_photon_list *list, const sl_map_face *face, size_t face_count, sl_error *error) {
    (void)error;
    for (const sl_map_face *f = face; f < face + face_count; f++) {
        for (int k = 0; k < f->rows; k++) {
            for (int i = 0; i < f->columns; i++) sl_photon_at_point(list, f, i * sl_block_texels(f), k * sl_block_texels(f), NULL);
        }
    }
    return SL_OK;
}

static sl_take_photons *way_to_take(const sl_radiance_map_settings *settings) {
    if (settings->filter == SL_MAP_FILTER_POINT) return sl_photons_at_points;
    if (settings->filter == SL_MAP_FILTER_RADIANCE) return sl_photons_of_filtered_radiance;
    return sl_photons_of_groups;
}

/* Faces of one light, from the first on. */
static size_t faces_of_light(const sl_radiance_map *map, size_t first) {
    size_t end = first;
    while (end < map->face_count && map->face[end].light == map->face[first].light) end++;
    return end - first;
}

static size_t count_blocks(const sl_map_face *face, size_t face_count) {
    size_t blocks = 0;
    for (size_t f = 0; f < face_count; f++) blocks += (size_t)face[f].columns * (size_t)face[f].rows;
    return blocks;
}

/* Room for the most that the samples can be: four groups a block. */
static sl_status create(const sl_radiance_map *map, bool quads, size_t room, sl_map_photons **photons, sl_error *error) {
    sl_map_photons *p = sl_allocate(1, sizeof *p);
    if (!p) return sl_fail_memory(error, "sample photons");
    p->photon = sl_allocate(room, sizeof *p->photon);
    if (!map->lambertian) p->lobe = sl_allocate(room, sizeof *p->lobe);
    if (quads) p->quad = sl_allocate(room, sizeof *p->quad);
    if (!p->photon || (!map->lambertian && !p->lobe) || (quads && !p->quad)) {
        sl_map_photons_destroy(p);
        return sl_fail_memory(error, "sample photons");
    }
    p->room = room;
    *photons = p;
    return SL_OK;
}

sl_status sl_map_photons_take(const sl_scene *scene, const sl_radiance_map *map, const sl_radiance_map_settings *settings,
                              sl_map_photons **photons, sl_counters *counters, sl_error *error) {
    bool quads = settings->weight == SL_WEIGHT_POLYGON;
    sl_status status = create(map, quads, SL_PHOTON_GROUPS * count_blocks(map->face, map->face_count), photons, error);
    if (status != SL_OK) return status;
    sl_map_photons *p = *photons;
    p->nearest = (float)(NEAREST_RECEIVER * (double)scene->scale);
    p->box_diagonal = scene->diagonal;

    sl_photon_list list = {.scene = scene, .map = map, .photons = p};
    sl_take_photons *take = way_to_take(settings);
    size_t face = 0;
    for (size_t light = 0; light < SL_MAP_POINTS_MAX && status == SL_OK; light++) {
        p->first_of_light[light] = p->count;
        if (face == map->face_count || map->face[face].light != light) continue; /* no pictures of that light were needed */
        size_t faces = faces_of_light(map, face);
        p->samples_of_light[light] = count_blocks(map->face + face, faces);
        status = take(&list, map->face + face, faces, error);
        face += faces;
    }
    p->first_of_light[SL_MAP_POINTS_MAX] = p->count;
    if (status != SL_OK) {
        sl_map_photons_destroy(p);
        *photons = NULL;
        return status;
    }
    sl_count(counters, SL_COUNT_MAP_PHOTONS, p->count);
    sl_count(counters, SL_COUNT_MAP_PHOTONS_DROPPED, p->dropped);
    return SL_OK;
}

void sl_map_photons_destroy(sl_map_photons *photons) {
    if (!photons) return;
    sl_free(photons->photon);
    sl_free(photons->lobe);
    sl_free(photons->quad);
    sl_free(photons);
}

size_t sl_map_photons_bytes(const sl_map_photons *photons) {
    if (!photons) return 0;
    size_t each = sizeof *photons->photon + (photons->lobe ? sizeof *photons->lobe : 0) + (photons->quad ? sizeof *photons->quad : 0);
    return sizeof *photons + photons->room * each;
}
