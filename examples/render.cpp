/* Renders a scene by any options: render SCENE OUT.exr [NAME=VALUE ...]
 * c++ render.cpp $(pkg-config --cflags --libs softlux) */
#include "softlux.hpp"

#include <cstdio>

int main(int argc, char **argv) try {
    if (argc < 3)
        return std::fprintf(stderr, "usage: %s SCENE OUT [NAME=VALUE ...]\n", argv[0]), SL_ERROR_USAGE;
    auto scene = softlux::make<softlux::scene>(sl_scene_load, argv[1]);
    auto settings = softlux::make<softlux::settings>(sl_settings_create);
    for (int i = 3; i < argc; i++) {
        const std::string option = argv[i];
        const auto equals = option.find('=');
        const auto value = equals == std::string::npos ? "1" : option.substr(equals + 1);
        softlux::call(sl_settings_set, settings.get(), option.substr(0, equals).c_str(), value.c_str());
    }
    auto method = softlux::make<softlux::method>(sl_method_create, scene.get(), settings.get());
    auto picture = softlux::finish(method, [](const sl_progress &p) {
        std::printf("\r%3.0f %%", 100 * p.fraction);
    });
    std::printf("\n");
    softlux::call(sl_image_write, picture.get(), argv[2]);
} catch (const softlux::error &e) {
    std::fprintf(stderr, "%s\n", e.what());
    return e.status;
}
