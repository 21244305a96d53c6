# The wheel of the Python package. Sourced by ./terravox.
# shellcheck shell=bash

WHEEL_TOOLS=$ROOT/build/deps/wheel-tools
WHEEL_REQUIREMENTS=$ROOT/config/setup/python/wheel.txt
# GDAL, PROJ and curl with what Terravox needs of them, to be linked into the package: those of
# Debian are shared libraries with a hundred others behind them.
GEO_DIR=$ROOT/build/deps/geo
# -fPIC among the flags: GDAL leaves CMake's property for it to builds of shared libraries. Small
# code, since they are a third of the wheel, and read what is prepared once.
GEO_FLAGS="-fPIC -ffunction-sections -fdata-sections -fvisibility=hidden"
GEO_OPTIMIZED="-Os -DNDEBUG"
GDAL_DRIVERS=(AAIGRID DTED JP2OPENJPEG JPEG PNG RAW SRTMHGT USGSDEM XYZ)

# fetch_debian_sources FOLDER PACKAGE...: the sources of this system's packages, which apt verifies,
# with Debian's patches, of which many are for security.
fetch_debian_sources() {
    local folder=$1 options=()
    shift
    mkdir -p "$folder/lists/partial"
    sed 's/^Types: .*/Types: deb-src/' /etc/apt/sources.list.d/debian.sources \
        >"$folder/debian.sources" ||
        die "fetch sources of $*: /etc/apt/sources.list.d/debian.sources is missing"
    options=(-o "Dir::Etc::SourceList=$folder/debian.sources" -o Dir::Etc::SourceParts=/dev/null
        -o "Dir::State::Lists=$folder/lists" -o APT::Sandbox::User=root)
    (
        cd "$folder" || exit
        apt-get "${options[@]}" update || exit
        apt-get "${options[@]}" source "$@"
    )
}

# build_geo_part NAME SOURCES CMAKE_OPTION...: into GEO_DIR
build_geo_part() {
    local name=$1 sources=$2
    shift 2
    cmake -S "$sources" -B "$GEO_DIR/build/$name" -G Ninja -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_C_FLAGS="$GEO_FLAGS" -DCMAKE_CXX_FLAGS="$GEO_FLAGS" \
        -DCMAKE_C_FLAGS_RELEASE="$GEO_OPTIMIZED" -DCMAKE_CXX_FLAGS_RELEASE="$GEO_OPTIMIZED" \
        -DBUILD_SHARED_LIBS=OFF -DBUILD_APPS=OFF -DBUILD_TESTING=OFF \
        -DCMAKE_INSTALL_PREFIX="$GEO_DIR" -DCMAKE_INSTALL_LIBDIR=lib "$@" || return
    cmake --build "$GEO_DIR/build/$name" --target install
}

# Called by `quietly`, in which a command that fails does not end the function: each says so.
build_geo() {
    local driver drivers=() gdal
    for driver in "${GDAL_DRIVERS[@]}"; do
        drivers+=("-DGDAL_ENABLE_DRIVER_$driver=ON")
    done
    fetch_debian_sources "$GEO_DIR/sources" curl gdal proj || return
    build_geo_part curl "$GEO_DIR"/sources/curl-*/ -DHTTP_ONLY=ON -DBUILD_CURL_EXE=OFF \
        -DCURL_USE_OPENSSL=ON -DOPENSSL_USE_STATIC_LIBS=ON -DCURL_USE_LIBSSH2=OFF \
        -DCURL_USE_LIBPSL=OFF -DUSE_LIBIDN2=OFF || return
    build_geo_part proj "$GEO_DIR"/sources/proj-*/ -DENABLE_TIFF=OFF -DENABLE_CURL=OFF || return
    # CMake's list names two files of other makers, which Debian leaves out of the sources.
    gdal=("$GEO_DIR"/sources/gdal-*/)
    touch "${gdal[0]}data"/{cubewerx_extra,ecw_cs}.wkt || return
    build_geo_part gdal "${gdal[0]}" "${drivers[@]}" \
        -DGDAL_BUILD_OPTIONAL_DRIVERS=OFF -DOGR_BUILD_OPTIONAL_DRIVERS=OFF \
        -DGDAL_USE_EXTERNAL_LIBS=OFF -DGDAL_USE_INTERNAL_LIBS=ON -DGDAL_USE_OPENJPEG=ON \
        -DBUILD_PYTHON_BINDINGS=OFF -DCMAKE_PREFIX_PATH="$GEO_DIR" || return
    rm -rf "$GEO_DIR/build" "$GEO_DIR/sources"
}

