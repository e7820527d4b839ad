#!/bin/bash
# Builds and runs ode.c: tests/bench/ode.sh BUILD_DIR
set -eu
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/bench/ode.sh BUILD_DIR}
mkdir -p "$build/bench"
libs="-lflint-arb -lflint -lmpfr -lgmp -lklu -lamd -lcolamd -lbtf -lsuitesparseconfig -lgsl -lgslcblas -lm"
${CC:-gcc} -std=gnu11 -O2 -g -Wall -Wextra -Werror -iquote tests/unit -iquote lib/ode -iquote lib/lin -iquote lib/base \
    -o "$build/bench/ode" tests/bench/ode.c "$build/libsga.a" $libs
exec "$build/bench/ode"
