# Packages of what is built (docs/adr/0030-packages.md). Sourced by ./terravox.
# shellcheck shell=bash

# 0.1.0
version_number() { version | cut -d ' ' -f 2; }

# The time of all files in packages: SOURCE_DATE_EPOCH, or that of the last commit.
package_epoch() {
    [[ -n ${SOURCE_DATE_EPOCH:-} ]] && printf '%s\n' "$SOURCE_DATE_EPOCH" && return
    git -C "$ROOT" log -1 --format=%ct 2>/dev/null ||
        die "make a package: no commit to take the date of, or no git; set SOURCE_DATE_EPOCH"
}

package_help() {
    cat <<'TEXT'
Makes packages of this checkout.

Usage: terravox package deb|image|sdist|wheel [--arm64] -o FOLDER

  deb              Debian packages of the programs, the library and the Python package, for the
                   Debian or Ubuntu of this machine; prints their names
  image            an image for containers (OCI) of the programs, made without a daemon, as root or
                   in a user namespace; prints its name
  sdist            the sources of the Python package, which pip builds a wheel of; prints its name
  wheel            the Python package: a wheel for Python 3.11 if that is here, and one for all
                   versions from 3.12 on if any of 3.12 to 3.14 is (takes half an hour: GDAL, PROJ
                   and curl are compiled once, and most of Terravox)
  --arm64          of deb: for 64-bit ARM, compiled on this machine against the libraries of its
                   Debian
  -o FOLDER        where they are written; made when missing

The same commit makes the same bytes: times are those of the commit, or SOURCE_DATE_EPOCH.
TEXT
}

# Brings up to date what packages are made of.
build_packaged() {
    if [[ $PACKAGE_PRESET == arm64 ]]; then
        build_arm64_packaged
    else
        build release terravox_packaged
    fi
}

# read_package_arguments KIND ARGUMENT...: into FOLDER, PACKAGE_PRESET
read_package_arguments() {
    local kind=$1
    shift
    while (($# > 0)); do
        case $1 in
            -o)
                FOLDER=${2:-}
                shift
                ;;
            --arm64)
                [[ $kind == deb ]] || usage_error "package $kind: --arm64 is of deb alone"
                PACKAGE_PRESET=arm64
                ;;
            *) usage_error "package $kind: unknown argument '$1'" ;;
        esac
        shift || usage_error "package $kind: -o FOLDER is missing"
    done
    [[ -n $FOLDER ]] || usage_error "package $kind: -o FOLDER is missing"
}

# package deb|image|sdist|wheel [--arm64] -o FOLDER
package() {
    local kind=${1:-} FOLDER=''
    case $kind in
        -h | --help) package_help && return ;;
        deb | image | sdist | wheel) ;;
        *) usage_error "package: '$kind'; allowed: deb, image, sdist, wheel" ;;
    esac
    read_package_arguments "$@"
    mkdir -p "$FOLDER"
    FOLDER=$(cd "$FOLDER" && pwd)
    # Before git is asked for a date, since it may be among the packages.
    [[ $kind == sdist || ${TERRAVOX_NO_BUILD:-0} == 1 ]] || set_up
    SOURCE_DATE_EPOCH=$(package_epoch)
    export SOURCE_DATE_EPOCH
    if [[ $kind == deb || $kind == image ]] && [[ ${TERRAVOX_NO_BUILD:-0} != 1 ]]; then
        build_packaged
    fi
    "package_$kind" "$FOLDER"
}
