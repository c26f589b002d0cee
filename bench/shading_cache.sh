#!/bin/sh
# bench/shading_cache.sh BUILD [--brief|--once] [--docs] [EXPERIMENT ...]: the four experiments on the shading cache, all of them or those named:
# shading_tables, shading_equal, shading_moving, shading_parts. See experiments.sh.
exec "$(dirname "$0")/experiments.sh" shading-cache 'shading_tables shading_equal shading_moving shading_parts' "$@"
