# Packages of what is built (docs/adr/0030-packages.md). Sourced by ./terravox.
# shellcheck shell=bash

# 0.1.0
version_number() { version | cut -d ' ' -f 2; }

# The time of all files in packages: SOURCE_DATE_EPOCH, or that of the last commit.
package_epoch() {
    [[ -n ${SOURCE_DATE_EPOCH:-} ]] && printf '%s\n' "$SOURCE_DATE_EPOCH" && return
    git -C "$ROOT" log -1 --format=%ct 2>/dev/null ||
        die "make a package: no commit to take the date of; set SOURCE_DATE_EPOCH"
}

package_help() {
    cat <<'TEXT'
Makes packages of this checkout.

Usage: terravox package deb|image|sdist|wheel -o FOLDER

  deb              Debian packages of the programs, the library and the Python package, for the
                   Debian or Ubuntu of this machine; prints their names
  image            an image for containers (OCI) of the programs, made without a daemon, as root or
                   in a user namespace; prints its name
  sdist            the sources of the Python package, which pip builds a wheel of; prints its name
  wheel            the Python package, for each Python from 3.11 to 3.13 that is here (takes half an
                   hour: GDAL, PROJ and curl are compiled once, and most of Terravox)
  -o FOLDER        where they are written; made when missing

The same commit makes the same bytes: times are those of the commit, or SOURCE_DATE_EPOCH.
TEXT
}

# Brings up to date what packages are made of.
build_packaged() {
    if [[ ${TERRAVOX_NO_BUILD:-0} != 1 ]]; then
        set_up
        build release terravox_packaged
    fi
}

# package deb|image|sdist|wheel -o FOLDER
package() {
    case ${1:-} in
        -h | --help) package_help && return ;;
        deb | image | sdist | wheel) ;;
        *) usage_error "package: '${1:-}'; allowed: deb, image, sdist, wheel" ;;
    esac
    [[ ${2:-} == -o && -n ${3:-} ]] || usage_error "package $1: -o FOLDER is missing"
    (($# == 3)) || usage_error "package $1: unknown argument '$4'"
    local folder
    mkdir -p "$3"
    folder=$(cd "$3" && pwd)
    SOURCE_DATE_EPOCH=$(package_epoch)
    export SOURCE_DATE_EPOCH
    case $1 in
        deb)
            build_packaged
            package_deb "$folder"
            ;;
        image)
            build_packaged
            package_image "$folder"
            ;;
        sdist) package_sdist "$folder" ;;
        wheel)
            set_up
            package_wheel "$folder"
            ;;
    esac
}
