"""The tools that make a release, and its version."""

import re
import sys

from support import ROOT, Run

TOOLS = ROOT / "config" / "release"
TIME = "1700000000"
sys.path.insert(0, str(TOOLS))
from licences import fetched_licence  # noqa: E402, F401


def tool(name, *arguments):
    return Run([sys.executable, "-B", TOOLS / name, *arguments])


def version():
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    return re.search(r"project\(terravox VERSION ([0-9.]+)", text)[1]
