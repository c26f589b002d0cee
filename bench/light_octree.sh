#!/bin/sh
# bench/light_octree.sh BUILD [--brief|--once] [--docs] [EXPERIMENT ...]: the four experiments on the light octree, all of them or those named:
# octree_time, octree_frames, octree_error, octree_curve. --once measures each thing once. See experiments.sh.
exec "$(dirname "$0")/experiments.sh" light-octree 'octree_time octree_frames octree_error octree_curve' "$@"
