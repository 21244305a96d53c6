#!/usr/bin/env python3
"""The notebooks of docs/examples, cell by cell, as a notebook would run them.

notebook_test.py [FOLDER]: the figures and pictures are written to FOLDER, to be looked at.
"""

import ast
import contextlib
import json
import os
import pathlib
import sys
import tempfile

import matplotlib as mpl

mpl.use("Agg")

from matplotlib import pyplot as plt  # noqa: E402 - the backend comes first

NOTEBOOKS = pathlib.Path(__file__).resolve().parents[4] / "docs" / "examples" / "python"


def run_cell(source, names):
    """Runs a cell.

    @return the value of its last expression; None where it ends with a statement
    """
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)  # noqa: S102 - it is our own notebook
    if last is None:
        return None
    return eval(compile(ast.Expression(last.value), "cell", "eval"), names)  # noqa: S307


def show(value, folder, number):
    """Does what a notebook does with a value.

    @return how it was shown
    """
    for method, ending in (("_repr_png_", "png"), ("_repr_html_", "html")):
        if hasattr(value, method):
            data = getattr(value, method)()
            data = data if isinstance(data, bytes) else data.encode()
            (folder / f"cell-{number}.{ending}").write_bytes(data)
            return ending
    return repr(value)


def run(notebook, folder):
    """Runs a notebook in a folder of its own, and counts what it shows."""
    names = {"__name__": "__main__"}
    shown = {"figures": 0, "png": 0, "html": 0}
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    for number, cell in enumerate(cells):
        if cell["cell_type"] != "code":
            continue
        assert not cell["outputs"], f"{notebook.name}: cell {number} holds outputs"
        value = run_cell("".join(cell["source"]), names)
        for figure in map(plt.figure, plt.get_fignums()):
            figure.savefig(folder / f"figure-{number}-{figure.number}.png", dpi=80)
            shown["figures"] += 1
        plt.close("all")
        if value is not None:
            how = show(value, folder, number)
            if how in shown:
                shown[how] += 1
    return shown


def main():
    with contextlib.ExitStack() as stack:
        temporary = tempfile.TemporaryDirectory(prefix="terravox-notebook-")
        folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else stack.enter_context(temporary))
        folder.mkdir(parents=True, exist_ok=True)
        os.chdir(folder)
        shown = run(NOTEBOOKS / "first_steps.ipynb", folder)
        assert shown == {"figures": 4, "png": 1, "html": 1}, shown
        assert (folder / "picture.png").read_bytes().startswith(b"\x89PNG")
        print(shown)


if __name__ == "__main__":
    main()
