#pragma once

#include <nanobind/nanobind.h>

namespace terravox::python {

/// Adds world_of_points and world_of_voxels, which make worlds of numpy's arrays, to the module.
void add_array_worlds(nanobind::module_& module);

}  // namespace terravox::python
