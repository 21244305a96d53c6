#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace terravox::python {

namespace nb = nanobind;

/// Three numbers for each ray, as numpy has them.
using RayArray = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

[[nodiscard]] inline std::span<const double> list_numbers(const RayArray& rays) {
    return {rays.data(), rays.size()};
}

/// The values as an array of numpy, without a copy: it owns them from now on.
/// @param values of a plain type whose elements are `Element`s, one after the other
template <class Element, class Value>
[[nodiscard]] nb::ndarray<nb::numpy, Element> make_array(std::vector<Value> values,
                                                         std::initializer_list<std::size_t> shape) {
    static_assert(sizeof(Value) % sizeof(Element) == 0);
    auto owned = std::make_unique<std::vector<Value>>(std::move(values));
    auto* const data = reinterpret_cast<Element*>(owned->data());
    const nb::capsule owner(owned.release(),
                            [](void* p) noexcept { delete static_cast<std::vector<Value>*>(p); });
    return nb::ndarray<nb::numpy, Element>(data, shape, owner);
}

/// Python objects that a thread without the interpreter's lock owns: they are let go with it.
template <class T>
[[nodiscard]] std::shared_ptr<T> shared_with_threads(T value) {
    return std::shared_ptr<T>(new T(std::move(value)), [](T* p) {
        const nb::gil_scoped_acquire with_lock;
        delete p;
    });
}

/// Adds world_of_points and world_of_voxels, which make worlds of numpy's arrays, to the module.
void add_array_worlds(nanobind::module_& module);

}  // namespace terravox::python
