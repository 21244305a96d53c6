"""What is inside a Debian package, a wheel and an image."""

import gzip
import io
import json
import re
import subprocess
import tarfile
import zipfile

# A line of the lists of licences that the grabber and the page bring: NAME VERSION (LICENCE)
BUNDLED = re.compile(r"^((?:@[^\s/]+/)?[^\s/]+) (\d\S*) \((.+)\)$", re.M)


def third_party(text):
    """@param text THIRD_PARTY.md @return rows as lists of cells, by heading"""
    found = {}
    rows = []
    for line in text.splitlines():
        if line.startswith("## "):
            rows = found[line.removeprefix("## ")] = []
        elif line.startswith("|---"):
            rows.clear()
        elif line.startswith("|"):
            rows.append([cell.strip().strip("`") for cell in line.strip("|").split("|")])
    return found


def short_name(row):
    """@return the name in a row of "Compiled in", without what comes with it"""
    return row[0].partition(", ")[0]


def compiled_in(tables, programs):
    """@return the rows of what is compiled into one of the programs"""
    return [row for row in tables["Compiled in"] if programs & set(row[5].split(", "))]


def compiled_into_wheels(tables):
    """@return the rows of what is compiled in nowhere else"""
    return [row for row in tables["In the wheel"] if row[2].startswith("compiled in")]


def program_name(path):
    """@return how THIRD_PARTY.md names a program, a module or a library, None for other files"""
    found = re.search(
        r"/(?:terravox-([a-z-]+(?:\.so)?)|(libterravox)\.so[0-9.]*|(_core)\.[^/]+\.so)$", path
    )
    if found is None:
        return None
    return found[1] or ("library" if found[2] else "python")


def control_fields(text):
    """@return the fields of a paragraph of Debian's control files"""
    joined = re.sub(r"\n[ \t]+", " ", text)
    return dict(re.findall(r"(?m)^([A-Za-z-]+):[ \t]*(.*)$", joined))


def deb_fields(path):
    done = subprocess.run(["dpkg-deb", "--field", path], capture_output=True, text=True, check=True)
    return control_fields(done.stdout)


def deb_depends(path):
    """@return name, what it says of the version of each package that it depends on"""
    for part in filter(None, deb_fields(path).get("Depends", "").split(",")):
        name, _, version = part.strip().partition(" ")
        yield name, version.strip("()")


def deb_files(path, ending):
    """@return the contents of the files whose names end so, by their names"""
    done = subprocess.run(["dpkg-deb", "--fsys-tarfile", path], capture_output=True, check=True)
    with tarfile.open(fileobj=io.BytesIO(done.stdout)) as archive:
        return {
            entry.name: archive.extractfile(entry).read()
            for entry in archive
            if entry.isreg() and entry.name.endswith(ending)
        }


def programs_in(path):
    """@return the programs, modules and libraries in a package or a wheel, as THIRD_PARTY.md names
    them; of an image those are in its packages"""
    if path.suffix == ".whl":
        return {"python"}
    names = deb_files(path, "") if path.suffix == ".deb" else ()
    return {program for program in map(program_name, names) if program is not None}


def bundled(text):
    """@return name, version, licence of each package of npm in a list of licences"""
    return sorted(set(BUNDLED.findall(text)))


def wheel_libraries(path):
    """@return the shared libraries that came into a wheel, by their names"""
    with zipfile.ZipFile(path) as archive:
        return {
            name.rpartition("/")[2]: archive.read(name)
            for name in archive.namelist()
            if name.startswith("terravox.libs/") and ".so" in name
        }


def image_packages(path):
    """@return the fields of each Debian package in an image"""
    with tarfile.open(path) as layout:
        (manifest,) = json.load(layout.extractfile("manifest.json"))
        for name in manifest["Layers"]:
            with (
                gzip.GzipFile(fileobj=layout.extractfile(name)) as plain,
                tarfile.open(fileobj=plain, mode="r|") as layer,
            ):
                for entry in layer:
                    if entry.name == "var/lib/dpkg/status":
                        text = layer.extractfile(entry).read().decode()
                        return [control_fields(each) for each in text.split("\n\n") if each.strip()]
    return []
