#!/bin/sh
# Writes C that holds the given files, by base name, as they are and as gzip packs them (without times: the same bytes at each build).
# usage: page.sh FILE ... > page_files.c
set -eu
bytes() {
    od -An -v -tu1 | sed -e 's/  */,/g' -e 's/^,//' -e 's/$/,/'
}
printf '/* Made by server/handlers/page.sh. */\n#include "page_files.h"\n\n'
n=0
for f in "$@"; do
    printf 'static const unsigned char text_%d[] = {\n' "$n"
    bytes < "$f"
    printf '};\nstatic const unsigned char packed_%d[] = {\n' "$n"
    gzip -9nc "$f" | bytes
    printf '};\n'
    n=$((n + 1))
done
printf 'const struct page_file page_files[] = {\n'
n=0
for f in "$@"; do
    printf '    { "%s", text_%d, sizeof text_%d, packed_%d, sizeof packed_%d },\n' "${f##*/}" "$n" "$n" "$n" "$n"
    n=$((n + 1))
done
printf '    { 0, 0, 0, 0, 0 }\n};\n'
