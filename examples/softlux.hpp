/* softlux in C++11: what is made destroys itself, what fails throws. render.cpp shows its use. */
#ifndef SOFTLUX_HPP
#define SOFTLUX_HPP

#include <softlux.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

namespace softlux {

struct error : std::runtime_error {
    explicit error(const sl_error &e) : std::runtime_error(e.message), status(e.status) {}
    sl_status status;
};

/* Calls a function of the library whose last parameter is an sl_error. */
template <class... P, class... A> void call(sl_status (*function)(P...), A... arguments) {
    sl_error why;
    if (function(arguments..., &why) != SL_OK) throw error(why);
}

template <class T, void (*destroy)(T *)> struct destroyer {
    void operator()(T *t) const { destroy(t); }
};
template <class T, void (*destroy)(T *)> using handle = std::unique_ptr<T, destroyer<T, destroy>>;

using scene = handle<sl_scene, sl_scene_destroy>;
using settings = handle<sl_settings, sl_settings_destroy>;
using method = handle<sl_method, sl_method_destroy>; /* to be destroyed before its scene */
using image = handle<sl_image, sl_image_destroy>;

/* Calls one that makes something: make<scene>(sl_scene_load, "scenes/cornell.json"). */
template <class H, class... P, class... A> H make(sl_status (*function)(P...), A... arguments) {
    typename H::pointer made = nullptr;
    call(function, arguments..., &made);
    return H(made);
}

/* Updates until nothing is left to refine, telling how far that is, and returns the picture. */
template <class F> image finish(const method &m, F told) {
    sl_progress progress = {};
    for (; !progress.done; told(progress)) call(sl_method_update, m.get(), &progress);
    return make<image>(sl_method_resolve, m.get());
}

} // namespace softlux

#endif
