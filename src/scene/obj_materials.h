/* The materials of an OBJ file: which libraries its mtllib statements mean, what those have, and which names
 * its usemtl statements want. */
#ifndef SL_SCENE_OBJ_MATERIALS_H
#define SL_SCENE_OBJ_MATERIALS_H

#include "scene/model.h"
#include "scene/text.h"

/* A name, of a library (line 0) or behind a usemtl. */
typedef struct sl_obj_material {
    size_t start, length; /* in the text of all names */
    const char *name;     /* set when that is complete */
    unsigned long line;
} sl_obj_material;

/* Zero but for the first three; release it. */
typedef struct sl_obj_materials {
    const char *path; /* of the OBJ file */
    sl_model *model;
    sl_text *texts;    /* what each library is to be read as, for sl_import_run() */
    sl_text libraries; /* a statement for each that exists, a line each: mtllib and one name */
    sl_text names;
    sl_obj_material *material;
    size_t count, room;
    bool starved;                       /* a name could not be added for want of memory */
    unsigned long readable, unreadable; /* libraries whose names are known, and not */
} sl_obj_materials;

/* What stands behind an mtllib, not empty, without blanks at its ends: one name, which may have blanks in it,
 * or several, if there is no file of that one. A library that does not exist is a warning; where none does,
 * that beside the OBJ file and named like it is taken, if there is one. What is wrong in a library is an
 * input error. */
sl_status sl_obj_materials_read(sl_obj_materials *materials, unsigned long line, const char *names,
                                size_t length, sl_error *error);
/* The name behind a usemtl. */
void sl_obj_materials_use(sl_obj_materials *materials, unsigned long line, const char *name, size_t length);
/* After the last statement: warns of the names that were used and that no library has, if there are libraries
 * and all of them are known. */
sl_status sl_obj_materials_conclude(sl_obj_materials *materials, sl_error *error);
void sl_obj_materials_release(sl_obj_materials *materials);

#endif
