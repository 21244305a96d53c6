# Sources of LASzip, into build/deps/laszip (config/cmake/LASzip.cmake has the reasons).
# Sourced by ./terravox.
# shellcheck shell=bash

LASZIP_VERSION=0.3.0  # of the Python package that carries the sources
LASZIP_SHA256=9ddf91649b519db308f63d772a19e7647458f5d5512e3d927629f0196b9c6216

install_laszip() {
    local target=$ROOT/build/deps/laszip archive part
    [[ -f $target/src/laszip_dll.cpp ]] && return
    say "Fetching LASzip"
    mkdir -p "$ROOT/build/deps"
    archive=$(fetch_from_pypi "laszip-$LASZIP_VERSION.tar.gz" "$LASZIP_SHA256" \
        --no-binary laszip "laszip==$LASZIP_VERSION")
    # Unpacked next to its place and renamed: a folder of that name is always complete.
    part=$(mktemp -d "$ROOT/build/deps/laszip.XXXXXX")
    tar --extract --file "$archive" --directory "$part" \
        --strip-components 4 --wildcards "laszip-$LASZIP_VERSION/src/vendor/LASzip-*/"
    [[ -f $part/src/laszip_dll.cpp && -f $part/dll/laszip_api.h ]] ||
        die "unpack LASzip: $archive does not hold its sources"
    rm -rf "$target"
    mv "$part" "$target"
}
