#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string_view>

namespace terravox::pointcloud {

class PointSource;

/// Classification of a file by its first bytes.
enum class Recognition : std::uint8_t {
    kUnknown,  ///< not this format, or too damaged to decide
    kPoints,   ///< points in this format
    kOther,    ///< this format, but with other content than points, such as a mesh
};

/// The number of bytes from the beginning of a file that recognise() receives; fewer for a shorter
/// file.
inline constexpr std::size_t kHeadBytes = 4096;

/// A format of point files: a struct without data members, in a folder of its own, that is listed
/// in formats/list.hpp. recognise() and open() are defined in different source files: a program
/// that only recognises files does not link the libraries that read them.
template <class T>
concept PointFormat = requires(std::string_view head, const std::filesystem::path& path) {
    { T::kName } -> std::convertible_to<std::string_view>;  ///< as in "a LAS, LAZ or COPC file"
    /// File name endings, lower case, with dot.
    { *std::begin(T::kEndings) } -> std::convertible_to<std::string_view>;
    /// Ending of a side file of the same name next to the point file, which open() reads when it
    /// exists; "" = none.
    { T::kSideEnding } -> std::convertible_to<std::string_view>;
    { T::recognise(head) } noexcept -> std::same_as<Recognition>;
    /// Reads and checks everything that is required before points are read.
    /// @throws Error for a missing file, one of another format, or a damaged one
    { T::open(path) } -> std::same_as<std::unique_ptr<const PointSource>>;
};

}  // namespace terravox::pointcloud
