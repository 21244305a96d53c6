# Debian packages (docs/adr/0030-packages.md). Sourced by ./terravox.
# shellcheck shell=bash

DEBIAN_DIR=$ROOT/config/debian
# Whose results are packed: `./terravox package deb --arm64` sets it to arm64.
PACKAGE_PRESET=release

# Who answers for a package: DEBFULLNAME and DEBEMAIL, as Debian's tools read them, else the author
# of the last commit.
package_maintainer() {
    if [[ -n ${DEBEMAIL:-} ]]; then
        printf '%s <%s>\n' "${DEBFULLNAME:-Terravox}" "$DEBEMAIL"
    else
        git -C "$ROOT" log -1 --format='%an <%ae>' 2>/dev/null ||
            die "make a package: no commit to take the maintainer of; set DEBEMAIL"
    fi
}

# The two numbers that programs which link the library ask for, as in the name of its package.
library_soversion() { version_number | cut -d . -f 1-2; }

# All packages, those that others depend on first.
debian_packages() {
    printf '%s\n' terravox-data terravox
    [[ ! -x $ROOT/build/$PACKAGE_PRESET/bin/terravox-preview ]] || printf '%s\n' terravox-preview
    printf '%s\n' "libterravox$(library_soversion)" libterravox-dev
    [[ ! -d $ROOT/build/$PACKAGE_PRESET/python ]] || printf '%s\n' python3-terravox
}

# install_components FOLDER COMPONENT...: as they lie below / of a Debian system
install_components() {
    local folder=$1 component
    shift
    for component in "$@"; do
        quietly "$LOGS/package-install.log" env "DESTDIR=$folder" \
            cmake --install "$ROOT/build/$PACKAGE_PRESET" --prefix /usr \
            --component "$component" --strip
    done
}

# The programs with units and settings. The manual is made of all programs, so the window is there
# while it is made, and leaves for the package terravox-preview.
stage_terravox() {
    local stage=$1/terravox preview=$1/terravox-preview
    local units=$stage/usr/lib/systemd/system man=usr/share/man/man1
    install_components "$stage" preview programs
    if [[ -x $stage/usr/lib/terravox/terravox-preview ]]; then
        install -d "$preview/usr/lib/terravox" "$preview/$man"
        mv "$stage/usr/lib/terravox/terravox-preview" "$preview/usr/lib/terravox"
        mv "$stage/$man/terravox-preview.1" "$preview/$man"
    fi
    find "$stage/usr/lib/terravox/grabber" -type f -exec chmod 644 {} +
    install -d "$units" "$stage/etc/terravox"
    install -m 644 "$ROOT"/config/systemd/*.service "$units"
    install -m 644 "$ROOT/config/worker.toml" "$DEBIAN_DIR/serve.env" "$stage/etc/terravox"
}

# stage_packages FOLDER: the files of each package, in a folder of its name
stage_packages() {
    local folder=$1 package doc=$1/terravox-data/usr/share/doc
    stage_terravox "$folder"
    install_components "$folder/terravox-data" data
    # The file `copyright` of each package names it.
    rm "$doc/terravox/LICENSE"
    mv "$doc/terravox" "$doc/terravox-data"
    install_components "$folder/libterravox$(library_soversion)" library
    install_components "$folder/libterravox-dev" development
    install_components "$folder/python3-terravox" python
    while read -r package; do
        stage_documents "$folder" "$package"
    done < <(debian_packages)
}

# stage_documents FOLDER PACKAGE: what Debian asks each package for, and compresses
stage_documents() {
    local package=$2 doc=$1/$2/usr/share/doc/$2
    install -d "$doc"
    cat "$DEBIAN_DIR/copyright" >"$doc/copyright"
    [[ ! -f $DEBIAN_DIR/$package.copyright ]] ||
        cat "$DEBIAN_DIR/$package.copyright" >>"$doc/copyright"
    gzip -9n <"$1/debian/changelog" >"$doc/changelog.gz"
    # Pages of the documents stay as they are: they lead to each other.
    find "$1/$package/usr/share" '(' -path '*/man/*' -o -name CHANGELOG.md -o \
        -name THIRD_PARTY.md ')' -type f -exec gzip -9n {} +
}

# write_sources FOLDER: what Debian's tools read of a source package
write_sources() {
    local maintainer
    maintainer=$(package_maintainer)
    mkdir "$1/debian"
    sed "s/@SOVERSION@/$(library_soversion)/" "$DEBIAN_DIR/control" |
        awk -v who="$maintainer" '/^Maintainer:/ { $0 = "Maintainer: " who } { print }' \
            >"$1/debian/control"
    {
        printf 'terravox (%s) unstable; urgency=medium\n\n' "$(version_number)"
        printf '  * See CHANGELOG.md.gz of the package terravox.\n\n'
        printf ' -- %s  %s\n' "$maintainer" \
            "$(date --utc --rfc-email --date "@$SOURCE_DATE_EPOCH")"
    } >"$1/debian/changelog"
}

# library_dependencies FOLDER PACKAGE: what its programs and modules are linked with, as variables
# for the control file. The compiled part of the grabber needs fewer libraries, and finds those of
# Node.js in Node.js.
library_dependencies() {
    local objects options=()
    if [[ $PACKAGE_PRESET == arm64 ]]; then
        options=("--admindir=$ARM64_ROOT/var/lib/dpkg" "-l$ARM64_ROOT/usr/lib/aarch64-linux-gnu")
    fi
    mapfile -t objects < <(find "$1/$2/usr/lib" -type f ! -path '*/grabber/*' \
        '(' -name '*.so' -o -name '*.so.*' -o -perm -u+x ')')
    ((${#objects[@]} > 0)) || return 0
    # It warns that the programs are not installed.
    (
        cd "$1" &&
            dpkg-shlibdeps "${options[@]}" -O "${objects[@]}" 2>>"$LOGS/package-shlibdeps.log"
    ) |
        grep '^shlibs:Depends=.' ||
        die "make a package: dpkg-shlibdeps found no libraries of $2;" \
            "see $LOGS/package-shlibdeps.log"
}

# The version of Python whose modules a staged package has: 3.11
module_python() {
    find "$1" -name '_core.cpython-*.so' -printf '%f\n' |
        sed -nE 's/^_core\.cpython-3([0-9]+)-.*/3.\1/p'
}

