/* Files of the first rank, for all. */
#include <dirent.h>
#include <mpi.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/ranks.h"
#include "mpi/end.h"

enum { NAME = 256, PIECE = 1 << 28 };

/* A file that is on its way; without a name there are no more. */
typedef struct parcel {
    char name[NAME];
    uint64_t size;
} parcel;

static void must(bool done) {
    if (!done) sl_ranks_end(sl_ranks_here().rank, "cannot read or write the scene's files");
}

static FILE *open_in(const char *folder, const char *name, const char *how) {
    char path[8192];
    must(snprintf(path, sizeof path, "%s/%s", folder, name) < (int)sizeof path);
    FILE *file = fopen(path, how);
    must(file);
    return file;
}

static void share(const char *folder, const parcel *p) {
    const bool gives = sl_ranks_here().rank == 0;
    FILE *file = open_in(folder, p->name, gives ? "rb" : "wb");
    char *bytes = malloc(PIECE);
    must(bytes);
    for (uint64_t at = 0; at < p->size; at += PIECE) {
        const size_t some = p->size - at < PIECE ? (size_t)(p->size - at) : PIECE;
        if (gives) must(fread(bytes, 1, some, file) == some);
        MPI_Bcast(bytes, (int)some, MPI_BYTE, 0, MPI_COMM_WORLD);
        if (!gives) must(fwrite(bytes, 1, some, file) == some);
    }
    free(bytes);
    must(fclose(file) == 0);
}

/* Fills in the next file of a folder; at its end no name. */
static void next_of(const char *folder, DIR *list, parcel *p) {
    *p = (parcel){.size = 0};
    for (struct dirent *e; (e = readdir(list)) != NULL;) {
        if (e->d_name[0] == '.') continue;
        FILE *file = open_in(folder, e->d_name, "rb");
        must(strlen(e->d_name) < NAME && fseek(file, 0, SEEK_END) == 0);
        memcpy(p->name, e->d_name, strlen(e->d_name));
        p->size = (uint64_t)ftell(file);
        fclose(file);
        return;
    }
}

bool sl_ranks_share_files(const char *folder, bool some) {
    const bool gives = sl_ranks_here().rank == 0;
    DIR *list = gives && some ? opendir(folder) : NULL;
    size_t count = 0;
    for (parcel p = {.size = 0};; count++) {
        if (list) next_of(folder, list, &p);
        MPI_Bcast(&p, sizeof p, MPI_BYTE, 0, MPI_COMM_WORLD);
        if (!p.name[0]) break;
        share(folder, &p);
    }
    if (list) closedir(list);
    return count > 0;
}
