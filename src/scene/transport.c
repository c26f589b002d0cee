#include "scene/transport.h"

#include <string.h>

enum { DIFFUSE_AND_GLOSSY = SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY };

bool sl_transport_named(const char *name, sl_transport *transport) {
    /* Common to all three: lights are seen, the sky is one of them, mirrors are followed, every leg may be
     * blocked. */
    sl_transport result = {.emission = true,
                           .sky_light = true,
                           .eye_mirrors = true,
                           .direct_lobes = DIFFUSE_AND_GLOSSY,
                           .direct_visibility = true,
                           .bounce_visibility = true,
                           .filter = SL_FILTER_BOX};
    if (!name) return false;
    if (strcmp(name, "one-bounce") == 0) {
        result.receiver_lobes = DIFFUSE_AND_GLOSSY;
        result.bounce_lobes = SL_LOBE_DIFFUSE;
        result.bounces = 1;
    } else if (strcmp(name, "full") == 0) {
        result.receiver_lobes = DIFFUSE_AND_GLOSSY;
        result.bounce_lobes = SL_LOBE_ALL;
        result.bounces = SL_BOUNCES_UNLIMITED;
    } else if (strcmp(name, "direct") != 0) {
        return false;
    }
    *transport = result;
    return true;
}
