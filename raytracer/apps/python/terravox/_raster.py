"""Rasters as arrays with coordinates and a CRS."""

from typing import Any

import numpy as np
import xarray as xr

_WKT_NAMES = ("crs_wkt", "spatial_ref")


def _coordinates(raster: dict[str, Any], crs_wkt: str) -> dict[str, Any]:
    west, south, east, north = raster["bounds"][:4]
    cell = raster["cell"]
    rows, columns = next(iter(raster["bands"].values())).shape
    # Coordinates are those of the middles of cells, as CF and rioxarray have them.
    out: dict[str, Any] = {
        "y": ("y", north - (np.arange(rows) + 0.5) * cell, {"axis": "Y"}),
        "x": ("x", west + (np.arange(columns) + 0.5) * cell, {"axis": "X"}),
    }
    if crs_wkt:
        attributes: dict[str, Any] = dict.fromkeys(_WKT_NAMES, crs_wkt)
        attributes["GeoTransform"] = f"{west!r} {cell!r} 0 {north!r} 0 {-cell!r}"
        out["spatial_ref"] = ((), 0, attributes)
    return out


def dataset_of(raster: dict[str, Any], crs_wkt: str) -> xr.Dataset:
    """Return a raster of the core as a dataset: a variable for each band."""
    variables = {}
    for name, values in raster["bands"].items():
        attributes = {"grid_mapping": "spatial_ref"} if crs_wkt else {}
        if raster["units"][name]:
            attributes["units"] = raster["units"][name]
        variables[name] = (("y", "x"), values, attributes)
    out = xr.Dataset(variables, _coordinates(raster, crs_wkt))
    out.attrs["holes"] = raster["holes"]
    return out


def array_of(raster: dict[str, Any], crs_wkt: str) -> xr.DataArray:
    """Return a raster of one band as an array."""
    data = dataset_of(raster, crs_wkt)
    (name,) = raster["bands"]
    out: xr.DataArray = data[name]
    out.attrs["holes"] = raster["holes"]
    return out
