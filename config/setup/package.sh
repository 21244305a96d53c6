# Packages of what is built (docs/adr/0030-packages.md). Sourced by ./terravox.
# shellcheck shell=bash

DEBIAN_DIR=$ROOT/config/debian

# The time of all files in packages: SOURCE_DATE_EPOCH, or that of the last commit.
package_epoch() {
    [[ -n ${SOURCE_DATE_EPOCH:-} ]] && printf '%s\n' "$SOURCE_DATE_EPOCH" && return
    git -C "$ROOT" log -1 --format=%ct 2>/dev/null ||
        die "make a package: no commit to take the date of; set SOURCE_DATE_EPOCH"
}

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

# stage_programs FOLDER: the programs as they lie below / of a Debian system.
stage_programs() {
    local doc=$1/usr/share/doc/terravox units=$1/lib/systemd/system
    DESTDIR=$1 cmake --install "$ROOT/build/release" --prefix /usr --component programs --strip
    # The file `copyright` names it.
    rm "$doc/LICENSE"
    install -m 644 "$DEBIAN_DIR/copyright" "$doc/copyright"
    debian_changelog | gzip -9n >"$doc/changelog.gz"
    gzip -9n "$doc/CHANGELOG.md" "$1"/usr/share/man/man1/*.1
    find "$1/usr/lib/terravox/grabber" -type f -exec chmod 644 {} +
    install -d "$units" "$1/etc/terravox"
    install -m 644 "$ROOT"/config/systemd/*.service "$units"
    install -m 644 "$ROOT/config/worker.toml" "$DEBIAN_DIR/serve.env" "$1/etc/terravox"
}

debian_changelog() {
    printf 'terravox (%s) unstable; urgency=medium\n\n' "$(version | cut -d ' ' -f 2)"
    printf '  * See CHANGELOG.md.gz.\n\n'
    printf ' -- %s  %s\n' "$(package_maintainer)" \
        "$(date --utc --rfc-email --date "@$SOURCE_DATE_EPOCH")"
}

# library_packages FOLDER: what the programs and modules in a staged folder are linked with. The
# compiled part of the grabber needs fewer libraries, and finds those of Node.js in Node.js.
library_packages() {
    local work objects
    work=$(mktemp -d)
    mkdir "$work/debian"
    printf 'Source: terravox\n\nPackage: terravox\nArchitecture: any\n' >"$work/debian/control"
    mapfile -t objects < <(find "$1/usr/lib/terravox" -maxdepth 1 -type f)
    # It warns that the programs are not installed.
    (cd "$work" && dpkg-shlibdeps -O "${objects[@]}" 2>"$LOGS/package-shlibdeps.log") |
        sed -n 's/^shlibs:Depends=//p'
    rm -rf "$work"
}

# write_control FOLDER
write_control() {
    local depends size file text
    depends=$(library_packages "$1")
    [[ -n $depends ]] ||
        die "make a package: dpkg-shlibdeps found no libraries; see $LOGS/package-shlibdeps.log"
    size=$(du -k --apparent-size -s "$1" | cut -f 1)
    install -d "$1/DEBIAN"
    text=$(<"$DEBIAN_DIR/control")
    text=${text/@VERSION@/"$(version | cut -d ' ' -f 2)"}
    text=${text/@ARCHITECTURE@/"$(dpkg --print-architecture)"}
    text=${text/@MAINTAINER@/"$(package_maintainer)"}
    text=${text/@SIZE_KIB@/"$size"}
    printf '%s\n' "${text/@DEPENDS@/"$depends"}" >"$1/DEBIAN/control"
    for file in postinst prerm postrm; do
        install -m 755 "$DEBIAN_DIR/$file" "$1/DEBIAN/$file"
    done
    (cd "$1" && find etc -type f -printf '/%p\n' | sort >DEBIAN/conffiles)
    (cd "$1" && find usr lib -type f -print0 | sort -z | xargs -0 md5sum >DEBIAN/md5sums)
}

# package_deb FOLDER
package_deb() {
    local stage file
    file=$1/terravox_$(version | cut -d ' ' -f 2)_$(dpkg --print-architecture).deb
    stage=$(mktemp -d)
    chmod 755 "$stage"
    (
        umask 022
        quietly "$LOGS/package-stage.log" stage_programs "$stage"
        write_control "$stage"
        chmod -R u=rwX,go=rX "$stage"
        quietly "$LOGS/package-deb.log" dpkg-deb --root-owner-group -Zxz --build "$stage" "$file"
    ) || {
        rm -rf "$stage"
        die "make $file: failed"
    }
    rm -rf "$stage"
    printf '%s\n' "$file"
}

package_help() {
    cat <<'TEXT'
Makes packages of this checkout.

Usage: terravox package deb|wheel -o FOLDER

  deb              the programs, for the Debian or Ubuntu of this machine; prints its name
  wheel            the Python package, for each Python from 3.11 to 3.13 that is here (takes half an
                   hour: GDAL, PROJ and curl are compiled once, and most of Terravox)
  -o FOLDER        where they are written; made when missing

The same commit makes the same bytes of a deb: times are those of the commit, or SOURCE_DATE_EPOCH.
TEXT
}

# build_and_package_deb FOLDER
build_and_package_deb() {
    command -v dpkg-shlibdeps >/dev/null ||
        die "package deb: dpkg-shlibdeps is not installed (Debian package dpkg-dev)"
    if [[ ${TERRAVOX_NO_BUILD:-0} != 1 ]]; then
        set_up
        build release
    fi
    SOURCE_DATE_EPOCH=$(package_epoch)
    export SOURCE_DATE_EPOCH
    package_deb "$1"
}

# package deb|wheel -o FOLDER
package() {
    case ${1:-} in
        -h | --help) package_help && return ;;
        deb | wheel) ;;
        *) usage_error "package: '${1:-}'; allowed: deb, wheel" ;;
    esac
    [[ ${2:-} == -o && -n ${3:-} ]] || usage_error "package $1: -o FOLDER is missing"
    (($# == 3)) || usage_error "package $1: unknown argument '$4'"
    mkdir -p "$3"
    if [[ $1 == wheel ]]; then
        set_up
        package_wheel "$(cd "$3" && pwd)"
    else
        build_and_package_deb "$(cd "$3" && pwd)"
    fi
}
