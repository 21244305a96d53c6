"""Stands in for the build backend scikit-build-core while pip downloads a source archive.

fetch_from_pypi in say.sh puts this folder into PYTHONPATH. Before pip saves an archive it gets name
and version from the backend. This backend reads them from the PKG-INFO of the archive and builds
nothing.
"""

import email.parser
import pathlib
import shutil


def get_requires_for_build_wheel(config_settings=None):
    return []


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    with pathlib.Path("PKG-INFO").open(encoding="utf-8") as file:
        about = email.parser.Parser().parse(file, headersonly=True)
    folder = pathlib.Path(metadata_directory, f"{about['Name']}-{about['Version']}.dist-info")
    folder.mkdir()
    shutil.copyfile("PKG-INFO", folder / "METADATA")
    return folder.name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    raise NotImplementedError("build a wheel: this backend only gives name and version")
