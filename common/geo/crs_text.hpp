#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace terravox::geo {

/// Of any text for a coordinate reference system (CRS), in bytes: what a variable length record of
/// a LAS file can hold.
inline constexpr std::size_t kLongestCrsText = 65'535;

/// The three ways to write down a CRS that are read here.
enum class CrsNotation {
    kCode,  ///< AUTHORITY:CODE or AUTHORITY:CODE+CODE, of EPSG, ESRI, IGNF or OGC
    kWkt,   ///< well-known text, version 1 or 2
    kProj,  ///< a PROJ string: +proj=utm +zone=33
};

/// By its first characters; the rest may be anything.
[[nodiscard]] CrsNotation notation_of(std::string_view text) noexcept;

/// Looks at the text of a CRS before PROJ does, which opens whatever path such a text names: in
/// +nadgrids, +init and +grids, in PARAMETERFILE, in EXTENSION["PROJ4"], in METHOD["PROJ ..."], in
/// GEOIDMODEL["PROJ ..."]. Only what is known to name no file passes: a fixed list of authorities,
/// of keywords of WKT (nested 16 deep at most), of parameters of PROJ. Geoids of vertical datums
/// may be told by a bare file name, as many files do: heights are never converted, so nothing looks
/// for them. Thread-safe; reads nothing but the text.
/// @return what is wrong, as the end of a message; empty: nothing
[[nodiscard]] std::string fault_of_crs_text(std::string_view text);

}  // namespace terravox::geo
