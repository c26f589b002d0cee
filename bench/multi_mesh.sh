#!/bin/sh
# bench/multi_mesh.sh BUILD [--brief|--once] [--docs] [EXPERIMENT ...]: the four experiments on multi-mesh caching, all of them or those named:
# light_sample, mesh_room, mesh_joint, mesh_curve. --once measures each thing once. See experiments.sh.
exec "$(dirname "$0")/experiments.sh" multi-mesh 'light_sample mesh_room mesh_joint mesh_curve' "$@"