# Once; takes some minutes.
install_geo() {
    [[ -f $GEO_DIR/.complete ]] && return
    say "Building GDAL, PROJ and curl for the wheel"
    rm -rf "$GEO_DIR"
    mkdir -p "$GEO_DIR"
    quietly "$LOGS/geo.log" build_geo || die "build GDAL, PROJ and curl: failed"
    touch "$GEO_DIR/.complete"
}

# in_wheel_tools COMMAND...: with the tools' packages in Python's path
in_wheel_tools() {
    PYTHONPATH=$WHEEL_TOOLS:$NANOBIND_DIR PATH=$WHEEL_TOOLS/bin:$PATH "$@"
}

# build_wheel PYTHON FOLDER: for one version of Python. All versions share a build: little of it
# depends on them.
build_wheel() {
    local python=$1 folder=$2 raw status
    raw=$(mktemp -d "$ROOT/build/wheels.XXXXXX") || return
    in_wheel_tools "$python" -m pip wheel "$ROOT/raytracer/apps/python" --no-deps \
        --no-build-isolation --disable-pip-version-check --wheel-dir "$raw" \
        --config-settings "cmake.define.CURL_DIR=$GEO_DIR/lib/cmake/CURL" \
        --config-settings cmake.define.OPENSSL_USE_STATIC_LIBS=ON \
        --config-settings "cmake.define.GDAL_DIR=$GEO_DIR/lib/cmake/gdal" \
        --config-settings "cmake.define.PROJ_DIR=$GEO_DIR/lib/cmake/proj" \
        --config-settings "cmake.define.TERRAVOX_PROJ_DATABASE=$GEO_DIR/share/proj/proj.db" \
        --config-settings "build-dir=$ROOT/build/wheel" &&
        in_wheel_tools "$python" -m auditwheel repair --strip --wheel-dir "$raw/whole" \
            "$raw"/*.whl &&
        python3 -B "$ROOT/config/release/wheel_licences.py" "$raw"/whole/*.whl -o "$folder" \
            --third-party "$ROOT/THIRD_PARTY.md" --deps "$ROOT/build/deps"
    status=$?
    rm -rf "$raw"
    return "$status"
}

# package_wheel FOLDER: a wheel for 3.11, whose stable interface nanobind cannot use, and one for
# all versions from 3.12 on, made with the first of them that is here
package_wheel() {
    local folder=$1 versions version python found=0
    install_pinned "$WHEEL_TOOLS" "$WHEEL_REQUIREMENTS" "scikit-build-core and auditwheel"
    install_geo
    mkdir -p "$folder"
    for versions in 3.11 "3.12 3.13 3.14"; do
        python=
        for version in $versions; do
            "python$version" -c 'import sys' 2>/dev/null || continue
            python=$(command -v "python$version")
            break
        done
        if [[ -z $python ]]; then
            say "No wheel for Python ${versions// / or }: python$version is not here"
            continue
        fi
        say "Building the wheel with Python $version"
        quietly "$LOGS/wheel-$version.log" build_wheel "$python" "$folder" ||
            die "package wheel: that of Python $version could not be built"
        found=1
    done
    ((found)) || die "package wheel: no Python from 3.11 to 3.14 is here"
}
