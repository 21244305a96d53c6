#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string_view>

namespace terravox::pointcloud {

class PointSource;

/// What the first bytes of a file say of it.
enum class Recognition : std::uint8_t {
    kUnknown,  ///< not this format, or too damaged to tell
    kPoints,   ///< points in this format
    kOther,    ///< this format, with something else than points in it, such as a mesh
};

/// How many first bytes of a file recognise() gets; fewer of a shorter file.
inline constexpr std::size_t kHeadBytes = 4096;

/// A format of point files: a struct without members, in a folder of its own, that formats/list.hpp
/// names. recognise() and open() are defined in different sources: a program that only recognises
/// files does not link the libraries that read them.
template <class T>
concept PointFormat = requires(std::string_view head, const std::filesystem::path& path) {
    { T::kName } -> std::convertible_to<std::string_view>;  ///< as in "a LAS, LAZ or COPC file"
    /// Endings of file names, lower case, with dot.
    { *std::begin(T::kEndings) } -> std::convertible_to<std::string_view>;
    /// Of a file of the same name beside it, which opening reads where it is there; "" = none.
    { T::kSideEnding } -> std::convertible_to<std::string_view>;
    { T::recognise(head) } noexcept -> std::same_as<Recognition>;
    /// Reads and checks what must be known before any point is read.
    /// @throws Error for a missing file, one of another format, or a damaged one
    { T::open(path) } -> std::same_as<std::unique_ptr<const PointSource>>;
};

}  // namespace terravox::pointcloud
