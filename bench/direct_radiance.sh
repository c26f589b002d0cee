#!/bin/sh
# bench/direct_radiance.sh BUILD [--brief|--once] [--docs] [EXPERIMENT ...]: the three experiments on direct radiance mapping, all of them or
# those named: drm_table1, drm_error, drm_animation. --once measures with one thread, and not for so long. See experiments.sh.
exec "$(dirname "$0")/experiments.sh" direct-radiance 'drm_table1 drm_error drm_animation' "$@"
