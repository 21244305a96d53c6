"""Takes the place of the build backend scikit-build-core while pip downloads a source archive (fetch_from_pypi in say.sh).

Before pip saves an archive it asks the backend for name and version. This one reads them from the archive's PKG-INFO; it builds nothing.
"""

import email.parser
import pathlib
import shutil


def get_requires_for_build_wheel(config_settings=None):
    return []


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    with open("PKG-INFO", encoding="utf-8") as file:
        about = email.parser.Parser().parse(file, headersonly=True)
    folder = pathlib.Path(metadata_directory, f"{about['Name']}-{about['Version']}.dist-info")
    folder.mkdir()
    shutil.copyfile("PKG-INFO", folder / "METADATA")
    return folder.name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    raise NotImplementedError("build a wheel: this backend only tells name and version")
