#!/bin/sh
# bench/direct_radiance.sh BUILD [--brief|--once] [--docs] [EXPERIMENT ...]: the four experiments on direct radiance mapping, all of them or
# those named: drm_table1, drm_error, drm_flux, drm_animation. --once measures with one thread, and not for so long. See experiments.sh.
exec "$(dirname "$0")/experiments.sh" direct-radiance 'drm_table1 drm_error drm_flux drm_animation' "$@"
