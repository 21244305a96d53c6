# An image for containers, made of Debian's packages and ours without a daemon
# (docs/adr/0030-packages.md). Sourced by ./terravox.
# shellcheck shell=bash

IMAGE_PACKAGE_LIST=$ROOT/config/setup/debian-image-packages.txt
# What no program here opens, and what makes up half of a system with GDAL: documentation but for
# licences, translations, drivers for graphics cards with their compiler, and the grabber, whose
# Node.js the image does not have.
IMAGE_WITHOUT=(
    '/usr/share/man/*' '/usr/share/info/*' '/usr/share/locale/*' '/usr/share/iso-codes/*'
    '/usr/share/xml/iso-codes/*' '/usr/lib/*/dri/*' '/usr/lib/*/libLLVM*' '/usr/lib/*/libz3.so*'
    '/usr/lib/*/mfx/*' '/usr/lib/*/libmfx*hw64*' '/usr/lib/terravox/grabber/*' '/usr/share/doc/*')

# The files with the addresses of packages that this machine's apt reads.
image_sources() {
    local file
    for file in /etc/apt/sources.list.d/{debian,ubuntu}.sources /etc/apt/sources.list; do
        [[ ! -s $file ]] || printf '%s\n' "$file"
    done
}

# make_root FILE DEB...: a tar archive of the least Debian with these packages
make_root() {
    local file=$1 hooks=/usr/share/mmdebstrap/hooks sources options=() path packages old_zones
    shift
    mapfile -t sources < <(image_sources)
    ((${#sources[@]} > 0)) || die "package image: apt has no sources of Debian or Ubuntu here"
    for path in "${IMAGE_WITHOUT[@]}"; do
        options+=("--dpkgopt=path-exclude=$path")
    done
    options+=('--dpkgopt=path-include=/usr/share/doc/*/copyright'
        '--dpkgopt=path-include=/usr/share/doc/terravox*/*')
    mapfile -t old_zones < <(offered_packages tzdata-legacy)
    packages=$(set -- "$@" "${old_zones[@]}" && IFS=, && printf '%s' "$*")
    # shellcheck source=/dev/null
    quietly "$LOGS/package-image.log" nice mmdebstrap --variant=essential \
        --aptopt='APT::Install-Recommends "false"' "${options[@]}" \
        --hook-dir="$hooks/maybe-merged-usr" --hook-dir="$hooks/file-mirror-automount" \
        --include="ca-certificates,$packages" \
        "$(. /etc/os-release && printf '%s' "$VERSION_CODENAME")" "$file" "${sources[@]}"
}

# package_image FOLDER: prints the name of the file
package_image() {
    local file architecture revision
    require_deb_tools
    [[ ${TERRAVOX_NO_BUILD:-0} == 1 ]] || install_packages "$IMAGE_PACKAGE_LIST"
    command -v mmdebstrap >/dev/null ||
        die "package image: mmdebstrap is not installed (Debian package mmdebstrap)"
    revision=$(git -C "$ROOT" rev-parse HEAD) ||
        die "package image: this is no checkout of git, whose commit the image names"
    [[ -z $(git -C "$ROOT" status --porcelain) ]] || revision=$revision-dirty
    architecture=$(dpkg --print-architecture)
    file=$1/terravox_$(version_number)_$architecture.oci.tar
    (
        work=$(mktemp -d)
        trap 'rm -rf "$work"' EXIT
        # apt in the new system reads them as a user of its own.
        chmod 755 "$work"
        mapfile -t debs < <(make_debs "$work" terravox-data terravox)
        ((${#debs[@]} == 2)) || die "package image: its Debian packages could not be made"
        make_root "$work/root.tar" "${debs[@]}"
        python3 -B "$ROOT/config/release/oci_image.py" "$work/root.tar" -o "$file" \
            --version "$(version_number)" --architecture "$architecture" \
            --time "$SOURCE_DATE_EPOCH" --revision "$revision"
    )
    printf '%s\n' "$file"
}
