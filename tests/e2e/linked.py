"""What of third parties is in a program: linked with it, or compiled into it."""

import pathlib
import re
import subprocess
import sys

from support import ROOT

sys.path.insert(0, str(ROOT / "config" / "release"))
from contents import (  # noqa: F401
    bundled,
    compiled_in,
    compiled_into_wheels,
    control_fields,
    deb_files,
    program_name,
    short_name,
    third_party,
    wheel_libraries,
)

# Sanitizers and the loader: no third party's choice.
NOT_LISTED = re.compile(r"ld-linux|lib(asan|tsan|ubsan)$")

# Bytes that stay in a program with the code of each row of "Compiled in", also where the names of
# its functions have been removed: texts of errors, names of types. What THIRD_PARTY.md says after
# a comma in the name of a row is left out.
MARKS = {
    "LASzip": b"LASzip DLL",
    "nanoflann": b"[nanoflann] ",
    "CLI11": b"N3CLI",
    "JSON for Modern C++": b"8nlohmann",
    "Dear ImGui": b"ProggyClean",
    "nanobind": b"nanobind",
    "Python": b"PyInit_",
    "Catch2": b"N5Catch",
}

# The same for what is compiled into wheels alone.
WHEEL_MARKS = {"GDAL": b"GDAL_DATA", "PROJ": b"PROJ_NETWORK", "curl": b"Operation timed out after"}

# What the namespaces in programs belong to, by the names in THIRD_PARTY.md. LASzip has none: these
# are its classes. One is missing, Endian: the linker takes the start-up code that sets its one
# variable into the voxel server, too, where nothing calls LASzip.
NAMESPACES = {
    r"CLI": "CLI11",
    r"Im[A-Z]\w*": "Dear ImGui",
    r"nlohmann": "JSON for Modern C++",
    r"nanobind|tsl": "nanobind",
    r"nanoflann": "nanoflann",
    r"Catch": "Catch2",
    r"(LAS|ByteStream|Arithmetic|Integer)\w*": "LASzip",
    r"OpenImageIO\w*": "OpenImageIO",
    r"Imath_\w*": "Imath",
    r"fmt": "{fmt}",
    r"google": "Protocol Buffers",
    r"grpc": "gRPC",
    r"hwy": "Highway",
    r"openvdb": "OpenVDB",
    r"spdlog": "spdlog",
    r"tbb": "oneTBB",
    r"toml": "toml++",
}
# Terravox, what protoc and the compiler write for it, and the compiler's own library.
OURS = re.compile(
    r"terravox\w*|TableStruct_raytracer\w*|main|_GLOBAL__N_1|__gnu_cxx|__cxxabiv1|Endian"
)
# The first name of a function or an object that is in a namespace or a class (Itanium C++ ABI,
# "Mangling"): _ZNK3fmt..., _ZTVN4toml..., _ZZN3CLI... Those of std are written otherwise.
NESTED = re.compile(r" [A-Za-z] _Z(?:T[VTISHW]|GV)?Z*N[VKRO]*(\d+)(\w+)")


def tables():
    return third_party((ROOT / "THIRD_PARTY.md").read_text(encoding="utf-8"))


def output_of(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def needed(path):
    """@return the shared libraries that a program is linked with, without their versions"""
    text = output_of("readelf", "--dynamic", "--wide", path)
    names = {name.split(".so")[0] for name in re.findall(r"\(NEEDED\).*\[(.+)\]", text)}
    return {name for name in names if not NOT_LISTED.match(name)}


def marked(data):
    """@param data a program's bytes @return the rows of "Compiled in" whose code it has"""
    return {name for name, mark in MARKS.items() if mark in data}


def namespaces(path):
    """@return the outermost namespaces and classes of all that a program holds"""
    found = NESTED.findall(output_of("nm", "--defined-only", path))
    return {name[: int(length)] for length, name in found}


def owner(namespace):
    """@return who made it, None for this project and the compiler"""
    if OURS.fullmatch(namespace):
        return None
    for pattern, name in NAMESPACES.items():
        if re.fullmatch(pattern, namespace):
            return name
    return f"unknown: {namespace}"


def programs_of_build(folder):
    """@return what is distributed of a build, by the names in THIRD_PARTY.md"""
    files = [path for path in folder.glob("bin/terravox-*") if path.suffix in ("", ".so")]
    files += [folder / "lib" / "libterravox.so", *folder.glob("python/terravox/_core*.so")]
    return {program_name(str(pathlib.PurePath(path))): path for path in files}
