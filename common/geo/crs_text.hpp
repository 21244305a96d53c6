#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace terravox::geo {

/// The longest accepted text of a coordinate reference system (CRS), in bytes: the capacity of a
/// variable length record of a LAS file.
inline constexpr std::size_t kLongestCrsText = 65'535;

/// The three accepted notations of a CRS.
enum class CrsNotation {
    kCode,  ///< AUTHORITY:CODE or AUTHORITY:CODE+CODE, of EPSG, ESRI, IGNF or OGC
    kWkt,   ///< well-known text, version 1 or 2
    kProj,  ///< a PROJ string: +proj=utm +zone=33
};

/// Decides by the first characters only; the rest is not checked.
[[nodiscard]] CrsNotation notation_of(std::string_view text) noexcept;

/// Checks the text of a CRS before it is passed to PROJ, which opens any path that such a text
/// names: in +nadgrids, +init and +grids, in PARAMETERFILE, in EXTENSION["PROJ4"], in METHOD["PROJ
/// ..."], in GEOIDMODEL["PROJ ..."]. Only text that is known to name no file passes: fixed lists of
/// authorities, of WKT keywords (nested at most 16 deep) and of PROJ parameters. A geoid of a
/// vertical datum may be given by a bare file name, as it is in many data files: heights are never
/// converted, so that file is never searched for. Thread-safe; reads nothing but the text.
/// @return what is wrong, as the end of a message; empty when the text is accepted
[[nodiscard]] std::string fault_of_crs_text(std::string_view text);

}  // namespace terravox::geo
