#pragma once

#include <nanobind/nanobind.h>

namespace terravox::python {

/// Adds the exceptions Error, a RuntimeError, and UsageError, an Error and a ValueError, and turns
/// those of the library into them.
void add_errors(nanobind::module_& module);

}  // namespace terravox::python
