#!/bin/sh
# bench/splatting.sh BUILD [--brief|--once] [--docs] [EXPERIMENT ...]: the experiments on radiance cache splatting, all of them or those
# named: table1, table2, glossy, walk, curve. --once measures each thing once, with one thread. See experiments.sh.
exec "$(dirname "$0")/experiments.sh" splatting 'table1 table2 glossy walk curve' "$@"
