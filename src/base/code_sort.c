/* Radix sort from the highest byte down, in place (McIlroy, Bostic, McIlroy 1993, "Engineering Radix Sort":
 * the American flag): each thing is carried to its byte's pile, and what it displaces is carried on, until
 * the circle is closed. */
#include "base/code_sort.h"

#include <stdbool.h>

enum { PILES = 256, FEW = 48, CODE_BYTES = 8, BYTES = CODE_BYTES + 4 };

/* The byte of that rank: the code's, highest first, then the item's. */
static unsigned byte_of(const sl_coded *c, int rank) {
    if (rank < CODE_BYTES) return (unsigned)(c->code >> (56 - 8 * rank)) & 255u;
    return c->item >> (24 - 8 * (rank - CODE_BYTES)) & 255u;
}

static bool precedes(const sl_coded *a, const sl_coded *b) {
    return a->code != b->code ? a->code < b->code : a->item < b->item;
}

static void insert_each(sl_coded *list, size_t count) {
    for (size_t i = 1; i < count; i++) {
        const sl_coded one = list[i];
        size_t at = i;
        for (; at > 0 && precedes(&one, &list[at - 1]); at--) list[at] = list[at - 1];
        list[at] = one;
    }
}

/* Carries each thing to its pile; next: the first place of each pile that is not filled yet. */
static void fill_piles(sl_coded *list, int rank, size_t next[PILES], const size_t end[PILES]) {
    for (unsigned pile = 0; pile < PILES; pile++) {
        while (next[pile] < end[pile]) {
            sl_coded one = list[next[pile]];
            for (unsigned to; (to = byte_of(&one, rank)) != pile;) {
                const sl_coded displaced = list[next[to]];
                list[next[to]++] = one;
                one = displaced;
            }
            list[next[pile]++] = one;
        }
    }
}

static void sort_from(sl_coded *list, size_t count, int rank);

static void sort_by_piles(sl_coded *list, size_t count, int rank) {
    size_t next[PILES] = {0}, end[PILES], at = 0;
    for (size_t i = 0; i < count; i++) next[byte_of(&list[i], rank)]++;
    for (int pile = 0; pile < PILES; pile++) {
        const size_t size = next[pile];
        next[pile] = at;
        end[pile] = at += size;
    }
    fill_piles(list, rank, next, end);
    for (int pile = 0; pile < PILES; pile++) {
        const size_t first = pile ? end[pile - 1] : 0;
        if (end[pile] - first > 1) sort_from(list + first, end[pile] - first, rank + 1);
    }
}

static void sort_from(sl_coded *list, size_t count, int rank) {
    if (count <= FEW || rank == BYTES) insert_each(list, count);
    else sort_by_piles(list, count, rank);
}

void sl_sort_coded(sl_coded *list, size_t count) { sort_from(list, count, 0); }
