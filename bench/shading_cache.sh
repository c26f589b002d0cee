#!/bin/sh
# bench/shading_cache.sh BUILD [--brief|--once] [--docs] [EXPERIMENT ...]: the experiments on the shading cache, all of them or those named:
# shading_tables, shading_live, shading_equal, shading_moving, shading_caustic,
# shading_parts. See experiments.sh.
exec "$(dirname "$0")/experiments.sh" shading-cache 'shading_tables shading_live shading_equal shading_moving shading_caustic shading_parts' "$@"
