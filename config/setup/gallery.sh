# The gallery: views of a synthetic survey, each a scene of config/scenes/gallery.
# Sourced by ./terravox.
# shellcheck shell=bash

GALLERY_SCENES=$ROOT/config/scenes/gallery
# Seven by seven kilometres, so that the land ends in haze behind hills. The square in the middle
# has more pulses.
# shellcheck disable=SC2054  # 459,98 is one value
GALLERY_AROUND=(--seed 7 --squares 7x7 --origin 459,98 --density 1)
GALLERY_MIDDLE=(--seed 7 --squares 1x1 --density 8)
GALLERY_SQUARE=TM_462_101
# That square once more, with the sun of a morning in its photograph.
# shellcheck disable=SC2034,SC2054  # used by its name; 120,32 is one value
GALLERY_PHOTO=(--seed 7 --squares 1x1 --density 8 --photo-sun 120,32)

# In the order of docs/gallery/README.md.
GALLERY_NAMES=(
    noon
    dusk
    fog
    water-from-above
    water-at-a-grazing-angle
    forest
    village
    cliff
    poster
    panorama
    clay
    orthophoto
    photograph
    no-photograph
    night
    noise
)
# Models of the middle square, and where trees hide the rest: that square alone is faster.
GALLERY_OF_THE_SQUARE=(poster orthophoto forest no-photograph)
GALLERY_WITHOUT_PHOTO=(no-photograph)
GALLERY_OF_THE_PHOTO=(photograph)
GALLERY_OF_NOISE=(noise)
GALLERY_SEED=7

gallery_help() {
    cat <<'TEXT'
Renders the pictures of docs/gallery from a synthetic survey.

Usage: terravox gallery [--size WxH] [--output FOLDER] [-v] [NAME...]
       terravox gallery --list

  NAME             which; all when none is named
  --size WxH       instead of the picture's own size
  --output FOLDER  where NAME.jpg goes [docs/gallery]
  --list           lists the names with what they show
TEXT
}

in_list() {
    local word
    for word in "${@:2}"; do [[ $word != "$1" ]] || return 0; done
    return 1
}

# The first line of a scene file: "# Gallery: what it shows."
gallery_title() { sed -n '1s/^# Gallery: //p' "$GALLERY_SCENES/$1.toml"; }

gallery_list() {
    local name
    for name in "${GALLERY_NAMES[@]}"; do
        printf '%-26s %s\n' "$name" "$(gallery_title "$name")"
    done
}

# Makes the place once for each set of options; prints its folder. It is made next to its final name
# and renamed: a folder of that name is always complete. A part that is finished when a run is
# interrupted is kept.
gallery_place() {
    local program=$ROOT/build/release/bin/terravox-survey key folder
    key=$(
        {
            printf '%s\n' "${GALLERY_AROUND[@]}" "${GALLERY_MIDDLE[@]}" "${GALLERY_PHOTO[@]}"
            cat "$program"
        } | sha256sum | cut -c 1-12
    )
    folder=$ROOT/build/gallery/place-$key
    locked "$ROOT/build/gallery/.lock" make_gallery_place "$program" "$folder"
    printf '%s\n' "$folder"
}

# make_gallery_place PROGRAM FOLDER: unless it is there, in place of earlier ones
make_gallery_place() {
    local program=$1 folder=$2 part
    [[ ! -d $folder ]] || return 0
    say "Making the survey (49 squares; a few minutes, once)"
    find "$ROOT/build/gallery" -mindepth 1 -maxdepth 1 \
        -name 'place-*' ! -name "${folder##*/}*" -exec rm -rf {} +
    for part in AROUND MIDDLE PHOTO; do gallery_part "$program" "$folder" "$part"; done
    # A run that was interrupted here may have moved it already.
    if [[ -f $folder-MIDDLE/$GALLERY_SQUARE.laz ]]; then
        mv -f "$folder-MIDDLE/$GALLERY_SQUARE.laz" "$folder-AROUND/$GALLERY_SQUARE.laz"
    fi
    rm -rf "$folder-MIDDLE" "$folder-AROUND/truth"
    mv "$folder-AROUND" "$folder"
}

# gallery_part PROGRAM FOLDER AROUND|MIDDLE|PHOTO: the last one stays a folder of its own.
gallery_part() {
    local -n options=GALLERY_$3
    [[ ! -d $2-$3 ]] || return 0
    rm -rf "$2-$3.part"
    quietly "$LOGS/gallery-survey.log" "$1" "${options[@]}" -o "$2-$3.part" ||
        die "gallery: the survey could not be made"
    mv "$2-$3.part" "$2-$3"
}

