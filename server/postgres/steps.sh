#!/bin/sh
# The SQL of the schema's steps as strings of C: steps.sh FILE...
set -eu
echo '#include "pg_steps.h"'
echo 'const char *const pg_steps[] = {'
for f in "$@"; do
    sed 's/\\/\\\\/g; s/"/\\"/g; s/^/    "/; s/$/\\n"/' "$f"
    echo '    ,'
done
echo '};'
