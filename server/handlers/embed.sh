#!/bin/sh
# Writes C that holds the given JSON files as string constants, by base name.
# usage: embed.sh FILE ... > embedded.c
printf '/* Made by server/handlers/embed.sh. */\n#include "embed.h"\n\n'
n=0
for f in "$@"; do
    printf 'static const char file_%d[] =\n' "$n"
    sed -e 's/\\/\\\\/g' -e 's/"/\\"/g' -e 's/\t/\\t/g' -e 's/^/    "/' -e 's/$/\\n"/' "$f"
    printf '    "";\n\n'
    n=$((n + 1))
done
printf 'const struct embedded embedded_files[] = {\n'
n=0
for f in "$@"; do
    b=${f##*/}
    printf '    { "%s", file_%d, sizeof file_%d - 1 },\n' "${b%.json}" "$n" "$n"
    n=$((n + 1))
done
printf '    { 0, 0, 0 }\n};\n'
