/* Frames beside updates, by another thread (cache/frame/method.h). */
#ifndef SL_MULTI_MESH_WINDOW_H
#define SL_MULTI_MESH_WINDOW_H

#include "cache/frame/method.h"

/* Copies of the meshes, between the method and a window. */
typedef struct sl_mesh_exchange sl_mesh_exchange;
/* The method or the window is gone. NULL is allowed. */
void sl_mesh_exchange_leave(sl_mesh_exchange *exchange);
/* Returns bytes of the copies. To be asked by the method's thread. NULL: 0. */
size_t sl_mesh_exchange_bytes(const sl_mesh_exchange *exchange);

extern const sl_window_class sl_multi_mesh_window;

#endif
