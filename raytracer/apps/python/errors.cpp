#include "raytracer/apps/python/errors.hpp"

#include <terravox/error.hpp>

namespace terravox::python {

namespace nb = nanobind;

namespace {

// They live as long as the interpreter.
PyObject* s_error = nullptr;
PyObject* s_usage_error = nullptr;

void translate(const std::exception_ptr& thrown, void* /*unused*/) {
    try {
        std::rethrow_exception(thrown);
    } catch (const UsageError& e) {
        PyErr_SetString(s_usage_error, e.what());
    } catch (const Error& e) {
        PyErr_SetString(s_error, e.what());
    }
}

PyObject* new_exception(const char* name, const char* about, const nb::object& bases) {
    PyObject* const made = PyErr_NewExceptionWithDoc(name, about, bases.ptr(), nullptr);
    if (made == nullptr)
        throw nb::python_error();
    return made;
}

}  // namespace

void add_errors(nb::module_& module) {
    s_error = new_exception("terravox.Error", "A request cannot be met; the message says why.",
                            nb::borrow(PyExc_RuntimeError));
    s_usage_error = new_exception(
        "terravox.UsageError", "The request is invalid; the message says what is allowed.",
        nb::make_tuple(nb::borrow(s_error), nb::borrow(PyExc_ValueError)));
    module.attr("Error") = nb::borrow(s_error);
    module.attr("UsageError") = nb::borrow(s_usage_error);
    nb::register_exception_translator(translate);
}

}  // namespace terravox::python