# write_variables FOLDER PACKAGE
write_variables() {
    local python
    if [[ -d $1/$2/usr/lib ]]; then
        library_dependencies "$1" "$2"
    fi
    if [[ $2 == python3-terravox ]]; then
        python=$(module_python "$1/$2")
        printf 'python3:Depends=python3 (>= %s), python3 (<< 3.%d), %s\n' \
            "$python" "$((${python#3.} + 1))" 'python3-numpy, python3-xarray'
    fi
}

# write_control FOLDER PACKAGE: the part of a package that describes it
write_control() {
    local stage=$1/$2 control=$1/$2/DEBIAN file
    install -d "$control"
    write_variables "$1" "$2" >"$1/debian/$2.substvars"
    (
        cd "$1" &&
            dpkg-gencontrol "-p$2" "-P$stage" "-Tdebian/$2.substvars" "-O$control/control" \
                -fdebian/files
    )
    for file in postinst prerm postrm; do
        [[ ! -f $DEBIAN_DIR/$2.$file ]] || install -m 755 "$DEBIAN_DIR/$2.$file" "$control/$file"
    done
    if [[ $2 == libterravox[0-9]* ]]; then
        install -m 644 "$DEBIAN_DIR/libterravox.triggers" "$control/triggers"
        printf 'libterravox %s %s (>= %s)\n' "$(library_soversion)" "$2" "$(version_number)" \
            >"$control/shlibs"
    fi
    if [[ -d $stage/etc ]]; then
        (cd "$stage" && find etc -type f -printf '/%p\n' | sort >DEBIAN/conffiles)
    fi
    (
        cd "$stage" &&
            find . -path ./DEBIAN -prune -o -path ./etc -prune -o -type f -printf '%P\0' |
            sort -z | xargs -0 md5sum >DEBIAN/md5sums
    )
}

# make_deb STAGES PACKAGE FOLDER: prints the name of the file
make_deb() {
    local architecture file
    write_control "$1" "$2"
    architecture=$(sed -n 's/^Architecture: //p' "$1/$2/DEBIAN/control")
    file=$3/$2_$(version_number)_$architecture.deb
    chmod -R u=rwX,go=rX "$1/$2"
    quietly "$LOGS/package-deb.log" dpkg-deb --root-owner-group -Zxz --build "$1/$2" "$file"
    printf '%s\n' "$file"
}

# make_debs FOLDER [PACKAGE...]: all, unless some are named
make_debs() {
    local folder=$1 package stages
    shift
    (($# > 0)) || mapfile -t < <(debian_packages)
    (($# > 0)) || set -- "${MAPFILE[@]}"
    # In a shell of its own, whose end removes the folder however it comes.
    (
        umask 022
        [[ $PACKAGE_PRESET != arm64 ]] || export DEB_HOST_ARCH=arm64
        stages=$(mktemp -d)
        trap 'rm -rf "$stages"' EXIT
        write_sources "$stages"
        stage_packages "$stages"
        : >"$LOGS/package-shlibdeps.log"
        for package in "$@"; do
            make_deb "$stages" "$package" "$folder"
        done
    )
}

# package_deb FOLDER: prints the names of the files
package_deb() {
    require_deb_tools
    make_debs "$1"
}

require_deb_tools() {
    command -v dpkg-shlibdeps >/dev/null ||
        die "make packages: dpkg-shlibdeps is not installed (Debian package dpkg-dev)"
}
