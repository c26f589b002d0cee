#!/bin/sh
# tests/hard/killed.sh BUILD: commands killed before every call that changes files, and half way through every write (tests/app/test_program_killed.c). Minutes.
set -u
cd "$(dirname "$0")/../.."
SOFTLUX_EVERY_MOMENT=1 OMP_WAIT_POLICY=passive "$1/tests/test_program_killed"
