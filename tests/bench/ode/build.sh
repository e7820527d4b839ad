#!/bin/bash
# Builds the integrators' benchmark: build.sh BUILD_DIR OUT_DIR. SUNDIALS is installed for it alone.
set -eu
cd "$(dirname "$0")/../../.."
build=$1
out=$2
if ! dpkg-query -W -f '${db:Status-Status}' libsundials-dev 2>/dev/null | grep -qx installed; then
    [ "$(id -u)" -eq 0 ] || { echo "bench: as root: apt-get install --no-install-recommends libsundials-dev" >&2; exit 1; }
    DEBIAN_FRONTEND=noninteractive apt-get -qq -o Acquire::Retries=3 install -y --no-install-recommends libsundials-dev >&2
fi
mkdir -p "$out"
/usr/bin/python3 tests/bench/ode/cases.py "$build" "$out"
flags="-std=gnu11 -O2 -g -Wall -Wextra -Werror"
cc=${CC:-gcc}
$cc $flags -Wno-unused-variable -iquote tests/bench/ode -c "$out/fields.c" -o "$out/fields.o"
$cc $flags -iquote tests/bench/ode -c tests/bench/ode/gsl.c -o "$out/gsl.o"
$cc $flags -iquote tests/bench/ode -c tests/bench/ode/sundials.c -o "$out/sundials.o"
inner=""
for floor in traj traj/flow traj/field traj/manifold traj/problem ode sga points lin num poly request form sys expr base; do inner="$inner -iquote lib/$floor"; done
$cc $flags -iquote tests/bench/ode $inner -c tests/bench/ode/main.c -o "$out/main.o"
$cc -o "$out/ode" "$out/main.o" "$out/fields.o" "$out/gsl.o" "$out/sundials.o" "$build/libsga.a" \
    -lsundials_cvode -lsundials_arkode -lsundials_ida -lsundials_nvecserial -lsundials_sunmatrixdense -lsundials_sunlinsoldense \
    -lsundials_sunnonlinsolfixedpoint -lflint-arb -lflint -lmpfr -lgmp -lklu -lldl -lamd -lcolamd -lbtf \
    -lsuitesparseconfig -lgsl -lgslcblas -ljansson -lm
