#!/bin/sh
# Writes C that holds the version: the product's, and a digest of the sources that answers come from, so that no answer of other
# sources is given for one of these.
# usage: version.sh VERSION FILE ... > version.c
version=$1
shift
printf '/* Made by lib/run/version.sh. */\n#include "sga.h"\n\nconst char *sga_version(void)\n{\n    return "%s+%s";\n}\n' \
    "$version" "$(cat "$@" | sha256sum | cut -c 1-12)"