# gallery_picture PLACE NAME FILE [render arguments]: the output of render goes to the log.
gallery_picture() {
    local place=$1 name=$2 file=$3 data=("$1" --ortho "$1/ortho") status=0
    local drawn=$ROOT/build/gallery/$2.png
    if in_list "$name" "${GALLERY_OF_THE_SQUARE[@]}"; then data[0]=$place/$GALLERY_SQUARE.laz; fi
    if in_list "$name" "${GALLERY_WITHOUT_PHOTO[@]}"; then data=("${data[0]}"); fi
    if in_list "$name" "${GALLERY_OF_THE_PHOTO[@]}"; then
        data=("$place-PHOTO/$GALLERY_SQUARE.laz" --ortho "$place-PHOTO/ortho")
    fi
    if in_list "$name" "${GALLERY_OF_NOISE[@]}"; then data=("generated:$GALLERY_SEED"); fi
    if [[ -f $GALLERY_SCENES/$name.geojson ]]; then
        data+=(--add "$GALLERY_SCENES/$name.geojson") # street lamps
    fi
    rm -f "$drawn"
    quietly "$LOGS/gallery-$name.log" \
        "$ROOT/build/release/bin/terravox-raytracer" render "${data[@]}" \
        --cache "$ROOT/build/gallery/cache" \
        --scene "$GALLERY_SCENES/$name.toml" \
        "${@:4}" -o "$drawn" || status=$?
    # A picture with holes (3) is kept.
    [[ $status == 0 || $status == 3 ]] || return "$status"
    # Smaller than the JPEG files of render, which keep more of the colours: the pictures are part
    # of the repository.
    quietly "$LOGS/gallery-$name-jpeg.log" \
        gdal_translate -q -of JPEG -co QUALITY=86 --config GDAL_PAM_ENABLED NO \
        "$drawn" "$file.part-$$" || {
        rm -f "$file.part-$$"
        return 1
    }
    mv -f "$file.part-$$" "$file" || return 1
    return "$status"
}

gallery() {
    local output=$ROOT/docs/gallery size=() names=() name place started failed=0 status outcome
    # shellcheck disable=SC2034  # VERBOSE is for say.sh
    while (($# > 0)); do
        case $1 in
            -h | --help) gallery_help && return ;;
            --list) gallery_list && return ;;
            -v | --verbose) VERBOSE=1 ;;
            --size | --output)
                (($# > 1)) || usage_error "gallery: $1 lacks its value"
                if [[ $1 == --size ]]; then size=(--size "$2"); else output=$2; fi
                shift
                ;;
            -*) usage_error "gallery: unknown option '$1'; terravox gallery --help lists them" ;;
            *)
                in_list "$1" "${GALLERY_NAMES[@]}" ||
                    usage_error "gallery: no picture is called '$1'; allowed: ${GALLERY_NAMES[*]}"
                names+=("$1")
                ;;
        esac
        shift
    done
    [[ ${#size[@]} == 0 || ${size[1]} =~ ^[1-9][0-9]{0,4}x[1-9][0-9]{0,4}$ ]] ||
        usage_error "gallery: --size '${size[1]}'; allowed: WIDTHxHEIGHT in pixels, such as 640x360"
    [[ -n $output ]] || usage_error "gallery: --output ''; allowed: a folder"
    ((${#names[@]} > 0)) || names=("${GALLERY_NAMES[@]}")
    if [[ ${TERRAVOX_NO_BUILD:-0} != 1 ]]; then
        [[ -f $ROOT/build/release/build.ninja ]] || set_up
        build release terravox-survey terravox-raytracer
    fi
    for name in terravox-survey terravox-raytracer; do
        [[ -x $ROOT/build/release/bin/$name ]] ||
            die "run $name: it was never built; run terravox build"
    done
    place=$(gallery_place)
    mkdir -p "$output" || die "gallery: the folder '$output' cannot be made"
    for name in "${names[@]}"; do
        started=${EPOCHREALTIME/,/.}
        status=0
        gallery_picture "$place" "$name" "$output/$name.jpg" "${size[@]}" || status=$?
        outcome=
        # The exit code is that of the worst picture: failed (1), then with holes (3).
        if ((status == 3)); then
            ((failed != 0)) || failed=3
            outcome="  with holes"
        elif ((status != 0)); then
            failed=1
            outcome="  failed"
        fi
        awk -v name="$name" -v from="$started" -v to="${EPOCHREALTIME/,/.}" -v outcome="$outcome" \
            'BEGIN { printf "%-26s %8.1f s%s\n", name, to - from, outcome }'
    done
    return "$failed"
}
