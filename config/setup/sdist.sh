# The source archive of the Python package. Sourced by ./terravox.
# shellcheck shell=bash

# package_sdist FOLDER: prints the name of the file
package_sdist() {
    local file
    file=$1/terravox-$(version_number).tar.gz
    install_laszip
    python3 -B "$ROOT/config/release/sdist.py" "$ROOT" -o "$file" \
        --version "$(version_number)" --time "$SOURCE_DATE_EPOCH"
    printf '%s\n' "$file"
}
